#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "converters/baselines/schemes.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// The numbers of three directions, counterclockwise as seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

/// Three directions and their weights, which are at least 0 and sum to 1.
struct Place {
  Triangle triangle{};
  std::array<double, 3> weights{};
};

/// The spherical Delaunay triangulation of a scheme's directions: their convex hull without its base, which lies below
/// the last ring. Of four directions on one circle either pair of triangles may be taken. Immutable after construction.
class Triangulation {
 public:
  /// kUnsupported where the scheme is the normal alone; where some directions lie outside the polygon of the last ring,
  /// as that one has too few; and where directions lie so near to each other that double precision loses them.
  [[nodiscard]] static Result<Triangulation> make(const UniformScheme& scheme);

  [[nodiscard]] std::span<const glm::dvec3> directions() const { return directions_; }
  [[nodiscard]] std::span<const Triangle> triangles() const { return triangles_; }

  /// Where the ray along `w`, of any length but 0, meets the triangles, with barycentric weights there. Below the rim,
  /// which is the polygon of the last ring, the place on the rim at the same azimuth.
  [[nodiscard]] Place place_of(const glm::dvec3& w) const;

 private:
  Triangulation() = default;
  void find_neighbours();
  void find_starts();
  [[nodiscard]] bool meets_all_directions() const;
  [[nodiscard]] std::uint32_t walk(std::uint32_t from, const glm::dvec3& w, glm::dvec3& weights) const;
  [[nodiscard]] Place place_on_rim(const glm::dvec3& w) const;

  std::vector<glm::dvec3> directions_;
  std::uint32_t rim_ = 0;  ///< number of the first direction of the last ring
  std::vector<Triangle> triangles_;
  /// Of each triangle the one beyond the side that lies across from each of its directions.
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<glm::dmat3> weights_of_;  ///< of each triangle: weights, not yet of sum 1, are this times w
  std::vector<std::uint32_t> starts_;   ///< a triangle in or near each cell of a grid over x and y
};

}  // namespace sbrdf::internal
