#pragma once

#include "codec/atlas/atlas.h"

namespace sbrdf::internal {

/// Which part of the numbers a texel format can hold is used, so that its steps are small beside what is stored.
enum class TexelRange : std::uint8_t {
  kAsIs,      ///< float32: texels are values of the value domain
  kSigned,    ///< from -1 to 1: half floats
  kUnsigned,  ///< from 0 to 1: shared exponents
  kBlocks,    ///< from kLeastInBlocks to 1: BC6H, between whose colours half floats lie evenly by their bits
};

inline constexpr float kLeastInBlocks = 0.25F;

/// Brings the texels of a freshly baked atlas into a range: each tile of the primary table and of tables with few,
/// other tables as a whole, per channel; with kSigned all tables as a whole, since half floats are fine enough, and
/// shaders look up no scales. Values stay what they were but for rounding.
void use_range(Atlas& atlas, TexelRange range);

}  // namespace sbrdf::internal
