#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "formats/core/directions.h"
#include "formats/core/half.h"

namespace sbrdf::internal {

// What everything else is measured against in the same run, so that figures are ratios and mean much the same on
// another machine: a plain look-up in a table, and how fast memory is. The table needs nothing but this header.

/// The bits of a half float, as a number of a table.
struct HalfNumber {
  std::uint16_t bits = 0;
};
[[nodiscard]] inline float as_float(double number) { return static_cast<float>(number); }
[[nodiscard]] inline float as_float(HalfNumber number) { return float_from_half(number.bits); }

/// What a renderer does with a MERL file in fifteen lines: from two unit vectors to half and difference angles, then
/// linear between the eight cells around, channel by channel as the file has them. Cells hold the value at the lower
/// edge of each axis. Nothing is done about marks, nor about phi_d closing after half a turn.
template <class Number>
class TrilinearTable {
 public:
  static constexpr std::array<std::size_t, 3> kCounts = {90, 90, 180};  ///< along theta_h, theta_d, phi_d
  static constexpr std::size_t kCells = kCounts[0] * kCounts[1] * kCounts[2];

  /// 3 x kCells numbers: f_r [1/sr] of the first channel, phi_d fastest, then the others.
  explicit TrilinearTable(std::vector<Number> numbers) : numbers_(std::move(numbers)) {}

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
    std::array<std::size_t, 3> low;
    std::array<std::size_t, 3> high;
    std::array<float, 3> t;
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(static_cast<std::size_t>(at[a]), kCounts[a] - 1);
      high[a] = std::min(low[a] + 1, kCounts[a] - 1);
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
      const std::size_t cell = index[2] + kCounts[2] * (index[1] + kCounts[1] * index[0]);
      for (int c = 0; c < 3; ++c) {
        sum[c] += weight * as_float(numbers_[cell + static_cast<std::size_t>(c) * kCells]);
      }
    }
    return sum;
  }

 private:
  std::vector<Number> numbers_;
};

/// The yardstick: a table of 64-bit numbers, whatever they are.
[[nodiscard]] inline TrilinearTable<double> make_yardstick() {
  std::vector<double> numbers(3 * TrilinearTable<double>::kCells);
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = 1.0 / static_cast<double>(1 + k % 97);
  return TrilinearTable<double>(std::move(numbers));
}

/// How fast one core reads and copies what no cache holds.
struct MemorySpeed {
  std::uint64_t array_bytes = 0;  ///< of each array that was gone through
  double read_gb_per_s = 0;       ///< 10^9 bytes that are added up
  double copy_gb_per_s = 0;       ///< 10^9 bytes that are read, as many being written
};

}  // namespace sbrdf::internal
