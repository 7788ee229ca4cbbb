#include "codec/frame/frame.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/analytic_brdf.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const FrameGeometry& elevation() { return geometry(FrameId::kElevation); }

DirectionPair pair_from_degrees(double theta_i, double phi_i, double theta_v, double phi_v) {
  return {direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)};
}

double turn_between(double a, double b, double period) { return std::abs(std::remainder(a - b, period)); }

DirectionPair pair_above_horizon(std::mt19937_64& random) {
  std::uniform_real_distribution<double> theta(0, 90);
  std::uniform_real_distribution<double> phi(0, 360);
  return pair_from_degrees(theta(random), phi(random), theta(random), phi(random));
}

std::vector<Symmetries> all_symmetries() {
  std::vector<Symmetries> all;
  for (int bits = 0; bits < 8; ++bits) all.push_back({(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0});
  return all;
}

TEST(ElevationCoordinates, AreTheSumAndDifferenceOfTheAzimuthsSeenFromTheSmallerElevation) {
  for (int phi_i = 0; phi_i < 360; phi_i += 15) {
    for (int phi_v = 0; phi_v < 360; phi_v += 24) {
      for (const auto& [theta_i, theta_v] : {std::array{10, 70}, std::array{70, 10}}) {
        const bool exchanged = theta_i > theta_v;
        const int u = exchanged ? phi_v - phi_i : phi_i - phi_v;
        const int s = phi_i + phi_v;
        const Coordinates x = elevation().coordinates(pair_from_degrees(theta_i, phi_i, theta_v, phi_v));
        EXPECT_NEAR(x[kHorizontal], 70, 1e-12);
        EXPECT_NEAR(x[kVertical], 10, 1e-12);
        EXPECT_NEAR(x[kDiagonal], u < 0 ? u + 360 : u, 1e-12);
        EXPECT_LT(turn_between(x[kAxial], u < 0 ? s + 360 : s, 720), 1e-12);
        EXPECT_GE(x[kAxial], 0);
        EXPECT_LT(x[kAxial], 720);
      }
    }
  }
}

TEST(ElevationCoordinates, HaveTheSameBitsAfterExchangingTheDirections) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 20000; ++k) {
    DirectionPair pair = pair_above_horizon(random);
    if (k % 4 == 0) pair.v.theta = pair.i.theta;
    if (k % 5 == 0) pair.v.phi = pair.i.phi;
    if (k % 7 == 0) pair.i.theta = 0;
    ASSERT_EQ(elevation().coordinates(pair), elevation().coordinates({pair.v, pair.i}));
  }
}

TEST(ElevationCoordinates, StayWithinThePaddedLatticeForAzimuthsOfAnyTurn) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> phi(-1000, 1000);
  for (int k = 0; k < 20000; ++k) {
    DirectionPair pair = pair_above_horizon(random);
    const DirectionPair within = pair;
    pair.i.phi += 2 * kPi * std::floor(phi(random));
    pair.v.phi += 2 * kPi * std::floor(phi(random));
    const Coordinates x = elevation().coordinates(pair);
    ASSERT_TRUE(x[kAxial] >= 0 && x[kAxial] <= 720);
    ASSERT_TRUE(x[kDiagonal] >= 0 && x[kDiagonal] <= 360);
    ASSERT_LT(measurement_distance(elevation().directions(x, 80), within, {}), 1e-11);
  }
}

TEST(ElevationCoordinates, LeadBackToTheSameDirections) {
  std::mt19937_64 random(3);
  for (int k = 0; k < 20000; ++k) {
    const DirectionPair pair = pair_above_horizon(random);
    ASSERT_LT(measurement_distance(elevation().directions(elevation().coordinates(pair), 80), pair, {}), 1e-14);
  }
}

