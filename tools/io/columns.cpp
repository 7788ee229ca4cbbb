#include "tools/io/columns.h"

#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "tools/console/plain_text.h"

namespace sbrdf::internal {

std::string figure_text(const Figure& figure) {
  if (const auto* number = std::get_if<double>(&figure)) {
    return std::isfinite(*number) ? fmt::format("{:.6g}", *number) : "";
  }
  if (const auto* count = std::get_if<std::uint64_t>(&figure)) return std::to_string(*count);
  if (const auto* name = std::get_if<std::string>(&figure)) return *name;
  if (const auto* answer = std::get_if<bool>(&figure)) return *answer ? "yes" : "no";
  return "";
}

nlohmann::ordered_json figure_json(const Figure& figure) {
  const std::string text = figure_text(figure);
  if (std::holds_alternative<std::string>(figure)) return text;
  if (const auto* answer = std::get_if<bool>(&figure)) return *answer;
  if (text.empty()) return nullptr;
  if (const auto* count = std::get_if<std::uint64_t>(&figure)) return *count;
  return std::strtod(text.c_str(), nullptr);
}

std::string csv_cell(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : one_line(text)) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace sbrdf::internal
