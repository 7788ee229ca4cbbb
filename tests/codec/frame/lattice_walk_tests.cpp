#include "codec/frame/lattice_walk.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

std::vector<Lattice> various_lattices() {
  std::vector<Lattice> lattices;
  for (const FrameSpec& spec :
       {elevation_frame(40, 60, {}).value(), elevation_frame(28, 90, {.isotropic = true}).value(),
        elevation_frame_from_nodes({0, 11, 80}, {0, 50, 200}, {0, 30, 330}, {}),
        half_difference_frame({0, 15, 40}, {0, 20, 40}, {0, 90, 180, 270}, {0, 45, 90, 135}, {.mirror_x = true}),
        half_difference_frame({0, 40}, {0, 80}, {0}, {0}, {.isotropic = true})}) {
    lattices.push_back(build_lattice(spec).value());
  }
  return lattices;
}

TEST(WalkGrid, VisitsEveryPointOnceWithAxis0Fastest) {
  std::vector<LatticePoint> visited;
  walk_grid({2, 1, 3, 1}, [&](const LatticePoint& p) { visited.push_back(p); });
  const std::vector<LatticePoint> expected = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 0, 1, 0},
                                              {1, 0, 1, 0}, {0, 0, 2, 0}, {1, 0, 2, 0}};
  EXPECT_EQ(visited, expected);
}

TEST(WalkLattice, MeetsPointsAndLinesInTheOrderOfTheirTables) {
  for (const Lattice& lattice : various_lattices()) {
    std::size_t next = 0;
    walk_lattice(lattice, kAxisCount,
                 [&](const LatticePoint& p) { ASSERT_EQ(index_at(p, lattice.corner_strides), next++); });
    EXPECT_EQ(next, lattice.corners.size());
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (lattice.nodes[axis].size() < 2) continue;
      next = 0;
      walk_lattice(lattice, axis,
                   [&](const LatticePoint& p) { ASSERT_EQ(index_at(p, lattice.line_strides[axis]), next++); });
      EXPECT_EQ(next, lattice.lines[axis].size());
    }
  }
}

TEST(FirstPoints, AreWhereEachCrossingIsMetFirst) {
  for (const Lattice& lattice : various_lattices()) {
    const std::vector<LatticePoint> first = first_points(lattice);
    ASSERT_EQ(first.size(), lattice.crossings.size());
    for (std::uint32_t k = 0; k < first.size(); ++k) {
      const auto met = std::find(lattice.corners.begin(), lattice.corners.end(), k);
      EXPECT_EQ(index_at(first[k], lattice.corner_strides), met - lattice.corners.begin());
    }
  }
}

TEST(FirstLines, AreWhereEachSliceIsMetFirst) {
  for (const Lattice& lattice : various_lattices()) {
    const std::vector<LatticeLine> first = first_lines(lattice);
    ASSERT_EQ(first.size(), lattice.slices.size());
    for (std::uint32_t k = 0; k < first.size(); ++k) {
      const auto on_slice = [&](const LineReference& line) { return line.target == k; };
      std::size_t axis = 0;
      while (std::none_of(lattice.lines[axis].begin(), lattice.lines[axis].end(), on_slice)) ++axis;
      const auto met = std::find_if(lattice.lines[axis].begin(), lattice.lines[axis].end(), on_slice);
      EXPECT_EQ(first[k].axis, axis);
      EXPECT_EQ(first[k].point[axis], 0U);
      EXPECT_EQ(index_at(first[k].point, lattice.line_strides[axis]), met - lattice.lines[axis].begin());
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
