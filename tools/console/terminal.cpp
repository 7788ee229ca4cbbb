#include "tools/console/terminal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sbrdf::internal {
namespace {

constexpr std::size_t kMostInColumn = 200;  // characters of a cell that others stand beside

}  // namespace

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
  for (std::size_t k = 0; k < cells.size(); ++k) {
    cells[k] = k + 1 < cells.size() ? one_line(cells[k], kMostInColumn) : one_line(cells[k]);
  }
  rows_.push_back(std::move(cells));
}

void Table::print() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()));
    // The last cell of a row has nothing to its right to be aligned with.
    for (std::size_t k = 0; k + 1 < row.size(); ++k) widths[k] = std::max(widths[k], character_count(row[k]));
  }
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) {
      line += row[k];
      if (k + 1 < row.size()) line.append(widths[k] - character_count(row[k]) + 2, ' ');
    }
    sbrdf::internal::print(line + "\n");
  }
}

}  // namespace sbrdf::internal
