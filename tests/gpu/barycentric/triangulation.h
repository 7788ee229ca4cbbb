#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace sbrdf::internal {

/// Directions equally far apart in azimuth, the first at 0.
struct Ring {
  double theta_deg = 0;
  std::size_t count = 1;
};

/// The uniform schemes of Table 1 of the paper that it compares with: 133 and 193 directions, 8,911 and 18,721 pairs.
[[nodiscard]] std::vector<Ring> scheme_14();
[[nodiscard]] std::vector<Ring> scheme_19();

/// The unit vectors of rings that grow in theta, ring by ring.
[[nodiscard]] std::vector<glm::dvec3> ring_directions(std::span<const Ring> rings);

/// The numbers of three directions, counterclockwise as seen from outside.
using Triangle = std::array<std::size_t, 3>;

/// The convex hull of the directions without its base, below the last ring. Of four directions on one circle either
/// pair of triangles may be taken.
[[nodiscard]] std::vector<Triangle> triangulate(std::span<const Ring> rings);

/// Three directions and their weights, which are at least 0 and sum to 1.
struct Place {
  Triangle triangle{};
  std::array<double, 3> weights{};
};

/// Where the ray along `w` meets the triangles; below the last ring the nearest place on its rim.
[[nodiscard]] Place place_of(const glm::dvec3& w, std::span<const glm::dvec3> directions,
                             std::span<const Triangle> triangles);

}  // namespace sbrdf::internal
