#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "converters/baselines/scheme_samples.h"
#include "converters/files/format.h"
#include "converters/files/options.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/byte_sink.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"
#include "formats/table/hdf5/file.h"

namespace sbrdf::internal {

// Uniform samples in HDF5 (specs/hdf5.md): the other content of the row "hdf5".

inline constexpr std::array kInterpolationChoices = names_of(kInterpolationNames);
inline constexpr std::array kRbfKernelChoices = names_of(kRbfKernelNames);

/// Whether a text names a scheme, or a file with one.
[[nodiscard]] Status check_scheme_name(std::string_view text);

/// --scheme, --interpolation and --rbf-kernel, for the table of options of the row.
inline constexpr OptionSpec kSchemeOption = {
    .name = "scheme",
    .unit = "N|FILE.json",
    .check = check_scheme_name,
    .meaning =
        "An HDF5 OUT gets uniform samples in place of a dense table: at the directions of this scheme of the "
        "paper's Table 1, or of one of your own (see sbrdf schemes)"};
inline constexpr OptionSpec kInterpolationOption = {
    .name = "interpolation",
    .kind = OptionKind::kChoice,
    .use = OptionUse::kBoth,
    .choices = kInterpolationChoices,
    .fallback = "barycentric, or as in an IN with uniform samples",
    .meaning = "Between uniform samples: in spherical triangles, or by radial basis functions"};
inline constexpr OptionSpec kRbfKernelOption = {
    .name = "rbf-kernel",
    .kind = OptionKind::kChoice,
    .use = OptionUse::kBoth,
    .choices = kRbfKernelChoices,
    .fallback = "cubic, or as in an IN with uniform samples",
    .meaning =
        "Interpolate uniform samples by radial basis functions of the chord r between two directions: r, r^3, "
        "r^2 log r, 1 / sqrt(r^2 + 0.3^2)"};

/// How hard files are compressed unless an option says.
inline constexpr std::uint64_t kHdf5Deflate = 4;

/// There are some, all different, and none is empty.
[[nodiscard]] bool usable_names(const std::vector<std::string>& names);

/// kUsage where options of dense tables meet those of uniform samples, or kernels an interpolation without.
[[nodiscard]] Status check_samples_options(const Options& options);

/// Samples as a source that interpolates them as the options say, or else as the file does. Errors as of
/// read_hdf5_samples, check_scheme and SchemeSource::make; kInvalidFile where values are not finite, or are not as many
/// as the scheme has pairs.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_samples(const Hdf5File& file,
                                                               std::shared_ptr<const ByteSource> bytes,
                                                               const Options& options);

/// Whether a table of the source's uniform samples is to be written rather than a dense one.
[[nodiscard]] bool wants_samples(const BrdfSource& source, const Options& options);

/// Samples a source by the scheme that the options name, or writes again the samples that it consists of. Errors as of
/// scheme_by_name and sample_scheme.
[[nodiscard]] Status save_samples(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                                  const Progress& progress);

}  // namespace sbrdf::internal
