#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace sbrdf::internal {

/// A lower triangular matrix that makes a lobe round: slopes of half vectors are it times stretched ones.
struct Stretch {
  double xx = 1;  ///< above 0
  double yx = 0;
  double yy = 1;  ///< above 0
};

/// Where a direction to the viewer lies, seen from the mirror direction of the light.
struct PolarPlace {
  glm::dvec2 heading = {1, 0};  ///< of the stretched slope: unit vector
  double radius = 0;            ///< q^2 / (1 + q^2), q the length of the stretched slope; in [0, 1)
};

/// All directions to the viewer above the horizon, in polar coordinates about the mirror direction, for one to the
/// light. A half vector h has the slope (h_x, h_y) / h_z. Seen from above, as points of the unit disc, the direction to
/// the viewer lies exactly in the direction of its half vector's slope from the mirror direction, and the further the
/// larger the slope (specs/importance.md). So for each heading the directions above the horizon are those up to one
/// radius, and no mass of a distribution that ends there is lost below the horizon.
///
/// `w_i` is a unit vector with z of at least kLeastHeight.
class MirrorPolar {
 public:
  static constexpr double kLeastHeight = 1e-6;

  MirrorPolar(const glm::dvec3& w_i, const Stretch& stretch) : w_i_(w_i), stretch_(stretch) {}

  /// The radius at which directions meet the horizon, in (0, 1).
  [[nodiscard]] double horizon(const glm::dvec2& heading) const;

  /// Unit vector; at the horizon z is 0 to rounding.
  [[nodiscard]] glm::dvec3 direction(const PolarPlace& place) const;

  /// The inverse, for z above 0.
  [[nodiscard]] PolarPlace place(const glm::dvec3& w_v) const;

  /// d(azimuth) d(radius) / d(solid angle of w_v) at the place of `w_v` [1/sr], azimuth the angle of the heading.
  [[nodiscard]] double density(const glm::dvec3& w_v) const;

 private:
  [[nodiscard]] glm::dvec2 slope(const glm::dvec2& q) const {
    return {stretch_.xx * q.x, stretch_.yx * q.x + stretch_.yy * q.y};
  }
  [[nodiscard]] glm::dvec2 stretched(const glm::dvec2& slope) const {
    const double x = slope.x / stretch_.xx;
    return {x, (slope.y - stretch_.yx * x) / stretch_.yy};
  }

  glm::dvec3 w_i_;
  Stretch stretch_;
};

}  // namespace sbrdf::internal
