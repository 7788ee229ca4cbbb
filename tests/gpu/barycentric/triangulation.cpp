#include "tests/gpu/barycentric/triangulation.h"

#include <algorithm>
#include <limits>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "formats/core/directions.h"

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

std::vector<Ring> scheme_14() { return {{0, 1}, {12, 6}, {24, 10}, {36, 12}, {48, 18}, {60, 20}, {72, 30}, {80, 36}}; }

std::vector<Ring> scheme_19() {
  return {{0, 1}, {10, 6}, {20, 10}, {30, 12}, {40, 18}, {50, 20}, {60, 30}, {70, 36}, {80, 60}};
}

std::vector<glm::dvec3> ring_directions(std::span<const Ring> rings) {
  std::vector<glm::dvec3> directions;
  for (const Ring& ring : rings) {
    for (std::size_t k = 0; k < ring.count; ++k) {
      const double phi_deg = 360.0 * static_cast<double>(k) / static_cast<double>(ring.count);
      directions.push_back(vector_from_direction(direction_from_degrees(ring.theta_deg, phi_deg)));
    }
  }
  return directions;
}

// Any three points with all others on one side; few enough that trying all takes no time.
std::vector<Triangle> triangulate(std::span<const Ring> rings) {
  const std::vector<glm::dvec3> points = moved_apart(ring_directions(rings));
  const std::size_t rim = points.size() - rings.back().count;
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
