#pragma once

#include "codec/importance/importance_table.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// A source as what importance sampling takes. `source` must outlive it.
[[nodiscard]] VectorBrdf vector_brdf_of(const BrdfSource& source);

}  // namespace sbrdf::internal
