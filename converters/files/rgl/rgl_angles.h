#pragma once

#include <algorithm>
#include <cmath>

#include "converters/files/rgl/rgl_tables.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {

// Coordinates of the square in which RGL materials keep the half direction (specs/rgl.md, section 3): x of the
// elevation, y of the azimuth, both in [0, 1].

[[nodiscard]] inline double unit_from_theta(double theta) { return std::sqrt(std::min(theta * (2 / kPi), 1.0)); }
[[nodiscard]] inline double theta_from_unit(double x) { return x * x * (kPi / 2); }

/// In [0, 1): whole turns are left out.
[[nodiscard]] inline double unit_from_phi(double phi) {
  const double turns = phi / (2 * kPi) + 0.5;
  return turns - std::floor(turns);
}
[[nodiscard]] inline double phi_from_unit(double y) { return (2 * y - 1) * kPi; }

/// What a light sees of the half direction at a point of the square.
struct RglReflection {
  glm::dvec3 v;            ///< unit vector to where light is reflected; below the horizon where z <= 0
  double cosine = 0;       ///< between light and half direction; below 0 the light does not see it
  double solid_angle = 0;  ///< of directions v for each part of the square [sr]; 0 where `cosine` <= 0
};
[[nodiscard]] inline RglReflection rgl_reflection(const Direction& i, const RglPoint& u_m) {
  const Direction m = {theta_from_unit(u_m.x), phi_from_unit(u_m.y)};
  const glm::dvec3 w_i = vector_from_direction(i);
  const glm::dvec3 w_m = vector_from_direction(m);
  const double cosine = w_i.x * w_m.x + w_i.y * w_m.y + w_i.z * w_m.z;
  // Of half directions a part of the square spans 2 pi^2 x sin(theta_m), and of v 4 cos times as much.
  const double solid_angle = 8 * kPi * kPi * u_m.x * std::sin(m.theta) * std::max(cosine, 0.0);
  return {{2 * cosine * w_m.x - w_i.x, 2 * cosine * w_m.y - w_i.y, 2 * cosine * w_m.z - w_i.z}, cosine, solid_angle};
}

}  // namespace sbrdf::internal
