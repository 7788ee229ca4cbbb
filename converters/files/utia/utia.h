#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "converters/files/format.h"
#include "converters/files/options.h"
#include "converters/source/brdf_source.h"
#include "converters/tables/grid.h"
#include "converters/tables/value_policy.h"
#include "formats/utia/utia.h"

namespace sbrdf::internal {

// Tables of the UTIA BRDF database (specs/utia.md): the row of the format table.

/// Whether numbers are encoded by the curve of sRGB, and where it is undone.
enum class UtiaGamma : std::uint8_t {
  kNone,        ///< they are not encoded
  kSrgbBefore,  ///< decoded at each node, then interpolated
  kSrgbAfter,   ///< interpolated, then decoded
};

/// How the numbers of a file are to be understood, as nothing in it tells: f_r = scale x decoded(number / white).
struct UtiaConventions {
  UtiaGamma gamma = UtiaGamma::kNone;
  double scale = 1;
  double white = 1;
  bool extrapolated = false;  ///< beyond the last theta: the straight line through the last two; else the last value

  /// Numbers are f_r itself.
  [[nodiscard]] bool plain() const { return gamma == UtiaGamma::kNone && scale == 1 && white == 1; }
};
/// Of options that check_options took.
[[nodiscard]] UtiaConventions utia_conventions(const Options& options);

/// f_r of a number in the file, and back.
[[nodiscard]] double utia_value(double number, const UtiaConventions& conventions);
[[nodiscard]] double utia_number(double value, const UtiaConventions& conventions);

/// The nodes of a table.
[[nodiscard]] Grid utia_grid(const UtiaShape& shape, bool extrapolated = false);

/// A table of any shape. Numbers are read from the file as they are needed. kInvalidFile where the size is not that of
/// the shape; otherwise as DenseSource::make. Where kSrgbAfter meets values that are extrapolated, what would be
/// negative is 0 before it is decoded.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> make_utia_source(std::shared_ptr<const ByteSource> file,
                                                                   const UtiaShape& shape,
                                                                   const UtiaConventions& conventions,
                                                                   const ValuePolicy& policy);

/// recognises_utia takes the beginning of a file, and it is no text.
[[nodiscard]] bool begins_like_utia(std::span<const std::byte> head, std::uint64_t file_size);

/// Opens a file of one of the published shapes. Errors of make_utia_source; kInvalidFile where the file begins with
/// numbers that are none of a table.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_utia(std::shared_ptr<const ByteSource> file,
                                                            const Options& options);

/// What becomes of nodes that the source did not measure, as the format has no mark for them.
enum class UtiaUnmeasured : std::uint8_t {
  kNan,     ///< NaN, which is read back as unmeasured here; other readers pass it on
  kZero,    ///< black
  kRefuse,  ///< an error
};

/// Writes a table of any shape, a row at a time. kUnsupported for a source with other than three channels or one
/// (repeated), and for values by which the file could not be recognised; kInvalidFile for a node that was not measured,
/// if that is to be refused; otherwise as sample_table.
[[nodiscard]] Status write_utia(const BrdfSource& source, const UtiaShape& shape, ByteSink& sink,
                                const Options& options, Report& report, const Progress& progress);

/// Writes a file of one of the published shapes; a source read from one is copied bit for bit where the options ask for
/// nothing else.
[[nodiscard]] Status save_utia(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                               const Progress& progress);

[[nodiscard]] std::span<const OptionSpec> utia_options();

}  // namespace sbrdf::internal
