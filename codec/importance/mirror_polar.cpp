#include "codec/importance/mirror_polar.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace sbrdf::internal {

double MirrorPolar::horizon(const glm::dvec2& heading) const {
  const glm::dvec2 along = slope(heading);
  const double length = glm::length(along);
  // From the mirror direction -w_i on the disc along the slope to the circle: d^2 - 2 b d = w_i.z^2.
  const double b = (w_i_.x * along.x + w_i_.y * along.y) / length;
  const double square_z = w_i_.z * w_i_.z;
  const double root = std::sqrt(b * b + square_z);
  const double distance = b < 0 ? square_z / (root - b) : root + b;
  const double most = distance / (w_i_.z * length);  // stretched: slope = distance / (w_i.z + w_v.z), w_v.z = 0
  return most * most / (1 + most * most);
}

glm::dvec3 MirrorPolar::direction(const PolarPlace& place) const {
  const double length = std::sqrt(place.radius / (1 - place.radius));
  const glm::dvec3 h = glm::normalize(glm::dvec3(slope(length * place.heading), 1));
  return 2 * glm::dot(w_i_, h) * h - w_i_;
}

PolarPlace MirrorPolar::place(const glm::dvec3& w_v) const {
  const glm::dvec2 q = stretched(glm::dvec2(w_i_ + w_v) / (w_i_.z + w_v.z));
  const double square = glm::dot(q, q);
  if (!(square > 0)) return {};
  return {q / std::sqrt(square), square / (1 + square)};
}

// d(azimuth) d(radius) = 2 d(q) / (1 + q^2)^2, d(q) = d(slope) / (xx yy), d(slope) = d(w_h) / cos^3 theta_h, and
// d(w_h) = d(w_v) / (4 w_v.h) (B. Walter, S. Marschner, H. Li, K. Torrance, "Microfacet Models for Refraction through
// Rough Surfaces", 2007, equation 14).
double MirrorPolar::density(const glm::dvec3& w_v) const {
  const glm::dvec3 sum = w_i_ + w_v;
  const double length = glm::length(sum);  // 2 w_v.h
  const glm::dvec2 q = stretched(glm::dvec2(sum) / sum.z);
  const double shrink = 1 + glm::dot(q, q);
  const double cosine = sum.z / length;
  return 1 / (shrink * shrink * stretch_.xx * stretch_.yy * cosine * cosine * cosine * length);
}

}  // namespace sbrdf::internal
