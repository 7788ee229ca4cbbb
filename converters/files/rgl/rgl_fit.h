#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "converters/tables/value_policy.h"
#include "formats/core/result.h"
#include "formats/rgl/rgl_material.h"

namespace sbrdf::internal {

// The colours of an RGL material, fitted to a source.

/// What was met on the way. Counts are of pairs of directions that the fit looked at.
struct RglFitLosses {
  std::uint64_t pairs = 0;             ///< all of them, above the horizon
  std::uint64_t unmeasured = 0;        ///< not measured by the source
  std::uint64_t beyond_theta_max = 0;  ///< with a direction beyond the source's theta_max
  std::uint64_t negative = 0;          ///< with a channel below 0
  std::uint64_t positive = 0;          ///< with a channel above 0
};

struct RglFitRequest {
  Negatives negatives = Negatives::kKeep;  ///< kUnmeasured: such pairs count for nothing
  double size = 1;                         ///< of the colours, roughly; above 0
};

/// Fills `colours` of a material that has everything else: [phi_i, theta_i, channel, y, x], as many channels as the
/// source has. For pairs of directions spread evenly over the warped square of each slice, and of some incidences
/// between slices, evaluation is to give the source's f_r cos(theta_v): least squares of the relative error, which is
/// linear in the colours, by conjugate gradients. So what is interpolated comes out nearer than if each node held its
/// own value. Nodes that no pair leads to, most of them below the horizon, continue their neighbours smoothly for two
/// steps, and may become negative where values fall to 0 at the horizon; above it, nothing becomes negative where the
/// source is not.
///
/// Where the material is anisotropic, its first and last phi_i are the same azimuth and get the same colours.
/// kInvalidFile where the source gives a value that is not finite or beyond kTableLargest, and where colours come out
/// beyond the range of float or nowhere positive; interrupted_error(). The same for any number of threads.
[[nodiscard]] Result<RglFitLosses> fit_colours(const BrdfSource& source, const RglFitRequest& request,
                                               RglMaterial& material, const Progress& progress);

/// The density over the warped square that draws directions in proportion to f_r cos(theta_v), the mean of all channels
/// or, of three, the luminance of linear sRGB; and which nodes lead above the horizon. Nodes hold the mean around them.
[[nodiscard]] RglSampling sampling_of(const BrdfSource& source, const RglMaterial& material);

}  // namespace sbrdf::internal
