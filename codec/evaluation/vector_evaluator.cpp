#include "codec/evaluation/vector_evaluator.h"

#include <cassert>

#include "codec/evaluation/simd/kernel.h"

namespace sbrdf::internal {

void VectorEvaluator::evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                               std::span<float> values) const {
  static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
  assert(w_i.size() == w_v.size() && values.size() == w_i.size() * channel_count());
  if (!w_i.empty()) evaluate_vectors(tables_, &w_i.front().x, &w_v.front().x, w_i.size(), values.data());
}

void VectorEvaluator::evaluate_at(const Coordinates& x, std::span<float> values) const {
  const double guide_angle = tables_.guided ? guide_angle_deg(tables_.guide_ratio, x) : 0;
  evaluate_coordinates(tables_, x, guide_angle, values.data());
}

}  // namespace sbrdf::internal
