#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "converters/audit/subject.h"
#include "converters/tables/grid.h"

namespace sbrdf::internal {

/// A grid, and what a table on it is off by before its numbers are rounded.
struct LadderStep {
  Grid grid;
  double percent = 0;  ///< relative L1 on the few directions
};

/// Grids over half and difference angles that suit a material, each larger than the one before: of the axes, the one is
/// refined that brings the error down most for the nodes that it takes. Nodes along theta_h lie densely at 0, as in
/// MERL tables.
class GridLadder {
 public:
  /// `subject` must outlive it.
  explicit GridLadder(const AuditSubject& subject);

  /// The number of the first step whose table is at most so far off [%]; size() of all that there are where none is
  /// within kMostNumbers.
  [[nodiscard]] std::size_t reach(double percent);
  /// Such a step, or the last that there is.
  [[nodiscard]] const LadderStep& step(std::size_t k);
  [[nodiscard]] std::size_t size() const { return steps_.size(); }

  static constexpr std::uint64_t kMostNumbers = 9'000'000;  ///< of all channels

 private:
  using Counts = std::array<std::uint32_t, 4>;
  [[nodiscard]] LadderStep judged(const Counts& counts) const;
  /// Appends a step; false where there is none.
  bool climb();

  const AuditSubject& subject_;
  std::vector<LadderStep> steps_;
  Counts counts_;
};

/// As --grid takes it.
[[nodiscard]] std::string grid_text(const Grid& grid);

}  // namespace sbrdf::internal
