#include "converters/scene/surface.h"

#include <cmath>

#include <glm/geometric.hpp>

#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

constexpr int kSphereParts = 8;  // about the axis, and half as many along it

SurfacePoint on_sphere(const Patch& patch, const glm::dvec2& at) {
  const glm::dvec3& axis = patch.points[1];
  const glm::dvec3& start = patch.points[2];
  const glm::dvec3 side = glm::cross(axis, start);
  SurfacePoint point;
  point.tangent = -std::sin(at.x) * start + std::cos(at.x) * side;
  point.normal = std::cos(at.y) * axis + std::sin(at.y) * (std::cos(at.x) * start + std::sin(at.x) * side);
  point.position = patch.points[0] + patch.radius * point.normal;
  return point;
}

// The side v = const of the square is a line from the first corner to a place between the others.
SurfacePoint on_triangle(const Patch& patch, const glm::dvec2& at) {
  const std::array<double, 3> weights = {1 - at.x, at.x * (1 - at.y), at.x * at.y};
  SurfacePoint point;
  glm::dvec3 normal{0, 0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    point.position += weights[k] * patch.points[k];
    normal += weights[k] * patch.normals[k];
  }
  point.normal = unit_or(normal, patch.normals[0]);
  point.tangent = across(point.normal, patch.tangent);
  return point;
}

}  // namespace

glm::dvec3 SurfacePoint::local(const glm::dvec3& direction) const {
  return {glm::dot(direction, tangent), glm::dot(direction, glm::cross(normal, tangent)), glm::dot(direction, normal)};
}

SurfacePoint Patch::at(double u, double v) const {
  const glm::dvec2 place = first + glm::dvec2(u, v) * (last - first);
  if (kind == Kind::kSphere) return on_sphere(*this, place);
  if (kind == Kind::kTriangle) return on_triangle(*this, place);
  SurfacePoint point;
  point.position = points[0] + place.x * points[1] + place.y * points[2];
  point.normal = normals[0];
  point.tangent = tangent;
  return point;
}

std::array<Patch, 4> Patch::split() const {
  const glm::dvec2 middle = 0.5 * (first + last);
  std::array<Patch, 4> quarters = {*this, *this, *this, *this};
  for (std::size_t k = 0; k < 4; ++k) {
    Patch& quarter = quarters[k];
    ((k & 1U) != 0 ? quarter.first.x : quarter.last.x) = middle.x;
    ((k & 2U) != 0 ? quarter.first.y : quarter.last.y) = middle.y;
  }
  return quarters;
}

glm::dvec3 unit_or(const glm::dvec3& v, const glm::dvec3& otherwise) {
  const double length = glm::length(v);
  return length > 1e-12 && std::isfinite(length) ? v / length : otherwise;
}

glm::dvec3 across(const glm::dvec3& normal, const glm::dvec3& wanted) {
  const glm::dvec3 other = std::abs(normal.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 fallback = glm::normalize(other - glm::dot(other, normal) * normal);
  return unit_or(wanted - glm::dot(wanted, normal) * normal, fallback);
}

std::vector<Patch> plane_patches(const glm::dvec3& center, const glm::dvec3& normal, const glm::dvec3& tangent,
                                 double width, double height) {
  Patch patch;
  patch.normals[0] = normal;
  patch.tangent = across(normal, tangent);
  const glm::dvec3 side = glm::cross(normal, patch.tangent);
  patch.points = {center - 0.5 * width * patch.tangent - 0.5 * height * side, width * patch.tangent, height * side};
  return {patch};
}

std::vector<Patch> sphere_patches(const glm::dvec3& center, double radius, const glm::dvec3& axis) {
  std::vector<Patch> patches;
  Patch patch;
  patch.kind = Patch::Kind::kSphere;
  patch.points = {center, axis, across(axis, {0, 0, 1})};
  patch.radius = radius;
  const double part = 2 * kPi / kSphereParts;
  for (int azimuth = 0; azimuth < kSphereParts; ++azimuth) {
    for (int polar = 0; polar < kSphereParts / 2; ++polar) {
      patch.first = {azimuth * part, polar * part};
      patch.last = {(azimuth + 1) * part, (polar + 1) * part};
      patches.push_back(patch);
    }
  }
  return patches;
}

}  // namespace sbrdf::internal
