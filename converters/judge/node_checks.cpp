#include "converters/judge/node_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "codec/frame/frame.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kBlock = std::uint64_t{1} << 14U;
constexpr std::uint64_t kMedianNodes = 20000;
constexpr double kFloorShare = 0.01;
/// What is less than this part of the largest channel beside it is noise of a sensor that sees all of them.
constexpr double kChannelShare = 0.1;
/// By how much a candidate is beyond both neighbours of an axis.
constexpr double kBeyond = 0.25;
constexpr std::size_t kLeastAxes = 2;
const double kLeastExcess = std::log(2.0);
constexpr double kLocalSteps = 3;
/// Of the values around, how often their median distance from their median: where noise is as large as what it lies on,
/// values near 0 are nothing unusual.
constexpr double kLocalDeviations = 8;
/// Of a plane: with more candidates than this share, the data are noise there.
constexpr double kNoisyShare = 0.1;
constexpr std::size_t kNoisyNodes = 40;  ///< and at least so many
/// Around a candidate, so many steps to each side along the last two axes, no more than so many others may be.
constexpr int kCrowdSteps = 4;
constexpr std::size_t kCrowd = 3;

using Step = std::array<int, 4>;

/// One of each pair of opposite steps to a node around.
std::array<Step, 40> make_directions() {
  std::array<Step, 40> directions{};
  for (int k = 41; k < 81; ++k) {  // 40 would be no step at all
    directions[static_cast<std::size_t>(k - 41)] = {k / 27 - 1, k / 9 % 3 - 1, k / 3 % 3 - 1, k % 3 - 1};
  }
  return directions;
}
const std::array<Step, 40> kDirections = make_directions();

bool closes(Ends ends) { return ends == Ends::kFullTurn || ends == Ends::kHalfTurn; }

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<GridNode> moved(const Grid& grid, const GridNode& node, const Step& step, int times) {
  GridNode result = node;
  for (std::size_t axis = 0; axis < result.size(); ++axis) {
    if (step[axis] == 0) continue;
    const GridAxis& along = grid.axes[axis];
    const auto size = static_cast<std::int64_t>(along.size());
    std::int64_t at = static_cast<std::int64_t>(node[axis]) + std::int64_t{step[axis]} * times;
    if (closes(along.ends()) && size >= 4) at = (at % size + size) % size;
    if (at < 0 || at >= size) return std::nullopt;
    result[axis] = static_cast<std::uint32_t>(at);
  }
  return result;
}

/// Half the distance to the nodes on both sides, in radians; 1 for an axis of one node.
double width_of(const GridAxis& axis, std::uint32_t index, double range_of_turn_deg) {
  const std::uint32_t last = axis.size() - 1;
  if (last == 0) return 1;
  const double range_deg = axis.ends() == Ends::kMirrored ? 180 : range_of_turn_deg;
  const auto& nodes = axis.nodes_deg();
  double below = index > 0 ? nodes[index - 1] : nodes[0];
  double above = index < last ? nodes[index + 1] : nodes[last];
  if (closes(axis.ends())) {
    const double turn = axis.ends() == Ends::kFullTurn ? 360 : 180;
    if (index == 0) below = nodes[last] - turn;
    if (index == last) above = nodes[0] + turn;
  } else {
    // A cell reaches to the ends of the range.
    if (index == 0) return radians_from_degrees(0.5 * (nodes[0] + nodes[1]));
    if (index == last) return radians_from_degrees(range_deg - 0.5 * (nodes[last] + nodes[last - 1]));
  }
  return radians_from_degrees(0.5 * (above - below));
}

/// What a node is of the solid angles of both directions.
class SolidAngles {
 public:
  explicit SolidAngles(const Grid& grid) : grid_(grid) {
    for (std::size_t axis = 0; axis < widths_.size(); ++axis) {
      for (std::uint32_t k = 0; k < grid.axes[axis].size(); ++k) {
        widths_[axis].push_back(width_of(grid.axes[axis], k, Grid::range_deg(grid.frame, axis)));
      }
    }
  }

  [[nodiscard]] double operator()(const GridNode& node) const {
    double cell = density(node);
    for (std::size_t axis = 0; axis < node.size(); ++axis) cell *= widths_[axis][node[axis]];
    return cell;
  }

