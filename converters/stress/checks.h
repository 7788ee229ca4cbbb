#pragma once

#include "converters/stress/trial.h"

// One function for each topic of the stress suite: the row of one frame and one domain, without its name. Materials and
// places are drawn from the trial's random numbers.

namespace sbrdf::internal::stress {

// check_directions.cpp: what must hold for special directions and between directions.

/// theta of 0, 80, 89.9 and 90 degrees, in one azimuth, opposite ones and any: float against exact.
[[nodiscard]] StressRow check_theta(Trial& trial);
/// Whole turns of either azimuth: the same bits.
[[nodiscard]] StressRow check_turns(Trial& trial);
/// Both directions exchanged: the same bits.
[[nodiscard]] StressRow check_reciprocity(Trial& trial);
/// An isotropic material, both directions turned by one angle: relative change.
[[nodiscard]] StressRow check_isotropy(Trial& trial);
/// The two sides of every node, where no clamp acts: jump as a part of the local maximum.
[[nodiscard]] StressRow check_continuity(Trial& trial);

// check_values.cpp: samples of unusual size.

/// Samples from 1e-30 to 1e12: values that are not finite or negative.
[[nodiscard]] StressRow check_range(Trial& trial);
/// Samples that are 0: 0 comes back at them.
[[nodiscard]] StressRow check_zeros(Trial& trial);
/// Constants, 1e-30, 1e12 and 0 among them: the same bits everywhere.
[[nodiscard]] StressRow check_constants(Trial& trial);
/// Very different samples side by side: values that are not finite or negative.
[[nodiscard]] StressRow check_spikes(Trial& trial);
/// Samples as close as they may lie: each comes back, and all else is finite.
[[nodiscard]] StressRow check_minimum_gap(Trial& trial);

// check_accuracy.cpp: float against exact.

/// A function that the linear domain gives back exactly but for roundings.
[[nodiscard]] StressRow check_linear(Trial& trial);
/// Axes of one node and slices of one sample.
[[nodiscard]] StressRow check_single(Trial& trial);
/// Kurt materials with some thousand samples.
[[nodiscard]] StressRow check_accuracy(Trial& trial);

}  // namespace sbrdf::internal::stress
