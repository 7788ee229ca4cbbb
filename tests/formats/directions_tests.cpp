#include "formats/core/directions.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

using Real = long double;
constexpr Real kPiExact = std::numbers::pi_v<Real>;
constexpr double kTwoPi = 2 * kPi;

struct Vector {
  Real x, y, z;
};

Vector vector_of(Real theta, Real phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

Vector turned_about_z(const Vector& w, Real angle) {
  return {w.x * std::cos(angle) - w.y * std::sin(angle), w.x * std::sin(angle) + w.y * std::cos(angle), w.z};
}

Vector turned_about_y(const Vector& w, Real angle) {
  return {w.x * std::cos(angle) + w.z * std::sin(angle), w.y, w.z * std::cos(angle) - w.x * std::sin(angle)};
}

struct Oracle {
  Real theta_h, phi_h, theta_d, phi_d;
};

Oracle oracle(const DirectionPair& pair) {
  const Vector i = vector_of(pair.i.theta, pair.i.phi);
  const Vector v = vector_of(pair.v.theta, pair.v.phi);
  const Vector h = {i.x + v.x, i.y + v.y, i.z + v.z};
  Oracle out{};
  out.theta_h = std::atan2(std::hypot(h.x, h.y), h.z);
  out.phi_h = std::atan2(h.y, h.x);
  const Vector d = turned_about_y(turned_about_z(i, -out.phi_h), -out.theta_h);
  out.theta_d = std::atan2(std::hypot(d.x, d.y), d.z);
  out.phi_d = std::atan2(d.y, d.x);
  return out;
}

double turn_between(Real a, Real b) { return std::fabs(static_cast<double>(std::remainder(a - b, 2 * kPiExact))); }

void expect_matches_oracle(const DirectionPair& pair, double tolerance, double phi_d_tolerance) {
  SCOPED_TRACE(testing::Message() << "theta_i " << pair.i.theta << " phi_i " << pair.i.phi << " theta_v "
                                  << pair.v.theta << " phi_v " << pair.v.phi);
  const Oracle expected = oracle(pair);
  const HalfDifference found = half_difference_from_pair(pair);
  EXPECT_NEAR(found.theta_h, static_cast<double>(expected.theta_h), tolerance);
  EXPECT_NEAR(found.theta_d, static_cast<double>(expected.theta_d), tolerance);
  EXPECT_LE(turn_between(found.phi_h, expected.phi_h) * found.theta_h, tolerance);
  EXPECT_LE(turn_between(found.phi_d, expected.phi_d), phi_d_tolerance);
  EXPECT_GE(found.phi_h, 0);
  EXPECT_LT(found.phi_h, kTwoPi);
  EXPECT_GE(found.phi_d, 0);
  EXPECT_LT(found.phi_d, kTwoPi);
}

double distance(const Direction& a, const Direction& b) {
  const Vector p = vector_of(a.theta, a.phi);
  const Vector q = vector_of(b.theta, b.phi);
  return static_cast<double>(std::hypot(p.x - q.x, p.y - q.y, p.z - q.z));
}

TEST(Wrap, GivesTheRepresentativeInTheHalfOpenPeriod) {
  EXPECT_EQ(wrap(0, 360), 0);
  EXPECT_EQ(wrap(360, 360), 0);
  EXPECT_EQ(wrap(-360, 360), 0);
  EXPECT_EQ(wrap(725, 360), 5);
  EXPECT_EQ(wrap(-90, 360), 270);
  EXPECT_EQ(wrap(359.5, 360), 359.5);
  EXPECT_EQ(wrap(360.0 * 1048576 + 0.25, 360), 0.25);
}

TEST(Wrap, NeverReturnsThePeriod) {
  for (const double period : {360.0, 180.0, kPi, kTwoPi}) {
    for (const double angle : {-std::numeric_limits<double>::denorm_min(), -1e-300, -1e-17, -1e-14}) {
      EXPECT_GE(wrap(angle, period), 0) << angle;
      EXPECT_LT(wrap(angle, period), period) << angle;
    }
  }
}

TEST(Wrap, HasNoNegativeZero) {
  EXPECT_FALSE(std::signbit(wrap(-0.0, 360)));
  EXPECT_FALSE(std::signbit(wrap(-360.0, 360)));
}

TEST(Wrap, KeepsNanVisible) { EXPECT_TRUE(std::isnan(wrap(std::numeric_limits<double>::quiet_NaN(), 360))); }

TEST(DirectionFromDegrees, IsExactAtRightAngles) {
  EXPECT_EQ(direction_from_degrees(90, 0).theta, kPi / 2);
  EXPECT_EQ(direction_from_degrees(0, 180).phi, kPi);
  EXPECT_EQ(direction_from_degrees(0, 90).phi, kPi / 2);
}

TEST(DirectionFromDegrees, GivesTheSameBitsAfterWholeTurns) {
  for (int eighth = 0; eighth < 360 * 8; ++eighth) {
    const double phi_deg = eighth / 8.0;
    const double phi = direction_from_degrees(30, phi_deg).phi;
    EXPECT_LT(phi, kTwoPi);
    for (const double turns : {-1000.0, -1.0, 1.0, 2.0, 1048576.0}) {
      EXPECT_EQ(direction_from_degrees(30, phi_deg + 360 * turns).phi, phi) << phi_deg << " + 360 x " << turns;
    }
  }
}

TEST(DirectionFromDegrees, StaysBelowAWholeTurn) {
  EXPECT_LT(direction_from_degrees(30, std::nextafter(360.0, 0.0)).phi, kTwoPi);
  EXPECT_LT(direction_from_degrees(30, -1e-13).phi, kTwoPi);
}

TEST(VectorFromDirection, HasExactZerosAtThePole) {
  for (const double phi : {0.0, 1.0, 3.0, -2.0}) {
    const glm::dvec3 w = vector_from_direction({0, phi});
    EXPECT_EQ(w.x, 0);
    EXPECT_EQ(w.y, 0);
    EXPECT_EQ(w.z, 1);
    EXPECT_FALSE(std::signbit(w.x) || std::signbit(w.y));
  }
}

TEST(DirectionFromVector, InvertsVectorFromDirectionAtPoleAndGrazing) {
  for (const double theta : {1e-300, 1e-12, 1e-6, 0.5, 1.5, kPi / 2 - 1e-12, kPi / 2}) {
    for (const double phi : {0.0, 1e-9, 1.0, kPi / 2, 3.0, kPi, 4.0, 6.28}) {
      const Direction back = direction_from_vector(vector_from_direction({theta, phi}));
      EXPECT_NEAR(back.theta, theta, 3e-16 * theta) << theta << " " << phi;
      EXPECT_LE(turn_between(back.phi, phi), 1e-15) << theta << " " << phi;
      EXPECT_LT(back.phi, kTwoPi);
    }
  }
}

TEST(DirectionFromVector, DoesNotNeedUnitLength) {
  const Direction expected = direction_from_vector({3, -4, 12});
  for (const double scale : {1e-160, 1e-3, 7.0, 1e160}) {
    const Direction found = direction_from_vector({3 * scale, -4 * scale, 12 * scale});
    EXPECT_NEAR(found.theta, expected.theta, 1e-15);
    EXPECT_NEAR(found.phi, expected.phi, 2e-15);
  }
  EXPECT_NEAR(expected.theta, std::atan2(5.0, 12.0), 1e-15);
}

TEST(DirectionFromVector, PhiIsZeroAtThePole) {
  EXPECT_EQ(direction_from_vector({0, 0, 2}).phi, 0);
  EXPECT_EQ(direction_from_vector({-0.0, -0.0, 2}).phi, 0);
  EXPECT_EQ(direction_from_vector({0, 0, 2}).theta, 0);
  EXPECT_EQ(direction_from_vector({-0.0, -0.0, -2}).theta, kPi);
}

TEST(HalfDifference, MatchesLongDoubleAtRandomPairs) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> theta(0.01, kPi / 2 - 0.01), phi(-7, 14);
  for (int n = 0; n < 20000; ++n) {
    const DirectionPair pair{{theta(random), phi(random)}, {theta(random), phi(random)}};
    const double theta_d = half_difference_from_pair(pair).theta_d;
    expect_matches_oracle(pair, 1e-14, 1e-14 / std::min(theta_d, half_difference_from_pair(pair).theta_h));
  }
}

