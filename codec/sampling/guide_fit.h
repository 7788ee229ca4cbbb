#pragma once

#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "codec/sampling/adaptive_sampling.h"

namespace sbrdf::internal {

/// Fits a guide: at each of its angles the mean of the source in the value domain over the lattice's other three axes,
/// as far as those directions lie above the horizon. Angles are added where the spline through the others is worst, up
/// to `sample_count` (at least the theta_h nodes). `sliced` gives frame, domain and channels.
/// `ratio` as in Guide. Each angle costs one measurement of up to 12 x 12 azimuths times the theta_d nodes, which are
/// not kept. Fewer samples where no gap is worth halving: errors below 0.001 in the value domain, or gaps below 0.1
/// degree. The errors of `measure`.
[[nodiscard]] Result<Guide> fit_guide(const SlicedBrdf& sliced, const Lattice& lattice, double ratio,
                                      std::size_t sample_count, const Measure& measure);

}  // namespace sbrdf::internal
