#pragma once

#include "codec/importance/importance_table.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// A source for those who have vectors; one of slices through a VectorEvaluator. `source` must outlive it.
[[nodiscard]] VectorBrdf vector_brdf_of(const BrdfSource& source);

}  // namespace sbrdf::internal
