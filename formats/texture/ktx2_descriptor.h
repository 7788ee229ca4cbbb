#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/texture/ktx2.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

// How KTX2 names and describes the formats of texels: VkFormat numbers, and the descriptors of the Khronos Data Format
// Specification 1.3.

struct Ktx2Format {
  TexelFormat format;
  std::uint32_t vk_format;  ///< VkFormat of Vulkan
  std::uint32_t type_size;  ///< bytes of what is swapped on big-endian machines; 1 of blocks
};

/// Nothing for kRgb32f, which graphics cards do not take.
[[nodiscard]] std::optional<Ktx2Format> ktx2_format_of(TexelFormat format);
/// Nothing for those that are not written here.
[[nodiscard]] std::optional<Ktx2Format> ktx2_format_of_number(std::uint32_t vk_format);

struct Ktx2CubeFormat {
  std::uint32_t vk_format;
  std::uint32_t type_size;
  std::uint32_t texel_bytes;
};
[[nodiscard]] Ktx2CubeFormat ktx2_format_of(CubeTexture::Texel texel);
[[nodiscard]] std::vector<std::byte> ktx2_descriptor(CubeTexture::Texel texel);

/// The Data Format Descriptor, its total size first: one basic block with linear BT.709 colours. kRgb32f has none.
///
/// Shared exponents are described as the specification does: each channel by its mantissa and, again, the exponent,
/// with a bias of 15; its `sampleUpper` of 8448 is the table's.
[[nodiscard]] std::vector<std::byte> ktx2_descriptor(TexelFormat format);

}  // namespace sbrdf::internal
