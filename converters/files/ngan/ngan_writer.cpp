#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/ngan/ngan.h"
#include "converters/files/table_options.h"
#include "converters/files/value_options.h"
#include "converters/tables/resampling_error.h"
#include "converters/tables/sampled_table.h"

namespace sbrdf::internal {
namespace {

/// In every channel of a bin that was not measured.
constexpr float kMark = -1;
/// Nodes of a block.
constexpr std::uint32_t kBlockNodes = std::uint32_t{1} << 17U;
/// Numbers of a file: readers count them in 32 bits.
constexpr std::uint64_t kMostNumbers = std::numeric_limits<std::int32_t>::max();

/// The header that a table of just this grid has, whichever way values lie in their bins.
std::optional<NganHeader> header_of(const Grid& grid) {
  if (grid.frame != GridFrame::kDifference) return std::nullopt;
  const auto& axes = grid.axes;
  for (const bool half : {false, true}) {
    const std::uint32_t phi_diff = half ? (axes[3].size() + 1) / 2 : axes[3].size();
    const NganHeader header = {{axes[1].size(), axes[2].size(), phi_diff, axes[0].size()}, half};
    const auto& n = header.counts;
    if (*std::max_element(n.begin(), n.end()) > kNganMaxCount) continue;
    if (ngan_grid(header, false) == grid || ngan_grid(header, true) == grid) return header;
  }
  return std::nullopt;
}

NganHeader header_for(const BrdfSource& source, const Options& options) {
  NganHeader header;
  header.half = options.has("ngan-half");
  header.channels = static_cast<std::uint32_t>(source.channel_count());
  if (const auto text = options.text("ngan-shape")) {
    header.counts = parse_ngan_shape_option(*text).value();
    return header;
  }
  if (const auto own = source.table() != nullptr ? header_of(source.table()->grid) : std::nullopt) {
    header.counts = own->counts;
    if (header.half && !own->half) header.counts[2] = (header.counts[2] + 1) / 2;
    if (!header.half && own->half) header.counts[2] = std::min(2 * header.counts[2], kNganMaxCount);
    return header;
  }
  header.counts = {45, 45, header.half ? 36U : 72U, source.traits().isotropic ? 1U : 36U};
  return header;
}

/// Whether the file that a source was read from is what the options ask for.
bool is_as_asked(const NganHeader& own, const NganConventions& conventions, const Options& options) {
  if (conventions.interleaved || conventions.at_edges || conventions.scale != 1) return false;
  const bool half = options.has("ngan-half");
  const auto shape = options.text("ngan-shape");
  if (!shape) return own.half || !half;
  return own.half == half && own.counts == parse_ngan_shape_option(*shape).value();
}

/// Takes blocks of nodes along phi_in and phi_diff, which lie in a row for each channel.
class Writer {
 public:
  Writer(const NganHeader& header, const NganConventions& conventions, ByteSink& sink)
      : header_(header), conventions_(conventions), sink_(sink) {}

  Status begin() { return sink_.write(0, emit_ngan_header(header_)); }

  Status take(const TableBlock& block, std::span<const double> values) {
    const std::uint64_t bins = block.node_count();
    const std::uint64_t channels = header_.channels;
    row_.resize(bins * channels);
    for (std::uint64_t node = 0; node < bins; ++node) {
      // Nodes have phi_diff fastest, bins phi_in.
      const std::uint64_t bin = node % block.count[3] * block.count[0] + node / block.count[3];
      const std::span<const double> colour = values.subspan(node * channels, channels);
      const bool mark = std::isnan(colour[0]);
      bool positive = false;
      bool negative = false;
      for (std::uint64_t c = 0; c < channels; ++c) {
        const float number = mark ? kMark : static_cast<float>(colour[c] / conventions_.scale);
        row_[conventions_.interleaved ? bin * channels + c : c * bins + bin] = number;
        positive = positive || number > 0;
        negative = negative || number < 0;
        if (number == 0 && colour[c] != 0) ++vanished_;
      }
      positive_ = positive_ || (positive && !negative);
    }
    return write_row(ngan_bin_index(header_, block.first[1], block.first[2], block.first[3], block.first[0]), bins);
  }

  [[nodiscard]] bool positive() const { return positive_; }           ///< in some bin that readers take
  [[nodiscard]] std::uint64_t vanished() const { return vanished_; }  ///< values too small for a float

 private:
  Status write_row(std::uint64_t first_bin, std::uint64_t bins) {
    const std::uint64_t channels = header_.channels;
    const auto write = [&](std::uint64_t number, std::span<const float> numbers) {
      return sink_.write(kNganHeaderSize + sizeof(float) * number, std::as_bytes(numbers));
    };
    if (conventions_.interleaved) return write(first_bin * channels, row_);
    for (std::uint64_t c = 0; c < channels; ++c) {
      const std::uint64_t at = c * ngan_bin_count(header_) + first_bin;
      if (Status written = write(at, std::span(row_).subspan(c * bins, bins)); !written) return written;
    }
    return ok_status();
  }

