#include "converters/files/merl/merl_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "codec/frame/frame.h"
#include "converters/files/merl/merl_source.h"
#include "converters/files/table_options.h"
#include "converters/source/reciprocity.h"
#include "formats/core/numbers.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

/// On disk, in every channel of a cell that has no value.
constexpr double kMark = -1;
/// Cells that are in memory at a time, or one row if that is longer.
constexpr std::uint64_t kBlockCells = std::uint64_t{1} << 17U;
constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();

using Colour = std::array<double, kMerlChannelCount>;

struct RowReport {
  std::uint64_t below_horizon = 0, unmeasured = 0, non_finite = 0, some_negative = 0, all_negative = 0, beyond = 0;
  std::uint64_t first_bad = kNone;  ///< least position among the values of the file
  bool positive = false;
};

/// The work of resample_merl: blocks of rows of phi_d, the rows of a block in parallel.
class Resampler {
 public:
  Resampler(const BrdfSource& source, const MerlShape& shape, const ValuePolicy& policy, const MerlWriting& writing)
      : source_(source),
        shape_(shape),
        policy_(policy),
        writing_(writing),
        row_count_(std::uint64_t{shape[0]} * shape[1]) {
    report_.theta_max_deg = source_.traits().theta_max_deg;
    report_.beyond = source_.traits().beyond_theta_max;
    report_.cells = merl_cell_count(shape);
    report_.anisotropic_source_cut = !source_.traits().isotropic;
    report_.source_not_reciprocal = !source_.traits().reciprocal;
    report_.channel_repeated = source_.channel_count() == 1;
  }

  Result<MerlReport> run(ByteSink& sink, const Progress& progress) {
    if (Status written = sink.write(0, emit_merl_header(shape_)); !written) return written.error();
    ProgressCounter counter(progress, row_count_);
    const std::uint64_t most = std::max<std::uint64_t>(1, kBlockCells / shape_[2]);
    for (first_row_ = 0; first_row_ < row_count_; first_row_ += rows_.size()) {
      rows_.assign(std::min(most, row_count_ - first_row_), {});
      for (auto& plane : planes_) plane.resize(rows_.size() * shape_[2]);
      parallel_for(rows_.size(), [&](std::uint64_t row) {
        if (counter.stopped()) return;
        sample_row(row);
        counter.advance();
      });
      if (counter.stopped()) return interrupted_error();
      if (Status sound = add_up(); !sound) return sound.error();
      if (Status written = write_block(sink); !written) return written.error();
    }
    if (!positive_) return invalid_file("no value of the source is positive: nothing reads such a MERL table");
    return report_;
  }

 private:
  void sample_row(std::uint64_t row) {
    std::vector<DirectionPair> pairs;
    std::vector<std::uint64_t> cells;  // in the block
    for (std::uint32_t p = 0; p < shape_[2]; ++p) {
      const std::uint64_t cell = row * shape_[2] + p;
      const DirectionPair pair = merl_cell_pair(shape_, writing_.convention, first_row_ * shape_[2] + cell);
      if (!above_horizon(pair)) {
        store(cell, {kMark, kMark, kMark});
      } else {
        pairs.push_back(pair);
        cells.push_back(cell);
      }
    }
    rows_[row].below_horizon = shape_[2] - cells.size();
    const std::size_t channels = source_.channel_count();
    std::vector<float> values(pairs.size() * channels);
    source_.evaluate(pairs, values);
    std::vector<std::uint8_t> measured(pairs.size(), 1);
    if (source_.mask_grid()) source_.measured(pairs, measured);
    const double theta_max = radians_from_degrees(report_.theta_max_deg);
    for (const DirectionPair& pair : pairs)
      rows_[row].beyond += std::max(pair.i.theta, pair.v.theta) > theta_max ? 1 : 0;
    for (std::size_t n = 0; n < cells.size(); ++n) {
      if (measured[n] == 0) {
        ++rows_[row].unmeasured;
        store(cells[n], {kMark, kMark, kMark});
        continue;
      }
      store_sample(rows_[row], cells[n], std::span(values).subspan(n * channels, channels));
    }
  }

