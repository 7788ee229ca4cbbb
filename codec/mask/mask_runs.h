#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "codec/mask/direction_mask.h"

namespace sbrdf::internal {

// A mask as it lies in a file (specs/sbrdf.md, section 8): lengths of runs of cells, measured ones first, in turn, each
// as a count.

[[nodiscard]] std::vector<std::byte> emit_runs(const DirectionMask& mask);

/// Nothing where a run but the first is empty, a length is no count, or the runs are not as long as the grid, which is
/// valid.
[[nodiscard]] std::optional<DirectionMask> parse_runs(std::span<const std::byte> bytes, const MaskGrid& grid);

}  // namespace sbrdf::internal
