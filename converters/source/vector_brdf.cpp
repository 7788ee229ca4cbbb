#include "converters/source/vector_brdf.h"

#include <algorithm>
#include <array>
#include <memory>

#include "codec/evaluation/vector_evaluator.h"
#include "codec/file/encoder.h"

namespace sbrdf::internal {

VectorBrdf vector_brdf_of(const BrdfSource& source) {
  const std::size_t channels = source.channel_count();
  const bool isotropic = source.traits().isotropic;
  if (const DecodedSliced* slices = source.sliced()) {
    const auto evaluator = std::make_shared<const VectorEvaluator>(slices->sliced, slices->lattice);
    return {[evaluator](std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v, std::span<float> values) {
              evaluator->evaluate(w_i, w_v, values);
            },
            channels, isotropic};
  }
  const auto evaluate = [&source, channels](std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                            std::span<float> values) {
    std::array<DirectionPair, 64> pairs;
    for (std::size_t first = 0; first < w_i.size(); first += pairs.size()) {
      const std::size_t size = std::min(pairs.size(), w_i.size() - first);
      for (std::size_t k = 0; k < size; ++k) {
        pairs[k] = {direction_from_vector(glm::dvec3(w_i[first + k])),
                    direction_from_vector(glm::dvec3(w_v[first + k]))};
      }
      source.evaluate(std::span(pairs).first(size), values.subspan(first * channels, size * channels));
    }
  };
  return {evaluate, channels, isotropic};
}

}  // namespace sbrdf::internal
