#pragma once

#include <array>
#include <cstdint>

namespace sbrdf::internal {

// E5B9G9R9: from the lowest bit on, nine bits each of red, green and blue, and five of an exponent e. A channel with
// the mantissa m is m x 2^(e - 24): there is no hidden bit, and the bias is 15. EXT_texture_shared_exponent,
// section 3.8.x.

/// 511 x 2^(31 - 24)
inline constexpr float kSharedExponentLargest = 65408;

/// The texel for a colour, each channel in [0, kSharedExponentLargest]. The exponent is the least that holds the
/// largest channel, and each mantissa the nearest one, upwards from the middle between two.
[[nodiscard]] std::uint32_t shared_exponent_from_rgb(const std::array<float, 3>& rgb);

/// The colour of any 32 bits, exactly.
[[nodiscard]] std::array<float, 3> rgb_from_shared_exponent(std::uint32_t texel);

}  // namespace sbrdf::internal