  void store(std::uint64_t cell, const Colour& colour) {
    for (std::size_t c = 0; c < colour.size(); ++c) planes_[c][cell] = colour[c];
  }

  void store_sample(RowReport& row, std::uint64_t cell, std::span<const float> values) {
    Colour colour{};
    bool positive = false;
    bool finite = true;
    for (std::size_t c = 0; c < colour.size(); ++c) {
      colour[c] = values[values.size() == 1 ? 0 : c] / kMerlScale[c];
      positive = positive || colour[c] > 0;
      if (std::fabs(colour[c] * kMerlScale[c]) <= kMerlLargest) continue;
      finite = false;
      if (policy_.non_finite == NonFinite::kUnmeasured) continue;
      row.first_bad = std::min(row.first_bad, c * report_.cells + first_row_ * shape_[2] + cell);
    }
    if (!finite) {
      ++row.non_finite;
      store(cell, {kMark, kMark, kMark});
      return;
    }
    const std::size_t negative = merl_negative_channels(colour);
    if (negative > 0 && policy_.negatives == Negatives::kUnmeasured) {
      colour = {kMark, kMark, kMark};
    } else if (negative > 0 && policy_.negatives == Negatives::kClamp) {
      for (double& value : colour) value = std::max(value, 0.0);
    }
    row.positive = row.positive || (positive && merl_negative_channels(colour) < kMerlChannelCount);
    store(cell, colour);
    if (negative == kMerlChannelCount) {
      ++row.all_negative;
    } else if (negative > 0) {
      ++row.some_negative;
    }
  }

  Status add_up() {
    std::uint64_t first_bad = kNone;
    for (const RowReport& row : rows_) {
      report_.below_horizon += row.below_horizon;
      report_.above_horizon += shape_[2] - row.below_horizon;
      report_.unmeasured += row.unmeasured;
      report_.non_finite += row.non_finite;
      report_.beyond_theta_max += row.beyond;
      report_.some_negative += row.some_negative;
      report_.all_negative += row.all_negative;
      positive_ = positive_ || row.positive;
      first_bad = std::min(first_bad, row.first_bad);
    }
    if (first_bad == kNone) return ok_status();
    return invalid_file(fmt::format("the source gives a NaN, an infinity or a value above {:g} for the MERL cell at {}",
                                    kMerlLargest,
                                    merl_cell_name(shape_, first_bad % report_.cells, first_bad / report_.cells)));
  }

  Status write_block(ByteSink& sink) {
    for (std::size_t c = 0; c < planes_.size(); ++c) {
      const std::uint64_t first = c * report_.cells + first_row_ * shape_[2];
      const std::uint64_t offset = kMerlHeaderSize + writing_.value_size * first;
      floats_.assign(planes_[c].begin(), planes_[c].end());
      const auto bytes = writing_.value_size == sizeof(float) ? std::as_bytes(std::span(floats_))
                                                              : std::as_bytes(std::span(planes_[c]));
      if (Status written = sink.write(offset, bytes); !written) return written;
    }
    return ok_status();
  }

  const BrdfSource& source_;
  MerlShape shape_;
  ValuePolicy policy_;
  const MerlWriting& writing_;
  std::uint64_t row_count_;
  MerlReport report_;
  bool positive_ = false;
  // The block at hand.
  std::uint64_t first_row_ = 0;
  std::vector<RowReport> rows_;
  std::array<std::vector<double>, kMerlChannelCount> planes_;
  std::vector<float> floats_;  ///< of one of them
};

