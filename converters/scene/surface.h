#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace sbrdf::internal {

/// Coordinates beyond are refused.
inline constexpr double kFarthest = 1e9;

/// A place on a surface with its frame: unit vectors, the tangent across the normal.
struct SurfacePoint {
  glm::dvec3 position{};
  glm::dvec3 normal{0, 0, 1};
  glm::dvec3 tangent{1, 0, 0};

  /// A direction of the world in this frame, as a BRDF takes it: x along the tangent, z along the normal.
  [[nodiscard]] glm::dvec3 local(const glm::dvec3& direction) const;
};

/// A piece of a surface over the unit square, (u, v): small enough that everything on it turns by less than half a
/// circle.
struct Patch {
  enum class Kind { kPlane, kSphere, kTriangle };
  Kind kind = Kind::kPlane;
  /// Plane: the corner at (0, 0) and both sides. Sphere: centre, axis (a unit vector), a unit vector across it.
  /// Triangle: its corners.
  std::array<glm::dvec3, 3> points{};
  /// Triangle: at its corners, of any length.
  std::array<glm::dvec3, 3> normals{};
  glm::dvec3 tangent{1, 0, 0};  ///< plane and triangle: along it, before the normal's part is taken off
  double radius = 0;            ///< of a sphere
  /// Of a sphere the part: azimuth about the axis from first.x to last.x [radians], angle from the axis from first.y
  /// to last.y. Of others the part of the unit square.
  glm::dvec2 first{0, 0}, last{1, 1};

  /// At (u, v) in [0, 1] of this part.
  [[nodiscard]] SurfacePoint at(double u, double v) const;
  /// The quarters.
  [[nodiscard]] std::array<Patch, 4> split() const;
};

/// A rectangle about `center`, `width` along the tangent.
[[nodiscard]] std::vector<Patch> plane_patches(const glm::dvec3& center, const glm::dvec3& normal,
                                               const glm::dvec3& tangent, double width, double height);
/// Tangents run about the axis.
[[nodiscard]] std::vector<Patch> sphere_patches(const glm::dvec3& center, double radius, const glm::dvec3& axis);

/// `v` of length 1, or `otherwise` where it has none to speak of.
[[nodiscard]] glm::dvec3 unit_or(const glm::dvec3& v, const glm::dvec3& otherwise);
/// A unit vector across a unit vector, as near to `wanted` as can be.
[[nodiscard]] glm::dvec3 across(const glm::dvec3& normal, const glm::dvec3& wanted);

}  // namespace sbrdf::internal