 private:
  [[nodiscard]] double density(const GridNode& node) const {
    const auto angle = [&](std::size_t axis) { return radians_from_degrees(grid_.axes[axis].node_deg(node[axis])); };
    switch (grid_.frame) {
      case GridFrame::kAngles:
        return std::sin(angle(0)) * std::sin(angle(2));
      case GridFrame::kDifference:
        return std::sin(angle(1)) * std::sin(angle(2));
      case GridFrame::kHalfDifference:  // d i d v = 4 cos theta_d d h d d
        return 4 * std::cos(angle(2)) * std::sin(angle(1)) * std::sin(angle(2));
      case GridFrame::kMirror:
        break;
    }
    return std::sin(angle(1)) * std::sin(angle(3));
  }

  const Grid& grid_;
  std::array<std::vector<double>, 4> widths_;
};

ShareSums shares_of_block(const DenseTable& table, const SolidAngles& solid, std::uint64_t first, std::uint64_t end) {
  std::vector<GridNode> nodes(end - first);
  for (std::uint64_t k = first; k < end; ++k) nodes[k - first] = table.grid.node(k);
  std::vector<double> values(nodes.size() * table.channel_count);
  table.values->gather(nodes, values);
  ShareSums sums;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const DirectionPair pair = table.grid.pair_of(nodes[n]);
    if (!above_horizon(pair)) continue;
    const auto colour = std::span<const double>(values).subspan(n * table.channel_count, table.channel_count);
    sums.add(pair, colour, !std::isnan(colour[0]), 1, solid(nodes[n]));
  }
  return sums;
}

/// Values of one plane of the last two axes and of those beside it, a row after the other.
class PlaneSearch {
 public:
  PlaneSearch(const DenseTable& table, std::span<const double> floors)
      : table_(table), floors_(floors), channels_(table.channel_count) {}

  void run(std::uint32_t first_axis, std::uint32_t second_axis, SpikeSearch& found) {
    const std::uint32_t rows = table_.grid.axes[2].size();
    for (std::uint32_t row = 0; row < rows; ++row) look_at_row({first_axis, second_axis, row, 0}, found);
    const std::uint64_t size = std::uint64_t{rows} * table_.grid.axes[3].size();
    if (candidates_.size() > kNoisyNodes &&
        static_cast<double>(candidates_.size()) > kNoisyShare * static_cast<double>(size)) {
      found.too_noisy += size;
      return;
    }
    for (const GridNode& node : candidates_) {
      if (is_in_a_crowd(node)) {
        ++found.too_noisy;
      } else {
        judge(node, found);
      }
    }
  }

 private:
  struct Row {
    bool there = false;
    std::vector<double> values;
  };

  void read_row(const std::optional<GridNode>& start, Row& row) {
    row.there = start.has_value();
    if (!start) return;
    const std::uint32_t size = table_.grid.axes[3].size();
    nodes_.resize(size);
    for (std::uint32_t k = 0; k < size; ++k) nodes_[k] = {(*start)[0], (*start)[1], (*start)[2], k};
    row.values.resize(size * channels_);
    table_.values->gather(nodes_, row.values);
  }

  void look_at_row(const GridNode& start, SpikeSearch& found) {
    const Grid& grid = table_.grid;
    read_row(start, middle_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Step step = {0, 0, 0, 0};
      step[axis] = 1;
      const bool alone = grid.axes[axis].size() == 1;
      read_row(alone ? std::nullopt : moved(grid, start, step, -1), beside_[axis][0]);
      read_row(alone ? std::nullopt : moved(grid, start, step, 1), beside_[axis][1]);
    }
    const std::uint32_t size = grid.axes[3].size();
    for (std::uint32_t k = 0; k < size; ++k) {
      if (std::isnan(middle_.values[k * channels_])) continue;
      ++found.nodes;
      for (std::size_t c = 0; c < channels_; ++c) {
        if (!stands_out(start, k, c)) continue;
        candidates_.push_back({start[0], start[1], start[2], k});
        break;
      }
    }
  }

