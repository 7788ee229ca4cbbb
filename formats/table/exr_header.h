#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "formats/core/byte_source.h"
#include "formats/core/result.h"
#include "formats/table/exr_image.h"

namespace sbrdf::internal {

/// A header that was looked at before the OpenEXR library sees it: a library that takes sizes on trust allocates what a
/// file of some bytes asks for.
struct ParsedExrHeader {
  ExrHeader header;
  /// All bytes up to the end of the header; the types of attributes that an image does not need begin with '?', so that
  /// the library knows nothing of them and keeps their bytes as they are.
  std::vector<std::byte> plain;
};

/// Longest header that is read [bytes].
inline constexpr std::uint64_t kExrLongestHeader = std::uint64_t{16} << 20U;

/// As ExrReader::open.
[[nodiscard]] Result<ParsedExrHeader> parse_exr_header(const ByteSource& bytes, std::string_view attribute);

}  // namespace sbrdf::internal
