#pragma once

#include <cstddef>
#include <random>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/core/directions.h"

namespace sbrdf::internal {

/// Pairs of unit vectors.
struct VectorPairs {
  std::vector<glm::vec3> i;
  std::vector<glm::vec3> v;
};

/// Uniform in theta up to 80 degrees and in both azimuths, as held-back directions are.
inline VectorPairs random_vector_pairs(std::size_t count) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> theta(0, radians_from_degrees(80));
  std::uniform_real_distribution<double> phi(0, 2 * kPi);
  const auto direction = [&] {
    const double at = theta(random);
    return glm::vec3(vector_from_direction({at, phi(random)}));
  };
  VectorPairs pairs;
  for (std::size_t k = 0; k < count; ++k) {
    pairs.i.push_back(direction());
    pairs.v.push_back(direction());
  }
  return pairs;
}

}  // namespace sbrdf::internal
