#pragma once

#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// A smaller sliced BRDF out of a larger one, without measuring anything again.
struct CutOptions {
  double theta_max_deg = 90;  ///< of both directions; the frame ends at its first node at or above
  int max_depth = kMaxDepth;  ///< samples of a greater depth (see depth_of) are left out; 0: crossings only
};

/// The frame that remains: polar nodes up to the first at or above theta_max.
[[nodiscard]] FrameSpec cut_frame(const FrameSpec& frame, double theta_max_deg);

/// Crossings and samples of `sliced` that lie in the frame that remains. Slices along a polar axis end earlier, so
/// values near the new end differ a little from the whole's. Metadata are those of `sliced`; kUsage for a theta_max
/// of 0 or less.
[[nodiscard]] Result<SlicedBrdf> cut_sliced(const SlicedBrdf& sliced, const Lattice& lattice,
                                            const CutOptions& options);

}  // namespace sbrdf::internal
