#pragma once

#include "codec/evaluation/tables/slice_tables.h"

namespace sbrdf::internal {

/// The curves of `exact` as straight lines between equally distant rows, bucket by bucket as many as it takes: no curve
/// is more than `tolerance` off, in the value domain. For logarithms that is the relative error of what stands on a
/// slice; for linear values it counts relative to the value, or to a thousandth of the largest of the curve. Sums of
/// slices are off by some times as much. Steps are not made smaller than a 1024th of a bucket.
[[nodiscard]] SliceTables presample(const SliceTables& exact, double tolerance);

}  // namespace sbrdf::internal
