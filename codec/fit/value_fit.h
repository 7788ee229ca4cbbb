#pragma once

#include <cstddef>

#include "codec/material/sliced_brdf.h"
#include "codec/search/held_back.h"
#include "codec/search/structure_search.h"

namespace sbrdf::internal {

/// Fits of more samples would take too much time and memory: all samples of a slice depend on each other.
inline constexpr std::size_t kMostFittedSamples = 30'000;

/// How many directions a fit should be given for so many samples: enough that none follows a few directions by chance.
[[nodiscard]] std::size_t fit_directions(std::size_t sample_count);

/// Moves the values at all samples so that the whole comes nearer to the source between them, where a slice is far:
/// interpolation keeps the source's values at samples and errs to one side in between. Places, domain and guide stay.
///
/// Least squares in the value domain, in which a reconstruction is linear in its values, weighed again and again so
/// that what is made small is the objective's error (mean or sum of |f - r|, not of squares), by conjugate gradients.
/// `directions`, with values f_r, must not be those that results are judged on. May be worse for other directions than
/// `sliced` is, where there are too few of them or slices are far from the source: the caller compares.
/// `sliced` itself where all values of `directions` are zero.
[[nodiscard]] SlicedBrdf fit_values(const SlicedBrdf& sliced, const Lattice& lattice, const HeldBack& directions,
                                    Objective objective);

}  // namespace sbrdf::internal
