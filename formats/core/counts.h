#pragma once

#include <cstdint>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {

// Counts of specs/sbrdf.md: seven bits a byte, the lowest first; the top bit says that more follow.

inline void put_count(ByteWriter& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7U) out.number(static_cast<std::uint8_t>(value | 0x80U));
  out.number(static_cast<std::uint8_t>(value));
}

/// At most five bytes, 2^32 - 1; larger ones, and those with a needless byte, fail the reader as a read past the end
/// does.
inline std::uint32_t take_count(ByteReader& in) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 35; shift += 7) {
    const std::uint8_t byte = in.u8();
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if ((byte & 0x80U) == 0) {
      // One way to write each number.
      if ((shift > 0 && byte == 0) || value > 0xFFFFFFFFU) break;
      return static_cast<std::uint32_t>(value);
    }
  }
  in.bytes(in.remaining() + 1);
  return 0;
}

}  // namespace sbrdf::internal