TEST(HalfDifference, KeepsTheDifferenceOfCloseDirections) {
  for (const double theta : {0.3, 1.0, 1.5, kPi / 2 - 1e-5}) {
    for (const double gap : {1e-3, 1e-6, 1e-8, 1e-10}) {
      // Steps that are exact in the angle itself, so that the oracle sees the same gap.
      const double theta_v = theta + gap, phi_v = 1.25 + gap * 0.75;
      const DirectionPair pair{{theta, 1.25}, {theta_v, phi_v}};
      const HalfDifference found = half_difference_from_pair(pair);
      const Real middle = (static_cast<Real>(theta) + theta_v) / 2;
      const Real expected = std::hypot((static_cast<Real>(theta_v) - theta) / 2,
                                       std::sin(middle) * (static_cast<Real>(phi_v) - 1.25L) / 2);
      EXPECT_NEAR(found.theta_d / static_cast<double>(expected), 1, 1e-14 + gap * gap) << theta << " " << gap;
      if (gap > 1e-7) expect_matches_oracle(pair, 1e-14, 1e-10);
    }
  }
}

TEST(HalfDifference, OfEqualDirectionsHasNoDifference) {
  for (const double theta : {0.0, 1e-9, 0.4, kPi / 2}) {
    const HalfDifference found = half_difference_from_pair({{theta, 2}, {theta, 2}});
    EXPECT_EQ(found.theta_d, 0);
    EXPECT_EQ(found.phi_d, 0);
    EXPECT_NEAR(found.theta_h, theta, 1e-15 * theta);
    EXPECT_NEAR(found.phi_h, theta > 0 ? 2 : 0, 1e-15);
  }
}

