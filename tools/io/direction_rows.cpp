#include "tools/io/direction_rows.h"

#include <algorithm>
#include <array>
#include <optional>

#include "tools/console/options.h"

namespace sbrdf {
namespace {

constexpr std::array<std::string_view, 4> kNames = {"theta_i", "phi_i", "theta_v", "phi_v"};
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view without_line_end(std::string_view line) {
  if (line.ends_with('\n')) line.remove_suffix(1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string_view bare(std::string_view field) {
  while (!field.empty() && (field.front() == ' ' || field.front() == '\t')) field.remove_prefix(1);
  while (!field.empty() && (field.back() == ' ' || field.back() == '\t')) field.remove_suffix(1);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
  return field;
}

Result<double> parse_angle(std::string_view field, std::string_view name) {
  const std::optional<double> value = parse_number(field);
  if (!value)
    return invalid_file(std::string(name) + " is not a finite number: '" + std::string(field.substr(0, 40)) + "'");
  const bool is_theta = name.starts_with("theta");
  if (is_theta && !(*value >= 0 && *value <= 90)) {
    return invalid_file(std::string(name) + " is " + std::string(field) + ", must be 0 to 90 degrees");
  }
  return *value;
}

}  // namespace

std::vector<std::string_view> split_fields(std::string_view line) {
  std::vector<std::string_view> fields;
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (line[k] == '"') quoted = !quoted;
    if (line[k] != ',' || quoted) continue;
    fields.push_back(bare(line.substr(begin, k - begin)));
    begin = k + 1;
  }
  fields.push_back(bare(line.substr(begin)));
  return fields;
}

Result<DirectionHeader> parse_direction_header(std::string_view line) {
  line = without_line_end(line);
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  const std::vector<std::string_view> fields = split_fields(line);
  if (fields.size() < kNames.size() || !std::equal(kNames.begin(), kNames.end(), fields.begin())) {
    return invalid_file("the header must begin with theta_i,phi_i,theta_v,phi_v, not '" +
                        std::string(line.substr(0, 60)) + "'");
  }
  return DirectionHeader{{fields.begin(), fields.end()}, std::string(line)};
}

Result<DirectionRow> parse_direction_row(std::string_view line, std::size_t column_count) {
  line = without_line_end(line);
  const std::vector<std::string_view> fields = split_fields(line);
  if (fields.size() != column_count) {
    return invalid_file(std::to_string(fields.size()) + " fields, the header has " + std::to_string(column_count));
  }
  std::array<double, kNames.size()> angles{};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const Result<double> angle = parse_angle(fields[k], kNames[k]);
    if (!angle) return angle.error();
    angles[k] = *angle;
  }
  return DirectionRow{
      {direction_from_degrees(angles[0], angles[1]), direction_from_degrees(angles[2], angles[3])}, angles[2], line};
}

std::string csv_field(std::string_view name) {
  if (name.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(name);
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace sbrdf
