#pragma once

#include <array>
#include <cstdint>
#include <span>

// BC6H (BPTC float): blocks of 4 x 4 texels of three half floats each, in 16 bytes, as graphics hardware reads them.
// Defined by the OpenGL extension ARB_texture_compression_bptc and by Direct3D 11; both variants, unsigned (UF16) and
// signed (SF16). A block stores one or two pairs of colours and, for every texel, how far it is between the two.

namespace sbrdf::internal {

/// Bytes of a block.
inline constexpr std::size_t kBc6hBlockSize = 16;
using Bc6hBytes = std::array<std::uint8_t, kBc6hBlockSize>;

/// Texels of a block, row by row: the bits of three halves, R, G, B.
using Bc6hTexels = std::array<std::array<std::uint16_t, 3>, 16>;

/// Any 16 bytes are a block: all texels are 0 in one of a reserved mode, as the specification says. Never NaN or
/// infinite, but for the one pattern of signed blocks that means minus infinity.
[[nodiscard]] Bc6hTexels decode_bc6h_block(std::span<const std::uint8_t, kBc6hBlockSize> bytes, bool is_signed);

}  // namespace sbrdf::internal
