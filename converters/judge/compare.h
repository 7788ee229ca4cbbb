#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "converters/difference/error_sums.h"
#include "converters/difference/false_values.h"
#include "converters/judge/compared_pairs.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"

namespace sbrdf::internal {

/// How two sources are compared.
struct CompareOptions : PairOptions {
  bool symmetrise = false;  ///< the reference is replaced by the mean of f(i,v) and f(v,i)
  /// Smallest denominator of relative errors [1/sr]. Unless given: 0 on the grid, else a hundredth of the mean |f| over
  /// the draw and the channels, as for held-back directions.
  std::optional<double> floor;
  FalseValueSearch false_values = FalseValueSearch::kAll;
};

/// Differences of a test r from a reference f, over all pairs and channels together.
struct Comparison : ErrorFigures {
  std::vector<ErrorFigures> channels;  ///< each by itself
  FalseValues false_values;            ///< none, and not complete, where they were not looked for
  double floor = 0;                    ///< that was used [1/sr]
  std::uint64_t directions = 0;        ///< pairs evaluated
  std::uint64_t unmeasured = 0;        ///< pairs left out, which one of the two did not measure
  std::uint64_t grid_directions = 0;   ///< pairs of the grid that these stand for, each as often as any other
};

/// Pairs that one of the two did not measure are left out. Where both sources are isotropic, only pairs of the grid
/// with phi_v = 0 are evaluated: the same means. The same bits for any number of threads. False values are looked for
/// until 10,000 were found, by the strict count if that is made, or 1,000 in one block of pairs. kUnsupported where the
/// numbers of channels differ; kUsage for options out of range and where no pair was measured; interrupted_error().
[[nodiscard]] Result<Comparison> compare_sources(const BrdfSource& reference, const BrdfSource& test,
                                                 const CompareOptions& options, const Progress& progress = {});

}  // namespace sbrdf::internal
