// Atlases that leave cells out: which cells are reached, and what is held.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "codec/atlas/atlas_evaluator.h"
#include "codec/atlas/bake.h"
#include "codec/atlas/part/reached_cells.h"
#include "codec/atlas/shader.h"
#include "codec/evaluation/evaluator.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

using Rgb = std::array<float, 3>;

std::vector<FrameSpec> frames() {
  return {
      elevation_frame(28, 60, {}, 70).value(),
      elevation_frame(28, 60, {.isotropic = true, .mirror_x = true}).value(),
      elevation_frame(10, 20, {.isotropic = true}, 90).value(),
      half_difference_frame({0, 3, 15, 40}, {0, 20, 40, 70}, {0, 90, 180, 270}, {0, 60, 120}, {}),
      half_difference_frame({0, 10, 40}, {0, 40, 60}, {0, 45, 180, 315}, {0, 30, 90, 150}, {.mirror_x = true}),
      half_difference_frame({0, 20, 90}, {0, 40, 90}, {0, 90, 180, 270}, {0, 90}, {.mirror_x = true, .mirror_y = true},
                            90),
      half_difference_frame({0, 2, 5, 40}, {0, 15, 40, 80}, {0}, {0, 50, 90, 130},
                            {.isotropic = true, .mirror_x = true}),
      half_difference_frame({0, 30, 50}, {0, 30}, {0}, {0}, {.isotropic = true, .mirror_x = true}),
  };
}

AtlasLayout axes_of(const FrameSpec& spec) { return atlas_axes(build_lattice(spec).value()); }

/// Uniform in theta, or near the normal, the horizon, or the mirror direction of the other.
DirectionPair pair_up_to(std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const auto theta = [&] {
    const double kind = share(random);
    if (kind < 0.2) return 3 * share(random);
    if (kind < 0.4) return 90 - 3 * share(random);
    return 90 * share(random);
  };
  DirectionPair pair = {direction_from_degrees(theta(), 360 * share(random)),
                        direction_from_degrees(theta(), 360 * share(random))};
  if (share(random) < 0.3) {
    pair.v = {std::min(pair.i.theta + 0.05 * share(random), kPi / 2), pair.i.phi + kPi + 0.1 * share(random)};
  }
  return pair;
}

/// A direction above the horizon within some degrees of one.
Direction near(const Direction& direction, double degrees, std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const glm::dvec3 w = vector_from_direction(direction);
  const glm::dvec3 other = std::abs(w.z) < 0.5 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 a = glm::normalize(glm::cross(w, other));
  const glm::dvec3 b = glm::cross(w, a);
  const double turn = 2 * kPi * share(random);
  const double tilt = radians_from_degrees(degrees) * std::sqrt(share(random));
  glm::dvec3 moved = std::cos(tilt) * w + std::sin(tilt) * (std::cos(turn) * a + std::sin(turn) * b);
  if (moved.z < 0) moved = w;
  return direction_from_vector(moved);
}

TEST(ReachedCells, HasTheCellsOfAllPairsNearBy) {
  std::mt19937_64 random(4);
  for (const FrameSpec& spec : frames()) {
    const AtlasLayout axes = axes_of(spec);
    for (const double margin : {0.01, 1.0, 4.0}) {
      for (int k = 0; k < 60; ++k) {
        const DirectionPair pair = pair_up_to(random);
        ReachedCells reach(axes);
        reach.add(pair, margin);
        for (int n = 0; n < 200; ++n) {
          const DirectionPair moved = {near(pair.i, margin, random), near(pair.v, margin, random)};
          ASSERT_TRUE(reach.cells().has(cell_of(axes, moved)))
              << geometry(axes.frame).name() << ", margin " << margin << ", "
              << testing::PrintToString(axes.axes[0].nodes_deg);
        }
      }
    }
  }
}

TEST(ReachedCells, OfOnePairIsItsCellAndHardlyMore) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> theta(20, 60);
  std::uniform_real_distribution<double> phi(0, 360);
  for (const FrameSpec& spec : frames()) {
    const AtlasLayout axes = axes_of(spec);
    std::size_t cells = 0;
    constexpr std::size_t kPairs = 200;
    for (std::size_t k = 0; k < kPairs; ++k) {
      const DirectionPair pair = {direction_from_degrees(theta(random), phi(random)),
                                  direction_from_degrees(theta(random), phi(random))};
      ReachedCells reach(axes);
      reach.add(pair, 0);
      EXPECT_TRUE(reach.cells().has(cell_of(axes, pair)));
      cells += reach.cells().size();
    }
    EXPECT_LE(cells, kPairs + kPairs / 20);
  }
}

