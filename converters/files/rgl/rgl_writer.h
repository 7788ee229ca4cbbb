#pragma once

#include <cstdint>
#include <span>

#include "converters/files/format.h"
#include "formats/core/byte_sink.h"

namespace sbrdf::internal {

// RGL material files of any source (specs/rgl.md, section 4). Dupuy & Jakob 2018 say how a device measures into this
// parameterisation; here a source is asked instead, and the colours are fitted.

/// Most nodes of the colours that are written, in all slices together, and of `vndf`.
inline constexpr std::uint64_t kRglMostColourNodes = std::uint64_t{1} << 22U;
inline constexpr std::uint64_t kRglMostWarpNodes = std::uint64_t{1} << 26U;

/// Options of files that are read and that are written.
[[nodiscard]] std::span<const OptionSpec> rgl_options();

/// Options of writing that contradict each other: sizes that make too many nodes.
[[nodiscard]] Status check_rgl_options(const Options& options);

/// The row's `save`. A source that is an RGL file already is copied, byte for byte, unless an option of writing is
/// given.
///
/// Of such a source with one azimuth the tables stay, unless options ask for other nodes, and the colours alone are
/// fitted. Otherwise a material is made with the fields of the database's files: of microfacets that reflect much as
/// the source does (rgl_microfacets.h), with the colours fitted (rgl_fit.h). A source of one channel is repeated in
/// R, G and B; one whose channels are wavelengths becomes a spectral file, or an RGB one with --rgl-values rgb. What
/// the source did not measure is filled from around it. Lost: values between the nodes of the source, as the report
/// says.
///
/// kUnsupported for another number of channels; kInvalidFile as fit_colours says; interrupted_error(); what the sink
/// says.
[[nodiscard]] Status save_rgl(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                              const Progress& progress = {});

}  // namespace sbrdf::internal
