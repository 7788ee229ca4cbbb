#include "converters/slicing/placements.h"

#include <algorithm>
#include <array>

namespace sbrdf::internal {
namespace {

constexpr std::array<Placement, 17> kTable3 = {{{28, 180},
                                                {20, 180},
                                                {16, 180},
                                                {28, 60},
                                                {20, 60},
                                                {16, 60},
                                                {14, 60},
                                                {16, 36},
                                                {14, 36},
                                                {12, 36},
                                                {10, 36},
                                                {8, 36},
                                                {12, 20},
                                                {10, 20},
                                                {8, 20},
                                                {6, 20},
                                                {6, 12}}};
// The most samples for which each but the last is used.
constexpr std::array<std::uint64_t, 16> kTable3Limits = {
    667, 932, 1'034, 1'060, 2'272, 3'230, 4'928, 5'645, 9'660, 17'096, 20'969, 22'291, 33'879, 38'735, 79'469, 184'655};

}  // namespace

std::span<const Placement> table_3_placements() { return kTable3; }

Placement table_3_placement(std::uint64_t sample_count) {
  const auto row = std::lower_bound(kTable3Limits.begin(), kTable3Limits.end(), sample_count);
  return kTable3[static_cast<std::size_t>(row - kTable3Limits.begin())];
}

}  // namespace sbrdf::internal
