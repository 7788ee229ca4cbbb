#pragma once

#include <cstdint>

namespace sbrdf::internal {

// Half floats (IEEE 754 binary16): 11 bits of precision, 6e-8 to 65504. Conversions are those of Imath.

/// Largest finite half float.
inline constexpr double kHalfLargest = 65504;

/// The number with these bits; NaN and infinities included.
[[nodiscard]] float float_from_half(std::uint16_t bits);
/// The bits of the half float next to a number: ties to the even one, infinite beyond 65520.
[[nodiscard]] std::uint16_t half_from_float(float value);

}  // namespace sbrdf::internal
