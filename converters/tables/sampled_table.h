#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "converters/tables/dense_source.h"
#include "converters/tables/grid.h"
#include "converters/tables/value_policy.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// How a table is made of a source.
struct TableRequest {
  Grid grid;
  ValuePolicy policy = {Negatives::kKeep, NonFinite::kRefuse};
  double largest = kTableLargest;  ///< values beyond are held there and counted: 65504 of half floats
};

/// What a table that was made holds of its source. Counts are of nodes.
struct TableLosses {
  std::uint64_t nodes = 0;
  std::uint64_t below_horizon = 0;     ///< the pair of the node lies below the horizon
  std::uint64_t unmeasured = 0;        ///< above it, not measured by the source
  std::uint64_t non_finite = 0;        ///< above it, NaN or infinite, made unmeasured as the policy says
  std::uint64_t some_negative = 0;     ///< above it, some channels below 0, not all
  std::uint64_t all_negative = 0;      ///< above it, all channels below 0
  std::uint64_t clamped = 0;           ///< above it, some channel beyond the largest
  std::uint64_t beyond_theta_max = 0;  ///< above it, a direction beyond the source's theta_max
  bool positive = false;               ///< a value above 0 is left
  bool copied = false;                 ///< the source is a table of the same grid: its numbers, nothing interpolated
};

/// A block of nodes: `count` along each axis from `first` on.
struct TableBlock {
  GridNode first = {0, 0, 0, 0};
  std::array<std::uint32_t, 4> count = {1, 1, 1, 1};

  [[nodiscard]] std::uint64_t node_count() const { return std::uint64_t{count[0]} * count[1] * count[2] * count[3]; }
};

/// Takes the values of a block [f_r], its nodes in C order with the channel fastest. A node that is unmeasured, or
/// below the horizon, has NaN in every channel.
using TakeBlock = std::function<Status(const TableBlock& block, std::span<const double> values)>;

/// The source's value at every node, a block after the other in C order, on all cores; a few MB are in memory at a
/// time. `block` is how many nodes of each axis make one (fewer at the ends of axes), at most some hundred thousand.
/// The same values for any number of threads.
///
/// A source that is no table of the same grid is evaluated: give one that was made reciprocal where the grid is, and
/// one whose phi_i is 0 where it is isotropic. kInvalidFile where the source gives a value that is not finite and the
/// policy refuses that; where nothing is positive; interrupted_error(); the errors of `take`.
[[nodiscard]] Result<TableLosses> sample_table(const BrdfSource& source, const TableRequest& request,
                                               std::array<std::uint32_t, 4> block, const TakeBlock& take,
                                               const Progress& progress);

/// Whether `source` consists of a table of just this grid, so that sample_table copies its numbers.
[[nodiscard]] bool is_table_of(const BrdfSource& source, const Grid& grid);

/// A block for files that are written in C order: whole rows of the last two axes, or of the last alone.
[[nodiscard]] std::array<std::uint32_t, 4> rows_of(const Grid& grid);

}  // namespace sbrdf::internal
