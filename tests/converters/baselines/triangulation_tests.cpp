#include "converters/baselines/triangulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

std::vector<UniformScheme> all_schemes() {
  std::vector<UniformScheme> schemes = paper_schemes();
  schemes.push_back({"few", {{0, 1}, {89, 3}}});
  schemes.push_back({"near the normal", {{0, 1}, {0.01, 5}, {0.02, 5}, {60, 4}}});
  schemes.push_back({"odd", {{0, 1}, {20, 7}, {33.3, 3}, {70, 11}, {71, 100}}});
  return schemes;
}

glm::dvec3 draw_above(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const glm::dvec3 w = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
  return {w.x, w.y, std::abs(w.z)};
}

TEST(Triangulation, HasTheTrianglesOfThePapersSchemes) {
  EXPECT_EQ(Triangulation::make(paper_scheme("14").value()).value().triangles().size(), 228U);
  EXPECT_EQ(Triangulation::make(paper_scheme("19").value()).value().triangles().size(), 324U);
}

// Euler's formula for a disc: with n points, h of them on the rim, 2 n - h - 2 triangles.
TEST(Triangulation, CoversADiscWithEveryDirectionOnce) {
  for (const UniformScheme& scheme : all_schemes()) {
    const Triangulation made = Triangulation::make(scheme).value();
    const std::size_t count = scheme.direction_count();
    ASSERT_EQ(made.triangles().size(), 2 * count - scheme.rings.back().count - 2) << scheme.name;
    std::set<std::uint32_t> used;
    for (const Triangle& t : made.triangles()) used.insert(t.begin(), t.end());
    ASSERT_EQ(used.size(), count) << scheme.name;
  }
}

// No direction lies beyond the plane of a triangle, that is within the circle through its corners.
TEST(Triangulation, IsDelaunay) {
  for (const UniformScheme& scheme : all_schemes()) {
    const Triangulation made = Triangulation::make(scheme).value();
    const auto w = made.directions();
    for (const Triangle& t : made.triangles()) {
      const glm::dvec3 normal = glm::normalize(glm::cross(w[t[1]] - w[t[0]], w[t[2]] - w[t[0]]));
      const double level = glm::dot(normal, w[t[0]]);
      ASSERT_GT(glm::dot(normal, w[t[0]] + w[t[1]] + w[t[2]]), 0) << scheme.name << ": counterclockwise from outside";
      for (const glm::dvec3& other : w) ASSERT_LE(glm::dot(normal, other), level + 1e-9) << scheme.name;
    }
  }
}

// Against trying all triangles.
TEST(Triangulation, FindsTheTriangleOfADirection) {
  std::mt19937 random(3);
  for (const UniformScheme& scheme : all_schemes()) {
    const Triangulation made = Triangulation::make(scheme).value();
    const auto w = made.directions();
    for (int trial = 0; trial < 300; ++trial) {
      const glm::dvec3 asked = draw_above(random);
      double least_of_best = -std::numeric_limits<double>::infinity();
      for (const Triangle& t : made.triangles()) {
        const double volume = glm::dot(w[t[0]], glm::cross(w[t[1]], w[t[2]]));
        const double least =
            std::min({glm::dot(asked, glm::cross(w[t[1]], w[t[2]])), glm::dot(asked, glm::cross(w[t[2]], w[t[0]])),
                      glm::dot(asked, glm::cross(w[t[0]], w[t[1]]))}) /
            volume;
        least_of_best = std::max(least_of_best, least);
      }
      const Place place = made.place_of(3.0 * asked);  // of any length
      glm::dvec3 met(0);
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_GE(place.weights[k], 0);
        met += place.weights[k] * w[place.triangle[k]];
        sum += place.weights[k];
      }
      ASSERT_NEAR(sum, 1, 1e-12);
      if (least_of_best > 1e-9) {
        ASSERT_LT(glm::length(glm::normalize(met) - asked), 1e-9) << scheme.name;
      } else if (least_of_best < -1e-9) {  // below the rim: the same azimuth, on the last ring
        ASSERT_LT(std::abs(met.x * asked.y - met.y * asked.x), 1e-9) << scheme.name;
        ASSERT_GT(met.x * asked.x + met.y * asked.y, 0) << scheme.name;
        ASSERT_NEAR(met.z, std::cos(radians_from_degrees(scheme.rings.back().theta_deg)), 1e-9) << scheme.name;
      }
    }
  }
}

TEST(Triangulation, MeetsItsDirectionsWhole) {
  for (const UniformScheme& scheme : all_schemes()) {
    const Triangulation made = Triangulation::make(scheme).value();
    for (std::uint32_t k = 0; k < made.directions().size(); ++k) {
      const Place place = made.place_of(made.directions()[k]);
      double weight = 0;
      for (std::size_t c = 0; c < 3; ++c) weight += place.triangle[c] == k ? place.weights[c] : 0;
      ASSERT_NEAR(weight, 1, 1e-9) << scheme.name << " direction " << k;
    }
  }
}

TEST(Triangulation, RefusesWhatItCannotCover) {
  for (const UniformScheme& scheme :
       {UniformScheme{"normal", {{0, 1}}}, UniformScheme{"last ring too sparse", {{0, 1}, {40, 8}, {78, 24}, {80, 4}}},
        UniformScheme{"likewise", {{0, 1}, {82, 60}, {85, 3}}},
        UniformScheme{"too near", {{0, 1}, {1e-5, 3}, {80, 12}}},
        UniformScheme{"much too near", {{0, 1}, {1e-12, 3}, {80, 12}}}}) {
    const Result<Triangulation> made = Triangulation::make(scheme);
    ASSERT_FALSE(made) << scheme.name;
    EXPECT_EQ(made.error().code, ErrorCode::kUnsupported);
  }
}

}  // namespace
}  // namespace sbrdf::internal
