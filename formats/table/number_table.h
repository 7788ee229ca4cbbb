#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/result.h"
#include "formats/core/text_lines.h"

namespace sbrdf::internal {

/// A table of numbers in a text file: rows of as many numbers each, between commas, semicolons or blanks. Empty lines
/// and those that begin with '#' or '%' are left out.
struct NumberTable {
  std::size_t column_count = 0;
  /// Of the line before the first row where that holds no number, or a name of an angle ("theta"); else empty.
  std::vector<std::string> names;
  /// Of the last '#' or '%' line before the first row where it has as many fields as a row; else empty. It may be a
  /// sentence by chance.
  std::vector<std::string> comment_names;
  std::vector<double> numbers;       ///< row by row, finite
  std::vector<std::uint64_t> lines;  ///< number of the line of each row, from 1

  [[nodiscard]] std::size_t row_count() const { return lines.size(); }
};

/// Fewest columns of a table that is recognised: four angles and a value.
inline constexpr std::size_t kFewestNumberColumns = 5;
inline constexpr std::size_t kMostNumberColumns = 4096;

/// What the beginning of a file says.
enum class NumberTableLook : std::uint8_t {
  kNone,
  kComments,  ///< nothing but comments so far, or names of angles
  kTable,     ///< numbers in at least kFewestNumberColumns columns, below at most one line of names
};
/// `head` is the beginning of a text, or all of it where `whole` says so.
[[nodiscard]] NumberTableLook look_at_number_table(std::string_view head, bool whole);

/// kInvalidFile, naming line and column, for what is no number, for NaN and infinities, for rows of different length,
/// for lines longer than kLongestLine, and where there is no row; kUnsupported for more than kMostNumberColumns
/// columns.
[[nodiscard]] Result<NumberTable> parse_number_table(std::string_view text);

}  // namespace sbrdf::internal
