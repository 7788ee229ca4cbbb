#include "formats/texture/shared_exponent.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sbrdf::internal {
namespace {

constexpr int kMantissaBits = 9;
constexpr int kBias = 15;
constexpr std::uint32_t kMantissaEnd = 1U << kMantissaBits;

// In double: in float a number just below the middle between two would become the middle.
std::uint32_t mantissa(float value, int exponent) {
  return static_cast<std::uint32_t>(std::floor(std::ldexp(double{value}, kBias + kMantissaBits - exponent) + 0.5));
}

// Before rounding.
int exponent_of(float largest) {
  if (largest <= 0) return 0;
  int exponent = 0;
  std::frexp(largest, &exponent);  // largest < 2^exponent
  return std::max(0, exponent + kBias);
}

}  // namespace

std::uint32_t shared_exponent_from_rgb(const std::array<float, 3>& rgb) {
  const auto [lowest, largest] = std::minmax_element(rgb.begin(), rgb.end());
  assert(*lowest >= 0 && *largest <= kSharedExponentLargest);
  static_cast<void>(lowest);
  int exponent = exponent_of(*largest);
  if (mantissa(*largest, exponent) == kMantissaEnd) ++exponent;
  std::uint32_t texel = static_cast<std::uint32_t>(exponent) << (3 * kMantissaBits);
  for (std::size_t c = 0; c < rgb.size(); ++c) texel |= mantissa(rgb[c], exponent) << (c * kMantissaBits);
  return texel;
}

std::array<float, 3> rgb_from_shared_exponent(std::uint32_t texel) {
  const int exponent = static_cast<int>(texel >> (3 * kMantissaBits));
  std::array<float, 3> rgb{};
  for (std::size_t c = 0; c < rgb.size(); ++c) {
    const auto digits = static_cast<float>(texel >> (c * kMantissaBits) & (kMantissaEnd - 1));
    rgb[c] = std::ldexp(digits, exponent - kBias - kMantissaBits);
  }
  return rgb;
}

}  // namespace sbrdf::internal
