#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

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

/// The yardstick: what a renderer does with a MERL file. Channel by channel, as the file has it.
class YardstickTable {
 public:
  YardstickTable() : values_(3 * kPlane) {
    for (std::size_t k = 0; k < values_.size(); ++k) values_[k] = 1.0 / static_cast<double>(1 + k % 97);
  }

  [[nodiscard]] glm::vec3 look_up(const glm::vec3& i, const glm::vec3& v) const {
    const glm::vec3 h = glm::normalize(i + v);
    const float theta_h = std::acos(std::min(h.z, 1.0F));
    const float theta_d = std::acos(std::min(glm::dot(h, i), 1.0F));
    const float phi_h = std::atan2(h.y, h.x);
    const float cos_h = std::cos(phi_h), sin_h = std::sin(phi_h);
    const float along = cos_h * i.x + sin_h * i.y, across = cos_h * i.y - sin_h * i.x;
    float phi_d = std::atan2(across, along * h.z - i.z * std::sqrt(h.x * h.x + h.y * h.y));
    if (phi_d < 0) phi_d += static_cast<float>(kPi);
    const std::array<float, 3> at = {std::sqrt(theta_h / static_cast<float>(kPi / 2)) * 90,
                                     theta_d / static_cast<float>(kPi / 2) * 90, phi_d / static_cast<float>(kPi) * 180};
    const std::array<std::size_t, 3> counts = {90, 90, 180};
    std::array<std::size_t, 3> low;
    std::array<std::size_t, 3> high;
    std::array<float, 3> t;
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(static_cast<std::size_t>(at[a]), counts[a] - 1);
      high[a] = std::min(low[a] + 1, counts[a] - 1);
      t[a] = std::min(at[a] - static_cast<float>(low[a]), 1.0F);
    }
    glm::vec3 sum(0);
    for (unsigned corner = 0; corner < 8; ++corner) {
      float weight = 1;
      std::array<std::size_t, 3> index;
      for (unsigned a = 0; a < 3; ++a) {
        const bool far = (corner >> a & 1U) != 0;
        index[a] = far ? high[a] : low[a];
        weight *= far ? t[a] : 1 - t[a];
      }
      const std::size_t cell = index[2] + 180 * (index[1] + 90 * index[0]);
      for (int c = 0; c < 3; ++c)
        sum[c] += weight * static_cast<float>(values_[cell + static_cast<std::size_t>(c) * kPlane]);
    }
    return sum;
  }

 private:
  static constexpr std::size_t kPlane = std::size_t{90} * 90 * 180;
  std::vector<double> values_;
};

}  // namespace sbrdf::internal
