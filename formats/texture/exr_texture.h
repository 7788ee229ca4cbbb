#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "formats/core/byte_source.h"
#include "formats/core/result.h"
#include "formats/sbrdf/memory_limit.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

// Textures as plain OpenEXR images of the channels R, G and B, which every image program and engine opens.

/// The bytes of a file, ZIP-compressed without loss: float channels of kRgb32f and kRgba32f, half ones of kRgba16f.
/// Alpha, which is 1, is not written. kUnsupported for other formats; errors as of check_texture().
[[nodiscard]] Result<std::vector<std::byte>> write_exr_texture(const Texture& texture);

/// The texture of an image with the channels R, G and B, all of them half floats (kRgba16f) or floats (kRgb32f).
///
/// Errors as of ExrReader; kUnsupported for other channels, and where unpacking would take more than `limit`.
[[nodiscard]] Result<Texture> read_exr_texture(std::shared_ptr<const ByteSource> bytes, const MemoryLimit& limit = {});

}  // namespace sbrdf::internal
