#include "tools/io/direction_rows.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "tools/console/options.h"
#include "tools/console/plain_text.h"

namespace sbrdf::internal {
namespace {

constexpr std::array<std::string_view, 4> kNames = {"theta_i", "phi_i", "theta_v", "phi_v"};
constexpr std::size_t kMostQuoted = 60;  // characters of what stood there instead
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view without_line_end(std::string_view line) {
  if (line.ends_with('\n')) line.remove_suffix(1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string_view trimmed(std::string_view field) {
  while (!field.empty() && (field.front() == ' ' || field.front() == '\t')) field.remove_prefix(1);
  while (!field.empty() && (field.back() == ' ' || field.back() == '\t')) field.remove_suffix(1);
  return field;
}

bool is_quoted(std::string_view field) { return field.size() >= 2 && field.front() == '"' && field.back() == '"'; }

/// The fields of a line as they stand there, outer spaces left out.
std::vector<std::string_view> raw_fields(std::string_view line) {
  std::vector<std::string_view> fields;
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (line[k] == '"') quoted = !quoted;
    if (line[k] != ',' || quoted) continue;
    fields.push_back(trimmed(line.substr(begin, k - begin)));
    begin = k + 1;
  }
  fields.push_back(trimmed(line.substr(begin)));
  return fields;
}

std::string unquoted(std::string_view field) {
  if (!is_quoted(field)) return std::string(field);
  std::string text;
  for (std::size_t k = 1; k + 1 < field.size(); ++k) {
    text += field[k];
    // Two quotes stand for one.
    if (field[k] == '"' && k + 2 < field.size() && field[k + 1] == '"') ++k;
  }
  return text;
}

Result<double> parse_angle(std::string_view field, std::string_view name) {
  if (is_quoted(field)) field = field.substr(1, field.size() - 2);
  const std::optional<double> value = parse_number(field);
  if (!value) {
    return invalid_file(std::string(name) + " is not a finite number: '" + one_line(field, kMostQuoted) + "'");
  }
  const bool is_theta = name.starts_with("theta");
  if (is_theta && !(*value >= 0 && *value <= 180)) {
    return invalid_file(std::string(name) + " is " + one_line(field, kMostQuoted) + ", must be 0 to 180 degrees");
  }
  return *value;
}

}  // namespace

std::vector<std::string> split_fields(std::string_view line) {
  std::vector<std::string> fields;
  for (const std::string_view field : raw_fields(line)) fields.push_back(unquoted(field));
  return fields;
}

Result<DirectionHeader> parse_direction_header(std::string_view line) {
  line = without_line_end(line);
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  std::vector<std::string> names = split_fields(line);
  if (names.size() < kNames.size() || !std::equal(kNames.begin(), kNames.end(), names.begin())) {
    return invalid_file("the header must begin with theta_i,phi_i,theta_v,phi_v, not '" + one_line(line, kMostQuoted) +
                        "'");
  }
  return DirectionHeader{std::move(names), std::string(line)};
}

Result<DirectionRow> parse_direction_row(std::string_view line, std::size_t column_count) {
  line = without_line_end(line);
  const std::vector<std::string_view> fields = raw_fields(line);
  if (fields.size() != column_count) {
    return invalid_file(std::to_string(fields.size()) + " fields, the header has " + std::to_string(column_count));
  }
  std::array<double, kNames.size()> angles{};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const Result<double> angle = parse_angle(fields[k], kNames[k]);
    if (!angle) return angle.error();
    angles[k] = *angle;
  }
  return DirectionRow{{direction_from_degrees(angles[0], angles[1]), direction_from_degrees(angles[2], angles[3])},
                      angles[0] > 90 || angles[2] > 90,
                      angles[2],
                      line};
}

std::size_t size_of_fields(std::string_view text, std::size_t count) {
  std::size_t size = 0;
  for (const std::string_view field : raw_fields(text)) {
    if (count-- == 0) break;
    size = static_cast<std::size_t>(field.data() - text.data()) + field.size();
  }
  return size;
}

std::string csv_field(std::string_view name) {
  if (name.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(name);
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace sbrdf::internal
