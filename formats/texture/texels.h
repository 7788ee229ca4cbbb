#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/core/named.h"
#include "formats/core/result.h"
#include "formats/texture/bc6h/bc6h.h"

namespace sbrdf::internal {

// 2-D textures of one level, as renderers upload them: what a texel is, and the bytes of a whole image
// (specs/texture-files.md). ktx2.h, dds.h and exr_texture.h put them into files.

enum class TexelFormat : std::uint8_t {
  kRgb32f,        ///< three floats
  kRgba32f,       ///< three floats and alpha, always 1
  kRgba16f,       ///< three half floats and alpha, always 1
  kE5b9g9r9,      ///< three mantissas with one exponent, no sign: shared_exponent.h
  kBc6hUnsigned,  ///< blocks of 4 x 4 texels in 16 bytes, no sign
  kBc6hSigned,    ///< the same with a sign
};

/// As commands and manifests call them.
inline constexpr std::array kTexelFormatNames = {
    Named{"rgb32f", TexelFormat::kRgb32f},     Named{"rgba32f", TexelFormat::kRgba32f},
    Named{"rgba16f", TexelFormat::kRgba16f},   Named{"e5b9g9r9", TexelFormat::kE5b9g9r9},
    Named{"bc6h", TexelFormat::kBc6hUnsigned}, Named{"bc6h-signed", TexelFormat::kBc6hSigned}};

/// Longest side of a texture that is read or written; graphics cards stop at half of it or before.
inline constexpr std::uint32_t kLongestTextureSide = 65536;

/// Largest number of a format, as a float; its negative is the smallest one, except of kE5b9g9r9 and kBc6hUnsigned,
/// whose smallest is 0.
[[nodiscard]] float largest_texel(TexelFormat format);
[[nodiscard]] bool has_sign(TexelFormat format);

/// What lies together in memory: a texel, or a block of BC6H.
struct TexelBlock {
  std::uint32_t side = 1;   ///< texels along each side
  std::uint32_t bytes = 0;  ///< of all its texels
};
[[nodiscard]] TexelBlock texel_block(TexelFormat format);

struct Texture {
  TexelFormat format = TexelFormat::kRgba32f;
  std::uint32_t width = 0;  ///< texels
  std::uint32_t height = 0;
  /// Rows of texels (of blocks) from the top, each from the left; little-endian, without padding.
  std::vector<std::uint8_t> bytes;
};

/// kUnsupported where a side is 0, longer than kLongestTextureSide, or, with blocks, no multiple of 4.
[[nodiscard]] Status check_texture_sides(TexelFormat format, std::uint32_t width, std::uint32_t height);
/// Bytes of the texels alone. The sides have passed check_texture_sides(), so that nothing wraps.
[[nodiscard]] std::size_t texture_bytes(TexelFormat format, std::uint32_t width, std::uint32_t height);
/// Errors as of check_texture_sides(); kUsage where `bytes` has another size than texture_bytes() says.
[[nodiscard]] Status check_texture(const Texture& texture);

/// How many channels of texels a format could not hold.
struct TexelCounts {
  std::uint64_t clamped = 0;   ///< beyond the largest number in size, infinities too: that number was written
  std::uint64_t negative = 0;  ///< below 0 where the format has no sign: 0 was written
};

/// How blocks of BC6H are found: see Bc6hOptions.
struct BlockEncoding {
  Bc6hSpeed speed = Bc6hSpeed::kThorough;
  Bc6hMetric metric = Bc6hMetric::kLog;
};

/// The texels nearest to given colours: ties to even in half floats, upwards in E5B9G9R9. Every number that is written
/// is finite.
///
/// `rgb`: width x height x 3 numbers, rows from the top, channel fastest. What does not fit is added to `counts`.
/// kInvalidFile, naming the place, where a number is NaN; kUsage where `rgb` has another length; kUnsupported as
/// check_texture_sides().
[[nodiscard]] Result<Texture> encode_texels(TexelFormat format, std::uint32_t width, std::uint32_t height,
                                            std::span<const float> rgb, TexelCounts& counts,
                                            const BlockEncoding& blocks = {});

/// Exactly what the texels say, in the order of `rgb` above; alpha is left out. Errors as of check_texture().
[[nodiscard]] Result<std::vector<float>> decode_texels(const Texture& texture);

}  // namespace sbrdf::internal