TEST(ElevationDirections, HaveHalfTheSumAndHalfTheDifferenceAsAzimuths) {
  const DirectionPair pair = elevation().directions({100, 30, 60, 20}, 80);
  EXPECT_NEAR(pair.i.theta, 20 * kPi / 180, 1e-15);
  EXPECT_NEAR(pair.i.phi, 65 * kPi / 180, 1e-15);
  EXPECT_NEAR(pair.v.theta, 60 * kPi / 180, 1e-15);
  EXPECT_NEAR(pair.v.phi, 35 * kPi / 180, 1e-15);
}

TEST(ElevationDirections, AreTheSameAfterWholeTurnsOfBothCoordinates) {
  for (double s = 0; s < 360; s += 24.5) {
    for (double u = 0; u < 360; u += 31.25) {
      const DirectionPair pair = elevation().directions({s, u, 60, 20}, 80);
      EXPECT_LT(vector_distance(elevation().directions({s + 360, u + 360, 60, 20}, 80), pair), 1e-14);
      EXPECT_LT(vector_distance(elevation().directions({s + 720, u, 60, 20}, 80), pair), 1e-14);
      EXPECT_GT(vector_distance(elevation().directions({s + 360, u, 60, 20}, 80), pair), 0.1);
    }
  }
}

TEST(ElevationImages, AreTheSameMeasurementForEveryMaterialOfThatSymmetry) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> azimuth(0, 360);
  for (const Symmetries& symmetries : all_symmetries()) {
    for (int k = 0; k < 200; ++k) {
      AffineLine line;
      line.offset = {azimuth(random), azimuth(random), 10.0 * (k % 5), 10.0 * (k % 3)};
      const auto moving = static_cast<std::size_t>(k) % (kAxisCount + 1);
      if (moving < kAxisCount) {
        line.offset[moving] = 0;
        line.slope[moving] = 1;
      }
      const Images images = elevation().images(line, symmetries);
      for (double p = 3; p < 90; p += 17) {
        const auto at = [&](const AffineLine& image) {
          Coordinates x;
          for (std::size_t axis = 0; axis < kAxisCount; ++axis) x[axis] = image.offset[axis] + image.slope[axis] * p;
          return analytic_brdf(elevation().directions(x, 80), symmetries);
        };
        for (std::size_t image = 0; image < images.count; ++image) {
          ASSERT_NEAR(at(images.lines[image]) / at(line), 1, 1e-12) << "image " << image << ", moving axis " << moving;
        }
      }
    }
  }
}

TEST(ElevationImages, AreOnePerCombinationOfReciprocityAndMirrors) {
  AffineLine point;
  point.offset = {50, 20, 60, 30};
  EXPECT_EQ(elevation().images(point, {}).count, 2U);
  EXPECT_EQ(elevation().images(point, {.mirror_x = true}).count, 4U);
  EXPECT_EQ(elevation().images(point, {.mirror_x = true, .mirror_y = true}).count, 8U);
}

TEST(ElevationImages, TakeOutTheAzimuthsThatDoNotMatter) {
  AffineLine point;
  point.offset = {100, 40, 60, 0};
  const AffineLine ring = elevation().images(point, {}).lines[0];
  EXPECT_EQ(ring.offset, (Coordinates{60, 0, 60, 0}));
  point.offset = {100, 40, 0, 0};
  EXPECT_EQ(elevation().images(point, {}).lines[0].offset, (Coordinates{0, 0, 0, 0}));
  point.offset = {100, 40, 60, 30};
  EXPECT_EQ(elevation().images(point, {.isotropic = true}).lines[0].offset, (Coordinates{0, 40, 60, 30}));
}

const FrameGeometry& half_difference() { return geometry(FrameId::kHalfDifference); }

TEST(HalfDifferenceCoordinates, HaveTheSameBitsAfterExchangingTheDirections) {
  std::mt19937_64 random(5);
  for (int k = 0; k < 20000; ++k) {
    DirectionPair pair = pair_above_horizon(random);
    if (k % 4 == 0) pair.v.theta = pair.i.theta;
    if (k % 5 == 0) pair.v.phi = pair.i.phi;
    if (k % 7 == 0) pair.i.theta = 0;
    ASSERT_EQ(half_difference().coordinates(pair), half_difference().coordinates({pair.v, pair.i}));
  }
}

