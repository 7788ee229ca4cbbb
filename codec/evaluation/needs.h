#pragma once

#include <vector>

#include "codec/frame/cells.h"
#include "codec/frame/lattice.h"

namespace sbrdf::internal {

/// Crossings and slices, each marked or not, by their numbers.
struct LatticeParts {
  std::vector<bool> crossings;
  std::vector<bool> slices;
};
/// What evaluation within some cells uses: their sixteen corners, their thirty-two lines, at a pole what lies on its
/// ring beside them (see PoleRing), and all crossings of these lines, since a spline takes all samples of its slice.
[[nodiscard]] LatticeParts needs_of(const Lattice& lattice, const CellSet& cells);

}  // namespace sbrdf::internal
