#include "converters/files/dense/dense_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "formats/core/half.h"

namespace sbrdf::internal {
namespace {

/// Room for what is only known after the numbers are written [bytes].
constexpr std::size_t kReportRoom = 2048;
/// Nodes are even within this share of a step.
constexpr double kEven = 1e-3;

template <class T>
void append(std::vector<std::byte>& bytes, T value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

TableRequest request_of(const BrdfSource& source, const Options& options) {
  TableRequest request;
  request.grid = grid_for(source, options);
  request.policy = policy_of(options, NonFinite::kRefuse);
  return request;
}

}  // namespace

void round_numbers(ValueType type, std::span<double> values) {
  if (type == ValueType::kFloat64) return;
  for (double& value : values) {
    const auto single = static_cast<float>(value);
    value = type == ValueType::kFloat16 ? float_from_half(half_from_float(single)) : single;
  }
}

void append_numbers(ValueType type, std::span<const double> values, std::vector<std::byte>& bytes) {
  bytes.reserve(bytes.size() + values.size() * size_of(type));
  for (const double value : values) {
    if (type == ValueType::kFloat64) {
      append(bytes, value);
    } else if (type == ValueType::kFloat32) {
      append(bytes, static_cast<float>(value));
    } else {
      append(bytes, half_from_float(static_cast<float>(value)));
    }
  }
}

DenseWriting::DenseWriting(const BrdfSource& source, const Options& options, ValueType most, Report& report)
    : source_(source),
      report_(report),
      request_(request_of(source, options)),
      type_(type_for(source, request_.grid, options)),
      fitting_(source, request_.grid, report) {
  if (size_of(type_) > size_of(most) && !options.has("type")) type_ = most;
  if (is_table_of(source_, request_.grid) && size_of(type_) < size_of(source_.table()->type)) {
    report_.remarks.push_back(
        {"rounded_to_bits", 8.0 * static_cast<double>(size_of(type_)),
         fmt::format("numbers of the source were rounded to {}", name_of(kValueTypeNames, type_))});
  }
  if (type_ == ValueType::kFloat16) request_.largest = kHalfLargest;
  remark_cost();
}

std::shared_ptr<const ByteSource> DenseWriting::stored(std::string_view format) const {
  const bool same = is_table_of(source_, request_.grid) && source_.table()->type == type_ &&
                    request_.policy.negatives == Negatives::kKeep;
  auto file = same ? source_.stored(format) : nullptr;
  if (file != nullptr) report_.remarks.push_back({"copied", 1, "copied bit for bit"});
  return file;
}

TableHead DenseWriting::head() const {
  return {request_.grid, source_.traits().channels, type_, reach_of(source_.traits()), report_json(report_)};
}

std::string DenseWriting::padded_head(std::size_t size) const {
  std::string text = emit_table_head(head());
  if (text.size() > size) {
    TableHead plain = head();
    plain.report.clear();
    text = emit_table_head(plain);
  }
  text.resize(std::max(size, text.size()), ' ');
  return text;
}

std::size_t DenseWriting::head_size() const { return emit_table_head(head()).size() + kReportRoom; }

void DenseWriting::remark_cost() {
  const bool clamps = request_.policy.negatives == Negatives::kClamp;
  const bool exact = is_table_of(source_, request_.grid) && size_of(type_) >= size_of(source_.table()->type);
  if ((type_ != ValueType::kFloat16 || exact) && !clamps) {
    remark_interpolation(report_, *fitting_, request_.grid);
    return;
  }
  const double largest = request_.largest;
  remark_interpolation(report_, *fitting_, request_.grid, [type = type_, clamps, largest](std::span<double> colour) {
    for (double& value : colour) value = std::clamp(value, clamps ? 0 : -largest, largest);
    round_numbers(type, colour);
  });
}

Status DenseWriting::sample(std::array<std::uint32_t, 4> block, const TakeBlock& take, const Progress& progress) {
  std::uint64_t vanished = 0;
  bool positive = false;
  std::vector<double> rounded;
  const auto round_and_take = [&](const TableBlock& part, std::span<const double> values) {
    rounded.assign(values.begin(), values.end());
    round_numbers(type_, rounded);
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (rounded[k] == 0 && values[k] != 0) ++vanished;
      positive = positive || rounded[k] > 0;
    }
    return take(part, rounded);
  };
  const Result<TableLosses> losses = sample_table(*fitting_, request_, block, round_and_take, progress);
  if (!losses) return losses.error();
  if (!positive) {
    return invalid_file(fmt::format("no value of the source is positive as a {} number: nothing reads such a table",
                                    name_of(kValueTypeNames, type_)));
  }
  remark_losses(report_, source_, request_, *losses, "NaN");
  remark_count(report_, "vanished_numbers", vanished,
               fmt::format("numbers too close to 0 for {}, 0 in their place", name_of(kValueTypeNames, type_)));
  return ok_status();
}

std::vector<std::string> default_channels(std::size_t count) {
  if (count == 1) return {"Y"};
  if (count == 3) return {"R", "G", "B"};
  std::vector<std::string> channels(count);
  for (std::size_t c = 0; c < count; ++c) channels[c] = fmt::format("channel {}", c + 1);
  return channels;
}

Result<Grid> grid_of_option(const Options& options, std::string_view whose) {
  const auto text = options.text("grid");
  if (!text) return usage_error(fmt::format("{}: say where the nodes of the table are by --grid", whose));
  return parse_grid(*text);
}

namespace {

/// Even nodes all the way round but for one step.
bool goes_round(const std::vector<double>& nodes_deg) {
  if (nodes_deg.size() < 2) return false;
  const double step = (nodes_deg.back() - nodes_deg.front()) / static_cast<double>(nodes_deg.size() - 1);
  for (std::size_t k = 0; k < nodes_deg.size(); ++k) {
    if (std::abs(nodes_deg[k] - nodes_deg.front() - static_cast<double>(k) * step) > kEven * step) return false;
  }
  return std::abs(step * static_cast<double>(nodes_deg.size()) - 360) <= kEven * step;
}

/// Azimuths that go round, in a file that says of their ends that they are held, or says nothing: a value held across
/// the last step is what nobody means.
bool close_turns(Grid& grid, std::vector<Finding>& findings) {
  bool closed = false;
  for (std::size_t k = 0; k < grid.axes.size(); ++k) {
    GridAxis& axis = grid.axes[k];
    if (axis.ends() != Ends::kHeld || Grid::natural_ends(grid.frame, k) != Ends::kFullTurn) continue;
    if (!goes_round(axis.nodes_deg())) continue;
    axis = GridAxis(axis.nodes_deg(), Ends::kFullTurn, axis.spacing());
    findings.push_back({fmt::format("nodes of {} go all the way round, though the file does not say so: the azimuth is "
                                    "taken to close after 360 degrees",
                                    grid.axis_name(k)),
                        axis.size(), axis.size()});
    closed = true;
  }
  return closed;
}

}  // namespace

Result<std::unique_ptr<BrdfSource>> open_dense(DenseTable table, std::string format, TableHead head,
                                               std::shared_ptr<const ByteSource> file, const Options& options,
                                               std::vector<Finding> findings) {
  std::vector<std::string>& channels = head.channels;
  if (close_turns(table.grid, findings)) file = nullptr;
  DenseDescription description;
  description.description = fmt::format(
      "dense table of {}, {} frame, {} {}, {}", table.grid.size_text(), name_of(kGridFrameNames, table.grid.frame),
      channels.size(), channels.size() == 1 ? "channel" : "channels", name_of(kValueTypeNames, table.type));
  description.format = std::move(format);
  description.channels = std::move(channels);
  description.file = std::move(file);
  description.policy = policy_of(options, NonFinite::kUnmeasured);
  description.reach = std::move(head.reach);
  description.findings = std::move(findings);
  return DenseSource::make(std::move(table), std::move(description));
}

}  // namespace sbrdf::internal
