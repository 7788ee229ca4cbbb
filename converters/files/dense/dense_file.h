#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "converters/files/dense/table_head.h"
#include "converters/files/format.h"
#include "converters/files/options.h"
#include "converters/files/table_options.h"
#include "converters/files/value_options.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "converters/tables/dense_source.h"
#include "converters/tables/dense_table.h"
#include "converters/tables/sampled_table.h"
#include "formats/core/byte_source.h"

namespace sbrdf::internal {

// What the formats have in common that hold nothing but a dense table and its head: NPY, EXR, CSV.

/// --grid, --type, --negatives, --non-finite.
inline constexpr std::array kDenseOptions = {grid_option(), type_option(), negatives_option(OptionUse::kBoth),
                                             non_finite_option(OptionUse::kBoth)};

/// Each value becomes the nearest number of the type.
void round_numbers(ValueType type, std::span<double> values);
/// Appends values as numbers of the type, little-endian.
void append_numbers(ValueType type, std::span<const double> values, std::vector<std::byte>& bytes);

/// How a source becomes a dense table in a file.
class DenseWriting {
 public:
  /// Grid, numbers and policy as the options say. Numbers of more bits than those of `most` become those, with a
  /// remark, unless --type asks for them. Says in `report` what interpolation in the table costs and what was made
  /// reciprocal. All three must outlive this.
  DenseWriting(const BrdfSource& source, const Options& options, ValueType most, Report& report);

  [[nodiscard]] const Grid& grid() const { return request_.grid; }
  [[nodiscard]] ValueType type() const { return type_; }
  [[nodiscard]] std::size_t channel_count() const { return source_.channel_count(); }

  /// The file of `format` that says just this already, or nullptr; then there is nothing to sample. Says so in the
  /// report.
  [[nodiscard]] std::shared_ptr<const ByteSource> stored(std::string_view format) const;

  /// With the report as it is now.
  [[nodiscard]] TableHead head() const;
  /// The head as text of exactly `size` bytes, blanks at its end. A report that does not fit is left out.
  [[nodiscard]] std::string padded_head(std::size_t size) const;
  /// A size at which padded_head() holds the report of the whole conversion.
  [[nodiscard]] std::size_t head_size() const;

  /// Every value, as sample_table() gives them, rounded to the numbers of the file. Afterwards the report says what was
  /// lost. kInvalidFile, too, where no value is positive as such a number.
  [[nodiscard]] Status sample(std::array<std::uint32_t, 4> block, const TakeBlock& take, const Progress& progress);

 private:
  void remark_cost();

  const BrdfSource& source_;
  Report& report_;
  TableRequest request_;
  ValueType type_;
  FittingSource fitting_;
};

/// Names for channels that a file does not name: R, G, B of three, Y of one, else "channel 1" and so on.
[[nodiscard]] std::vector<std::string> default_channels(std::size_t count);

/// The grid of --grid for a file that does not tell its own. kUsage saying so where the option is not given.
[[nodiscard]] Result<Grid> grid_of_option(const Options& options, std::string_view whose);

/// What DenseSource::make gives for a table that was read from `file`, with the policy of the options. Of `head`, the
/// channels and the reach are taken.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_dense(DenseTable table, std::string format, TableHead head,
                                                             std::shared_ptr<const ByteSource> file,
                                                             const Options& options,
                                                             std::vector<Finding> findings = {});

}  // namespace sbrdf::internal
