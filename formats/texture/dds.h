#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "formats/core/result.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

// DDS files with the DX10 header (Microsoft, "Programming Guide for DDS") that hold one 2-D texture of one level. Rows
// go down from the top.

/// The bytes of a file: kRgba32f, kE5b9g9r9 and BC6H. kUnsupported for kRgba16f, which two common readers take for
/// something else, and for kRgb32f; errors as of check_texture().
[[nodiscard]] Result<std::vector<std::byte>> write_dds(const Texture& texture);

/// The file begins as a DDS file does.
[[nodiscard]] bool recognises_dds(std::span<const std::byte> head);

/// The texture of a file of the formats that write_dds() writes. Fields that say nothing new, which writers fill in
/// many ways, are not judged: flags, pitch, capabilities, alpha mode.
///
/// kInvalidFile where the file is cut off, goes on behind the texels or contradicts itself; kUnsupported, saying what,
/// for files without a DX10 header, other formats, several levels, layers or faces, and volumes. Both with the offset.
[[nodiscard]] Result<Texture> read_dds(std::span<const std::byte> bytes);

}  // namespace sbrdf::internal
