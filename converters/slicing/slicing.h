#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "codec/file/encoder.h"
#include "codec/material/sliced_brdf.h"
#include "codec/search/held_back.h"
#include "converters/difference/error_sums.h"
#include "converters/difference/false_values.h"
#include "converters/slicing/options.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"

namespace sbrdf::internal {

/// What slicing changed. Counts are of channel values among the samples taken.
struct SliceReport {
  double reciprocity_difference_percent = 0;  ///< of the source before it was symmetrised
  std::uint64_t values = 0;
  std::uint64_t zero_values = 0;
  std::uint64_t negative_values = 0;
  std::uint64_t wanted_samples = 0;
  bool fitted = false;  ///< values at samples are not the source's, but nearer to it between samples
  std::uint64_t filled_samples =
      0;                      ///< at directions that the source did not measure: FilledSource says what they hold
  double theta_max_deg = 90;  ///< of the slices
  HeldBackError error;        ///< on directions that took no part in any choice
  std::uint64_t error_directions = 0;
  ErrorFigures figures;                ///< on the same, all channels together, with the same floor
  FalseValues false_values;            ///< on the same, without the strict counts
  bool error_values_all_zero = false;  ///< the source is zero on them: the error is 0 or infinite, and says nothing
  std::vector<std::string> reasons;    ///< why this structure, where one was searched for
};

struct Slicing {
  SlicedBrdf sliced;
  Lattice lattice;
  SliceReport report;
  std::optional<double> precision =
      std::nullopt;  ///< of the file, see EncodeOptions; open as long as samples are sought
};

/// How a file of a slicing is coded.
[[nodiscard]] inline EncodeOptions encoding_of(const Slicing& slicing, const SliceOptions& options) {
  return {slicing.precision.value_or(0), options.chunks};
}

/// Samples a source into slices. One that is not reciprocal is replaced by the mean of f(i,v) and f(v,i). `metadata` of
/// the result records the source, the choices and the report.
///
/// kUsage for a placement or a number of samples that cannot be; kInvalidFile where the source gives a NaN, an
/// infinity, or no positive value at all; kDifference where a target cannot be reached or no file is small enough,
/// saying how far it came; kUnsupported where no structure has a finite error; interrupted_error() where `progress`
/// asked to stop. Progress ends at 1 with a result and with kDifference.
[[nodiscard]] Result<Slicing> slice_source(const BrdfSource& source, const SliceOptions& options,
                                           const Progress& progress = {});

}  // namespace sbrdf::internal
