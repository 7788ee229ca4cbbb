#include "codec/mask/direction_mask.h"

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "codec/mask/mask_runs.h"
#include "tests/support/analytic_brdf.h"

namespace sbrdf::internal {
namespace {

const MaskGrid kMerlGrid = {MaskFrame::kHalfDifference, {1, 90, 90, 180}};

bool is_above(const DirectionPair& pair) { return pair.i.theta < kPi / 2 && pair.v.theta < kPi / 2; }

TEST(MaskGrid, FindsTheCellThatACentreLiesIn) {
  for (const MaskGrid& grid :
       {kMerlGrid, MaskGrid{MaskFrame::kHalfDifference, {4, 7, 6, 5}}, MaskGrid{MaskFrame::kAngles, {6, 8, 6, 8}},
        MaskGrid{MaskFrame::kAngles, {9, 1, 9, 12}}}) {
    ASSERT_TRUE(grid.is_valid());
    std::size_t above = 0;
    for (std::uint64_t cell = 0; cell < grid.cell_count(); ++cell) {
      const DirectionPair centre = grid.centre_of(cell);
      if (!is_above(centre)) continue;
      ++above;
      ASSERT_EQ(grid.cell_of(centre), cell);
    }
    EXPECT_GT(above, grid.cell_count() / 4);
  }
}

// Rusinkiewicz' angles by rotating the vectors, and the cell of a MERL table as its published reader finds it.
TEST(MaskGrid, CountsCellsOfTheHalfDifferenceFrameAsMerlTablesDo) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> theta(0, 1.5);
  std::uniform_real_distribution<double> phi(0, 2 * kPi);
  for (int k = 0; k < 2000; ++k) {
    const DirectionPair pair = {{theta(random), phi(random)}, {theta(random), phi(random)}};
    const glm::dvec3 i = vector_from_direction(pair.i);
    const glm::dvec3 v = vector_from_direction(pair.v);
    glm::dvec3 h = {i.x + v.x, i.y + v.y, i.z + v.z};
    const double length = std::sqrt(h.x * h.x + h.y * h.y + h.z * h.z);
    h = {h.x / length, h.y / length, h.z / length};
    const double theta_h = std::acos(h.z);
    const double phi_h = std::atan2(h.y, h.x);
    const double x = std::cos(phi_h) * i.x + std::sin(phi_h) * i.y;
    const double y = -std::sin(phi_h) * i.x + std::cos(phi_h) * i.y;
    const double turned_x = std::cos(theta_h) * x - std::sin(theta_h) * i.z;
    const double turned_z = std::sin(theta_h) * x + std::cos(theta_h) * i.z;
    double phi_d = std::atan2(y, turned_x);
    if (phi_d < 0) phi_d += kPi;
    const auto h_index = static_cast<std::uint64_t>(90 * std::sqrt(theta_h / (kPi / 2)));
    const auto d_index = static_cast<std::uint64_t>(90 * std::acos(turned_z) / (kPi / 2));
    const auto p_index = static_cast<std::uint64_t>(180 * phi_d / kPi);
    EXPECT_EQ(kMerlGrid.cell_of(pair), (h_index * 90 + d_index) * 180 + p_index);
    EXPECT_EQ(kMerlGrid.cell_of({pair.v, pair.i}), kMerlGrid.cell_of(pair)) << "reciprocity";
  }
}

TEST(MaskGrid, CountsCellsOfAnglesByTheAnglesAsTheyAre) {
  const MaskGrid grid = {MaskFrame::kAngles, {9, 36, 9, 36}};
  const auto pair = [](double theta_i, double phi_i, double theta_v, double phi_v) {
    return DirectionPair{direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)};
  };
  EXPECT_EQ(grid.cell_of(pair(15, 25, 85, 355)), ((1 * 36 + 2) * 9 + 8) * 36 + 35);
  EXPECT_EQ(grid.cell_of(pair(90, 0, 90, 0)), (8 * 36 * 9 + 8) * 36) << "the horizon belongs to the last cell";
  const MaskGrid isotropic = {MaskFrame::kAngles, {9, 1, 9, 36}};
  EXPECT_EQ(isotropic.cell_of(pair(15, 200, 25, 235)), (1 * 9 + 2) * 36 + 3) << "only the difference of azimuths";
}

TEST(MaskGrid, TellsWhatAFileCanHold) {
  EXPECT_FALSE((MaskGrid{MaskFrame::kHalfDifference, {1, 0, 1, 1}}.is_valid()));
  EXPECT_FALSE((MaskGrid{MaskFrame::kHalfDifference, {1, 4097, 1, 1}}.is_valid()));
  EXPECT_FALSE((MaskGrid{MaskFrame::kHalfDifference, {3, 4096, 4096, 2}}.is_valid()));
  EXPECT_TRUE((MaskGrid{MaskFrame::kHalfDifference, {1, 4096, 4096, 4}}.is_valid()));
  EXPECT_FALSE((MaskGrid{static_cast<MaskFrame>(3), {1, 1, 1, 1}}.is_valid()));
}

TEST(MaskRuns, ComeBackAsTheyWere) {
  std::mt19937_64 random(2);
  for (const std::vector<bool>& bits :
       {std::vector<bool>(720, false), std::vector<bool>(720, true), std::vector<bool>()}) {
    DirectionMask mask = {{MaskFrame::kAngles, {4, 6, 5, 6}}, bits};
    for (int k = 0; bits.empty() && k < 720; ++k) mask.unmeasured.push_back(random() % 7 < 3);
    EXPECT_EQ(parse_runs(emit_runs(mask), mask.grid), mask);
  }
}

TEST(MaskRuns, SmoothMasksTakeFewBytes) {
  DirectionMask mask = {kMerlGrid, {}};
  for (std::uint64_t cell = 0; cell < kMerlGrid.cell_count(); ++cell) {
    mask.unmeasured.push_back(cell / 180 % 90 >= 70);  // theta_d
  }
  EXPECT_LT(emit_runs(mask).size(), 500U);
}

TEST(MaskRuns, RefuseWhatFillsTheCellsInAnotherWay) {
  const MaskGrid grid = {MaskFrame::kAngles, {1, 1, 1, 10}};
  const auto parsed = [&](std::vector<unsigned> bytes) {
    std::vector<std::byte> runs;
    for (const unsigned byte : bytes) runs.push_back(static_cast<std::byte>(byte));
    return parse_runs(runs, grid).has_value();
  };
  EXPECT_TRUE(parsed({10}));
  EXPECT_TRUE(parsed({0, 10}));
  EXPECT_FALSE(parsed({}));
  EXPECT_FALSE(parsed({9}));
  EXPECT_FALSE(parsed({11}));
  EXPECT_FALSE(parsed({4, 0, 6}));
  EXPECT_FALSE(parsed({10, 0}));
  EXPECT_FALSE(parsed({0, 0, 10}));
  EXPECT_FALSE(parsed({0x8A, 0}));
  EXPECT_FALSE(parsed({4, 0x86}));
}

}  // namespace
}  // namespace sbrdf::internal
