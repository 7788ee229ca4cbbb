#include "tools/console/terminal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "converters/source/progress.h"
#include "formats/os/interrupt.h"

namespace sbrdf {
namespace {

// The first failure's reason; later calls may overwrite errno.
int output_errno = 0;

void note_failure(bool failed) {
  if (failed && output_errno == 0) output_errno = errno != 0 ? errno : EIO;
}

void print_error(std::string_view line) {
  const std::string text = "sbrdf: " + one_line(line) + "\n";
  // Nothing is left to tell it to where this fails, too.
  std::fwrite(text.data(), 1, text.size(), stderr);
}

/// Objects and what holds them on lines of their own, lists of plain values on one. `line_feed` is followed by the
/// indent.
void append_json(const nlohmann::ordered_json& json, const std::string& line_feed, std::string& text) {
  const bool on_one_line = !json.is_object() && std::none_of(json.begin(), json.end(),
                                                             [](const auto& item) { return item.is_structured(); });
  if (!json.is_structured() || json.empty() || on_one_line) {
    text += json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    return;
  }
  const std::string deeper = line_feed + "  ";
  text += json.is_object() ? '{' : '[';
  const char* separator = "";
  for (const auto& [key, value] : json.items()) {
    text += separator + deeper;
    if (json.is_object()) {
      append_json(key, deeper, text);
      text += ": ";
    }
    append_json(value, deeper, text);
    separator = ",";
  }
  text += line_feed + (json.is_object() ? "}" : "]");
}

}  // namespace

void print(std::string_view text) {
  if (output_errno != 0) return;
  note_failure(std::fwrite(text.data(), 1, text.size(), stdout) != text.size());
}

bool flush_output() {
  if (output_errno == 0) note_failure(std::fflush(stdout) != 0);
  return output_errno == 0;
}

void print_json(const nlohmann::ordered_json& json) {
  std::string text;
  append_json(json, "\n", text);
  print(text + "\n");
}

int finish_output(int exit_code) {
  if (flush_output() || exit_code != 0) return exit_code;
  print_error("standard output: " + std::generic_category().message(output_errno));
  return static_cast<int>(ErrorCode::kIo);
}

int report_error(std::string_view subject, const Error& error) {
  if (interrupted() && error.message == interrupted_error().message) {
    print_error(error.message);
    return interrupt_exit_code();
  }
  std::string line = subject.empty() ? error.message : std::string(subject) + ": " + error.message;
  if (error.offset) line += fmt::format(" (at byte {})", *error.offset);
  print_error(line);
  return static_cast<int>(error.code);
}

std::string one_line(std::string_view text) {
  std::string clean(text);
  std::replace_if(
      clean.begin(), clean.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7F'; }, '?');
  return clean;
}

std::string format_number(double value) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0 ? "infinite" : "-infinite";
  return fmt::format("{:.4g}", value);
}

std::string format_count(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t k = digits.size(); k > 3; k -= 3) digits.insert(k - 3, ",");
  return digits;
}

std::string join(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

void Table::add(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = one_line(cell);
  rows_.push_back(std::move(cells));
}

void Table::print() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()));
    // The last cell of a row has nothing to its right to be aligned with.
    for (std::size_t k = 0; k + 1 < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  }
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) {
      line += k + 1 < row.size() ? fmt::format("{:<{}}  ", row[k], widths[k]) : row[k];
    }
    sbrdf::print(line + "\n");
  }
}

}  // namespace sbrdf
