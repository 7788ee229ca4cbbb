#include "converters/audit/tables/grid_ladder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "converters/tables/dense_source.h"

namespace sbrdf::internal {
namespace {

constexpr double kFiner = 1.4;  // nodes along an axis that is refined
constexpr std::uint32_t kMostAlong = 1024;

/// `count` nodes along each axis, the whole range of each.
Grid half_difference_grid(const std::array<std::uint32_t, 4>& count) {
  Grid grid;
  grid.frame = GridFrame::kHalfDifference;
  for (std::size_t axis = 0; axis < count.size(); ++axis) {
    const double range = Grid::range_deg(grid.frame, axis);
    const Ends ends = Grid::natural_ends(grid.frame, axis);
    const std::uint32_t n = count[axis];
    if (axis == 0 && n == 1) continue;  // isotropic
    const bool closes = ends != Ends::kHeld;
    std::vector<double> nodes(n);
    for (std::uint32_t k = 0; k < n; ++k) {
      const double share = static_cast<double>(k) / (closes ? n : n - 1);
      nodes[k] = range * (axis == 1 ? share * share : share);
    }
    grid.axes[axis] = GridAxis(std::move(nodes), ends);
  }
  return grid;
}

std::uint64_t nodes_of(const std::array<std::uint32_t, 4>& counts) {
  return std::uint64_t{counts[0]} * counts[1] * counts[2] * counts[3];
}

}  // namespace

GridLadder::GridLadder(const AuditSubject& subject)
    : subject_(subject), counts_{subject.symmetries().isotropic ? 1U : 8U, 6, 4, 4} {
  steps_.push_back(judged(counts_));
}

LadderStep GridLadder::judged(const Counts& counts) const {
  LadderStep step = {half_difference_grid(counts), 0};
  std::vector<float> values(subject_.few().values.size());
  interpolate_table(table_of_source(subject_.source(), step.grid), subject_.few().pairs, values);
  step.percent = subject_.few_percent(values);
  return step;
}

bool GridLadder::climb() {
  struct Trial {
    Counts counts;
    LadderStep step;
    double gain;
  };
  std::optional<Trial> best;
  const double before = std::log(std::max(steps_.back().percent, 1e-9));
  for (std::size_t axis = 0; axis < counts_.size(); ++axis) {
    Counts counts = counts_;
    if (counts[axis] == 1) continue;
    counts[axis] = static_cast<std::uint32_t>(std::ceil(kFiner * counts[axis]));
    if (counts[axis] > kMostAlong || nodes_of(counts) * subject_.channel_count() > kMostNumbers) continue;
    LadderStep step = judged(counts);
    const double gain =
        (before - std::log(std::max(step.percent, 1e-9))) / std::log(static_cast<double>(counts[axis]) / counts_[axis]);
    if (!best || gain > best->gain) best = Trial{counts, std::move(step), gain};
  }
  if (!best) return false;
  counts_ = best->counts;
  steps_.push_back(std::move(best->step));
  return true;
}

std::size_t GridLadder::reach(double percent) {
  for (std::size_t k = 0;; ++k) {
    if (k == steps_.size() && !climb()) return k;
    if (steps_[k].percent <= percent) return k;
  }
}

const LadderStep& GridLadder::step(std::size_t k) {
  while (k >= steps_.size() && climb()) {
  }
  return steps_[std::min(k, steps_.size() - 1)];
}

std::string grid_text(const Grid& grid) {
  std::string text = fmt::format("{}/", name_of(kGridFrameNames, grid.frame));
  for (std::size_t axis = 0; axis < grid.axes.size(); ++axis) {
    text += fmt::format("{}{}", axis == 0 ? "" : ":", fmt::join(grid.axes[axis].nodes_deg(), ","));
  }
  return text;
}

}  // namespace sbrdf::internal
