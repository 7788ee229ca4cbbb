#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "codec/frame/frame.h"

namespace sbrdf::internal {

// Coordinates as whole numbers, which the kernel of the evaluator works with. A *turn* is a coordinate in 2^-32 of the
// longest period of its frame, so that a sum of azimuths wraps by itself; polar angles are counted likewise, with 90
// degrees for the period. A *place* lies along a slice, an axis or a ring, in 2^-31 of its length: where that is a
// whole period, of half of it between mirrors, a turn is two places or less. Both are at most 3.4e-7 degrees.

/// The last place of all, and what stands behind the last place of a list, so that nothing is found after it.
inline constexpr std::int32_t kLastPlace = 0x7FFFFFFE;
inline constexpr std::int32_t kBeyond = 0x7FFFFFFF;
/// Widths of segments are counted in so many places where slopes are concerned: about a degree, so that slopes keep
/// their exponents.
inline constexpr float kWidthUnit = 8388608.0F;

/// The longest period of an azimuth [degrees].
[[nodiscard]] constexpr double longest_period_deg(FrameId frame) {
  return frame == FrameId::kElevation ? 720.0 : 360.0;
}

/// Log2 of how often a shorter period goes into the longest: all are halves of it, quarters, and so on.
[[nodiscard]] inline std::uint32_t periods_log2(double longest_deg, double period_deg) {
  const auto shift = static_cast<std::uint32_t>(std::lround(std::log2(longest_deg / period_deg)));
  assert(std::abs(std::ldexp(period_deg, static_cast<int>(shift)) - longest_deg) < 1e-6);
  return shift;
}

/// The turn of a polar angle in [0, 90] [degrees].
inline constexpr double kTurnsPerPolarDegree = 4294967296.0 / 90.0;
[[nodiscard]] inline std::uint32_t polar_turn(double degrees) {
  return static_cast<std::uint32_t>(std::min(degrees * kTurnsPerPolarDegree + 0.5, 4294967295.0));
}

/// The turn of an azimuth [degrees] of any sign, up to some thousand periods.
[[nodiscard]] inline std::uint32_t azimuth_turn(double degrees, double longest_deg) {
  return static_cast<std::uint32_t>(
      static_cast<std::int64_t>(std::floor(degrees * (4294967296.0 / longest_deg) + 0.5)));
}

/// How an angle [degrees] becomes a turn in vectors of doubles: round(angle scale + bias), as a signed number whose
/// bits are then exchanged with flip. So azimuths may be negative, and a polar angle uses all bits.
struct TurnRule {
  double scale = 0;
  double bias = 0;
  std::int32_t flip = 0;
};
[[nodiscard]] inline TurnRule turn_rule(FrameId frame, std::size_t axis) {
  if (axis == kAxial || axis == kDiagonal) return {4294967296.0 / longest_period_deg(frame), 0, 0};
  return {kTurnsPerPolarDegree, -2147483648.0, std::numeric_limits<std::int32_t>::min()};
}

/// The place of a turn on a list that spans the longest period.
[[nodiscard]] inline std::int32_t place_of_turn(std::uint32_t turn) {
  return std::min(static_cast<std::int32_t>(turn >> 1U), kLastPlace);
}

/// The place of a polar angle in [0, 90] [degrees].
[[nodiscard]] inline std::int32_t polar_place(double degrees) { return place_of_turn(polar_turn(degrees)); }

}  // namespace sbrdf::internal
