#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/table_options.h"
#include "converters/files/utia/utia.h"
#include "converters/files/value_options.h"
#include "converters/tables/resampling_error.h"
#include "converters/tables/sampled_table.h"

namespace sbrdf::internal {
namespace {

UtiaUnmeasured unmeasured_of(const Options& options) {
  const auto text = options.text("utia-unmeasured");
  return text == "zero" ? UtiaUnmeasured::kZero : text == "refuse" ? UtiaUnmeasured::kRefuse : UtiaUnmeasured::kNan;
}

/// Takes the viewers of one light after the other.
class Writer {
 public:
  Writer(const UtiaShape& shape, const Grid& grid, const Options& options, ByteSink& sink)
      : shape_(shape),
        grid_(grid),
        conventions_(utia_conventions(options)),
        unmeasured_(unmeasured_of(options)),
        sink_(sink) {}

  Status take(const TableBlock& block, std::span<const double> values) {
    const std::uint64_t count = block.node_count();
    const std::size_t channels = values.size() / count;
    row_.resize(count);
    for (std::size_t c = 0; c < kUtiaChannelCount; ++c) {
      for (std::uint64_t n = 0; n < count; ++n) {
        const double value = values[n * channels + (channels == 1 ? 0 : c)];
        if (std::isnan(value) && unmeasured_ == UtiaUnmeasured::kRefuse) return refuse(block, n);
        const bool black = std::isnan(value) && unmeasured_ == UtiaUnmeasured::kZero;
        row_[n] = black ? 0 : utia_number(value, conventions_);
      }
      const auto& first = block.first;
      const std::uint64_t at = utia_index(shape_, c, first[0], first[1], first[2], first[3]);
      if (Status known = check_head(at); !known) return known;
      if (Status written = sink_.write(sizeof(double) * at, std::as_bytes(std::span(row_))); !written) return written;
    }
    return ok_status();
  }

 private:
  [[nodiscard]] Status refuse(const TableBlock& block, std::uint64_t node) const {
    GridNode at = block.first;
    at[2] += static_cast<std::uint32_t>(node / block.count[3]);
    at[3] += static_cast<std::uint32_t>(node % block.count[3]);
    return invalid_file("the source has no value at " + grid_.node_text(at));
  }

  // Of the beginning of the file, which is nothing but numbers.
  [[nodiscard]] Status check_head(std::uint64_t at) const {
    if (at != 0 || row_.size() < kUtiaHeadNumbers) return ok_status();
    if (are_utia_numbers(std::span(row_).first(kUtiaHeadNumbers))) return ok_status();
    return unsupported("a UTIA table is recognised by numbers between 1e-46 and 1e42, which these values are not");
  }

  const UtiaShape& shape_;
  const Grid& grid_;
  UtiaConventions conventions_;
  UtiaUnmeasured unmeasured_;
  ByteSink& sink_;
  std::vector<double> row_;
};

void remark_conventions(Report& report, const BrdfSource& source, const UtiaConventions& conventions) {
  const std::string part = conventions.white == 1 ? "number" : fmt::format("(number / {:g})", conventions.white);
  report.remarks.push_back({"conventions", 1,
                            conventions.plain()
                                ? "numbers are f_r"
                                : fmt::format("f_r = {:g} x {}{}", conventions.scale,
                                              conventions.gamma == UtiaGamma::kNone ? "" : "sRGB-decoded ", part)});
  if (source.channel_count() == 1) {
    report.remarks.push_back({"channel_repeated", 1, "the only channel stands in R, G and B"});
  } else if (source.traits().channels != std::vector<std::string>{"R", "G", "B"}) {
    report.remarks.push_back(
        {"channel_names_lost", 3,
         fmt::format("channels {} are read back as R, G, B", fmt::join(source.traits().channels, ", "))});
  }
}

/// Directions that the table leaves out.
void remark_end(Report& report, const BrdfSource& source, const Grid& grid) {
  const double last = grid.theta_max_deg();
  const double measured = source.traits().theta_max_deg;
  if (measured <= last) return;
  report.remarks.push_back(
      {"theta_last_deg", last,
       fmt::format("theta beyond {:g} degrees, of {:g} in the source, is left out: readers make up "
                   "what lies there",
                   last, measured)});
}

/// What the table gives back between its nodes.
void remark_difference(Report& report, const BrdfSource& source, const Grid& grid, const UtiaConventions& conventions) {
  if (conventions.gamma != UtiaGamma::kSrgbAfter) return remark_interpolation(report, source, grid);
  if (is_table_of(source, grid)) return;
  const DenseTable numbers = table_of_source(source, grid, [&](std::span<double> colour) {
    for (double& value : colour) value = utia_number(value, conventions);
  });
  remark_resampling(report, source, resampling_error(source, [&](auto pairs, auto values) {
                      interpolate_table(numbers, pairs, values);
                      for (float& value : values) value = static_cast<float>(utia_value(value, conventions));
                    }));
}

std::string_view mark_of(UtiaUnmeasured unmeasured) {
  return unmeasured == UtiaUnmeasured::kZero
             ? "0, which nothing tells from black"
             : "NaN, which is read back as unmeasured here but may be taken for a value elsewhere";
}

}  // namespace

Status write_utia(const BrdfSource& source, const UtiaShape& shape, ByteSink& sink, const Options& options,
                  Report& report, const Progress& progress) {
  if (source.channel_count() != kUtiaChannelCount && source.channel_count() != 1) {
    return unsupported(fmt::format("a UTIA table holds 3 channels, the source has {}", source.channel_count()));
  }
  const UtiaConventions conventions = utia_conventions(options);
  TableRequest request = {own_grid_if_same_nodes(source, utia_grid(shape)), policy_of(options, NonFinite::kRefuse)};
  // Rounding must not lead beyond what is read.
  if (!conventions.plain()) request.largest = kTableLargest * 0.999;
  Writer writer(shape, request.grid, options, sink);
  const Result<TableLosses> losses = sample_table(
      source, request, rows_of(request.grid),
      [&](const TableBlock& block, std::span<const double> values) { return writer.take(block, values); }, progress);
  if (!losses) return losses.error();
  remark_conventions(report, source, conventions);
  remark_end(report, source, request.grid);
  remark_losses(report, source, request, *losses, mark_of(unmeasured_of(options)));
  remark_difference(report, source, request.grid, conventions);
  return ok_status();
}

Status save_utia(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                 const Progress& progress) {
  const auto wanted = options.text("utia-grid");
  const bool own_is_dense = has_nodes_of(source, utia_grid(kUtiaDense));
  const UtiaShape shape = (wanted ? wanted == "dense" : own_is_dense) ? kUtiaDense : kUtiaStandard;
  const std::shared_ptr<const ByteSource> stored = source.stored("utia");
  const bool holes_stay = !options.has("utia-unmeasured") || !source.mask_grid();
  if (stored != nullptr && holes_stay && utia_conventions(options).plain() && stored->size() == utia_file_size(shape)) {
    report.remarks.push_back({"copied", 1, "copied bit for bit"});
    return copy_bytes(*stored, sink, progress);
  }
  return write_utia(source, shape, sink, options, report, progress);
}

}  // namespace sbrdf::internal
