#include "converters/source/filled_source.h"

#include <array>
#include <cassert>
#include <limits>
#include <utility>

#include "codec/frame/frame.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kBlock = 4096;  // cells that one task looks at

/// The best stand-in of each cell so far.
struct Nearest {
  std::vector<std::uint32_t> cell;
  std::vector<float> distance_deg;
};

/// Walks along one axis of a grid, in both directions, carrying the last measured cell that was met.
class AxisSweep {
 public:
  AxisSweep(const MaskGrid& grid, std::size_t axis) : grid_(grid), axis_(axis) {
    for (std::size_t faster = axis + 1; faster < grid.counts.size(); ++faster) stride_ *= grid.counts[faster];
  }

  template <class IsMeasured>
  void run(const IsMeasured& is_measured, Nearest& nearest) const {
    const std::uint64_t count = grid_.counts[axis_];
    for (std::uint64_t line = 0; line < grid_.cell_count() / count; ++line) {
      const std::uint64_t first = line / stride_ * stride_ * count + line % stride_;
      for (const bool up : {true, false}) {
        std::uint64_t last = count;  // none yet
        // Twice round where the axis closes.
        for (std::uint64_t step = 0; step < (closes() ? 2 * count : count); ++step) {
          const std::uint64_t k = up ? step % count : count - 1 - step % count;
          const std::uint64_t cell = first + k * stride_;
          if (is_measured(cell)) {
            last = k;
          } else if (last != count) {
            offer(cell, k, first + last * stride_, last, nearest);
          }
        }
      }
    }
  }

 private:
  [[nodiscard]] bool closes() const {
    return grid_.frame == MaskFrame::kAngles ? axis_ % 2 == 1 : axis_ == 0 || axis_ == 3;
  }

  void offer(std::uint64_t cell, std::uint64_t k, std::uint64_t other, std::uint64_t other_k, Nearest& nearest) const {
    const auto distance =
        static_cast<float>(grid_.distance_deg(axis_, static_cast<double>(k) + 0.5, static_cast<double>(other_k) + 0.5));
    if (!(distance < nearest.distance_deg[cell])) return;
    nearest.distance_deg[cell] = distance;
    nearest.cell[cell] = static_cast<std::uint32_t>(other);
  }

  const MaskGrid& grid_;
  std::size_t axis_;
  std::uint64_t stride_ = 1;
};

}  // namespace

FilledSource::FilledSource(const BrdfSource& source) : source_(source), grid_(source.mask_grid().value()) {
  assert(grid_.is_valid());
  const std::vector<State> states = look_at_cells();
  DirectionMask mask = {grid_, {}};
  mask.unmeasured.reserve(states.size());
  bool before = false;
  for (const State state : states) {
    if (state != State::kBelowHorizon) before = state == State::kUnmeasured;
    mask.unmeasured.push_back(before);
  }
  mask_ = std::make_shared<const DirectionMask>(std::move(mask));
  find_stand_ins(states);
}

std::vector<FilledSource::State> FilledSource::look_at_cells() const {
  std::vector<State> states(grid_.cell_count(), State::kBelowHorizon);
  parallel_blocks(states.size(), kBlock, [&](std::size_t first, std::size_t size) {
    std::vector<DirectionPair> pairs;
    std::vector<std::size_t> cells;
    for (std::size_t cell = first; cell < first + size; ++cell) {
      const DirectionPair centre = grid_.centre_of(cell);
      if (!above_horizon(centre)) continue;
      pairs.push_back(centre);
      cells.push_back(cell);
    }
    std::vector<std::uint8_t> flags(pairs.size());
    source_.measured(pairs, flags);
    for (std::size_t k = 0; k < cells.size(); ++k) {
      states[cells[k]] = flags[k] == 1 ? State::kMeasured : State::kUnmeasured;
    }
  });
  return states;
}

void FilledSource::find_stand_ins(const std::vector<State>& states) {
  const auto is_measured = [&](std::uint64_t cell) { return states[cell] == State::kMeasured; };
  Nearest nearest = {std::vector<std::uint32_t>(states.size(), kNone),
                     std::vector<float>(states.size(), std::numeric_limits<float>::infinity())};
  for (std::size_t axis = 0; axis < grid_.counts.size(); ++axis) {
    if (grid_.counts[axis] > 1) AxisSweep(grid_, axis).run(is_measured, nearest);
  }
  // What no axis leads to takes the last measured cell before it, or the first of all.
  std::uint32_t last = kNone;
  for (std::uint32_t cell = 0; cell < states.size() && last == kNone; ++cell) {
    if (is_measured(cell)) last = cell;
  }
  stand_ins_ = std::move(nearest.cell);
  for (std::uint32_t cell = 0; cell < states.size(); ++cell) {
    if (is_measured(cell)) stand_ins_[cell] = last = cell;
    if (stand_ins_[cell] == kNone) stand_ins_[cell] = last;
  }
}

DirectionPair FilledSource::stand_in(const DirectionPair& pair) const {
  const std::uint64_t cell = grid_.cell_of(pair);
  const std::uint32_t target = stand_ins_[cell];
  if (target == kNone) return pair;  // nothing was measured at all
  const MaskGrid::Place from = grid_.place_of_centre(cell);
  const MaskGrid::Place to = grid_.place_of_centre(target);
  MaskGrid::Place place = grid_.place_of(pair);
  for (std::size_t axis = 0; axis < place.size(); ++axis) {
    if (from[axis] != to[axis]) place[axis] = to[axis];
  }
  const DirectionPair moved = grid_.pair_at(place);
  std::uint8_t flag = 0;
  source_.measured(std::span(&moved, 1), std::span(&flag, 1));
  return flag == 1 && above_horizon(moved) ? moved : grid_.pair_at(to);
}

void FilledSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  std::vector<std::uint8_t> flags(pairs.size());
  source_.measured(pairs, flags);
  std::vector<DirectionPair> stand_ins(pairs.begin(), pairs.end());
  for (std::size_t k = 0; k < flags.size(); ++k) {
    if (flags[k] == 0) stand_ins[k] = stand_in(pairs[k]);
  }
  source_.evaluate(stand_ins, values);
}

}  // namespace sbrdf::internal
