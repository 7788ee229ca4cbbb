#pragma once

#include <memory>
#include <span>

#include "converters/files/format.h"

namespace sbrdf::internal {

// OpenEXR images as dense tables (specs/exr.md): a row of pixels for each node of the first two axes, a column for each
// of the last two; f_r [1/sr]. The string attribute "sbrdf" holds the head (converters/files/dense/table_head.h).

/// Options: grid, type, negatives, non-finite.
[[nodiscard]] std::span<const OptionSpec> exr_options();
/// kUnsupported for --type float64, which OpenEXR does not have.
[[nodiscard]] Status check_exr_options(const Options& options);

/// Unpacks all pixels into memory, as halves where all channels are halves, else as floats. NaN is unmeasured. An image
/// without head has the nodes that --grid says; one of 288 x 288 pixels and no --grid those of UTIA's images, which is
/// a finding. Of an image without head that has channels R, G and B, the others are left out, which is a finding.
///
/// Errors as of ExrReader and parse_table_head; kInvalidFile where head and image do not fit; kUsage where there is
/// neither a head nor --grid, and where that does not fit the image; kUnsupported where it takes more memory than
/// allowed.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_exr(std::shared_ptr<const ByteSource> bytes,
                                                           const Options& options);

/// A few MB at a time. An image that was read and is asked for as it is, is copied byte for byte. kUnsupported where
/// ExrWriter::check says so.
[[nodiscard]] Status save_exr(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                              const Progress& progress);

}  // namespace sbrdf::internal
