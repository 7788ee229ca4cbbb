#include "formats/core/directions.h"

#include <cmath>
#include <limits>

namespace sbrdf::internal {

namespace {

constexpr double kTwoPi = 2 * kPi;
/// What the rounding of two azimuths half a turn apart leaves of the cosine of half their difference.
constexpr double kNoise = 4 * std::numeric_limits<double>::epsilon();

/// Takes whole turns off large angles by the library's exact reduction, so that sums of two azimuths stay accurate.
double moderate(double phi) { return std::fabs(phi) <= kTwoPi ? phi : std::atan2(std::sin(phi), std::cos(phi)); }

/// (i + v)/2 and (i - v)/2 as seen after a turn of both by -phi about z.
struct HalfSums {
  double phi;
  glm::dvec3 sum;
  glm::dvec3 difference;
};

// Products of half sums and half differences of the angles rather than sums of vectors: they lose no digits where
// i is close to v, nor where both are near grazing.
HalfSums half_sums(const DirectionPair& pair) {
  const double phi_v = moderate(pair.v.phi);
  const double turn = (moderate(pair.i.phi) - phi_v) / 2;
  const double lean = (pair.i.theta - pair.v.theta) / 2;
  const double theta = pair.v.theta + lean;
  const double sin_theta = std::sin(theta), cos_theta = std::cos(theta);
  const double sin_lean = std::sin(lean), cos_lean = std::cos(lean);
  const double sin_turn = std::sin(turn);
  // Mirrored directions, and opposite ones at grazing, have the normal as half vector; rounding alone would otherwise
  // choose its azimuth.
  const double cos_turn = std::fabs(std::cos(turn)) <= kNoise ? 0 : std::cos(turn);
  return {phi_v + turn,
          {sin_theta * cos_lean * cos_turn, cos_theta * sin_lean * sin_turn, cos_theta * cos_lean},
          {cos_theta * sin_lean * cos_turn, sin_theta * cos_lean * sin_turn, -sin_theta * sin_lean}};
}

double length(const glm::dvec3& w) { return std::sqrt(w.x * w.x + w.y * w.y + w.z * w.z); }

}  // namespace

Direction direction_from_degrees(double theta_deg, double phi_deg) {
  return {radians_from_degrees(theta_deg), wrap(radians_from_degrees(wrap(phi_deg, 360)), kTwoPi)};
}

glm::dvec3 vector_from_direction(const Direction& direction) {
  if (direction.theta == 0) return {0, 0, 1};
  const double radius = std::sin(direction.theta);
  return {radius * std::cos(direction.phi), radius * std::sin(direction.phi), std::cos(direction.theta)};
}

Direction direction_from_vector(const glm::dvec3& w) {
  const double radius = std::hypot(w.x, w.y);
  if (radius == 0) return {std::atan2(0.0, w.z), 0};
  return {std::atan2(radius, w.z), wrap(std::atan2(w.y, w.x), kTwoPi)};
}

HalfDifference half_difference_from_pair(const DirectionPair& pair) {
  const auto [phi, h, d] = half_sums(pair);
  const double radius = std::sqrt(h.x * h.x + h.y * h.y);
  const double h_length = length(h);
  const double d_length = length(d);

  // At the pole phi_h is 0, so the axes of the half vector's frame are turned back by phi.
  const glm::dvec3 axis =
      radius > 0 ? glm::dvec3(h.x / radius, h.y / radius, 0) : glm::dvec3(std::cos(phi), -std::sin(phi), 0);
  const double along = d.x * axis.x + d.y * axis.y;
  const double across = d.y * axis.x - d.x * axis.y;
  const double x = (h.z * along - radius * d.z) / h_length;

  HalfDifference out;
  out.theta_h = std::atan2(radius, h.z);
  out.phi_h = radius > 0 ? wrap(phi + std::atan2(h.y, h.x), kTwoPi) : 0;
  out.theta_d = std::atan2(d_length, h_length);
  out.phi_d = d_length > 0 ? wrap(std::atan2(across, x), kTwoPi) : 0;
  return out;
}

DirectionPair pair_from_half_difference(const HalfDifference& angles) {
  const double sin_h = std::sin(angles.theta_h), cos_h = std::cos(angles.theta_h);
  const double sin_d = std::sin(angles.theta_d), cos_d = std::cos(angles.theta_d);
  const double x = sin_d * std::cos(angles.phi_d), y = sin_d * std::sin(angles.phi_d);
  const auto turned = [&](double side) {
    Direction out =
        direction_from_vector({side * x * cos_h + cos_d * sin_h, side * y, cos_d * cos_h - side * x * sin_h});
    if (out.theta > 0) out.phi = wrap(out.phi + angles.phi_h, kTwoPi);
    return out;
  };
  return {turned(1), turned(-1)};
}

double wrap(double angle, double period) {
  if (angle >= 0 && angle < period) return angle + 0.0;  // what fmod would give, without the call
  double out = std::abs(angle) < period ? angle : std::fmod(angle, period);
  if (out < 0) out += period;
  // A tiny negative angle rounds up to the whole period; adding zero makes +0 of -0.
  return out >= period ? 0.0 : out + 0.0;
}

}  // namespace sbrdf::internal