TEST(HalfDifferenceCoordinates, LeadBackToTheSameDirectionsUpTo80Degrees) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> theta(0, 80);
  for (int k = 0; k < 20000; ++k) {
    DirectionPair pair = pair_above_horizon(random);
    pair.i.theta = radians_from_degrees(theta(random));
    pair.v.theta = radians_from_degrees(theta(random));
    const Coordinates x = half_difference().coordinates(pair);
    ASSERT_TRUE(x[kAxial] >= 0 && x[kAxial] < 360 && x[kDiagonal] >= 0 && x[kDiagonal] < 180);
    ASSERT_LT(measurement_distance(half_difference().directions(x, 80), pair, {}), 1e-13);
  }
}

TEST(HalfDifferenceDirections, StayAboveTheHorizonWhereverTheAnglesLie) {
  for (double theta_h = 0; theta_h <= 90; theta_h += 7.5) {
    for (double theta_d = 0; theta_d <= 90; theta_d += 7.5) {
      for (double phi_d = 0; phi_d < 180; phi_d += 20) {
        const DirectionPair pair = half_difference().directions({30, phi_d, theta_d, theta_h}, 80);
        EXPECT_LE(std::max(pair.i.theta, pair.v.theta), radians_from_degrees(81));
      }
    }
  }
}

TEST(HalfDifferenceDirections, RiseSmoothlyPast80Degrees) {
  double last = 0;
  double last_step = 1;
  for (double theta = 70; theta < 90; theta += 0.125) {
    const double eased = degrees_from_radians(half_difference().directions({0, 90, 0, theta}, 80).i.theta);
    EXPECT_GE(eased, last);
    EXPECT_TRUE(theta < 70.2 || std::abs(eased - last - last_step) < 0.02) << theta;
    last_step = eased - last;
    last = eased;
  }
}

// Wherever the frame ends; never below the horizon.
TEST(HalfDifferenceDirections, EaseFromThetaMaxOnAndEndADegreeBeyond) {
  for (const double theta_max : {40.0, 80.0, 85.5, 89.0, 90.0}) {
    const double from = std::min(theta_max, 89.0);
    const auto eased = [&](double theta_h, double theta_d) {
      const DirectionPair pair = half_difference().directions({0, 0, theta_d, theta_h}, theta_max);
      EXPECT_LE(std::max(pair.i.theta, pair.v.theta), kPi / 2);
      return degrees_from_radians(std::max(pair.i.theta, pair.v.theta));
    };
    EXPECT_NEAR(eased(from / 2, from / 2), from, 1e-9);
    EXPECT_NEAR(eased(from / 2, from / 2 + 1), from + 1 - std::exp(-1), 1e-9);
    EXPECT_NEAR(eased(90, 90), from + 1, 1e-9);
  }
}

TEST(HalfDifferenceImages, AreTheSameMeasurementForEveryMaterialOfThatSymmetry) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> azimuth(0, 180);
  for (const Symmetries& symmetries : all_symmetries()) {
    for (int k = 0; k < 200; ++k) {
      AffineLine line;
      line.offset = {2 * azimuth(random), azimuth(random), 10.0 * (k % 5), 10.0 * (k % 3)};
      const auto moving = static_cast<std::size_t>(k) % (kAxisCount + 1);
      if (moving < kAxisCount) {
        line.offset[moving] = 0;
        line.slope[moving] = 1;
      }
      const Images images = half_difference().images(line, symmetries);
      for (double p = 3; p < 90; p += 17) {
        const auto at = [&](const AffineLine& image) {
          Coordinates x;
          for (std::size_t axis = 0; axis < kAxisCount; ++axis) x[axis] = image.offset[axis] + image.slope[axis] * p;
          return analytic_brdf(half_difference().directions(x, 80), symmetries);
        };
        for (std::size_t image = 0; image < images.count; ++image) {
          ASSERT_NEAR(at(images.lines[image]) / at(line), 1, 1e-12) << "image " << image << ", moving axis " << moving;
        }
      }
    }
  }
}

