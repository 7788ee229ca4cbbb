#include "codec/importance/mirror_polar.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "codec/search/random_pairs.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

const std::vector<Stretch> kStretches = {{1, 0, 1}, {1, 0, 0.1}, {0.3, -0.4, 0.8}};
const std::vector<double> kThetas = {0, 12, 45, 70, 85, 89.9};

glm::dvec3 light(double theta_deg) { return vector_from_direction(direction_from_degrees(theta_deg, 34)); }

glm::dvec2 heading_of(double angle) { return {std::cos(angle), std::sin(angle)}; }

glm::dvec3 random_direction(std::mt19937_64& random) {
  const double z = draw_uniform(random, 1);
  const double phi = draw_uniform(random, 2 * kPi);
  return {std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z};
}

TEST(MirrorPolar, PlacesADirectionWhereItCameFrom) {
  std::mt19937_64 random(1);
  for (const Stretch& stretch : kStretches) {
    for (const double theta : kThetas) {
      const MirrorPolar polar(light(theta), stretch);
      for (int k = 0; k < 200; ++k) {
        const glm::dvec3 w_v = random_direction(random);
        EXPECT_LT(glm::length(polar.direction(polar.place(w_v)) - w_v), 1e-7) << theta;
      }
    }
  }
}

TEST(MirrorPolar, BeginsAtTheMirrorDirection) {
  for (const double theta : kThetas) {
    const glm::dvec3 w_i = light(theta);
    EXPECT_LT(glm::length(MirrorPolar(w_i, {}).direction({{1, 0}, 0}) - glm::dvec3(-w_i.x, -w_i.y, w_i.z)), 1e-15);
    EXPECT_EQ(MirrorPolar(w_i, {}).place({-w_i.x, -w_i.y, w_i.z}).radius, 0);
  }
}

TEST(MirrorPolar, LeavesTheHemisphereAtTheHorizonAndNowhereElse) {
  for (const Stretch& stretch : kStretches) {
    for (const double theta : kThetas) {
      const MirrorPolar polar(light(theta), stretch);
      for (double angle = 0.1; angle < 2 * kPi; angle += 0.3) {
        const double horizon = polar.horizon(heading_of(angle));
        for (const double share : {0.01, 0.3, 0.9, 0.9999}) {
          EXPECT_GT(polar.direction({heading_of(angle), share * horizon}).z, 0) << theta << ' ' << angle;
        }
        EXPECT_NEAR(polar.direction({heading_of(angle), horizon}).z, 0, 1e-7) << theta << ' ' << angle;
        const double beyond = horizon + 0.01 * (1 - horizon);
        EXPECT_LT(polar.direction({heading_of(angle), beyond}).z, 0) << theta << ' ' << angle;
      }
    }
  }
}

// The oracle is the area of a small triangle on the sphere, by finite differences.
TEST(MirrorPolar, TellsHowAreasChange) {
  std::mt19937_64 random(2);
  for (const Stretch& stretch : kStretches) {
    for (const double theta : {0.0, 12.0, 45.0, 70.0, 85.0}) {
      const MirrorPolar polar(light(theta), stretch);
      for (int k = 0; k < 50; ++k) {
        const glm::dvec3 w_v = random_direction(random);
        const PolarPlace place = polar.place(w_v);
        const double angle = std::atan2(place.heading.y, place.heading.x);
        const double turn = 1e-6;
        const double step = 1e-6 * std::min(place.radius, 1 - place.radius);
        const glm::dvec3 by_angle = polar.direction({heading_of(angle + turn), place.radius}) -
                                    polar.direction({heading_of(angle - turn), place.radius});
        const glm::dvec3 by_radius = polar.direction({place.heading, place.radius + step}) -
                                     polar.direction({place.heading, place.radius - step});
        const double area = glm::length(glm::cross(by_angle, by_radius)) / (4 * turn * step);
        EXPECT_NEAR(polar.density(w_v) * area, 1, 1e-4) << theta << ' ' << w_v.z;
      }
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
