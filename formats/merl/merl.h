#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/core/directions.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Cells along theta_h, theta_d and phi_d.
using MerlShape = std::array<std::uint32_t, 3>;

/// What every published file has.
inline constexpr MerlShape kMerlShape = {90, 90, 180};
/// Largest count along one axis that is read or written; larger tables exist, but none near this.
inline constexpr std::uint32_t kMerlMaxCount = 4096;
/// Always R, G, B.
inline constexpr std::size_t kMerlChannelCount = 3;
/// f_r [1/sr] = value on disk x scale of its channel.
inline constexpr std::array<double, kMerlChannelCount> kMerlScale = {1.00 / 1500, 1.15 / 1500, 1.66 / 1500};
/// Three int32 counts.
inline constexpr std::size_t kMerlHeaderSize = 12;

/// An isotropic table in half and difference angles (specs/merl.md).
struct MerlTable {
  MerlShape shape = {0, 0, 0};
  /// As on disk: planar R, G, B, phi_d fastest and theta_h slowest within a channel, not scaled. Any bit pattern.
  std::vector<double> values;
};

/// Cells of one channel.
[[nodiscard]] constexpr std::uint64_t merl_cell_count(const MerlShape& shape) {
  return std::uint64_t{shape[0]} * shape[1] * shape[2];
}
/// Position of a cell within its channel; add `channel * merl_cell_count(shape)` for its place in `values`.
[[nodiscard]] constexpr std::uint64_t merl_cell_index(const MerlShape& shape, std::uint64_t theta_h_index,
                                                      std::uint64_t theta_d_index, std::uint64_t phi_d_index) {
  return phi_d_index + shape[2] * (theta_d_index + shape[1] * theta_h_index);
}
/// Bytes of the file. Cannot wrap for counts up to kMerlMaxCount.
[[nodiscard]] constexpr std::uint64_t merl_file_size(const MerlShape& shape, std::size_t value_size = sizeof(double)) {
  return kMerlHeaderSize + kMerlChannelCount * value_size * merl_cell_count(shape);
}
/// Every count is in [1, kMerlMaxCount].
[[nodiscard]] bool is_sane_merl_shape(const MerlShape& shape);

/// Angles [radians] at a position along an axis of `count` cells. A position is the cell's index at its lower edge and
/// index + 0.5 at its centre. theta_h grows with the square of the position, so that cells are narrow at the highlight.
[[nodiscard]] constexpr double merl_theta_h(double position, std::uint32_t count) {
  return position / count * (position / count) * (kPi / 2);
}
[[nodiscard]] constexpr double merl_theta_d(double position, std::uint32_t count) {
  return position / count * (kPi / 2);
}
[[nodiscard]] constexpr double merl_phi_d(double position, std::uint32_t count) { return position / count * kPi; }
/// The inverse of merl_theta_h, for theta_h in [0, pi/2].
[[nodiscard]] double merl_theta_h_position(double theta_h, std::uint32_t count);

/// What a header and the size of a file tell.
struct MerlHead {
  MerlShape shape = {0, 0, 0};
  std::size_t value_size = sizeof(double);  ///< bytes of a number: 8, or 4 of a table that an array library saved
};

/// The head of a table of either kind of number; errors as of parse_merl_shape.
[[nodiscard]] Result<MerlHead> parse_merl_head(std::span<const std::byte> head, std::uint64_t file_size);

/// The shape of a table of 64-bit floats, from the first bytes of a file (kMerlHeaderSize suffice) and its whole size.
/// kInvalidFile where the header is cut off, where a count is outside [1, kMerlMaxCount], or where the size is not
/// exactly that of the shape; kUnsupported, saying so, where the size is that of 32-bit floats or the counts make sense
/// as big-endian ones.
[[nodiscard]] Result<MerlShape> parse_merl_shape(std::span<const std::byte> head, std::uint64_t file_size);

/// The file is a whole MERL table of 64-bit floats: parse_merl_shape takes it.
[[nodiscard]] bool recognises_merl(std::span<const std::byte> head, std::uint64_t file_size);

/// The file begins as a MERL table does but may have another size, or is one in big-endian order. Text and the other
/// formats here do not begin so. Where no format recognises a file, this one's error is the one to give: it tells how
/// many bytes are missing, or what was meant.
[[nodiscard]] bool resembles_merl(std::span<const std::byte> head, std::uint64_t file_size);

/// The bytes of a whole file. Errors as of parse_merl_shape; nothing is allocated before. The values are not judged.
/// Large tables need not be copied: parse_merl_shape and a view of the file do.
Result<MerlTable> parse_merl(std::span<const std::byte> bytes);

/// What a file begins with; the values follow.
[[nodiscard]] std::array<std::byte, kMerlHeaderSize> emit_merl_header(const MerlShape& shape);

/// The inverse of parse_merl, bit for bit. `values` must have the length that `shape` asks for.
[[nodiscard]] std::vector<std::byte> emit_merl(const MerlTable& table);

}  // namespace sbrdf::internal