void remark_negatives(const MerlReport& losses, Negatives negatives, Report& report) {
  const std::string some = "cells with one or two negative channels, ";
  const std::string all = "cells negative in every channel, ";
  if (negatives == Negatives::kKeep) {
    remark_count(report, "some_negative_cells", losses.some_negative, some + "kept");
    remark_count(report, "all_negative_cells", losses.all_negative, all + "kept; readers take them for unmeasured");
    return;
  }
  const std::string done = negatives == Negatives::kClamp ? "0 in their place" : "marked -1";
  remark_count(report, "some_negative_cells", losses.some_negative, some + done);
  remark_count(report, "all_negative_cells", losses.all_negative, all + done);
}

void remark_losses(const MerlReport& losses, Negatives negatives, Report& report) {
  remark_count(report, "below_horizon_cells", losses.below_horizon, "cells below the horizon, marked -1");
  remark_count(report, "unmeasured_cells", losses.unmeasured,
               "cells above the horizon unmeasured by the source, marked -1");
  remark_count(report, "non_finite_cells", losses.non_finite, "cells with a value that is not finite, marked -1");
  remark_negatives(losses, negatives, report);
  if (losses.beyond_theta_max > 0) {
    remark_count(
        report, "cells_beyond_theta_max", losses.beyond_theta_max,
        fmt::format("of {} cells above the horizon ({:.3g} %) have a direction beyond theta_max = {:g} degrees, "
                    "how far the source is measured: {}",
                    losses.above_horizon,
                    100 * static_cast<double>(losses.beyond_theta_max) / static_cast<double>(losses.above_horizon),
                    losses.theta_max_deg, losses.beyond));
  }
  if (losses.anisotropic_source_cut) {
    report.remarks.push_back(
        {"anisotropic_source_cut", 1, "the source is anisotropic; the table holds phi_h = 0 only"});
  }
  if (losses.channel_repeated) {
    report.remarks.push_back({"channel_repeated", 1, "the only channel stands in R, G and B"});
  }
}

Status check_shape(std::string_view text) {
  const Result<MerlShape> shape = parse_merl_shape_option(text);
  return shape ? ok_status() : Status(shape.error());
}

constexpr auto kPositionChoices = names_of(kMerlPositionNames);
constexpr auto kLookupChoices = names_of(kMerlLookupNames);
constexpr auto kTurnChoices = names_of(kMerlTurnNames);
constexpr std::array<std::string_view, 2> kTypeChoices = {"float64", "float32"};

constexpr std::array kOptions = {
    OptionSpec{.name = "merl-shape",
               .unit = "H,D,P",
               .fallback = "90,90,180, or that of a MERL IN",
               .check = check_shape,
               .meaning = "Cells along theta_h, theta_d and phi_d, each 1 to 4096"},
    OptionSpec{.name = "merl-position",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kBoth,
               .choices = kPositionChoices,
               .fallback = "centre",
               .meaning = "Where in a cell of a MERL table its value belongs: at the centre, or at the lower edge"},
    OptionSpec{.name = "merl-lookup",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kRead,
               .choices = kLookupChoices,
               .fallback = "linear",
               .meaning = "Between the cells of a MERL table that is read: interpolated, or the cell that a pair of "
                          "directions lies in, as the published reader takes it"},
    OptionSpec{.name = "merl-turn",
               .kind = OptionKind::kChoice,
               .use = OptionUse::kBoth,
               .choices = kTurnChoices,
               .fallback = "auto: as the content tells; written like a MERL IN, else half",
               .meaning = "Whether the third dimension of a MERL table covers half a turn of phi_d, which makes it "
                          "reciprocal, or a full one"},
    OptionSpec{.name = "merl-float32",
               .kind = OptionKind::kFlag,
               .use = OptionUse::kRead,
               .meaning = "The numbers of a MERL table that is read are 32-bit floats"},
    OptionSpec{.name = "merl-type",
               .kind = OptionKind::kChoice,
               .choices = kTypeChoices,
               .fallback = "float64",
               .meaning = "Numbers of a MERL table that is written; few readers take float32"},
    negatives_option(OptionUse::kBoth),
    non_finite_option(OptionUse::kBoth),
};

}  // namespace

