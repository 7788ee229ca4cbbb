#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/evaluation/vector_evaluator.h"
#include "codec/series/series.h"
#include "converters/slicing/slicing.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"

namespace sbrdf::internal {

/// The largest table that a fit may ask for [bytes]: what every reader allows.
inline constexpr std::uint64_t kMostTableBytes = std::uint64_t{64} << 20U;

struct SeriesFit {
  SeriesBrdf brdf;
  /// Of its samples nothing is said: there are none.
  SliceReport report;
  std::size_t table_bytes = 0;  ///< of the values of its table
};

/// f_r of pairs of angles from the table of a series; 0 below the horizon.
void evaluate_pairs(const VectorEvaluator& table, std::span<const DirectionPair> pairs, std::span<float> values);

/// Fits a series to a source, made reciprocal if it is not: the smallest file that reaches the target of `options.stop`
/// on directions that choices are made by, or the least error within its bytes. Without either: 2 % relative L1. Of
/// `options`, what belongs to slices (structure but mirrors, domain, refinement, precision, chunks) has no meaning.
///
/// kInvalidFile where the source gives a value that is not finite, or none that is positive; kDifference where a target
/// cannot be reached or no file is small enough, saying how far it came; interrupted_error() where `progress` asked to
/// stop.
[[nodiscard]] Result<SeriesFit> fit_series(const BrdfSource& source, const SliceOptions& options,
                                           const Progress& progress = {});

}  // namespace sbrdf::internal
