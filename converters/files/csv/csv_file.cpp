#include "converters/files/csv/csv_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "converters/files/dense/dense_file.h"
#include "formats/core/directions.h"
#include "formats/core/half.h"
#include "formats/core/text_lines.h"

namespace sbrdf::internal {
namespace {

constexpr std::array<std::string_view, 4> kAngles = {"theta_i", "phi_i", "theta_v", "phi_v"};
/// How far an angle may lie from that of its node [degrees]: they are written with ten digits.
constexpr double kAngleTolerance = 1e-6;

/// theta_i, phi_i, theta_v, phi_v of a node [degrees]; as in the head where an axis is such an angle.
std::array<double, 4> angles_of(const Grid& grid, const GridNode& node) {
  std::array<double, 4> at{};
  for (std::size_t k = 0; k < at.size(); ++k) at[k] = grid.axes[k].node_deg(node[k]);
  if (grid.frame == GridFrame::kAngles) return at;
  if (grid.frame == GridFrame::kDifference) return {at[1], at[0], at[2], wrap(at[0] + at[3], 360)};
  const DirectionPair pair = grid.pair_of(node);
  return {degrees_from_radians(pair.i.theta), degrees_from_radians(pair.i.phi), degrees_from_radians(pair.v.theta),
          degrees_from_radians(pair.v.phi)};
}

/// Steps through the nodes of a grid in C order.
void advance(const Grid& grid, GridNode& node) {
  for (std::size_t axis = node.size(); axis-- > 0;) {
    if (++node[axis] < grid.axes[axis].size()) return;
    node[axis] = 0;
  }
}

// ---- Writing ----

using Text = fmt::memory_buffer;

void put(Text& text, double value, ValueType type) {
  if (std::isnan(value)) {
    text.append(std::string_view("nan"));
  } else if (type == ValueType::kFloat64) {
    fmt::format_to(std::back_inserter(text), "{}", value);
  } else {
    fmt::format_to(std::back_inserter(text), "{}", static_cast<float>(value));
  }
}

Status check_names(const std::vector<std::string>& channels) {
  for (const std::string& name : channels) {
    const bool plain = name.find_first_of(",\"\r\n") == std::string::npos && trimmed(name) == name && !name.empty();
    if (!plain) return unsupported("a channel with a name that cannot stand in a line of names");
  }
  return ok_status();
}

std::string line_of_names(const std::vector<std::string>& channels) {
  return fmt::format("{},{}\n", fmt::join(kAngles, ","), fmt::join(channels, ","));
}

class LineWriter {
 public:
  LineWriter(DenseWriting& writing, ByteSink& sink, std::uint64_t offset)
      : writing_(writing), sink_(sink), offset_(offset) {}

  Status write(const Progress& progress) {
    const auto take = [this](const TableBlock&, std::span<const double> values) { return take_values(values); };
    return writing_.sample(rows_of(writing_.grid()), take, progress);
  }

 private:
  // Blocks are whole rows, so that nodes come one after the other.
  Status take_values(std::span<const double> values) {
    text_.clear();
    const std::size_t channels = writing_.channel_count();
    for (std::size_t first = 0; first < values.size(); first += channels) {
      const auto [theta_i, phi_i, theta_v, phi_v] = angles_of(writing_.grid(), node_);
      fmt::format_to(std::back_inserter(text_), "{:.10g},{:.10g},{:.10g},{:.10g}", theta_i, phi_i, theta_v, phi_v);
      for (const double value : values.subspan(first, channels)) {
        text_.push_back(',');
        put(text_, value, writing_.type());
      }
      text_.push_back('\n');
      advance(writing_.grid(), node_);
    }
    Status written = sink_.write(offset_, std::as_bytes(std::span(text_.data(), text_.size())));
    offset_ += text_.size();
    return written;
  }

  DenseWriting& writing_;
  ByteSink& sink_;
  std::uint64_t offset_;
  GridNode node_ = {0, 0, 0, 0};
  Text text_;
};

Status write_text(ByteSink& sink, std::uint64_t offset, std::string_view text) {
  return sink.write(offset, std::as_bytes(std::span(text.data(), text.size())));
}

// ---- Reading ----

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Error wrong(const TextLine& line, std::string_view what) {
  return invalid_file(fmt::format("line {}: {}", line.number, what), line.offset);
}

/// Reads the lines of the nodes.
class LineReader {
 public:
  LineReader(std::string_view text, std::size_t size) : lines_(text), size_(size) {}

  Result<TableHead> read_head() {
    const std::optional<TextLine> line = lines_.next();
    if (!line || !line->text.starts_with('#')) return invalid_file("the first line is not \"# {...}\"", 0);
    Result<TableHead> head = parse_table_head(line->text.substr(1));
    if (!head) {
      Error error = wrong(*line, head.error().message);
      error.code = head.error().code;
      return error;
    }
    const std::optional<TextLine> names = next();
    if (!names) return invalid_file("truncated: no line of names", size_);
    const std::string expected = line_of_names(head->channels);
    if (names->text != std::string_view(expected).substr(0, expected.size() - 1)) {
      return wrong(*names,
                   fmt::format("not the names of the head: {}", field_text(expected.substr(0, expected.size() - 1))));
    }
    return head;
  }

