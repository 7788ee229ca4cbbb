#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/directions.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// The CSV that `sbrdf eval` reads: a header that begins with theta_i,phi_i,theta_v,phi_v, then one pair of directions
/// per row [degrees]. Further columns are allowed and not looked at, but each row must have as many fields as the
/// header. Fields are separated by commas and may stand in double quotes, two of which stand for one inside. A line may
/// end in CR LF, and the file may begin with the byte order mark of UTF-8.
struct DirectionHeader {
  std::vector<std::string> names;  ///< of all columns, without quotes and outer spaces
  std::string text;                ///< as it was, without the mark and the end of the line
};

struct DirectionRow {
  DirectionPair pair;          ///< to be evaluated only where it is not below the horizon
  bool below_horizon = false;  ///< one of the thetas is above 90 degrees: f_r is 0 (specs/conventions.md)
  double theta_v_deg = 0;
  std::string_view text;  ///< the line as it was, without its end
};

/// kInvalidFile where the first four names are others.
[[nodiscard]] Result<DirectionHeader> parse_direction_header(std::string_view line);

/// `line` must outlive the row. kInvalidFile for another number of fields than `column_count`, for a field that is not
/// a finite number, and for a theta outside [0, 180] degrees; the message names the column.
[[nodiscard]] Result<DirectionRow> parse_direction_row(std::string_view line, std::size_t column_count);

/// The fields of a line, with their quotes and outer spaces taken off.
[[nodiscard]] std::vector<std::string> split_fields(std::string_view line);

/// The part of a line that its first `count` fields take [bytes].
[[nodiscard]] std::size_t size_of_fields(std::string_view text, std::size_t count);

/// A name as a CSV field: in quotes where it needs them.
[[nodiscard]] std::string csv_field(std::string_view name);

}  // namespace sbrdf::internal
