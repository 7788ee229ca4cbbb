#pragma once

#include <memory>
#include <span>

#include "converters/files/options.h"
#include "converters/source/brdf_source.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Opens a Zemax tabular BSDF text (specs/zemax.md): the row of the format table. Options: negatives, zemax-zeros,
/// zemax-rotation.
///
/// The source is a dense table in GridFrame::kMirror, in memory; nothing of the bytes is kept. One channel "Y" of a
/// monochrome file; R, G, B of one with X, Y, Z, which the matrix of IEC 61966-2-1 turns into linear sRGB, so that
/// colours out of gamut are negative.
///
/// Findings: zeros above the horizon and what they were taken for; how far the table's integrals are from the TIS that
/// the file states, which is never used as a scale; nodes at 360 degrees that differ from those at 0, which are the
/// ones used; angles that the file does not cover.
///
/// Fails as parse_zemax does; kUnsupported for a BTDF; kInvalidFile where no value is positive.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_zemax(std::shared_ptr<const ByteSource> bytes,
                                                             const Options& options = {});
[[nodiscard]] std::span<const OptionSpec> zemax_options();

}  // namespace sbrdf::internal
