#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "converters/files/format.h"
#include "converters/files/merl/merl_source.h"
#include "converters/files/value_options.h"
#include "formats/merl/merl.h"

namespace sbrdf::internal {

/// What a resampled table lost against its source. Counts are of cells.
struct MerlReport {
  std::uint64_t cells = 0;
  std::uint64_t below_horizon = 0;      ///< the centre lies below the horizon: -1 in every channel, on disk
  std::uint64_t above_horizon = 0;      ///< the others
  std::uint64_t unmeasured = 0;         ///< above the horizon, not measured by the source: -1 in every channel
  std::uint64_t non_finite = 0;         ///< above the horizon, NaN or infinite: the same, where the policy says so
  std::uint64_t some_negative = 0;      ///< above the horizon, one or two channels negative: as the policy says
  std::uint64_t all_negative = 0;       ///< above the horizon, all negative: if kept, readers take them for marks
  std::uint64_t beyond_theta_max = 0;   ///< above the horizon, a direction beyond the source's theta_max
  bool anisotropic_source_cut = false;  ///< the source varies with phi_h; the table holds phi_h = 0 only
  bool source_not_reciprocal = false;   ///< the table holds only one of f(i,v) and f(v,i)
  bool channel_repeated = false;        ///< the only channel of the source stands in R, G and B
  double theta_max_deg = 90;            ///< of the source
  std::string beyond;                   ///< what it gives there, see SourceTraits
};

/// Largest number of cells that resample_merl makes (6 GiB of values).
inline constexpr std::uint64_t kMerlMaxResampledCells = std::uint64_t{1} << 28;

/// How a table is written, beside its shape.
struct MerlWriting {
  MerlConvention convention = {};  ///< kAuto of the turn is not one; of its two that concern reading, none counts
  std::size_t value_size = sizeof(double);  ///< 8 or 4 bytes of a number
};

/// Writes a whole file: the source's value at every cell's place, at phi_h = 0, divided by kMerlScale. A few MB of
/// values are in memory at a time. The same bytes for any number of threads. Nothing is symmetrised: of a source that
/// is not reciprocal the table holds f(i,v) with the light at phi_d in [0, pi), so give it one that was symmetrised
/// before.
///
/// Cells that the source did not measure are marks. Writes nothing that MerlSource would refuse: kInvalidFile where the
/// source gives a NaN, an infinity or a value above kMerlLargest, unless `policy` makes marks of these, and where none
/// of its values is positive. kUsage for a shape outside [1, kMerlMaxCount] or above kMerlMaxResampledCells;
/// kUnsupported for a source with other than three channels (taken as R, G, B) or one (repeated); interrupted_error()
/// where `progress` asked to stop.
Result<MerlReport> resample_merl(const BrdfSource& source, const MerlShape& shape, ByteSink& sink,
                                 const Progress& progress = {}, const ValuePolicy& policy = {},
                                 const MerlWriting& writing = {});

/// Three counts such as "90,90,180"; kUsage otherwise.
[[nodiscard]] Result<MerlShape> parse_merl_shape_option(std::string_view text);

/// Writes a MERL file: the row of the format table. A MERL source is copied byte for byte unless another shape is asked
/// for or reading changed its values; others are resampled, after they were made reciprocal unless the table covers a
/// full turn. Options: merl-shape; merl-position; merl-turn, of which the default is that of a MERL source, else half;
/// merl-type; negatives; non-finite, of which the default is refuse.
[[nodiscard]] Status save_merl(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                               const Progress& progress);
[[nodiscard]] std::span<const OptionSpec> merl_options();

}  // namespace sbrdf::internal
