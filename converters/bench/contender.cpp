#include "converters/bench/contender.h"

#include <vector>

#include "formats/core/directions.h"

namespace sbrdf::internal {

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