  // T: what the numbers are kept as.
  template <class T>
  Result<std::vector<T>> read_values(const TableHead& head) {
    const std::uint64_t nodes = head.grid.node_count();
    const std::size_t channels = head.channels.size();
    // Each field takes a character and what ends it.
    if (nodes > size_ / 2 / (channels + kAngles.size())) {
      return invalid_file(
          fmt::format("truncated: lines of {} do not fit a file of {} bytes", head.grid.size_text(), size_), size_);
    }
    std::vector<T> values(nodes * channels);
    GridNode node = {0, 0, 0, 0};
    for (std::uint64_t k = 0; k < nodes; ++k) {
      const std::optional<TextLine> line = next();
      if (!line) return invalid_file(fmt::format("truncated: {} of {} lines are there", k, nodes), size_);
      if (line->text.size() > kLongestLine) return wrong(*line, "longer than 2^20 characters");
      if (Status read = read_line(*line, head, node, std::span(values).subspan(k * channels, channels)); !read) {
        return read.error();
      }
      advance(head.grid, node);
    }
    if (const std::optional<TextLine> more = next()) return wrong(*more, "more lines than the table has nodes");
    return values;
  }

 private:
  // Without comments and empty lines.
  std::optional<TextLine> next() {
    std::optional<TextLine> line = lines_.next();
    while (line && (line->text.starts_with('#') || trimmed(line->text).empty())) line = lines_.next();
    return line;
  }

  template <class T>
  Status read_line(const TextLine& line, const TableHead& head, const GridNode& node, std::span<T> values) {
    split_fields(line.text, Separator::kComma, fields_);
    if (fields_.size() != kAngles.size() + values.size()) {
      return wrong(line, fmt::format("{} fields instead of {}", fields_.size(), kAngles.size() + values.size()));
    }
    const std::array<double, 4> angles = angles_of(head.grid, node);
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const FieldNumber angle = read_field(fields_[k]);
      if (angle.kind == FieldNumber::Kind::kFinite && std::abs(angle.value - angles[k]) <= kAngleTolerance) continue;
      return wrong(line, fmt::format("{} is '{}' where the next node has {:.10g}: lines stand in the order of the head",
                                     kAngles[k], field_text(fields_[k]), angles[k]));
    }
    for (std::size_t c = 0; c < values.size(); ++c) {
      const std::string_view field = fields_[kAngles.size() + c];
      const FieldNumber number = std::is_same_v<T, float> ? read_float_field(field) : read_field(field);
      if (number.kind == FieldNumber::Kind::kNone) {
        return wrong(line, fmt::format("{} is '{}', no number", head.channels[c], field_text(field)));
      }
      values[c] = number.kind == FieldNumber::Kind::kFinite ? static_cast<T>(number.value)
                  : number.kind == FieldNumber::Kind::kNan  ? std::numeric_limits<T>::quiet_NaN()
                                                            : std::numeric_limits<T>::infinity();
    }
    return ok_status();
  }

  LineWalker lines_;
  std::size_t size_;
  std::vector<std::string_view> fields_;
};

bool are_halves(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](float value) { return std::isnan(value) || float_from_half(half_from_float(value)) == value; });
}

Result<DenseTable> read_table(LineReader& reader, const TableHead& head) {
  if (head.type == ValueType::kFloat64) {
    Result<std::vector<double>> values = reader.read_values<double>(head);
    if (!values) return values.error();
    return table_in_memory(head.grid, head.channels.size(), *std::move(values));
  }
  Result<std::vector<float>> values = reader.read_values<float>(head);
  if (!values) return values.error();
  const bool halves = head.type == ValueType::kFloat16 && are_halves(*values);
  DenseTable table = table_in_memory(head.grid, head.channels.size(), *std::move(values));
  if (halves) table.type = ValueType::kFloat16;
  return table;
}

}  // namespace

std::span<const OptionSpec> csv_options() { return kDenseOptions; }

bool recognises_csv(std::span<const std::byte> head) {
  std::string_view text = text_of(head);
  if (!text.starts_with('#')) return false;
  return begins_table_head(text.substr(1));
}

Result<std::unique_ptr<BrdfSource>> open_csv(std::shared_ptr<const ByteSource> bytes, const Options& options) {
  const Result<std::shared_ptr<const ByteSource>> viewed = with_view(bytes);
  if (!viewed) return viewed.error();
  const std::string_view text = text_of(*(*viewed)->view());
  LineReader reader(text, text.size());
  Result<TableHead> head = reader.read_head();
  if (!head) return head.error();
  Result<DenseTable> table = read_table(reader, *head);
  if (!table) return table.error();
  return open_dense(*std::move(table), "csv", *std::move(head), std::move(bytes), options);
}

Status save_csv(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                const Progress& progress) {
  DenseWriting writing(source, options, ValueType::kFloat64, report);
  if (const auto stored = writing.stored("csv")) return copy_bytes(*stored, sink, progress);
  if (Status plain = check_names(source.traits().channels); !plain) return plain;
  const std::size_t head_size = writing.head_size();
  const std::string names = line_of_names(source.traits().channels);
  const std::uint64_t names_offset = 2 + head_size + 1;
  if (Status written = write_text(sink, names_offset, names); !written) return written;
  if (Status written = LineWriter(writing, sink, names_offset + names.size()).write(progress); !written) return written;
  return write_text(sink, 0, "# " + writing.padded_head(head_size) + "\n");
}

}  // namespace sbrdf::internal