TEST(ElevationFrame, HasTheElevationsOfThePaper) {
  const auto elevations = [](double step) { return elevation_frame(step, 60, {}).value().axes[kVertical].nodes_deg; };
  EXPECT_THAT(elevations(28), ElementsAre(0, 28, 56, 80));
  EXPECT_THAT(elevations(20), ElementsAre(0, 20, 40, 60, 80));
  EXPECT_THAT(elevations(14), ElementsAre(0, 14, 28, 42, 56, 70, 80));
  EXPECT_THAT(elevations(80), ElementsAre(0, 80));
  EXPECT_THAT(elevation_frame(40, 60, {}, 90).value().axes[kHorizontal].nodes_deg, ElementsAre(0, 40, 80, 90));
}

TEST(ElevationFrame, HasAnAxialAndADiagonalSliceEveryAzimuthStep) {
  const FrameSpec spec = elevation_frame(40, 90, {}).value();
  EXPECT_THAT(spec.axes[kAxial].nodes_deg, ElementsAre(0, 90, 180, 270));
  EXPECT_THAT(spec.axes[kDiagonal].nodes_deg, ElementsAre(0, 90, 180, 270));
  EXPECT_EQ(spec.axes[kAxial].name, "s");
  EXPECT_EQ(spec.axes[kDiagonal].name, "u");
  EXPECT_EQ(spec.axes[kHorizontal].name, "theta_v");
  EXPECT_EQ(spec.axes[kVertical].name, "theta_i");
}

TEST(ElevationFrame, HasOneNodeOfTheSumForAnIsotropicMaterial) {
  const FrameSpec spec = elevation_frame(40, 90, {.isotropic = true}).value();
  EXPECT_THAT(spec.axes[kAxial].nodes_deg, ElementsAre(0));
  EXPECT_EQ(spec.axes[kDiagonal].nodes_deg.size(), 4U);
}

TEST(ElevationFrame, RefusesPlacementsThatCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double elevation_step : {-14.0, 0.0, 0.1, 81.0, nan, infinite}) {
    const auto spec = elevation_frame(elevation_step, 36, {});
    ASSERT_FALSE(spec) << elevation_step;
    EXPECT_EQ(spec.error().code, ErrorCode::kUsage);
  }
  for (const double azimuth_step : {-36.0, 0.0, 0.5, 7.0, 361.0, nan, infinite}) {
    EXPECT_FALSE(elevation_frame(14, azimuth_step, {})) << azimuth_step;
  }
  for (const double theta_max : {0.0, -80.0, 91.0, nan}) EXPECT_FALSE(elevation_frame(14, 36, {}, theta_max));
}

FrameSpec valid_spec() { return elevation_frame_from_nodes({0, 30, 80}, {0, 120, 240}, {0, 90, 180, 270}, {}); }

std::string refusal(const FrameSpec& spec) {
  const Status status = check_frame(spec);
  return status ? "" : status.error().message;
}

TEST(CheckFrame, TakesListsOfAnyStepAndLength) { EXPECT_EQ(refusal(valid_spec()), ""); }

TEST(CheckFrame, RefusesNodesThatBreakTheRulesOfTheirAxis) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<double>> azimuths = {{},           {1, 90}, {0, 90, 90},   {0, 90, 80}, {0, 360},
                                                     {0, 90, nan}, {nan},   {0, infinite}, {-90, 0},    {0, 400}};
  for (const auto& nodes : azimuths) {
    FrameSpec spec = valid_spec();
    spec.axes[kDiagonal].nodes_deg = nodes;
    EXPECT_THAT(refusal(spec), HasSubstr("axis u"));
  }
  const std::vector<std::vector<double>> elevations = {{}, {10, 80}, {0, 80, 80}, {0, 91}, {0, nan}, {0, infinite}};
  for (const auto& nodes : elevations) {
    FrameSpec spec = valid_spec();
    spec.axes[kHorizontal].nodes_deg = spec.axes[kVertical].nodes_deg = nodes;
    EXPECT_THAT(refusal(spec), HasSubstr("axis theta_v"));
  }
}

