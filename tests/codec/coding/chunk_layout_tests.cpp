#include "codec/coding/chunk_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "codec/coding/crossing_order.h"
#include "codec/coding/guide_steps.h"
#include "codec/file/index.h"

namespace sbrdf::internal {
namespace {

using Point = std::array<std::uint32_t, kAxisCount>;

std::vector<Lattice> lattices() {
  std::vector<Lattice> made;
  for (const Symmetries& symmetries : {Symmetries{}, Symmetries{.isotropic = true, .mirror_x = true},
                                       Symmetries{.mirror_x = true, .mirror_y = true}}) {
    made.push_back(build_lattice(elevation_frame(20, 60, symmetries).value()).value());
    const std::vector<double> phi_h = symmetries.isotropic ? std::vector{0.0} : std::vector{0.0, 90.0, 180.0, 270.0};
    made.push_back(
        build_lattice(half_difference_frame({0, 2, 10, 30, 80}, {0, 20, 80}, phi_h, {0, 45, 90, 135}, symmetries))
            .value());
  }
  return made;
}

/// Whole, split, one node to a block, and sizes that do not divide anything.
std::vector<ChunkLayout> layouts(const Lattice& lattice) {
  ChunkLayout single;
  for (auto& block : single.block_nodes) block = {1, 1, 1, 1};
  ChunkLayout odd;
  odd.piece_depths = {1, 3, 7};
  odd.block_nodes = {{{0, 3, 2, 0}, {5, 0, 1, 2}, {1, 2, 0, 3}, {2, 2, 2, 0}, {3, 0, 2, 100}}};
  return {ChunkLayout(), split_layout(lattice, 3000), single, odd};
}

/// The first point of the padded lattice at which something is met: axis 0 fastest, axis 3 slowest, the `moving` axis
/// left out.
template <class IsThere>
Point first_met(const Lattice& lattice, std::size_t moving, const IsThere& is_there) {
  std::array<std::size_t, kAxisCount> counts{};
  std::size_t total = 1;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    counts[axis] = axis == moving ? 1 : lattice.nodes[axis].size();
    total *= counts[axis];
  }
  for (std::size_t k = 0; k < total; ++k) {
    Point p{};
    std::size_t rest = k;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      p[axis] = static_cast<std::uint32_t>(rest % counts[axis]);
      rest /= counts[axis];
    }
    if (is_there(p)) return p;
  }
  ADD_FAILURE() << "met nowhere";
  return {};
}

std::uint32_t at(const Point& p, const Strides& strides) {
  std::uint32_t k = 0;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) k += p[axis] * strides[axis];
  return k;
}

Point first_point_of(const Lattice& lattice, std::uint32_t crossing) {
  return first_met(lattice, kAxisCount,
                   [&](const Point& p) { return lattice.corners[at(p, lattice.corner_strides)] == crossing; });
}

/// Lines along axis 0 are walked before those along axis 1, and so on.
Point first_line_of(const Lattice& lattice, std::uint32_t slice) {
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const auto& lines = lattice.lines[axis];
    if (lattice.nodes[axis].size() < 2) continue;
    const auto refers = [&](const LineReference& line) { return !line.is_constant() && line.target == slice; };
    if (std::none_of(lines.begin(), lines.end(), refers)) continue;
    return first_met(lattice, axis, [&](const Point& p) { return refers(lines[at(p, lattice.line_strides[axis])]); });
  }
  ADD_FAILURE() << "slice " << slice << " is met nowhere";
  return {};
}

/// Place of the block, in the order in which places are compared.
std::array<std::uint32_t, kAxisCount> place_of(const Point& p, const std::array<std::uint32_t, kAxisCount>& nodes) {
  const auto along = [&](std::size_t axis) { return nodes[axis] == 0 ? 0 : p[axis] / nodes[axis]; };
  return {along(3), along(2), along(1), along(0)};
}

/// Blocks have a member each, members of one place, rising; places rise from block to block.
template <class PlaceOf>
void expect_in_order(const Blocks& blocks, const PlaceOf& place) {
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    ASSERT_FALSE(blocks[b].empty());
    EXPECT_TRUE(std::is_sorted(blocks[b].begin(), blocks[b].end()));
    for (const std::uint32_t member : blocks[b]) EXPECT_EQ(place(member), place(blocks[b][0]));
    if (b == 0) continue;
    EXPECT_LT(place(blocks[b - 1][0]), place(blocks[b][0]));
  }
}

