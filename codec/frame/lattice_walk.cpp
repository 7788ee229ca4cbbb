#include "codec/frame/lattice_walk.h"

namespace sbrdf {

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

}  // namespace sbrdf
