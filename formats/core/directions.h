#pragma once

#include <glm/vec3.hpp>

namespace sbrdf::internal {

inline constexpr double kPi = 3.141592653589793238462643383279502884;
[[nodiscard]] constexpr double radians_from_degrees(double degrees) { return degrees * (kPi / 180.0); }
[[nodiscard]] constexpr double degrees_from_radians(double radians) { return radians * (180.0 / kPi); }

/// A direction on the upper hemisphere [radians]: `theta` from the normal (+z), in [0, pi/2]; `phi` from the tangent
/// (+x) towards +y, any finite value.
struct Direction {
  double theta = 0;
  double phi = 0;
};

/// Directions to the light (`i`) and to the viewer (`v`).
struct DirectionPair {
  Direction i;
  Direction v;
};

/// Half and difference angles [radians] (Rusinkiewicz, "A New Change of Variables for Efficient BRDF Representation",
/// 1998): `theta_h, phi_h` place the half vector; `theta_d, phi_d` place the light after the half vector was turned
/// to the normal (by -phi_h about z, then by -theta_h about y). phi_h and phi_d are in [0, 2 pi).
struct HalfDifference {
  double theta_h = 0;
  double phi_h = 0;
  double theta_d = 0;
  double phi_d = 0;
};

/// From degrees. Whole turns are taken off `phi_deg` before the conversion, where that is exact: phi and phi + 360 k
/// give the same bits, in [0, 2 pi).
[[nodiscard]] Direction direction_from_degrees(double theta_deg, double phi_deg);

/// Unit vector; exact zeros at the pole.
[[nodiscard]] glm::dvec3 vector_from_direction(const Direction& direction);

/// `w` need not be normalised. theta is accurate to rounding at the pole and at grazing (atan2, not acos); phi is in
/// [0, 2 pi), and 0 at the pole.
[[nodiscard]] Direction direction_from_vector(const glm::dvec3& w);

/// phi_h is 0 where theta_h is 0; phi_d is 0 where theta_d is 0. Accurate for i close to v and for both at grazing.
[[nodiscard]] HalfDifference half_difference_from_pair(const DirectionPair& pair);

/// The inverse. theta_i and theta_v come out beyond pi/2 where the half/difference angles lie below the horizon.
[[nodiscard]] DirectionPair pair_from_half_difference(const HalfDifference& angles);

/// `angle` brought into [0, period) by whole periods; -0 becomes 0. Exact when the result is representable.
[[nodiscard]] double wrap(double angle, double period);

}  // namespace sbrdf::internal
