#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/core/result.h"

// BC6H (BPTC float): blocks of 4 x 4 texels of three half floats each, in 16 bytes, as graphics hardware reads them.
// Defined by the OpenGL extension ARB_texture_compression_bptc and by Direct3D 11; both variants, unsigned (UF16) and
// signed (SF16). A block stores one or two pairs of colours and, for every texel, how far it is between the two.

namespace sbrdf::internal {

/// Bytes of a block.
inline constexpr std::size_t kBc6hBlockSize = 16;
using Bc6hBytes = std::array<std::uint8_t, kBc6hBlockSize>;

/// Texels of a block, row by row: the bits of three halves, R, G, B.
using Bc6hTexels = std::array<std::array<std::uint16_t, 3>, 16>;

/// How much time an encoder may take.
enum class Bc6hSpeed : std::uint8_t {
  kFast,      ///< the few partitions that look best: some 20,000 blocks a second on a core
  kThorough,  ///< all partitions, and more of the best trials improved: a tenth of that
};

/// What an encoder keeps small: the sum of squared differences of what.
enum class Bc6hMetric : std::uint8_t {
  kLog,     ///< of the bits of the halves as whole numbers in order: about of logarithms, as 1024 are a factor of 2
  kLinear,  ///< of the numbers themselves
};

struct Bc6hOptions {
  bool is_signed = false;
  Bc6hSpeed speed = Bc6hSpeed::kThorough;
  Bc6hMetric metric = Bc6hMetric::kLog;
};

/// Any 16 bytes are a block: all texels are 0 in one of a reserved mode, as the specification says. Never NaN or
/// infinite, but for the one pattern of signed blocks that means minus infinity.
[[nodiscard]] Bc6hTexels decode_bc6h_block(std::span<const std::uint8_t, kBc6hBlockSize> bytes, bool is_signed);

/// A block that looks like these texels. What the format cannot hold counts as the nearest that it can: infinities as
/// +-65504, and negative numbers as 0 where there is no sign; NaN counts as 0.
///
/// `weights`: of the error at each texel, at least 0, and 0 for texels that nobody looks at. No randomness, no state:
/// the same block every time.
[[nodiscard]] Bc6hBytes encode_bc6h_block(const Bc6hTexels& texels, const std::array<float, 16>& weights,
                                          const Bc6hOptions& options);
/// The same with equal weights.
[[nodiscard]] Bc6hBytes encode_bc6h_block(const Bc6hTexels& texels, const Bc6hOptions& options);

/// Bytes of an image: its sides are multiples of 4.
[[nodiscard]] constexpr std::uint64_t bc6h_size(std::uint32_t width, std::uint32_t height) {
  return std::uint64_t{width / 4} * (height / 4) * kBc6hBlockSize;
}

/// A whole image as rows of blocks from above, blocks from the left. Numbers become the nearest halves first.
///
/// `rgb`: rows of texels from above, R, G, B of each; width x height x 3 numbers, both sides multiples of 4. `weights`:
/// one for each texel, or none at all. On all cores; the same bytes for any number of threads.
[[nodiscard]] std::vector<std::uint8_t> encode_bc6h(std::uint32_t width, std::uint32_t height,
                                                    std::span<const float> rgb, std::span<const float> weights,
                                                    const Bc6hOptions& options);

/// The way back: rows of texels from above, R, G, B of each.
///
/// kInvalidFile where a side is 0 or no multiple of 4, and where there are more or fewer bytes than blocks need, which
/// is found out before anything is allocated.
[[nodiscard]] Result<std::vector<float>> decode_bc6h(std::uint32_t width, std::uint32_t height,
                                                     std::span<const std::uint8_t> bytes, bool is_signed);

}  // namespace sbrdf::internal
