#pragma once

#include "codec/frame/frame.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// The symmetries that a source keeps to rounding, found by evaluating it at random directions up to theta_max, many
/// of them near the mirror direction, and their images: a relative L1 difference below 1e-5. Isotropy is also taken
/// from the source's own traits.
[[nodiscard]] Symmetries detect_symmetries(const BrdfSource& source, double theta_max_deg = kPaperThetaMaxDeg);

}  // namespace sbrdf::internal