/// Whether some pair of a cell of the half/difference frame has both thetas up to a limit.
bool has_pair_up_to(const AtlasLayout& axes, const AtlasCell& cell, double theta_max_deg) {
  constexpr int kSteps = 12;
  const auto angle = [&](std::size_t axis, int step) {
    const std::vector<double>& nodes = axes.axes[axis].nodes_deg;
    if (nodes.size() < 2) return radians_from_degrees(axis == kDiagonal ? 15.0 * step : 0.0);
    const double low = nodes[cell[axis]];
    return radians_from_degrees(low + (nodes[cell[axis] + 1] - low) * step / kSteps);
  };
  for (int d = 0; d <= kSteps; ++d) {
    const DirectionPair pair =
        pair_from_half_difference({angle(kVertical, 0), 0, angle(kHorizontal, 0), angle(kDiagonal, d)});
    if (std::max(pair.i.theta, pair.v.theta) <= radians_from_degrees(theta_max_deg) + 1e-9) return true;
  }
  return false;
}

TEST(ReachedCells, UpToAThetaMaxHasAllCellsWithSuchPairsAndNoOthers) {
  std::mt19937_64 random(6);
  for (const FrameSpec& spec : frames()) {
    const AtlasLayout axes = axes_of(spec);
    std::size_t before = 0;
    for (const double theta_max : {10.0, 30.0, 55.0, 90.0}) {
      ReachedCells reach(axes);
      reach.add_up_to(theta_max);
      std::uniform_real_distribution<double> theta(0, theta_max);
      std::uniform_real_distribution<double> phi(0, 360);
      for (int k = 0; k < 3000; ++k) {
        const DirectionPair pair = {direction_from_degrees(theta(random), phi(random)),
                                    direction_from_degrees(theta(random), phi(random))};
        ASSERT_TRUE(reach.cells().has(cell_of(axes, pair))) << theta_max;
      }
      EXPECT_GE(reach.cells().size(), before);
      before = reach.cells().size();
      reach.cells().for_each([&](const AtlasCell& cell) {
        if (axes.frame == FrameId::kHalfDifference) {
          EXPECT_TRUE(has_pair_up_to(axes, cell, theta_max)) << theta_max;
        } else {
          EXPECT_LE(axes.axes[kHorizontal].nodes_deg[cell[kHorizontal]], theta_max);
        }
      });
    }
  }
}

SampledBrdf sampled(const FrameSpec& spec) {
  return sample_function(
      spec, 300, DomainKind::kLog,
      [&](const DirectionPair& pair, std::size_t channel) {
        return std::pow(analytic_brdf(pair, spec.symmetries), 1.0 + 0.5 * static_cast<double>(channel));
      },
      3);
}

/// Cells about some pairs, at the pole or not.
AtlasCells some_cells(const AtlasLayout& axes, int pairs, std::mt19937_64& random) {
  ReachedCells reach(axes);
  for (int k = 0; k < pairs; ++k) reach.add(pair_up_to(random), 2);
  return reach.cells();
}

TEST(PartOfAtlas, HasTheValuesOfTheWholeWhereItHoldsCellsAndElseTheColour) {
  std::mt19937_64 random(7);
  for (const FrameSpec& spec : frames()) {
    const SampledBrdf made = sampled(spec);
    for (const bool blocks : {false, true}) {
      const Atlas whole =
          bake_atlas(made.sliced, made.lattice, {.tolerance = 0.02, .blocks = blocks, .dense = blocks}).value();
      const AtlasCells cells = some_cells(whole.layout, blocks ? 1 : 6, random);
      const Atlas part =
          bake_atlas(made.sliced, made.lattice, {.tolerance = 0.02, .blocks = blocks, .dense = blocks, .cells = cells})
              .value();
      EXPECT_LE(part.texels.size(), whole.texels.size() + 48 * std::size_t{whole.layout.width});
      const AtlasEvaluator of_whole(whole);
      const AtlasEvaluator of_part(part);
      for (int k = 0; k < 3000; ++k) {
        const DirectionPair pair = pair_up_to(random);
        Rgb expected{};
        Rgb values{};
        of_whole.evaluate(pair, expected);
        of_part.evaluate(pair, values);
        ASSERT_EQ(of_part.holds(pair), cells.has(cell_of(part.layout, pair)));
        if (!of_part.holds(pair)) {
          ASSERT_EQ(values, kLeftOutColour);
          continue;
        }
        for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(values[c], expected[c], 1e-5 * std::abs(expected[c]) + 1e-9);
      }
    }
  }
}