TEST(HalfDifference, OfMirroredDirectionsHasTheNormalAsHalfVector) {
  for (int theta_deg = 2; theta_deg <= 90; theta_deg += 2) {
    for (int phi_deg = 0; phi_deg < 360; phi_deg += 2) {
      const HalfDifference found = half_difference_from_pair(
          {direction_from_degrees(theta_deg, phi_deg), direction_from_degrees(theta_deg, phi_deg + 180)});
      EXPECT_EQ(found.theta_h, 0);
      EXPECT_EQ(found.phi_h, 0);
      EXPECT_NEAR(found.theta_d, radians_from_degrees(theta_deg), 1e-15);
      EXPECT_LE(turn_between(found.phi_d, radians_from_degrees(phi_deg)), 2e-15) << theta_deg << " " << phi_deg;
    }
  }
}

TEST(HalfDifference, IsAccurateNearGrazing) {
  for (const double below : {1e-3, 1e-6, 1e-9}) {
    const double theta = kPi / 2 - below;
    expect_matches_oracle({{theta, 0.5}, {theta, 0.7}}, 1e-14, 1e-12);
    expect_matches_oracle({{theta, 0.5}, {0, 0}}, 1e-14, 1e-12);
    expect_matches_oracle({{theta, 0}, {theta - below / 2, 3.0}}, 1e-14, 1e-12);
    expect_matches_oracle({{theta, 0}, {theta, kPi - below}}, 1e-9, 1e-6);
  }
}

TEST(HalfDifference, DoesNotDependOnWholeTurns) {
  const HalfDifference expected = half_difference_from_pair({{0.4, 1}, {0.9, 2}});
  for (const double turns : {-1e6, -3.0, 5.0, 1e6}) {
    const HalfDifference found = half_difference_from_pair({{0.4, 1 + kTwoPi * turns}, {0.9, 2}});
    EXPECT_NEAR(found.theta_h, expected.theta_h, 1e-9);
    EXPECT_NEAR(found.theta_d, expected.theta_d, 1e-9);
    EXPECT_NEAR(found.phi_d, expected.phi_d, 1e-8);
  }
}

