#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "converters/files/merl/merl_cells.h"
#include "converters/files/merl/merl_convention.h"
#include "converters/tables/value_policy.h"

namespace sbrdf::internal {

/// What a block of cells, or all of them, hold.
struct MerlCensus {
  std::uint64_t marks = 0;        ///< all channels negative
  std::uint64_t marks_above = 0;  ///< of these, and of the two below where they are marks, above the horizon
  std::uint64_t mixed = 0;        ///< some channels negative, none of them infinite
  std::uint64_t bad_cells = 0;    ///< with a value that is not finite
  std::uint64_t bad = 0;          ///< such values
  std::uint64_t first_bad = std::numeric_limits<std::uint64_t>::max();  ///< position among all values of the file
};

/// Looks at all cells of a table, on all cores.
[[nodiscard]] MerlCensus take_merl_census(const MerlCells& cells, const MerlConvention& convention,
                                          const ValuePolicy& policy);

/// Whether some value is positive, in a cell that is no mark. Looks no further than the first.
[[nodiscard]] bool has_positive_value(const MerlCells& cells, const ValuePolicy& policy);

/// What the third dimension of a table covers, as far as its content tells: where one of the two readings has its
/// horizon and the other has not, the cells that are blank; without blank cells, whether values half the dimension
/// apart are as near as reciprocity makes them. Nothing where the content does not tell.
[[nodiscard]] std::optional<MerlTurn> judge_merl_turn(const MerlCells& cells, MerlPosition position);

}  // namespace sbrdf::internal