Result<MerlReport> resample_merl(const BrdfSource& source, const MerlShape& shape, ByteSink& sink,
                                 const Progress& progress, const ValuePolicy& policy, const MerlWriting& writing) {
  if (!is_sane_merl_shape(shape) || merl_cell_count(shape) > kMerlMaxResampledCells) {
    return usage_error(
        fmt::format("a MERL table has 1 to {} cells along each axis and here at most {} in all, not {} x {} x {}",
                    kMerlMaxCount, kMerlMaxResampledCells, shape[0], shape[1], shape[2]));
  }
  if (source.channel_count() != kMerlChannelCount && source.channel_count() != 1) {
    return unsupported(fmt::format("a MERL table holds 3 channels, the source has {}", source.channel_count()));
  }
  return Resampler(source, shape, policy, writing).run(sink, progress);
}

Result<MerlShape> parse_merl_shape_option(std::string_view text) {
  MerlShape shape{};
  std::string_view rest = text;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    const std::size_t end = axis + 1 < shape.size() ? rest.find(',') : rest.size();
    const auto count = parse_count(rest.substr(0, end));
    if (end == std::string_view::npos || !count || *count < 1 || *count > kMerlMaxCount) {
      return usage_error(fmt::format("'{}' is not three counts of 1 to {} such as 90,90,180", text, kMerlMaxCount));
    }
    shape[axis] = static_cast<std::uint32_t>(*count);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return shape;
}

std::span<const OptionSpec> merl_options() { return kOptions; }

namespace {

// Of the numbers in a file of the source's own.
std::size_t stored_value_size(const BrdfSource& source) {
  const bool narrow = source.stored("merl") != nullptr && source.table()->type == ValueType::kFloat32;
  return narrow ? sizeof(float) : sizeof(double);
}

MerlWriting writing_of(const BrdfSource& source, const Options& options) {
  const bool full = source.traits().format == "merl" && !source.traits().reciprocal;
  MerlWriting writing = {merl_convention_of(options, MerlTurn::kAuto)};
  if (writing.convention.turn == MerlTurn::kAuto) writing.convention.turn = full ? MerlTurn::kFull : MerlTurn::kHalf;
  const std::optional<std::string> type = options.text("merl-type");
  writing.value_size = !type ? stored_value_size(source) : *type == "float32" ? sizeof(float) : sizeof(double);
  return writing;
}

}  // namespace

Status save_merl(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                 const Progress& progress) {
  const ValuePolicy policy = policy_of(options, NonFinite::kRefuse);
  const MerlWriting writing = writing_of(source, options);
  MerlShape shape = kMerlShape;
  if (const auto wanted = options.text("merl-shape")) {
    shape = parse_merl_shape_option(*wanted).value();
  } else if (source.traits().format == "merl") {  // one that is not what its file says, too
    std::copy_n(source.traits().shape.begin(), shape.size(), shape.begin());
  }
  const Grid grid = merl_cell_grid(shape, writing.convention);
  const std::shared_ptr<const ByteSource> stored = source.stored("merl");
  if (stored != nullptr && is_table_of(source, grid) && stored_value_size(source) == writing.value_size) {
    report.remarks.push_back({"copied", 1, "copied bit for bit"});
    return copy_bytes(*stored, sink, progress);
  }
  const SymmetrisedSource symmetrised(source);
  const bool fits = source.traits().reciprocal || writing.convention.turn == MerlTurn::kFull;
  const BrdfSource& fitting = fits ? source : symmetrised;
  const Result<MerlReport> losses = resample_merl(fitting, shape, sink, progress, policy, writing);
  if (!losses) return losses.error();
  if (!fits) remark_reciprocity(report, reciprocity_difference_percent(source));
  remark_losses(*losses, policy.negatives, report);
  if (writing.convention.turn == MerlTurn::kFull) {
    report.remarks.push_back(
        {"full_turn", 1, "the third dimension covers a full turn of phi_d, which few readers expect"});
  }
  remark_interpolation(report, fitting, grid);
  return ok_status();
}

}  // namespace sbrdf::internal
