#pragma once

#include <memory>
#include <span>

#include "converters/files/options.h"
#include "converters/source/brdf_source.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Opens a Klems matrix in XML (specs/klems.md): the row of the format table. Options: negatives, klems-side,
/// klems-band, klems-transmission, klems-incident, klems-azimuth.
///
/// The source has one channel, "Y" of the visible band or "solar", and the value of a pair's patches: constant in each,
/// with steps between them, as the format means it. A transmission has its outgoing directions on the other side, given
/// here as if they lay on this one: theta_v from the normal of that side, phi_v as it is. Not reciprocal. The largest
/// hemispherical reflectance (or transmittance) of an incident patch is a finding. Nothing of the bytes is kept.
///
/// Fails as parse_klems does; kInvalidFile where no value is positive.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_klems(std::shared_ptr<const ByteSource> bytes,
                                                             const Options& options = {});
[[nodiscard]] std::span<const OptionSpec> klems_options();

}  // namespace sbrdf::internal
