#include "formats/merl/merl.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {

namespace {

constexpr std::array<const char*, 3> kAxisNames = {"theta_h", "theta_d", "phi_d"};

std::string times(const MerlShape& shape) {
  return std::to_string(shape[0]) + " x " + std::to_string(shape[1]) + " x " + std::to_string(shape[2]);
}

Result<MerlShape> parse_counts(std::span<const std::byte> head) {
  ByteReader in(head);
  const std::array<std::int32_t, 3> counts = {in.i32(), in.i32(), in.i32()};
  if (!in.ok()) {
    Error error = in.error();
    error.message = "MERL header " + error.message;
    return error;
  }
  MerlShape shape{};
  // Compared one by one: a product of three hostile counts can wrap to the right number.
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    if (counts[axis] < 1 || counts[axis] > std::int32_t{kMerlMaxCount}) {
      return invalid_file(std::string("MERL count of ") + kAxisNames[axis] + " is " + std::to_string(counts[axis]) +
                              ", must be 1 to " + std::to_string(kMerlMaxCount),
                          axis * sizeof(std::int32_t));
    }
    shape[axis] = static_cast<std::uint32_t>(counts[axis]);
  }
  return shape;
}

std::uint64_t float32_file_size(const MerlShape& shape) { return merl_file_size(shape, sizeof(float)); }

// Sane counts in the other order, and a size that fits them: too much for chance.
bool is_big_endian(std::span<const std::byte> head, std::uint64_t file_size) {
  if (head.size() < kMerlHeaderSize) return false;
  std::array<std::byte, kMerlHeaderSize> swapped{};
  for (std::size_t k = 0; k < swapped.size(); ++k) swapped[k] = head[k / 4 * 4 + 3 - k % 4];
  const Result<MerlShape> shape = parse_counts(swapped);
  return shape && (file_size == merl_file_size(*shape) || file_size == float32_file_size(*shape));
}

}  // namespace

bool is_sane_merl_shape(const MerlShape& shape) {
  return std::all_of(shape.begin(), shape.end(), [](std::uint32_t n) { return n >= 1 && n <= kMerlMaxCount; });
}

double merl_theta_h_position(double theta_h, std::uint32_t count) { return count * std::sqrt(theta_h / (kPi / 2)); }

Result<MerlShape> parse_merl_shape(std::span<const std::byte> head, std::uint64_t file_size) {
  const Result<MerlShape> shape = parse_counts(head);
  if (!shape && is_big_endian(head, file_size)) {
    return unsupported("a MERL table in big-endian byte order; only little-endian ones can be read", 0);
  }
  if (!shape) return shape.error();
  const std::uint64_t expected = merl_file_size(*shape);
  if (file_size == expected) return shape;
  if (file_size == float32_file_size(*shape)) {
    return unsupported("a MERL table of " + times(*shape) +
                           " cells that has exactly the size of float32 values; only float64 ones can be read",
                       kMerlHeaderSize);
  }
  return invalid_file((file_size < expected ? "truncated MERL file: " : "bytes after the end of the MERL table: ") +
                          times(*shape) + " cells need " + std::to_string(expected) + " bytes, the file has " +
                          std::to_string(file_size),
                      std::min(file_size, expected));
}

Result<MerlHead> parse_merl_head(std::span<const std::byte> head, std::uint64_t file_size) {
  const Result<MerlShape> counts = parse_counts(head);
  if (counts && file_size == float32_file_size(*counts)) return MerlHead{*counts, sizeof(float)};
  const Result<MerlShape> shape = parse_merl_shape(head, file_size);
  if (!shape) return shape.error();
  return MerlHead{*shape, sizeof(double)};
}

bool recognises_merl(std::span<const std::byte> head, std::uint64_t file_size) {
  return parse_merl_shape(head, file_size).ok();
}

bool resembles_merl(std::span<const std::byte> head, std::uint64_t file_size) {
  return parse_counts(head).ok() || is_big_endian(head, file_size);
}

Result<MerlTable> parse_merl(std::span<const std::byte> bytes) {
  const Result<MerlShape> shape = parse_merl_shape(bytes, bytes.size());
  if (!shape) return shape.error();
  MerlTable table;
  table.shape = *shape;
  table.values.resize(kMerlChannelCount * merl_cell_count(*shape));
  const auto block = bytes.subspan(kMerlHeaderSize);
  std::memcpy(table.values.data(), block.data(), block.size());
  return table;
}

std::array<std::byte, kMerlHeaderSize> emit_merl_header(const MerlShape& shape) {
  assert(is_sane_merl_shape(shape));
  std::array<std::byte, kMerlHeaderSize> header{};
  std::memcpy(header.data(), shape.data(), header.size());
  return header;
}

std::vector<std::byte> emit_merl(const MerlTable& table) {
  assert(table.values.size() == kMerlChannelCount * merl_cell_count(table.shape));
  std::vector<std::byte> bytes(merl_file_size(table.shape));
  const auto header = emit_merl_header(table.shape);
  std::memcpy(bytes.data(), header.data(), header.size());
  std::memcpy(bytes.data() + kMerlHeaderSize, table.values.data(), bytes.size() - kMerlHeaderSize);
  return bytes;
}

}  // namespace sbrdf::internal