TEST(LevelOf, Is16LessTheTrailingZeros) {
  EXPECT_EQ(depth_of(0), 0);
  for (std::uint32_t fraction = 1; fraction < 65'536; ++fraction) {
    int depth = 16;
    for (std::uint32_t rest = fraction; rest % 2 == 0; rest /= 2) --depth;
    ASSERT_EQ(depth_of(fraction), depth) << fraction;
  }
}

TEST(FirstPoints, AreWhereCrossingsAreMetFirst) {
  for (const Lattice& lattice : lattices()) {
    const std::vector<Point> first = first_points(lattice);
    ASSERT_EQ(first.size(), lattice.crossings.size());
    for (std::uint32_t k = 0; k < first.size(); ++k) EXPECT_EQ(first[k], first_point_of(lattice, k)) << k;
  }
}

TEST(MakeBlocks, PutsEveryCrossingAndSliceInExactlyOneBlock) {
  for (const Lattice& lattice : lattices()) {
    for (const ChunkLayout& layout : layouts(lattice)) {
      const LatticeBlocks blocks = make_blocks(lattice, layout);
      std::multiset<std::uint32_t> crossings;
      for (std::uint32_t b = 0; b < blocks.crossings.size(); ++b) {
        crossings.insert(blocks.crossings[b].begin(), blocks.crossings[b].end());
      }
      EXPECT_EQ(crossings.size(), lattice.crossings.size());
      for (std::uint32_t k = 0; k < lattice.crossings.size(); ++k) EXPECT_EQ(crossings.count(k), 1U);
      std::multiset<std::uint32_t> slices;
      for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
        for (std::uint32_t b = 0; b < blocks.slices[kind].size(); ++b) {
          slices.insert(blocks.slices[kind][b].begin(), blocks.slices[kind][b].end());
          for (const std::uint32_t k : blocks.slices[kind][b]) {
            EXPECT_EQ(lattice.slices[k].kind, kind);
          }
        }
      }
      EXPECT_EQ(slices.size(), lattice.slices.size());
      for (std::uint32_t k = 0; k < lattice.slices.size(); ++k) EXPECT_EQ(slices.count(k), 1U);
    }
  }
}

TEST(MakeBlocks, OrdersBlocksByTheirPlaceAndMembersByNumber) {
  for (const Lattice& lattice : lattices()) {
    std::vector<Point> lines;
    for (std::uint32_t k = 0; k < lattice.slices.size(); ++k) lines.push_back(first_line_of(lattice, k));
    const std::vector<Point> points = first_points(lattice);
    for (const ChunkLayout& layout : layouts(lattice)) {
      const LatticeBlocks blocks = make_blocks(lattice, layout);
      expect_in_order(blocks.crossings, [&](std::uint32_t k) {
        return place_of(points[k], layout.block_nodes[ChunkLayout::kCrossings]);
      });
      for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
        expect_in_order(blocks.slices[kind],
                        [&](std::uint32_t k) { return place_of(lines[k], layout.block_nodes[kind]); });
      }
    }
  }
}

TEST(ChunkOrder, IsGuideCrossingsThenPieceByPieceKindByKindBlockByBlock) {
  for (const Lattice& lattice : lattices()) {
    for (const ChunkLayout& layout : layouts(lattice)) {
      const LatticeBlocks blocks = make_blocks(lattice, layout);
      const ChunkOrder order(blocks, layout.piece_depths.size());
      EXPECT_EQ(ChunkOrder::kGuide, 0U);
      std::size_t next = 1;
      for (std::size_t b = 0; b < blocks.crossings.size(); ++b) EXPECT_EQ(order.crossings(b), next++);
      for (std::size_t piece = 0; piece < layout.piece_depths.size(); ++piece) {
        for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
          for (std::size_t b = 0; b < blocks.slices[kind].size(); ++b) {
            EXPECT_EQ(order.slices(piece, kind, b), next++);
          }
        }
      }
      EXPECT_EQ(order.count(), next);
    }
  }
}

TEST(WholeLayout, HasOneBlockOfCrossingsAndOneOfEachKind) {
  for (const Lattice& lattice : lattices()) {
    const LatticeBlocks blocks = make_blocks(lattice, ChunkLayout());
    EXPECT_EQ(blocks.crossings.size(), 1U);
    for (const Blocks& kind : blocks.slices) EXPECT_LE(kind.size(), 1U);
  }
}

std::size_t chunk_count(const Lattice& lattice, const ChunkLayout& layout) {
  return ChunkOrder(make_blocks(lattice, layout), layout.piece_depths.size()).count();
}

