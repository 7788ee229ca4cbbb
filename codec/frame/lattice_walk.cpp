#include "codec/frame/lattice_walk.h"

namespace sbrdf::internal {

std::vector<LatticePoint> first_points(const Lattice& lattice) {
  // Without a branch: whether a point is a first one is hard to foresee.
  std::vector<LatticePoint> first(lattice.crossings.size() + 1);
  std::size_t next = 0;
  std::size_t k = 0;
  walk_lattice(lattice, kAxisCount, [&](const LatticePoint& p) {
    first[next] = p;
    next += lattice.corners[k++] == next ? 1 : 0;
  });
  first.pop_back();
  return first;
}

std::vector<LatticeLine> first_lines(const Lattice& lattice) {
  std::vector<LatticeLine> first;
  first.reserve(lattice.slices.size());
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (lattice.lines[axis].empty()) continue;
    std::size_t k = 0;
    walk_lattice(lattice, axis, [&](const LatticePoint& p) {
      // A constant's target is no number of a slice.
      if (lattice.lines[axis][k++].target == first.size()) first.push_back({axis, p});
    });
  }
  return first;
}

}  // namespace sbrdf::internal
