#include "formats/merl/merl.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "formats/core/byte_reader.h"

namespace sbrdf {

namespace {

constexpr std::array<const char*, 3> kAxisNames = {"theta_h", "theta_d", "phi_d"};

std::string times(const MerlShape& shape) {
  return std::to_string(shape[0]) + " x " + std::to_string(shape[1]) + " x " + std::to_string(shape[2]);
}

Result<MerlShape> parse_shape(ByteReader& in) {
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

}  // namespace

bool is_sane_merl_shape(const MerlShape& shape) {
  return std::all_of(shape.begin(), shape.end(), [](std::uint32_t n) { return n >= 1 && n <= kMerlMaxCount; });
}

double merl_theta_h_position(double theta_h, std::uint32_t count) { return count * std::sqrt(theta_h / (kPi / 2)); }

bool recognises_merl(std::span<const std::byte> head, std::uint64_t total_size) {
  ByteReader in(head);
  const Result<MerlShape> shape = parse_shape(in);
  return shape.ok() && merl_file_size(*shape) == total_size;
}

bool resembles_merl(std::span<const std::byte> head) {
  ByteReader in(head);
  return parse_shape(in).ok();
}

Result<MerlTable> parse_merl(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  const Result<MerlShape> shape = parse_shape(in);
  if (!shape) return shape.error();
  const std::uint64_t expected = merl_file_size(*shape);
  if (bytes.size() != expected) {
    return invalid_file(
        (bytes.size() < expected ? "truncated MERL file: " : "bytes after the end of the MERL table: ") +
            times(*shape) + " cells need " + std::to_string(expected) + " bytes, the file has " +
            std::to_string(bytes.size()),
        std::min<std::uint64_t>(bytes.size(), expected));
  }
  MerlTable table;
  table.shape = *shape;
  table.values.resize(kMerlChannelCount * merl_cell_count(*shape));
  const auto block = in.bytes(in.remaining());
  std::memcpy(table.values.data(), block.data(), block.size());
  return table;
}

std::vector<std::byte> emit_merl(const MerlTable& table) {
  assert(is_sane_merl_shape(table.shape));
  assert(table.values.size() == kMerlChannelCount * merl_cell_count(table.shape));
  std::vector<std::byte> bytes(merl_file_size(table.shape));
  std::memcpy(bytes.data(), table.shape.data(), kMerlHeaderSize);
  std::memcpy(bytes.data() + kMerlHeaderSize, table.values.data(), bytes.size() - kMerlHeaderSize);
  return bytes;
}

}  // namespace sbrdf
