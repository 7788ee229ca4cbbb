#include "codec/search/moves.h"

#include <array>
#include <cmath>
#include <optional>

namespace sbrdf::internal {
namespace {

constexpr std::array<double, kAxisCount> kLeastCellDeg = {4, 4, 2, 0.5};
constexpr std::array kFloorHalvings = {2, 5, 10};
using Ratio = std::optional<double>;
constexpr std::array<Ratio, 2> kIsotropicRatios = {std::nullopt, 1};
constexpr std::array<Ratio, 6> kRatios = {std::nullopt, 1, 0.2, 0.4, 2.5, 5};

// In steps of 1/32 degree, which f64 holds exactly.
double third_of(double gap_deg) { return std::round(gap_deg * 32 / 3) / 32; }

void move_nodes(const Structure& from, std::size_t axis, std::vector<Structure>& moves) {
  const std::vector<double>& list = from.outline.lists[axis];
  const auto changed = [&]() -> std::vector<double>& { return moves.emplace_back(from).outline.lists[axis]; };
  for (std::size_t k = 0; k + 1 < list.size(); ++k) {
    if (list[k + 1] - list[k] < 2 * kLeastCellDeg[axis]) continue;
    std::vector<double>& target = changed();
    target.insert(target.begin() + static_cast<std::ptrdiff_t>(k + 1), (list[k] + list[k + 1]) / 2);
  }
  for (std::size_t k = 1; k + 1 < list.size(); ++k) {
    std::vector<double>& target = changed();
    target.erase(target.begin() + static_cast<std::ptrdiff_t>(k));
    changed()[k] -= third_of(list[k] - list[k - 1]);
    changed()[k] += third_of(list[k + 1] - list[k]);
  }
}

/// Each of `values` in place of the structure's own, which is left out.
template <class T>
void replace(const Structure& from, T Structure::*member, std::span<const T> values, Moves& moves) {
  for (const T& value : values) {
    if (value == from.*member) {
      ++moves.known;
    } else {
      moves.structures.emplace_back(from).*member = value;
    }
  }
}

}  // namespace

Moves moves_from(const Structure& structure, const SearchOptions& options) {
  Moves moves;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) move_nodes(structure, axis, moves.structures);
  if (!options.domain) {
    moves.structures.emplace_back(structure).domain =
        structure.domain == DomainKind::kLog ? DomainKind::kLinear : DomainKind::kLog;
  }
  if (structure.domain != DomainKind::kLog) return moves;
  replace<int>(structure, &Structure::floor_halvings, kFloorHalvings, moves);
  if (structure.outline.id != FrameId::kHalfDifference) return moves;
  const auto ratios = options.symmetries.isotropic ? std::span<const Ratio>(kIsotropicRatios) : kRatios;
  replace<Ratio>(structure, &Structure::guide_ratio, ratios, moves);
  return moves;
}

}  // namespace sbrdf::internal