TEST(DenseAtlas, IsOneTableAsNearToTheSlicesAsItsToleranceSays) {
  std::mt19937_64 random(10);
  for (const FrameSpec& spec : {frames()[6], frames()[7]}) {
    const SampledBrdf made = sampled(spec);
    const Evaluator slices(made.sliced, made.lattice);
    double before = 1;
    for (const double tolerance : {0.03, 0.003}) {
      const Atlas dense = bake_atlas(made.sliced, made.lattice, {.tolerance = tolerance, .dense = true}).value();
      ASSERT_EQ(dense.layout.tables.size(), 1U);
      const AtlasEvaluator evaluator(dense);
      double mean = 0;
      constexpr int kPairs = 2000;
      for (int k = 0; k < kPairs; ++k) {
        const DirectionPair pair = pair_up_to(random);
        Rgb expected{};
        Rgb values{};
        slices.evaluate(pair, expected);
        evaluator.evaluate(pair, values);
        for (std::size_t c = 0; c < 3; ++c) mean += std::abs(values[c] - expected[c]) / expected[c] / (3 * kPairs);
      }
      EXPECT_LE(mean, 3 * tolerance);
      EXPECT_LT(mean, 0.7 * before);
      before = mean;
    }
  }
  const SampledBrdf other = sampled(frames()[3]);
  EXPECT_EQ(dense_axis(other.lattice), std::nullopt);
  EXPECT_GT(bake_atlas(other.sliced, other.lattice, {.dense = true}).value().layout.tables.size(), 1U);
}

TEST(PartOfAtlas, OfAllCellsIsTheWhole) {
  const SampledBrdf made = sampled(frames()[3]);
  const Atlas whole = bake_atlas(made.sliced, made.lattice).value();
  EXPECT_TRUE(whole.layout.cells.is_everything());
  ReachedCells reach(whole.layout);
  reach.add_up_to(90);
  const Atlas part = bake_atlas(made.sliced, made.lattice, {.cells = reach.cells()}).value();
  std::size_t texels = 0;
  for (const AtlasTable& table : part.layout.tables) {
    for (const AtlasTile& tile : table.tiles) texels += std::size_t{tile.width} * tile.height;
  }
  EXPECT_LE(texels, std::size_t{whole.layout.width} * whole.layout.height);
  EXPECT_GT(reach.cells().size(), 0U);
}

TEST(PartOfAtlas, HasTilesThatDoNotOverlap) {
  std::mt19937_64 random(8);
  for (const FrameSpec& spec : frames()) {
    const SampledBrdf made = sampled(spec);
    const AtlasLayout axes = axes_of(spec);
    const Atlas part =
        bake_atlas(made.sliced, made.lattice, {.tolerance = 0.05, .blocks = true, .cells = some_cells(axes, 4, random)})
            .value();
    const AtlasLayout& layout = part.layout;
    std::vector<int> covered(std::size_t{layout.width} * layout.height);
    const auto cover = [&](std::uint32_t x, std::uint32_t y, std::uint32_t width, std::uint32_t height) {
      ASSERT_LE(x + width, layout.width);
      ASSERT_LE(y + height, layout.height);
      EXPECT_EQ((x | y | width | height) % 4, 0U);
      for (std::uint32_t row = y; row < y + height; ++row) {
        for (std::uint32_t column = x; column < x + width; ++column) ++covered[row * layout.width + column];
      }
    };
    for (const AtlasTable& table : layout.tables) {
      for (const AtlasTile& tile : table.tiles) cover(tile.x, tile.y, tile.width, tile.height);
    }
    if (layout.ring) cover(layout.ring->x, layout.ring->y, layout.ring->tile_width, layout.ring->tile_height);
    EXPECT_LE(*std::max_element(covered.begin(), covered.end()), 1);
  }
}

TEST(PartOfAtlas, IsRefusedForNoCellsAndForCellsOfOtherAxes) {
  const SampledBrdf made = sampled(frames()[1]);
  const AtlasLayout axes = axes_of(frames()[1]);
  const Result<Atlas> none = bake_atlas(made.sliced, made.lattice, {.cells = AtlasCells(cell_counts(axes))});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kUsage);
  ReachedCells other(atlas_axes(build_lattice(frames()[2]).value()));
  other.add_up_to(90);
  const Result<Atlas> wrong = bake_atlas(made.sliced, made.lattice, {.cells = other.cells()});
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::kUsage);
}

TEST(PartOfAtlas, SaysInItsShaderWhatIsLeftOut) {
  std::mt19937_64 random(9);
  const SampledBrdf made = sampled(frames()[4]);
  const AtlasLayout axes = axes_of(frames()[4]);
  const Atlas part = bake_atlas(made.sliced, made.lattice, {.cells = some_cells(axes, 2, random)}).value();
  EXPECT_THAT(atlas_shader(part), testing::HasSubstr("#ifdef SBRDF_DEBUG"));
  const Atlas whole = bake_atlas(made.sliced, made.lattice).value();
  EXPECT_THAT(atlas_shader(whole), testing::Not(testing::HasSubstr("SBRDF_DEBUG")));
}

}  // namespace
}  // namespace sbrdf::internal
