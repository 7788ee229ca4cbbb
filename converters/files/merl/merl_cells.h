#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "formats/merl/merl.h"

namespace sbrdf::internal {

/// Largest f_r that a table may hold: weighted sums of such values still fit a float.
inline constexpr double kMerlLargest = 1e38;

/// R, G, B of a cell as on disk, not scaled.
using MerlColour = std::array<double, kMerlChannelCount>;

/// The cells of a table where the bytes of its file lie.
class MerlCells {
 public:
  /// `file` has the size that `head` asks for, and must outlive this.
  MerlCells(const MerlHead& head, const std::byte* file) : head_(head) {
    const std::byte* values = file + kMerlHeaderSize;
    for (std::size_t c = 0; c < planes_.size(); ++c) planes_[c] = values + head.value_size * count() * c;
  }

  [[nodiscard]] const MerlShape& shape() const { return head_.shape; }
  [[nodiscard]] std::size_t value_size() const { return head_.value_size; }
  [[nodiscard]] std::uint64_t count() const { return merl_cell_count(head_.shape); }

  [[nodiscard]] MerlColour colour(std::uint64_t cell) const {
    return value_size() == sizeof(float) ? colour_as<float>(cell) : colour_as<double>(cell);
  }
  /// `T` is the type of value_size().
  template <class T>
  [[nodiscard]] MerlColour colour_as(std::uint64_t cell) const {
    MerlColour colour;
    for (std::size_t c = 0; c < colour.size(); ++c) {
      T value;
      std::memcpy(&value, planes_[c] + sizeof(T) * cell, sizeof value);  // not aligned
      colour[c] = value;
    }
    return colour;
  }
  /// Sends for the values of a cell.
  void fetch(std::uint64_t cell) const {
    for (const std::byte* plane : planes_) __builtin_prefetch(plane + value_size() * cell);
  }

 private:
  MerlHead head_;
  std::array<const std::byte*, kMerlChannelCount> planes_{};
};

/// How many channels of a cell are negative: all of them make a mark.
[[nodiscard]] inline std::size_t merl_negative_channels(const MerlColour& values) {
  return static_cast<std::size_t>(std::count_if(values.begin(), values.end(), [](double value) { return value < 0; }));
}

/// Not so where a value is NaN, infinite, or beyond kMerlLargest once scaled.
[[nodiscard]] inline bool is_finite_merl_value(double value, std::size_t channel) {
  return std::fabs(value * kMerlScale[channel]) <= kMerlLargest;
}

}  // namespace sbrdf::internal
