#pragma once

#include <cstddef>

#include "codec/evaluation/tables/slice_tables.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

struct DenseLimits {
  /// Half way between two nodes of an axis, the mean of both is off by no more than this on average over drawn places,
  /// in the value domain: for logarithms relative to the value. For linear values it counts relative to the value
  /// there.
  double tolerance = 0.005;
  std::size_t most_bytes = std::size_t{8} << 20U;  ///< of the values; where they are reached the tolerance is not
};

/// The function of `exact` as a table of values at all combinations of nodes, with linear interpolation between them:
/// the nodes of the lattice, and more of them where the function bends. A poor trade where four axes move, the fastest
/// form where three do. What it is off by has to be measured: nothing bounds it.
[[nodiscard]] SliceTables make_dense(const SliceTables& exact, const SlicedBrdf& sliced, const Lattice& lattice,
                                     const DenseLimits& limits);

}  // namespace sbrdf::internal
