#pragma once

#include <cstdint>
#include <string_view>

#include "converters/files/format.h"
#include "formats/merl/merl.h"

namespace sbrdf::internal {

/// What a resampled table lost against its source. Counts are of cells.
struct MerlReport {
  std::uint64_t cells = 0;
  std::uint64_t below_horizon = 0;      ///< the centre lies below the horizon: -1 in every channel, on disk
  std::uint64_t some_negative = 0;      ///< above the horizon, one or two channels negative: kept
  std::uint64_t all_negative = 0;       ///< above the horizon, all negative: kept, but readers take them for marks
  bool anisotropic_source_cut = false;  ///< the source varies with phi_h; the table holds phi_h = 0 only
  bool source_not_reciprocal = false;   ///< the table holds only one of f(i,v) and f(v,i)
  bool channel_repeated = false;        ///< the only channel of the source stands in R, G and B
};

/// Largest number of cells that resample_merl makes (6 GiB of values).
inline constexpr std::uint64_t kMerlMaxResampledCells = std::uint64_t{1} << 28;

/// Writes a whole file: the source's value at every cell's centre, at phi_h = 0, divided by kMerlScale. A few MB of
/// values are in memory at a time. The same bytes for any number of threads. Nothing is symmetrised: of a source that
/// is not reciprocal the table holds f(i,v) with the light at phi_d in [0, pi), so give it one that was symmetrised
/// before.
///
/// Writes nothing that MerlSource would refuse: kInvalidFile where the source gives a NaN, an infinity or a value above
/// kMerlLargest, and where none of its values is positive. kUsage for a shape outside [1, kMerlMaxCount] or above
/// kMerlMaxResampledCells; kUnsupported for a source with other than three channels (taken as R, G, B) or one
/// (repeated); interrupted_error() where `progress` asked to stop.
Result<MerlReport> resample_merl(const BrdfSource& source, const MerlShape& shape, ByteSink& sink,
                                 const Progress& progress = {});

/// Three counts such as "90,90,180"; kUsage otherwise.
[[nodiscard]] Result<MerlShape> parse_merl_shape_option(std::string_view text);

/// Writes a MERL file: the row of the format table. A MERL source is copied byte for byte unless another shape is asked
/// for; others are resampled, after they were made reciprocal. Option: merl-shape.
[[nodiscard]] Status save_merl(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                               const Progress& progress);
[[nodiscard]] std::span<const OptionSpec> merl_options();

}  // namespace sbrdf::internal
