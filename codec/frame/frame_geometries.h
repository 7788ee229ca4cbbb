#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "codec/frame/frame.h"

namespace sbrdf::internal {

/// The paper's frame: (s, u, theta_v, theta_i) with s = phi_i + phi_v and u = phi_i - phi_v. (s, u), (s + 360, u + 360)
/// and (s + 720, u) are the same directions.
[[nodiscard]] const FrameGeometry& elevation_geometry();

/// Rusinkiewicz' angles (phi_h, phi_d, theta_d, theta_h). Reciprocity makes phi_d repeat every 180 degrees. Highlights
/// lie along theta_h = 0, on an axis, whatever their direction.
[[nodiscard]] const FrameGeometry& half_difference_geometry();

// What both have in common.

/// Coordinates that agree to 1e-6 degrees are the same node. Nodes of a list are at least a thousand times as far
/// apart, and what images add to a coordinate by rounding is a million times as small.
inline constexpr double kUnitsPerDegree = 1e6;
/// Coordinates in whole units: comparable and hashable. Degrees of any sign, up to some turns.
[[nodiscard]] inline std::int64_t node_units(double degrees) {
  // Halves away from zero as std::llround, without the call.
  const double scaled = degrees * kUnitsPerDegree;
  return static_cast<std::int64_t>(scaled < 0 ? scaled - 0.5 : scaled + 0.5);
}

/// wrap(), and 0 where rounding left the result just below the period: nodes come from decimal degrees and their sums.
[[nodiscard]] inline double wrap_node(double angle_deg, double period_deg) {
  constexpr double kSnap = 1e-9;
  if (angle_deg >= 0 && period_deg - angle_deg >= kSnap) return angle_deg + 0.0;  // as below, without the calls
  const double wrapped = wrap(angle_deg, period_deg);
  return period_deg - wrapped < kSnap ? 0.0 : wrapped;
}
/// This coordinate is 0 all along the line.
[[nodiscard]] inline bool stays_at_zero(const AffineLine& line, std::size_t axis) {
  return line.slope[axis] == 0 && line.offset[axis] == 0;
}
/// Takes a coordinate that does not matter out of a line, so that all lines that differ in it alone become one.
inline void drop_axis(AffineLine& line, std::size_t axis) {
  line.offset[axis] = 0;
  line.slope[axis] = 0;
}
/// Mirrors the two azimuths: the axial one at shift / 2, the diagonal one at 0. This is what a mirror plane does in
/// both frames: phi -> -phi of both directions negates s, u, phi_h and phi_d; phi -> 180 - phi makes 360 - s of s, 180
/// - phi_h of phi_h, and negates u and phi_d.
[[nodiscard]] inline AffineLine mirror_azimuths(AffineLine line, double axial_shift_deg) {
  line.offset[kAxial] = axial_shift_deg - line.offset[kAxial];
  line.slope[kAxial] = -line.slope[kAxial];
  line.offset[kDiagonal] = -line.offset[kDiagonal];
  line.slope[kDiagonal] = -line.slope[kDiagonal];
  return line;
}

/// From half way to the node before to half way to the node after; at an end of the axis from or to the node itself.
struct ServedRange {
  double begin_deg = 0;
  double end_deg = 0;
};
/// Of the node nearest to `node_deg`; `padded` as in Lattice::nodes.
[[nodiscard]] ServedRange served_range(std::span<const double> padded, double node_deg);

}  // namespace sbrdf::internal