TEST(SplitLayout, KeepsAboutAThousandChunksForABigLattice) {
  const Lattice big = build_lattice(elevation_frame(8, 30, {}).value()).value();
  ASSERT_GT(big.slices.size(), 4000U);
  const std::size_t few = chunk_count(big, split_layout(big, 20'000));
  EXPECT_LE(few, 2000U);
  EXPECT_GE(few, 500U);
  const std::size_t many = chunk_count(big, split_layout(big, 640'000));
  EXPECT_LE(many, 10'000U + 2);
  EXPECT_GT(many, few);
}

TEST(SplitLayout, HasPiecesAndBlocksThatAFileMayHave) {
  for (const Lattice& lattice : lattices()) {
    for (const std::size_t samples : {std::size_t{0}, std::size_t{3000}, std::size_t{100'000}}) {
      const ChunkLayout layout = split_layout(lattice, samples);
      EXPECT_EQ(layout.piece_depths.front(), 1);
      EXPECT_TRUE(std::is_sorted(layout.piece_depths.begin(), layout.piece_depths.end()));
      for (std::size_t kind = 0; kind < kAxisCount; ++kind) EXPECT_EQ(layout.block_nodes[kind][kind], 0U);
      EXPECT_GT(chunk_count(lattice, layout), chunk_count(lattice, ChunkLayout()));
    }
  }
}

TEST(LevelsOfPiece, ShareOutAllLevels) {
  for (const ChunkLayout& layout : layouts(lattices()[0])) {
    int next = 1;
    for (std::size_t piece = 0; piece < layout.piece_depths.size(); ++piece) {
      const auto [first, end] = depths_of_piece(layout, piece);
      EXPECT_EQ(first, next);
      EXPECT_GT(end, first);
      next = end;
    }
    EXPECT_EQ(next, kMaxDepth + 1);
  }
}

TEST(CrossingPlan, CodesEveryCrossingOnceFromThoseOfItsBlockBeforeIt) {
  for (const Lattice& lattice : lattices()) {
    for (const ChunkLayout& layout : layouts(lattice)) {
      const LatticeBlocks blocks = make_blocks(lattice, layout);
      const CrossingPlan plan = plan_crossings(lattice, blocks);
      ASSERT_EQ(plan.block_begin.size(), blocks.crossings.size() + 1);
      ASSERT_EQ(plan.block_begin.back(), plan.steps.size());
      for (std::uint32_t b = 0; b < blocks.crossings.size(); ++b) {
        std::set<std::uint32_t> coded;
        for (std::uint32_t s = plan.block_begin[b]; s < plan.block_begin[b + 1]; ++s) {
          const CrossingPlan::Step& step = plan.steps[s];
          EXPECT_EQ(step.stencil_count == 0, coded.empty());
          for (std::uint32_t k = 0; k < step.stencil_count; ++k) {
            const Stencil& stencil = plan.stencils[step.first_stencil + k];
            ASSERT_GE(stencil.count, 1U);
            double sum = 0;
            for (std::uint32_t m = 0; m < stencil.count; ++m) {
              EXPECT_TRUE(coded.contains(stencil.member[m]));
              EXPECT_LE(std::abs(stencil.weight[m]), 2.5);
              sum += stencil.weight[m];
            }
            EXPECT_NEAR(sum, 1, 1e-12);
          }
          EXPECT_TRUE(coded.insert(step.crossing).second);
        }
        EXPECT_EQ((std::vector<std::uint32_t>(coded.begin(), coded.end())), blocks.crossings[b]);
      }
    }
  }
}

TEST(SetWeights, GivesBackEveryPolynomialThatTheMembersDetermine) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> gap(0.5, 20);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> positions = {gap(random)};
    while (positions.size() < 1 + static_cast<std::size_t>(trial) % 4)
      positions.push_back(positions.back() + gap(random));
    const double x = positions.front() + gap(random) - 5;
    Stencil stencil;
    stencil.count = static_cast<std::uint32_t>(positions.size());
    set_weights(stencil, positions, x);
    for (std::size_t power = 0; power < positions.size(); ++power) {
      double sum = 0;
      double size = 0;
      for (std::size_t k = 0; k < positions.size(); ++k) {
        const double term = stencil.weight[k] * std::pow(positions[k], static_cast<double>(power));
        sum += term;
        size += std::abs(term);
      }
      EXPECT_NEAR(sum, std::pow(x, static_cast<double>(power)), 1e-10 * (1 + size));
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
