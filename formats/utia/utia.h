#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace sbrdf::internal {

/// Directions of a UTIA table (specs/utia.md), the same for light and viewer: theta = 0, step, ... and phi likewise
/// around the full turn. A file has no header, so its size alone says which of the published ones it is.
struct UtiaShape {
  std::uint32_t theta_count = 0;
  std::uint32_t phi_count = 0;
  double theta_step_deg = 0;
  double phi_step_deg = 0;

  bool operator==(const UtiaShape&) const = default;
};
/// theta 0 to 75 degrees, phi 0 to 352.5: 1,990,656 bytes.
inline constexpr UtiaShape kUtiaStandard = {6, 48, 15, 7.5};
/// theta 0 to 86 degrees, phi 0 to 358: 1,505,433,600 bytes.
inline constexpr UtiaShape kUtiaDense = {44, 180, 2, 2};
/// Always R, G, B.
inline constexpr std::size_t kUtiaChannelCount = 3;

/// Directions of the light, and of the viewer.
[[nodiscard]] constexpr std::uint64_t utia_direction_count(const UtiaShape& shape) {
  return std::uint64_t{shape.theta_count} * shape.phi_count;
}
/// Values of one channel.
[[nodiscard]] constexpr std::uint64_t utia_value_count(const UtiaShape& shape) {
  return utia_direction_count(shape) * utia_direction_count(shape);
}
/// Position of a value among all float64 of the file: channels one after the other, in each a row for each direction of
/// the light, in it those of the viewer, phi faster than theta.
[[nodiscard]] constexpr std::uint64_t utia_index(const UtiaShape& shape, std::uint64_t channel, std::uint64_t theta_i,
                                                 std::uint64_t phi_i, std::uint64_t theta_v, std::uint64_t phi_v) {
  const std::uint64_t row = shape.phi_count * theta_i + phi_i;
  const std::uint64_t column = shape.phi_count * theta_v + phi_v;
  return channel * utia_value_count(shape) + utia_direction_count(shape) * row + column;
}
/// Bytes of the file.
[[nodiscard]] constexpr std::uint64_t utia_file_size(const UtiaShape& shape) {
  return kUtiaChannelCount * sizeof(double) * utia_value_count(shape);
}

/// The published shape of a file of this size; nothing for any other size.
[[nodiscard]] std::optional<UtiaShape> utia_shape_of_size(std::uint64_t file_size);

/// Numbers at the beginning of a file by which it is recognised (512 bytes).
inline constexpr std::size_t kUtiaHeadNumbers = 64;

/// Whether numbers look like the first ones of a table: the first eight and three quarters of all are 0, NaN, or of a
/// size between 1e-46 and 1e42. Of eight random bytes one in seven is such a number; the headers of other formats here
/// begin with none.
[[nodiscard]] bool are_utia_numbers(std::span<const double> numbers);

/// The file has the size of a published shape, and begins with numbers that look right.
[[nodiscard]] bool recognises_utia(std::span<const std::byte> head, std::uint64_t file_size);

}  // namespace sbrdf::internal
