#pragma once

#include "converters/slicing/slicer.h"

namespace sbrdf::internal {

/// The slicing that the stop rule of the slicer's options asks for, not finished. Looking for the number of samples
/// goes through many numbers, each sliced with Effort::kStarts; the one that is found is sliced with all effort.
///
/// kDifference where the rule asks for what cannot be, saying how far it came: the least error that was reached and
/// what it took, or the size of the smallest file. Otherwise the errors of Slicer::slice().
[[nodiscard]] Result<Slicing> slice_by_rule(const Slicer& slicer, const Progress& progress);

}  // namespace sbrdf::internal
