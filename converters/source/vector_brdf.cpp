#include "converters/source/vector_brdf.h"

namespace sbrdf::internal {

VectorBrdf vector_brdf_of(const BrdfSource& source) {
  return {[&source](std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v, std::span<float> values) {
            source.evaluate_vectors(w_i, w_v, values);
          },
          source.channel_count(), source.traits().isotropic};
}

}  // namespace sbrdf::internal
