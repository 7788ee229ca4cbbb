#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/frame/lattice.h"

namespace sbrdf::internal {

// Whatever goes through points, lines, cells or polar pairs of a lattice does so in one order, the one in which the
// file format numbers crossings and slices: axis 0 fastest.

/// A point of the padded lattice: the number of its node on each axis.
using LatticePoint = std::array<std::uint32_t, kAxisCount>;

/// Calls `visit(point)` for every point with point[axis] < counts[axis], axis 0 fastest.
template <class Visit>
void walk_grid(const LatticePoint& counts, const Visit& visit) {
  LatticePoint p{};
  for (p[3] = 0; p[3] < counts[3]; ++p[3])
    for (p[2] = 0; p[2] < counts[2]; ++p[2])
      for (p[1] = 0; p[1] < counts[1]; ++p[1])
        for (p[0] = 0; p[0] < counts[0]; ++p[0]) visit(p);
}

/// The same for every point of the padded lattice; on the axis `left_out` for the first node only, which visits the
/// lines along it once each (kAxisCount: no axis is left out). Crossings and slices have their numbers in the order in
/// which these walks meet them first.
template <class Visit>
void walk_lattice(const Lattice& lattice, std::size_t left_out, const Visit& visit) {
  LatticePoint counts{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    counts[axis] = axis == left_out ? 1 : static_cast<std::uint32_t>(lattice.nodes[axis].size());
  }
  walk_grid(counts, visit);
}

/// Where a table with these strides (Lattice::corner_strides, line_strides) holds what belongs to a point.
[[nodiscard]] inline std::uint32_t index_at(const LatticePoint& point, const Strides& strides) {
  std::uint32_t index = 0;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) index += point[axis] * strides[axis];
  return index;
}

/// A line of the padded lattice, through a point whose own place on `axis` is 0.
struct LatticeLine {
  std::size_t axis = 0;  ///< along which it runs
  LatticePoint point{};  ///< where it begins
};

/// The padded lattice point at which each crossing is met first, by number of the crossing.
[[nodiscard]] std::vector<LatticePoint> first_points(const Lattice& lattice);

/// The line on which each slice is met first, by number of the slice.
[[nodiscard]] std::vector<LatticeLine> first_lines(const Lattice& lattice);

}  // namespace sbrdf::internal
