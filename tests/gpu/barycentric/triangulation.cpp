#include "tests/gpu/barycentric/triangulation.h"

#include <algorithm>
#include <limits>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace sbrdf::internal {
namespace {

/// So far out is a direction moved at most, so that no four lie on one circle.
constexpr double kJitter = 1e-6;

std::vector<glm::dvec3> moved_apart(std::vector<glm::dvec3> directions) {
  std::mt19937 random(1);
  for (glm::dvec3& w : directions) w *= 1 + kJitter * static_cast<double>(random()) / 4294967296.0;
  return directions;
}

bool is_facet(const std::vector<glm::dvec3>& points, const Triangle& t) {
  const glm::dvec3 normal = glm::cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
  const double level = glm::dot(normal, points[t[0]]);
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (std::find(t.begin(), t.end(), k) == t.end() && glm::dot(normal, points[k]) > level) return false;
  }
  return true;
}

}  // namespace

// Any three points with all others on one side; few enough that trying all takes no time.
std::vector<Triangle> triangulate(const UniformScheme& scheme) {
  const std::vector<glm::dvec3> points = moved_apart(scheme_directions(scheme));
  const std::size_t rim = points.size() - scheme.rings.back().count;
  std::vector<Triangle> triangles;
  for (std::size_t a = 0; a < rim; ++a) {
    for (std::size_t b = a + 1; b < points.size(); ++b) {
      for (std::size_t c = b + 1; c < points.size(); ++c) {
        if (is_facet(points, {a, b, c})) triangles.push_back({a, b, c});
        if (is_facet(points, {a, c, b})) triangles.push_back({a, c, b});
      }
    }
  }
  return triangles;
}

Place place_of(const glm::dvec3& w, std::span<const glm::dvec3> directions, std::span<const Triangle> triangles) {
  Place best;
  double least_of_best = -std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles) {
    const glm::dvec3& a = directions[t[0]];
    const glm::dvec3& b = directions[t[1]];
    const glm::dvec3& c = directions[t[2]];
    const double volume = glm::dot(a, glm::cross(b, c));
    glm::dvec3 weights(glm::dot(w, glm::cross(b, c)), glm::dot(w, glm::cross(c, a)), glm::dot(w, glm::cross(a, b)));
    weights /= volume;
    const double sum = weights.x + weights.y + weights.z;
    if (sum <= 0) continue;  // behind
    const double least = std::min({weights.x, weights.y, weights.z}) / sum;
    if (least <= least_of_best) continue;
    least_of_best = least;
    weights = glm::max(weights, glm::dvec3(0));
    weights /= weights.x + weights.y + weights.z;
    best = {t, {weights.x, weights.y, weights.z}};
  }
  return best;
}

}  // namespace sbrdf::internal
