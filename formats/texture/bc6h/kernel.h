#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "formats/texture/bc6h/region.h"

// The hot loops of the encoder, compiled once for each set of instructions; the best one of the machine is taken when
// the program runs. All of them give the same bits: nothing is fused, and sums are added up in one order.

namespace sbrdf::internal {

/// Endpoints of a channel.
using Bc6hEnds = std::array<std::int32_t, 2>;

/// The index of the nearest colour for each texel in the order of the region, and the sum of what they are off. The
/// anchor takes one of the lower half.
struct Bc6hMatch {
  float error = 0;
  alignas(32) std::array<std::int32_t, 16> indices{};
};

/// `ends`: of R, G and B.
[[nodiscard]] Bc6hMatch match_bc6h(const Bc6hRegion& region, const Bc6hScale& scale,
                                   const std::array<Bc6hEnds, 3>& ends);

/// What the other two channels are off, by index and texel.
using Bc6hOthers = std::array<Bc6hRow, 16>;
[[nodiscard]] Bc6hOthers other_channels_bc6h(const Bc6hRegion& region, const Bc6hScale& scale,
                                             const std::array<Bc6hEnds, 3>& ends, std::size_t channel);

/// The error of a region for each of several ends of one channel, while the other channels stay.
void channel_errors_bc6h(const Bc6hRegion& region, const Bc6hScale& scale, const Bc6hOthers& others,
                         std::size_t channel, std::span<const Bc6hEnds> ends, std::span<float> errors);

}  // namespace sbrdf::internal
