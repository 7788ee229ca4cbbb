#include "codec/search/random_pairs.h"

#include <cmath>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

double theta_h_deg(const DirectionPair& pair) { return degrees_from_radians(half_difference_from_pair(pair).theta_h); }

// The same by another way: a rotation-free half vector of two unit vectors.
double theta_h_of_vectors_deg(const DirectionPair& pair) {
  const auto h = vector_from_direction(pair.i) + vector_from_direction(pair.v);
  return degrees_from_radians(std::atan2(std::hypot(h.x, h.y), h.z));
}

TEST(RandomPairs, AreUniformInAllFourAngles) {
  std::mt19937_64 random(1);
  constexpr int kCount = 100'000;
  std::vector<double> sums(4);
  std::vector<double> squares(4);
  for (int k = 0; k < kCount; ++k) {
    const DirectionPair pair = draw_pair(random, 60);
    const std::vector<double> parts = {degrees_from_radians(pair.i.theta) / 60, degrees_from_radians(pair.i.phi) / 360,
                                       degrees_from_radians(pair.v.theta) / 60, degrees_from_radians(pair.v.phi) / 360};
    for (int a = 0; a < 4; ++a) {
      ASSERT_GE(parts[a], 0);
      ASSERT_LE(parts[a], 1);
      sums[a] += parts[a] / kCount;
      squares[a] += parts[a] * parts[a] / kCount;
    }
  }
  for (int a = 0; a < 4; ++a) {
    EXPECT_NEAR(sums[a], 1.0 / 2, 0.004);  // four standard errors
    EXPECT_NEAR(squares[a], 1.0 / 3, 0.004);
  }
}

TEST(HighlightDraw, HasTheMeansOfTheUniformDraw) {
  for (const double theta_max : {80.0, 25.0}) {
    const HighlightDraw draw(theta_max);
    std::mt19937_64 random(2);
    constexpr int kCount = 400'000;
    std::vector<double> means(5);
    for (int k = 0; k < kCount; ++k) {
      const auto [pair, weight] = draw(random);
      ASSERT_GT(weight, 0);
      ASSERT_LE(weight, 3 + 1e-12);
      ASSERT_LE(degrees_from_radians(pair.v.theta), theta_max + 1e-9);
      ASSERT_LE(degrees_from_radians(pair.i.theta), theta_max + 1e-9);
      means[0] += weight / kCount;
      means[1] += weight * degrees_from_radians(pair.v.theta) / theta_max / kCount;
      means[2] += weight * degrees_from_radians(pair.v.phi) / 360 / kCount;
      means[3] += weight * std::pow(std::sin(pair.i.phi - pair.v.phi), 2) / kCount;
      means[4] += weight * (theta_h_deg(pair) < 10 ? 1 : 0) / kCount;
    }
    EXPECT_NEAR(means[0], 1, 0.01);
    EXPECT_NEAR(means[1], 0.5, 0.01);
    EXPECT_NEAR(means[2], 0.5, 0.01);
    EXPECT_NEAR(means[3], 0.5, 0.01);
    double within = 0;
    for (int k = 0; k < kCount; ++k) within += theta_h_of_vectors_deg(draw_pair(random, theta_max)) < 10 ? 1 : 0;
    EXPECT_NEAR(means[4], within / kCount, 0.004);
  }
}

TEST(HighlightDraw, LooksDenselyAtHighlightsAHundredthOfADegreeWide) {
  const HighlightDraw draw(80);
  std::mt19937_64 random(3);
  constexpr int kCount = 100'000;
  for (const auto& [width_deg, share] : std::vector<std::pair<double, double>>{{0.01, 0.02}, {0.1, 0.1}, {1, 0.25}}) {
    int within = 0;
    for (int k = 0; k < kCount; ++k) within += theta_h_of_vectors_deg(draw(random).pair) < width_deg ? 1 : 0;
    EXPECT_GT(within, share * kCount) << width_deg;
  }
}

TEST(HighlightDraw, IsTheSameForASeed) {
  const HighlightDraw draw(80);
  std::mt19937_64 one(7);
  std::mt19937_64 other(7);
  for (int k = 0; k < 100; ++k) {
    const WeightedPair a = draw(one);
    const WeightedPair b = draw(other);
    EXPECT_EQ(a.pair.i.theta, b.pair.i.theta);
    EXPECT_EQ(a.pair.v.phi, b.pair.v.phi);
    EXPECT_EQ(a.weight, b.weight);
  }
}

}  // namespace
}  // namespace sbrdf::internal
