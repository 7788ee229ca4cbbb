#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "converters/baselines/schemes.h"

namespace sbrdf::internal {

/// The numbers of three directions, counterclockwise as seen from outside.
using Triangle = std::array<std::size_t, 3>;

/// The convex hull of a scheme's directions without its base, below the last ring. Of four directions on one circle
/// either pair of triangles may be taken.
[[nodiscard]] std::vector<Triangle> triangulate(const UniformScheme& scheme);

/// Three directions and their weights, which are at least 0 and sum to 1.
struct Place {
  Triangle triangle{};
  std::array<double, 3> weights{};
};

/// Where the ray along `w` meets the triangles; below the last ring the nearest place on its rim.
[[nodiscard]] Place place_of(const glm::dvec3& w, std::span<const glm::dvec3> directions,
                             std::span<const Triangle> triangles);

}  // namespace sbrdf::internal
