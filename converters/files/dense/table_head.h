#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "converters/tables/dense_source.h"
#include "converters/tables/grid.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// What a dense table is, beside its numbers, for files that have no place for it of their own (specs/npy.md):
///
///     {"sbrdf": "dense table", "version": 1, "frame": "angles",
///      "axes": [{"name": "theta_i", "unit": "degree", "ends": "held", "spacing": "angle", "nodes": [0, 15, 30]}, ...],
///      "channels": ["R", "G", "B"], "type": "float32", "quantity": "f_r, without cosine", "unit": "1/sr",
///      "unmeasured": "NaN", "theta_max": 80, "slice_theta_max": 80, "beyond_theta_max": "extrapolated", "report":
///      {"findings": [...], "remarks": [...]}}
struct TableHead {
  Grid grid;
  std::vector<std::string> channels;     ///< in the order of the values
  ValueType type = ValueType::kFloat32;  ///< of the numbers as they were written
  MeasuredReach reach;                   ///< of the source that the table was made of
  std::string report;                    ///< JSON, as report_json() makes it; empty: none
};

/// Longest head that is read [bytes]: four axes of the most nodes that an axis has take less.
inline constexpr std::size_t kLongestTableHead = std::size_t{8} << 20U;
/// Most channels of a table that is read.
inline constexpr std::size_t kMostTableChannels = 4096;

/// One line. Numbers have as many digits as it takes to read back the same.
[[nodiscard]] std::string emit_table_head(const TableHead& head);

/// The text begins as one of emit_table_head() does; blanks do not matter. For telling files apart.
[[nodiscard]] bool begins_table_head(std::string_view text);

/// The whole text is a head that parse_table_head() takes, or begins as one of emit_table_head() does.
[[nodiscard]] bool is_table_head(std::string_view text);

/// What others wrote may have more entries, which are left out; a `report` is left out, too. kInvalidFile naming the
/// entry that is missing or cannot be: no JSON, nodes that do not rise or leave the range of their axis, more than 2^36
/// nodes in all, channels without names or with the same. kUnsupported for another version, quantity or unit, and for a
/// text longer than kLongestTableHead.
[[nodiscard]] Result<TableHead> parse_table_head(std::string_view text);

}  // namespace sbrdf::internal