  // A quick look along the axes alone.
  [[nodiscard]] bool stands_out(const GridNode& start, std::uint32_t k, std::size_t channel) const {
    const double f = middle_.values[k * channels_ + channel];
    std::size_t above = 0;
    std::size_t below = 0;
    const auto weigh = [&](double a, double b) {
      if (std::isnan(a) || std::isnan(b)) return;
      const double high = std::max(a, b);
      const double low = std::min(a, b);
      if (f - high > kBeyond * std::max(std::abs(high), floors_[channel])) ++above;
      if (low - f > kBeyond * std::max(std::abs(f), floors_[channel])) ++below;
    };
    for (const auto& [before, after] : beside_) {
      if (before.there && after.there)
        weigh(before.values[k * channels_ + channel], after.values[k * channels_ + channel]);
    }
    const GridNode node = {start[0], start[1], start[2], k};
    const auto before = moved(table_.grid, node, {0, 0, 0, 1}, -1);
    const auto after = moved(table_.grid, node, {0, 0, 0, 1}, 1);
    if (before && after) {
      weigh(middle_.values[(*before)[3] * channels_ + channel], middle_.values[(*after)[3] * channels_ + channel]);
    }
    return std::max(above, below) >= kLeastAxes;
  }

  // Candidates lie in the order of rows and columns.
  [[nodiscard]] bool is_in_a_crowd(const GridNode& node) const {
    std::size_t others = 0;
    for (int row = -kCrowdSteps; row <= kCrowdSteps; ++row) {
      for (int column = -kCrowdSteps; column <= kCrowdSteps; ++column) {
        if (row == 0 && column == 0) continue;
        const auto other = moved(table_.grid, node, {0, 0, row, column}, 1);
        if (other && std::binary_search(candidates_.begin(), candidates_.end(), *other)) ++others;
      }
    }
    return others > kCrowd;
  }

  // NaN where there is no such node, or it lies below the horizon.
  void read_around(const GridNode& node) {
    nodes_.clear();
    around_.assign(4 * kDirections.size(), std::numeric_limits<std::size_t>::max());
    for (std::size_t d = 0; d < kDirections.size(); ++d) {
      bool alone = false;
      for (std::size_t axis = 0; axis < node.size(); ++axis) {
        alone = alone || (kDirections[d][axis] != 0 && table_.grid.axes[axis].size() == 1);
      }
      if (alone) continue;
      constexpr std::array kTimes = {-1, 1, -2, 2};
      for (std::size_t t = 0; t < kTimes.size(); ++t) {
        const auto other = moved(table_.grid, node, kDirections[d], kTimes[t]);
        if (!other || !above_horizon(table_.grid.pair_of(*other))) continue;
        around_[4 * d + t] = nodes_.size();
        nodes_.push_back(*other);
      }
    }
    values_.resize(nodes_.size() * channels_);
    table_.values->gather(nodes_, values_);
  }

  void judge(const GridNode& node, SpikeSearch& found) {
    const DirectionPair pair = table_.grid.pair_of(node);
    if (!above_horizon(pair)) return;
    std::vector<double> own(channels_);
    table_.values->gather(std::span(&node, 1), own);
    read_around(node);
    double brightest = 0;
    for (const double value : own) brightest = std::max(brightest, std::abs(value));
    std::optional<Spike> worst;
    for (std::size_t c = 0; c < channels_; ++c) {
      const double floor = std::max(floors_[c], kChannelShare * brightest);
      const std::optional<Spike> spike = spike_in(own[c], c, floor);
      if (spike && (!worst || spike->excess > worst->excess)) worst = spike;
    }
    if (!worst) return;
    ++found.count;
    worst->node = node;
    worst->pair = pair;
    worst->place = table_.grid.node_text(node);
    found.worst.push_back(*std::move(worst));
  }

  [[nodiscard]] std::optional<Spike> spike_in(double value, std::size_t channel, double floor) {
    const auto log_of = [&](double f) { return std::asinh(f / (2 * floor)); };
    const double own = log_of(value);
    double up = std::numeric_limits<double>::infinity();
    double down = up;
    Spike spike;
    spike.channel = channel;
    spike.value = value;
    spike.least = std::numeric_limits<double>::infinity();
    spike.largest = -spike.least;
    steps_.clear();
    near_.clear();
    for (std::size_t d = 0; d < kDirections.size(); ++d) {
      std::array<double, 4> at{};
      for (std::size_t t = 0; t < at.size(); ++t) {
        const std::size_t place = around_[4 * d + t];
        const double f = place == std::numeric_limits<std::size_t>::max() ? std::numeric_limits<double>::quiet_NaN()
                                                                          : values_[place * channels_ + channel];
        at[t] = log_of(f);
        if (t >= 2 || std::isnan(f)) continue;
        near_.push_back(f);
        spike.least = std::min(spike.least, f);
        spike.largest = std::max(spike.largest, f);
      }
      if (!std::isnan(at[0]) && !std::isnan(at[1])) {
        const double middle = 0.5 * (at[0] + at[1]);
        up = std::min(up, own - middle);
        down = std::min(down, middle - own);
        steps_.push_back(std::abs(at[0] - at[1]));
        continue;
      }
      const double near = std::isnan(at[0]) ? at[1] : at[0];
      const double far = std::isnan(at[0]) ? at[3] : at[2];
      if (std::isnan(near)) continue;
      const double line = std::isnan(far) ? near : 2 * near - far;
      up = std::min(up, own - std::max(near, line));
      down = std::min(down, std::min(near, line) - own);
    }
    if (steps_.empty()) return std::nullopt;
    spike.excess = std::max(up, down);
    if (!(spike.excess > std::max(kLeastExcess, kLocalSteps * median(steps_)))) return std::nullopt;
    const double around = median(near_);
    for (double& f : near_) f = std::abs(f - around);
    if (!(std::abs(value - around) > kLocalDeviations * median(near_))) return std::nullopt;
    return spike;
  }

