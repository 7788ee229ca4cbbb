#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "converters/difference/error_sums.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// What a table, or any other file, gives back at directions at which its source is known.
struct ResamplingError : ErrorFigures {
  bool at_nodes = false;         ///< at the source's own nodes, where it is a table; else at random directions
  std::uint64_t directions = 0;  ///< that were looked at; 0: none of the drawn ones was measured
};

/// Evaluates many pairs: values as BrdfSource::evaluate gives them.
using EvaluatePairs = std::function<void(std::span<const DirectionPair> pairs, std::span<float> values)>;

/// Compares at up to 20,000 directions: nodes of the source's own table that were measured and lie above the horizon,
/// picked at random, or those of a HighlightDraw as far as slices of it go. Denominators of relative errors are at
/// least a hundredth of the mean |f| over these. The same for each call, whatever the number of threads. `evaluate`
/// gives as many channels as the source has.
[[nodiscard]] ResamplingError resampling_error(const BrdfSource& source, const EvaluatePairs& evaluate);

}  // namespace sbrdf::internal
