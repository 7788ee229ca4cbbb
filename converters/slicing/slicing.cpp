#include "converters/slicing/slicing.h"

#include <algorithm>

#include "converters/slicing/slicer.h"
#include "converters/slicing/stop_rules.h"

namespace sbrdf::internal {
namespace {

constexpr double kSlicingShare = 0.98;  // of the work; the rest is the report

bool has_positive(const SlicedBrdf& sliced) {
  const auto positive = [](float v) { return v > 0; };
  return std::any_of(sliced.crossing_values.begin(), sliced.crossing_values.end(), positive) ||
         std::any_of(sliced.sample_values.begin(), sliced.sample_values.end(), positive);
}

}  // namespace

Result<Slicing> slice_source(const BrdfSource& source, const SliceOptions& options, const Progress& progress) {
  const Result<Slicer> slicer = Slicer::make(source, options);
  if (!slicer) return slicer.error();
  StepwiseProgress steps(progress);
  Result<Slicing> slicing = slice_by_rule(*slicer, steps.step(kSlicingShare));
  if (!slicing && slicing.error().code != ErrorCode::kDifference) return slicing;
  if (slicing) {
    slicer->look_closer(slicer->finish(*slicing), *slicing);
  }
  if (!steps.finish()) return interrupted_error();
  if (slicing && !has_positive(slicing->sliced)) {
    return invalid_file("none of the " + std::to_string(slicing->report.values) +
                        " values sampled is positive; this is no reflectance");
  }
  return slicing;
}

}  // namespace sbrdf::internal