  const DenseTable& table_;
  std::span<const double> floors_;
  std::size_t channels_;
  Row middle_;
  std::array<std::array<Row, 2>, 3> beside_;
  std::vector<GridNode> candidates_;
  std::vector<GridNode> nodes_;
  std::vector<std::size_t> around_;  ///< of each direction -1, 1, -2, 2 steps: which of nodes_
  std::vector<double> values_;
  std::vector<double> steps_;
  std::vector<double> near_;
};

std::vector<double> floors_of(const DenseTable& table) {
  const std::uint64_t total = table.grid.node_count();
  const std::uint64_t count = std::min(total, kMedianNodes);
  std::vector<GridNode> nodes;
  for (std::uint64_t k = 0; k < count; ++k) {
    // In steps of no simple ratio, so that all values of each axis come up.
    const auto index = static_cast<std::uint64_t>(std::fmod(static_cast<double>(k) * 0.6180339887498949, 1.0) *
                                                  static_cast<double>(total));
    const GridNode node = table.grid.node(std::min(index, total - 1));
    if (above_horizon(table.grid.pair_of(node))) nodes.push_back(node);
  }
  std::vector<double> values(nodes.size() * table.channel_count);
  table.values->gather(nodes, values);
  std::vector<double> floors;
  for (std::size_t c = 0; c < table.channel_count; ++c) {
    std::vector<double> sizes;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const double size = std::abs(values[n * table.channel_count + c]);
      if (size > 0 && std::isfinite(size)) sizes.push_back(size);
    }
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    if (!sizes.empty()) std::nth_element(sizes.begin(), middle, sizes.end());
    floors.push_back(kFloorShare * (sizes.empty() ? 1 : *middle));
  }
  return floors;
}

}  // namespace

Shares shares_of_nodes(const DenseTable& table) {
  const std::uint64_t total = table.grid.node_count();
  const SolidAngles solid(table.grid);
  std::vector<ShareSums> blocks((total + kBlock - 1) / kBlock);
  parallel_for(blocks.size(), [&](std::uint64_t k) {
    blocks[k] = shares_of_block(table, solid, k * kBlock, std::min(total, (k + 1) * kBlock));
  });
  ShareSums all;
  for (const ShareSums& block : blocks) all.add(block);
  return all.shares();
}

Result<SpikeSearch> find_spikes(const DenseTable& table, const Progress& progress) {
  const std::uint64_t second = table.grid.axes[1].size();
  const std::uint64_t planes = table.grid.axes[0].size() * second;
  const std::vector<double> floors = floors_of(table);
  std::vector<SpikeSearch> found(planes);
  ProgressCounter counter(progress, planes);
  parallel_for(planes, [&](std::uint64_t k) {
    if (counter.stopped()) return;
    PlaneSearch(table, floors)
        .run(static_cast<std::uint32_t>(k / second), static_cast<std::uint32_t>(k % second), found[k]);
    counter.advance();
  });
  if (counter.stopped()) return interrupted_error();
  SpikeSearch all;
  for (SpikeSearch& plane : found) {
    all.nodes += plane.nodes;
    all.count += plane.count;
    all.too_noisy += plane.too_noisy;
    std::move(plane.worst.begin(), plane.worst.end(), std::back_inserter(all.worst));
  }
  std::stable_sort(all.worst.begin(), all.worst.end(),
                   [](const Spike& a, const Spike& b) { return a.excess > b.excess; });
  if (all.worst.size() > kMostSpikes) all.worst.resize(kMostSpikes);
  return all;
}

}  // namespace sbrdf::internal
