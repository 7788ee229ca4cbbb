#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

static_assert(std::endian::native == std::endian::little, "every format here is little-endian; no big-endian port yet");

/// Reads little-endian numbers from a block of bytes, in order. The first read past the end sticks: it and all later
/// reads give zero, and `error()` tells where it happened. One `ok()` check per fixed-size record is enough.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool ok() const { return !failed_; }
  /// Only meaningful after `ok()` turned false: "truncated: N bytes needed, M left", at the offset of the failed read.
  [[nodiscard]] Error error() const {
    return invalid_file(
        "truncated: " + std::to_string(wanted_) + " bytes needed, " + std::to_string(bytes_.size() - offset_) + " left",
        offset_);
  }
  [[nodiscard]] std::size_t offset() const { return offset_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - offset_; }

  template <class T>
  requires std::is_arithmetic_v<T> T number() {
    T value{};
    const std::span<const std::byte> taken = bytes(sizeof(T));
    if (taken.size() == sizeof(T)) std::memcpy(&value, taken.data(), sizeof(T));
    return value;
  }
  std::uint8_t u8() { return number<std::uint8_t>(); }
  std::uint16_t u16() { return number<std::uint16_t>(); }
  std::uint32_t u32() { return number<std::uint32_t>(); }
  std::uint64_t u64() { return number<std::uint64_t>(); }
  std::int32_t i32() { return number<std::int32_t>(); }
  double f64() { return number<double>(); }

  /// An unsigned number below 2^`bits` (at most 63) in groups of seven bits, the lowest first; the top bit of a byte
  /// says that another follows. A larger one, or one with a needless byte, fails as a read past the end does: there is
  /// one way to write each number.
  std::uint64_t count(unsigned bits) {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < bits; shift += 7) {
      const std::uint64_t byte = u8();
      value |= (byte & 0x7FU) << shift;
      if (byte >= 0x80) continue;
      if ((byte == 0 && shift != 0) || value >> bits != 0) break;
      return value;
    }
    if (!failed_) wanted_ = 1;
    failed_ = true;
    return 0;
  }

  /// A count with its sign folded in: 0, 1, 2, 3 ... are 0, -1, 1, -2 ...
  std::int64_t signed_count(unsigned bits) {
    const std::uint64_t folded = count(bits);
    const auto half = static_cast<std::int64_t>(folded / 2);
    return folded % 2 == 0 ? half : -half - 1;
  }

  /// The next `size` bytes, not copied; empty after a short read.
  std::span<const std::byte> bytes(std::uint64_t size) {
    if (failed_ || size > remaining()) {
      if (!failed_) wanted_ = size;
      failed_ = true;
      return {};
    }
    const auto taken = bytes_.subspan(offset_, static_cast<std::size_t>(size));
    offset_ += static_cast<std::size_t>(size);
    return taken;
  }
  std::string text(std::uint64_t size) {
    const auto taken = bytes(size);
    return {reinterpret_cast<const char*>(taken.data()), taken.size()};
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
  std::uint64_t wanted_ = 0;
  bool failed_ = false;
};

/// Appends little-endian numbers and blocks to a growing buffer.
class ByteWriter {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void number(T value) { bytes(std::as_bytes(std::span<const T, 1>(&value, 1))); }
  /// As ByteReader::count() reads it.
  void count(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7U) number(static_cast<std::uint8_t>(value | 0x80U));
    number(static_cast<std::uint8_t>(value));
  }
  /// As ByteReader::signed_count() reads it.
  void signed_count(std::int64_t value) {
    count(value < 0 ? 2 * static_cast<std::uint64_t>(-(value + 1)) + 1 : 2 * static_cast<std::uint64_t>(value));
  }
  void bytes(std::span<const std::byte> block) { buffer_.insert(buffer_.end(), block.begin(), block.end()); }
  void text(std::string_view text) { bytes(std::as_bytes(std::span(text.data(), text.size()))); }
  /// Overwrites a number that was written before, for sizes known only later.
  template <class T>
  requires std::is_arithmetic_v<T>
  void patch(std::size_t offset, T value) { std::memcpy(buffer_.data() + offset, &value, sizeof(T)); }
  [[nodiscard]] std::size_t size() const { return buffer_.size(); }
  [[nodiscard]] std::vector<std::byte> take() && { return std::move(buffer_); }

 private:
  std::vector<std::byte> buffer_;
};

}  // namespace sbrdf::internal
