#include "converters/bench/contender.h"

#include <algorithm>
#include <array>
#include <vector>

#include "formats/core/directions.h"

namespace sbrdf::internal {

void evaluate_vectors(const BrdfSource& source, std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                      std::span<float> values) {
  constexpr std::size_t kBlock = 64;
  const std::size_t channels = source.channel_count();
  std::array<DirectionPair, kBlock> pairs;
  for (std::size_t first = 0; first < w_i.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, w_i.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      pairs[k] = {direction_from_vector(glm::dvec3(w_i[first + k])), direction_from_vector(glm::dvec3(w_v[first + k]))};
    }
    source.evaluate(std::span(pairs).first(count), values.subspan(first * channels, count * channels));
  }
}

ContenderSource::ContenderSource(const Contender& contender, const BrdfSource& reference) : contender_(contender) {
  traits_.format = "contender";
  traits_.channels = reference.traits().channels;
  traits_.reciprocal = contender.is_reciprocal();
}

void ContenderSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  std::vector<glm::vec3> w_i;
  std::vector<glm::vec3> w_v;
  for (const DirectionPair& pair : pairs) {
    w_i.emplace_back(vector_from_direction(pair.i));
    w_v.emplace_back(vector_from_direction(pair.v));
  }
  contender_.evaluate(w_i, w_v, values);
}

}  // namespace sbrdf::internal