TEST(HalfDifference, TakesLargeAzimuthsByTheirSineAndCosine) {
  for (const double large : {1.3e8 + 0.1, -1.3e8 - 0.1, 1e15, -1e15, std::numeric_limits<double>::max()}) {
    const double small = std::atan2(std::sin(large), std::cos(large));
    const HalfDifference expected = half_difference_from_pair({{0.4, small}, {0.9, 2.1}});
    const HalfDifference found = half_difference_from_pair({{0.4, large}, {0.9, 2.1}});
    EXPECT_EQ(found.theta_h, expected.theta_h) << large;
    EXPECT_EQ(found.phi_d, expected.phi_d) << large;
  }
}

TEST(HalfDifference, IsFiniteForAnyFiniteAzimuth) {
  const double huge = std::numeric_limits<double>::max();
  const HalfDifference found = half_difference_from_pair({{0.4, huge}, {0.9, -huge}});
  EXPECT_TRUE(std::isfinite(found.theta_h + found.phi_h + found.theta_d + found.phi_d));
}

TEST(HalfDifference, ExchangeOfDirectionsTurnsPhiDByHalfATurn) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> theta(0.01, kPi / 2), phi(0, kTwoPi);
  for (int n = 0; n < 2000; ++n) {
    const Direction i{theta(random), phi(random)}, v{theta(random), phi(random)};
    const HalfDifference a = half_difference_from_pair({i, v});
    const HalfDifference b = half_difference_from_pair({v, i});
    EXPECT_NEAR(a.theta_h, b.theta_h, 1e-15);
    EXPECT_NEAR(a.theta_d, b.theta_d, 1e-15);
    EXPECT_LE(turn_between(a.phi_d, b.phi_d + kPi), 1e-13 / a.theta_d);
  }
}

TEST(HalfDifference, ComesBackFromThePair) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> theta(0, kPi / 2), phi(-1, 8);
  for (int n = 0; n < 20000; ++n) {
    const DirectionPair pair{{theta(random), phi(random)}, {theta(random), phi(random)}};
    const DirectionPair back = pair_from_half_difference(half_difference_from_pair(pair));
    EXPECT_LE(distance(back.i, pair.i), 4e-15);
    EXPECT_LE(distance(back.v, pair.v), 4e-15);
  }
}

TEST(HalfDifference, ComesBackAtTheEdgesOfTheDomain) {
  const std::vector<double> thetas = {0, 1e-16, 1e-8, 0.5, kPi / 2 - 1e-8, kPi / 2};
  const std::vector<double> phis = {0, 1e-16, kPi / 2, kPi - 1e-15, kPi, kTwoPi - 1e-15, kTwoPi};
  for (const double theta_i : thetas) {
    for (const double theta_v : thetas) {
      for (const double phi_i : phis) {
        for (const double phi_v : phis) {
          const DirectionPair pair{{theta_i, phi_i}, {theta_v, phi_v}};
          const DirectionPair back = pair_from_half_difference(half_difference_from_pair(pair));
          EXPECT_LE(distance(back.i, pair.i), 4e-15) << theta_i << " " << phi_i << " " << theta_v << " " << phi_v;
          EXPECT_LE(distance(back.v, pair.v), 4e-15) << theta_i << " " << phi_i << " " << theta_v << " " << phi_v;
        }
      }
    }
  }
}

TEST(PairFromHalfDifference, GoesBeyondTheHorizon) {
  const DirectionPair pair = pair_from_half_difference({1.2, 0.3, 1.0, 0});
  EXPECT_NEAR(pair.i.theta, 2.2, 1e-15);
  EXPECT_NEAR(pair.i.phi, 0.3, 1e-15);
  EXPECT_NEAR(pair.v.theta, 0.2, 1e-15);
}

TEST(PairFromHalfDifference, PutsTheLightAtPhiHPlusPhiDUnderTheNormal) {
  const DirectionPair pair = pair_from_half_difference({0, 0, 0.6, 1.1});
  EXPECT_NEAR(pair.i.theta, 0.6, 1e-15);
  EXPECT_NEAR(pair.i.phi, 1.1, 1e-15);
  EXPECT_NEAR(pair.v.theta, 0.6, 1e-15);
  EXPECT_NEAR(pair.v.phi, 1.1 + kPi, 1e-15);
}

}  // namespace
}  // namespace sbrdf::internal