TEST(CheckFrame, RefusesMoreThan4096Nodes) {
  FrameSpec spec = valid_spec();
  spec.axes[kAxial].nodes_deg.resize(4097);
  for (std::size_t k = 0; k < 4097; ++k) spec.axes[kAxial].nodes_deg[k] = 0.05 * static_cast<double>(k);
  EXPECT_THAT(refusal(spec), HasSubstr("4097"));
}

TEST(CheckFrame, RefusesNodesTooCloseToBeToldApart) {
  for (const auto& nodes : {std::vector{0.0, 1e-8}, std::vector{0.0, 5e-324}, std::vector{0.0, 40.0, 40.0 + 1e-9}}) {
    FrameSpec spec = valid_spec();
    spec.axes[kHorizontal].nodes_deg = spec.axes[kVertical].nodes_deg = nodes;
    EXPECT_NE(refusal(spec), "");
  }
  FrameSpec spec = valid_spec();
  spec.axes[kDiagonal].nodes_deg = {0, 90, 360 - 1e-10};
  EXPECT_NE(refusal(spec), "");
}

TEST(CheckFrame, RefusesDifferentElevationsOfLightAndViewer) {
  FrameSpec spec = valid_spec();
  spec.axes[kHorizontal].nodes_deg = {0, 40, 80};
  EXPECT_THAT(refusal(spec), HasSubstr("same nodes"));
}

TEST(CheckFrame, RefusesAzimuthDifferencesThatChangeWhenTheDirectionsAreExchanged) {
  for (const bool isotropic : {false, true}) {
    FrameSpec spec = valid_spec();
    spec.symmetries.isotropic = isotropic;
    if (isotropic) spec.axes[kAxial].nodes_deg = {0};
    for (const auto& nodes :
         {std::vector{0.0, 100.0}, {0.0, 90.0, 180.0, 200.0}, {0.0, 90.0, 269.0}, {0.0, 90.0, 270.00001}}) {
      spec.axes[kDiagonal].nodes_deg = nodes;
      EXPECT_THAT(refusal(spec), HasSubstr("axis u")) << testing::PrintToString(nodes);
    }
    for (const auto& nodes : {std::vector{0.0},
                              {0.0, 180.0},
                              {0.0, 90.0, 270.0},
                              {0.0, 360 / 7.0, 360 - 360 / 7.0},
                              {0.0, 2e-3, 359.998}}) {
      spec.axes[kDiagonal].nodes_deg = nodes;
      EXPECT_EQ(refusal(spec), "") << testing::PrintToString(nodes);
    }
  }
}

TEST(CheckFrame, RefusesMoreThanOneNodeOfTheSumForAnIsotropicMaterial) {
  FrameSpec spec = valid_spec();
  spec.symmetries.isotropic = true;
  EXPECT_THAT(refusal(spec), HasSubstr("isotropic"));
}

TEST(CheckFrame, RefusesAnUnknownFrameAsUnsupported) {
  FrameSpec spec = valid_spec();
  spec.id = static_cast<FrameId>(200);
  const Status status = check_frame(spec);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kUnsupported);
}

TEST(FindGeometry, KnowsOnlyTheNumbersOfTheFormat) {
  ASSERT_NE(find_geometry(FrameId::kElevation), nullptr);
  EXPECT_EQ(find_geometry(FrameId::kElevation)->name(), "elevation");
  ASSERT_NE(find_geometry(FrameId::kHalfDifference), nullptr);
  EXPECT_EQ(find_geometry(FrameId::kHalfDifference)->name(), "half-difference");
  EXPECT_EQ(find_geometry(static_cast<FrameId>(0)), nullptr);
  EXPECT_EQ(find_geometry(static_cast<FrameId>(255)), nullptr);
}

}  // namespace
}  // namespace sbrdf::internal
