#include "converters/source/brdf_source.h"

#include <algorithm>

#include "formats/core/parallel.h"

namespace sbrdf::internal {

void BrdfSource::measured(std::span<const DirectionPair> /*pairs*/, std::span<std::uint8_t> flags) const {
  std::fill(flags.begin(), flags.end(), std::uint8_t{1});
}

void evaluate_in_parallel(const BrdfSource& source, std::span<const DirectionPair> pairs, std::span<float> values) {
  constexpr std::size_t kBlock = 256;
  const std::size_t channels = source.channel_count();
  parallel_blocks(pairs.size(), kBlock, [&](std::size_t first, std::size_t size) {
    source.evaluate(pairs.subspan(first, size), values.subspan(first * channels, size * channels));
  });
}

}  // namespace sbrdf::internal
