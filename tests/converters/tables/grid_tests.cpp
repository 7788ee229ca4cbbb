#include "converters/tables/grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <string>

#include "codec/frame/frame.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

TEST(GridAxis, BracketsEveryAngleByItsNeighbours) {
  const GridAxis even(even_nodes(0, 10, 10));
  EXPECT_EQ(even.bracket(34).low, 3U);
  EXPECT_NEAR(even.bracket(34).weight, 0.4, 1e-12);
  EXPECT_EQ(even.bracket(95).high, 9U);
  EXPECT_EQ(even.bracket(95).weight, 1);
  const GridAxis uneven({5, 15, 40, 80});
  EXPECT_EQ(uneven.bracket(0).weight, 0);
  EXPECT_EQ(uneven.bracket(20).low, 1U);
  EXPECT_NEAR(uneven.bracket(20).weight, 0.2, 1e-12);
  EXPECT_EQ(GridAxis().bracket(77).low, 0U);
}

TEST(GridAxis, ClosesTurnsAndMirrorsThem) {
  const GridAxis full(even_nodes(5, 10, 36), Ends::kFullTurn);
  for (const double angle : {2.0, 362.0, -358.0}) {
    EXPECT_EQ(full.bracket(angle).low, 35U) << angle;
    EXPECT_EQ(full.bracket(angle).high, 0U);
    EXPECT_NEAR(full.bracket(angle).weight, 0.7, 1e-9);
  }
  const GridAxis half(even_nodes(0, 45, 4), Ends::kHalfTurn);
  EXPECT_EQ(half.bracket(170).high, 0U);
  EXPECT_EQ(half.bracket(190).low, 0U);
  const GridAxis mirrored(even_nodes(0, 45, 5), Ends::kMirrored);
  for (const double angle : {60.0, -60.0, 300.0, 420.0}) {
    EXPECT_EQ(mirrored.bracket(angle).low, 1U) << angle;
    EXPECT_NEAR(mirrored.bracket(angle).weight, 1.0 / 3, 1e-9);
  }
}

TEST(GridAxis, GoesOnInAStraightLineWhereItIsExtrapolated) {
  const GridAxis axis(even_nodes(0, 15, 6), Ends::kExtrapolated);
  EXPECT_EQ(axis.bracket(90).low, 4U);
  EXPECT_NEAR(axis.bracket(90).weight, 2, 1e-12);
  EXPECT_NEAR(axis.bracket(37.5).weight, 0.5, 1e-12);
}

TEST(GridAxis, GivesANodeItsOwnWeightWhateverItsRounding) {
  const GridAxis axis(even_nodes(0, 7.5, 48), Ends::kFullTurn);
  for (std::uint32_t k = 0; k < 48; ++k) {
    const Bracket at = axis.bracket(degrees_from_radians(radians_from_degrees(7.5 * k)) + 3e-13);
    EXPECT_TRUE((at.weight == 0 && at.low == k) || (at.weight == 1 && at.high == k)) << k;
  }
}

TEST(GridAxis, IsLinearInTheRootWhereItSaysSo) {
  const GridAxis axis({0, 10, 40, 90}, Ends::kHeld, Spacing::kRoot);
  const Bracket at = axis.bracket(22.5);  // sqrt: 3.162, 4.743, 6.325
  EXPECT_EQ(at.low, 1U);
  EXPECT_NEAR(at.weight, 0.5, 1e-12);
}

// A place and the pair there belong together, whatever the frame; -0 and whole turns apart.
TEST(Grid, PlacesAndPairsAreInverse) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const auto& [name, frame] : kGridFrameNames) {
    Grid grid;
    grid.frame = frame;
    grid.axes[0] = GridAxis(even_nodes(0, 90, 4), Ends::kFullTurn);
    for (int k = 0; k < 1000; ++k) {
      const DirectionPair pair = {{1.5 * unit(random), 6.2 * unit(random)}, {1.5 * unit(random), 6.2 * unit(random)}};
      const DirectionPair back = grid.pair_at(grid.place_of(pair));
      EXPECT_LT(glm::distance(vector_from_direction(back.i), vector_from_direction(pair.i)), 1e-9) << name;
      EXPECT_LT(glm::distance(vector_from_direction(back.v), vector_from_direction(pair.v)), 1e-9) << name;
    }
  }
}

// Worked out by hand: light at 30 degrees in the plane x-z, so the mirror direction is at 30 degrees, phi 180.
TEST(Grid, MirrorCoordinatesLeadFromTheMirrorDirectionOverTheNormal) {
  Grid grid;
  grid.frame = GridFrame::kMirror;
  const auto at = [&](double azimuth, double radius) { return grid.pair_at({0, 30, azimuth, radius}).v; };
  EXPECT_NEAR(degrees_from_radians(at(0, 30).theta), 0, 1e-6);
  EXPECT_NEAR(degrees_from_radians(at(0, 50).theta), 20, 1e-9);
  EXPECT_NEAR(std::cos(at(0, 50).phi), 1, 1e-9);
  EXPECT_NEAR(degrees_from_radians(at(180, 20).theta), 50, 1e-9);
  EXPECT_NEAR(std::cos(at(180, 20).phi), -1, 1e-9);
  // Seen from outside one looks along minus the mirror direction; with the normal's side up, +y is to the left, which
  // is where counter-clockwise leads.
  const glm::dvec3 side = vector_from_direction(at(90, 20));
  EXPECT_GT(side.y, 0);
  EXPECT_NEAR(glm::dot(side, vector_from_direction({radians_from_degrees(30), kPi})),
              std::cos(radians_from_degrees(20)), 1e-12);
}

TEST(ParseGrid, TakesStepsListsAndNames) {
  const Grid steps = parse_grid("5:10:15:30").value();
  EXPECT_EQ(steps.frame, GridFrame::kAngles);
  EXPECT_EQ(steps.size_text(), "19 x 36 x 7 x 12 nodes");
  EXPECT_EQ(steps.axes[0].nodes_deg().back(), 90);
  EXPECT_EQ(steps.axes[1].nodes_deg().back(), 350);
  const Grid lists = parse_grid("difference/0:0,1,90:30:90").value();
  EXPECT_EQ(lists.size_text(), "1 x 3 x 4 x 4 nodes");
  EXPECT_TRUE(lists.is_isotropic());
  EXPECT_EQ(parse_grid("utia").value().size_text(), "6 x 48 x 6 x 48 nodes");
  EXPECT_EQ(parse_grid("utia-dense").value().size_text(), "44 x 180 x 44 x 180 nodes");
  const Grid merl = parse_grid("merl").value();
  EXPECT_EQ(merl.size_text(), "1 x 90 x 90 x 180 nodes");
  EXPECT_NEAR(merl.axes[1].nodes_deg()[89], 89.5 * 89.5 / 90, 1e-12);
  EXPECT_TRUE(merl.is_reciprocal());
}

TEST(ParseGrid, SaysWhatIsWrong) {
  EXPECT_THAT(parse_grid("7:10:5:10").error().message,
              HasSubstr("a step of 7 does not divide the 90 degrees of theta_i"));
  EXPECT_THAT(parse_grid("1e9:10:5:10").error().message, HasSubstr("a step of 1e+09 does not divide"));
  EXPECT_THAT(parse_grid("5:10:5").error().message, HasSubstr("four axes"));
  EXPECT_THAT(parse_grid("x/5:10:5:10").error().message, HasSubstr("'x' is none of angles, difference"));
  EXPECT_THAT(parse_grid("0,95:10:5:10").error().message, HasSubstr("theta_i must rise"));
}

}  // namespace
}  // namespace sbrdf::internal
