#include "converters/source/brdf_source.h"

#include <algorithm>
#include <array>
#include <cassert>

#include <glm/vec3.hpp>

#include "formats/core/parallel.h"

namespace sbrdf::internal {

void BrdfSource::evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                  std::span<float> values) const {
  constexpr std::size_t kBlock = 64;  // pairs translated at a time, on the stack
  constexpr Direction kBelow = {kPi, 0};
  const std::size_t channels = channel_count();
  assert(w_i.size() == w_v.size() && values.size() == w_i.size() * channels);
  const auto direction = [&](const glm::vec3& w) {
    return above_horizon(w) ? direction_from_vector(glm::dvec3(w)) : kBelow;
  };
  std::array<DirectionPair, kBlock> pairs;
  for (std::size_t first = 0; first < w_i.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, w_i.size() - first);
    for (std::size_t k = 0; k < count; ++k) pairs[k] = {direction(w_i[first + k]), direction(w_v[first + k])};
    evaluate(std::span(pairs).first(count), values.subspan(first * channels, count * channels));
  }
}

SourceTraits BrdfSource::reported_traits() const {
  SourceTraits all = traits();
  all.findings = findings();
  return all;
}

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

void evaluate_in_parallel(const BrdfSource& source, std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                          std::span<float> values) {
  constexpr std::size_t kBlock = 256;
  const std::size_t channels = source.channel_count();
  parallel_blocks(w_i.size(), kBlock, [&](std::size_t first, std::size_t size) {
    source.evaluate_vectors(w_i.subspan(first, size), w_v.subspan(first, size),
                            values.subspan(first * channels, size * channels));
  });
}

}  // namespace sbrdf::internal