  const NganHeader& header_;
  const NganConventions& conventions_;
  ByteSink& sink_;
  std::vector<float> row_;
  bool positive_ = false;
  std::uint64_t vanished_ = 0;
};

void remark_conventions(Report& report, const BrdfSource& source, const NganHeader& header,
                        const NganConventions& conventions) {
  report.remarks.push_back(
      {"conventions", 1,
       fmt::format("{}, values at {} of their bins, f_r = number x {:g}",
                   conventions.interleaved ? "channels side by side" : "one channel after the other",
                   conventions.at_edges ? "the lower edges" : "the centres", conventions.scale)});
  if (source.traits().channels != std::vector<std::string>{"R", "G", "B"}) {
    report.remarks.push_back(
        {"channel_names_lost", static_cast<double>(header.channels),
         fmt::format("the names of the channels ({}) are not stored", fmt::join(source.traits().channels, ", "))});
  }
  if (header.half) {
    report.remarks.push_back({"half_data", 1,
                              "phi_v - phi_i beyond 180 degrees is left out; it is read back as the mirror image about "
                              "the tangent"});
  }
}

void remark_rounding(Report& report, const BrdfSource& source, const Writer& writer) {
  if (source.table() != nullptr && source.table()->type == ValueType::kFloat64) {
    report.remarks.push_back({"rounded_to_float32", 1, "64-bit numbers were rounded to 32 bits"});
  }
  remark_count(report, "vanished_values", writer.vanished(), "values too small for 32-bit numbers, 0 in their place");
}

/// What the table gives back between its nodes, and in the half that it leaves out.
void remark_difference(Report& report, const BrdfSource& source, const NganHeader& header, bool at_edges,
                       bool clamped) {
  const Grid grid = ngan_grid(header, at_edges);
  std::function<void(std::span<double>)> change;
  if (clamped) {
    change = [](std::span<double> colour) {
      for (double& value : colour) value = value < 0 ? 0 : value;
    };
  }
  if (!header.half) return remark_interpolation(report, source, grid, change);
  DenseTable table = table_of_source(source, grid, change);
  table.values = with_other_half(std::move(table.values), header, at_edges, NganOtherHalf::kTangent);
  remark_resampling(report, source, resampling_error(source, [&](auto pairs, auto values) {
                      interpolate_table(table, pairs, values);
                    }));
}

Status check_size(const NganHeader& header) {
  if (header.channels > kNganMaxChannels) {
    return unsupported(
        fmt::format("such a table holds at most {} channels, the source has {}", kNganMaxChannels, header.channels));
  }
  if (ngan_bin_count(header) > kMostNumbers / header.channels) {
    return usage_error(fmt::format("{} bins of {} channels are more than {} numbers, which readers count in 32 bits",
                                   fmt::join(header.counts, " x "), header.channels, kMostNumbers));
  }
  return ok_status();
}

}  // namespace

Status save_ngan(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                 const Progress& progress) {
  const NganConventions conventions = ngan_conventions(options);
  if (const std::shared_ptr<const ByteSource> stored = source.stored("ngan")) {
    const Result<std::vector<std::byte>> head = read_start(*stored, kNganHeaderSize);
    const Result<NganHeader> own = head ? parse_ngan_header(*head, stored->size()) : head.error();
    if (!own) return own.error();
    if (is_as_asked(*own, conventions, options)) {
      report.remarks.push_back({"copied", 1, "copied bit for bit"});
      return copy_bytes(*stored, sink, progress);
    }
  }
  const NganHeader header = header_for(source, options);
  if (Status possible = check_size(header); !possible) return possible;
  TableRequest request = {ngan_stored_grid(header, conventions.at_edges),
                          policy_of(options, NonFinite::kRefuse, Negatives::kClamp)};
  request.largest = kTableLargest * std::min(1.0, conventions.scale);
  Writer writer(header, conventions, sink);
  if (Status begun = writer.begin(); !begun) return begun;
  const std::uint32_t phi_in = header.counts[3];
  const std::uint32_t rows = std::clamp(kBlockNodes / phi_in, 1U, header.counts[2]);
  const Result<TableLosses> losses = sample_table(
      source, request, {phi_in, 1, 1, rows},
      [&](const TableBlock& block, std::span<const double> values) { return writer.take(block, values); }, progress);
  if (!losses) return losses.error();
  if (!writer.positive()) {
    return invalid_file("no bin has a positive value and no negative one: nothing reads such a table");
  }
  remark_conventions(report, source, header, conventions);
  remark_losses(report, source, request, *losses, "-1 in every channel");
  const std::uint64_t negative = losses->some_negative + losses->all_negative;
  if (request.policy.negatives == Negatives::kKeep) {
    remark_count(report, "read_as_unmeasured", negative,
                 "nodes with a negative value: readers take them for unmeasured");
  }
  remark_rounding(report, source, writer);
  const bool clamped = negative > 0 && request.policy.negatives == Negatives::kClamp;
  remark_difference(report, source, header, conventions.at_edges, clamped);
  return ok_status();
}

}  // namespace sbrdf::internal
