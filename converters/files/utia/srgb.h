#pragma once

#include <cmath>

namespace sbrdf::internal {

// The curve of sRGB (IEC 61966-2-1), which goes on beyond 1 by its power and below 0 by its straight line.

/// Of an encoded number, 1 being white.
[[nodiscard]] inline double srgb_decoded(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
/// The inverse.
[[nodiscard]] inline double srgb_encoded(double linear) {
  return linear <= 0.04045 / 12.92 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

}  // namespace sbrdf::internal
