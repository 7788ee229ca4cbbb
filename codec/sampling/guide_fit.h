#pragma once

#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "codec/sampling/adaptive_sampling.h"

namespace sbrdf {

/// Fits a guide: at each of its angles the mean of the source in the value domain over the lattice's other three axes,
/// as far as those directions lie above the horizon. Angles are added where the spline through the others is worst, up
/// to `sample_count` (at least the theta_h nodes). `sliced` gives frame, domain and channels.
[[nodiscard]] Result<Guide> fit_guide(const SlicedBrdf& sliced, const Lattice& lattice, double ratio,
                                      std::size_t sample_count, const Measure& measure);

}  // namespace sbrdf
