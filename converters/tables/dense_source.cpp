#include "converters/tables/dense_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "codec/frame/frame.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

/// Nodes that one task looks at.
constexpr std::uint64_t kBlock = std::uint64_t{1} << 14U;
/// Pairs whose nodes are asked for together.
constexpr std::size_t kPairs = 16;
constexpr std::size_t kCorners = 16;
/// Sums of weights below this are rounding, and their quotients noise.
constexpr double kFaintest = 1e-20;

bool is_hole(std::span<const double> colour) { return std::isnan(colour[0]); }

/// Values of another table after what a policy makes of them.
class PolicedValues final : public NodeValues {
 public:
  PolicedValues(std::shared_ptr<const NodeValues> values, std::size_t channels, const ValuePolicy& policy)
      : values_(std::move(values)), channels_(channels), policy_(policy) {}

  void gather(std::span<const GridNode> nodes, std::span<double> values) const override {
    values_->gather(nodes, values);
    for (std::size_t n = 0; n < nodes.size(); ++n) apply(values.subspan(n * channels_, channels_));
  }

 private:
  void apply(std::span<double> colour) const {
    const bool wild =
        std::any_of(colour.begin(), colour.end(), [](double v) { return !(std::abs(v) <= kTableLargest); });
    const bool negative = std::any_of(colour.begin(), colour.end(), [](double v) { return v < 0; });
    if (wild || (negative && policy_.negatives == Negatives::kUnmeasured)) {
      std::fill(colour.begin(), colour.end(), std::numeric_limits<double>::quiet_NaN());
    } else if (negative && policy_.negatives == Negatives::kClamp) {
      for (double& value : colour) value = std::max(value, 0.0);
    }
  }

  std::shared_ptr<const NodeValues> values_;
  std::size_t channels_;
  ValuePolicy policy_;
};

/// The nodes around a pair, each with its weight.
struct Corners {
  std::array<GridNode, kCorners> nodes;
  std::array<double, kCorners> weights;
  std::size_t count = 0;
  bool beyond = false;  ///< the last node of an axis that is extrapolated
};

Corners corners_of(const Grid& grid, const DirectionPair& pair) {
  const Grid::Place place = grid.place_of(pair);
  std::array<Bracket, 4> brackets;
  Corners corners;
  for (std::size_t axis = 0; axis < brackets.size(); ++axis) {
    brackets[axis] = grid.axes[axis].bracket(place[axis]);
    corners.beyond = corners.beyond || brackets[axis].weight > 1;
  }
  for (std::size_t k = 0; k < kCorners; ++k) {
    GridNode node{};
    double weight = 1;
    for (std::size_t axis = 0; axis < brackets.size(); ++axis) {
      const bool high = (k >> axis & 1U) != 0;
      node[axis] = high ? brackets[axis].high : brackets[axis].low;
      weight *= high ? brackets[axis].weight : 1 - brackets[axis].weight;
    }
    if (weight == 0) continue;
    corners.nodes[corners.count] = node;
    corners.weights[corners.count++] = weight;
  }
  return corners;
}

/// Interpolates one pair after the other from the values of its corners, in the order of the pairs.
class Interpolator {
 public:
  explicit Interpolator(const DenseTable& table) : table_(table), sums_(table.channel_count) {}

  void run(std::span<const DirectionPair> pairs, std::span<float> values) {
    const std::size_t channels = table_.channel_count;
    for (std::size_t first = 0; first < pairs.size(); first += kPairs) {
      const std::size_t count = std::min(kPairs, pairs.size() - first);
      gather(pairs.subspan(first, count));
      std::size_t at = 0;
      for (std::size_t k = 0; k < count; ++k) {
        const std::span<float> result = values.subspan((first + k) * channels, channels);
        if (!mix(corners_[k], std::span(numbers_).subspan(at * channels), result)) {
          at_horizon(pairs[first + k], result);
        }
        at += corners_[k].count;
      }
    }
  }

 private:
  void gather(std::span<const DirectionPair> pairs) {
    nodes_.clear();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      corners_[k] = above_horizon(pairs[k]) ? corners_of(table_.grid, pairs[k]) : Corners();
      nodes_.insert(nodes_.end(), corners_[k].nodes.begin(), corners_[k].nodes.begin() + corners_[k].count);
    }
    numbers_.resize(nodes_.size() * table_.channel_count);
    table_.values->gather(nodes_, numbers_);
  }

  // False where there is nothing but holes.
  bool mix(const Corners& corners, std::span<const double> numbers, std::span<float> result) {
    const std::size_t channels = table_.channel_count;
    std::fill(sums_.begin(), sums_.end(), 0.0);
    double weights = 0;
    bool holes = false;
    bool negative = false;
    for (std::size_t n = 0; n < corners.count; ++n) {
      const std::span<const double> colour = numbers.subspan(n * channels, channels);
      if (is_hole(colour)) {
        holes = true;
        continue;
      }
      const double weight = corners.weights[n];
      weights += weight;
      for (std::size_t c = 0; c < channels; ++c) {
        sums_[c] += weight * colour[c];
        negative = negative || colour[c] < 0;
      }
    }
    const bool found = weights > kFaintest;
    for (std::size_t c = 0; c < channels; ++c) {
      double value = found ? (holes ? sums_[c] / weights : sums_[c]) : 0;
      if (corners.beyond) value = std::clamp(value, negative ? -kTableLargest : 0.0, kTableLargest);
      result[c] = static_cast<float>(value);
    }
    return found || corners.count == 0;
  }

  void at_horizon(DirectionPair pair, std::span<float> result) {
    const GridFrame frame = table_.grid.frame;
    if (frame != GridFrame::kHalfDifference && frame != GridFrame::kMirror) return;
    const GridAxis& axis = table_.grid.axes[2];
    const double step = frame == GridFrame::kMirror ? 2 : 90.0 / axis.size();
    const double limit = radians_from_degrees(std::max(0.0, 90 - 1.5 * step));
    pair.i.theta = std::min(pair.i.theta, limit);
    pair.v.theta = std::min(pair.v.theta, limit);
    const Corners corners = corners_of(table_.grid, pair);
    std::array<GridNode, kCorners> nodes = corners.nodes;
    std::vector<double> numbers(corners.count * table_.channel_count);
    table_.values->gather(std::span(nodes).first(corners.count), numbers);
    mix(corners, numbers, result);
  }

  const DenseTable& table_;
  std::array<Corners, kPairs> corners_;
  std::vector<GridNode> nodes_;
  std::vector<double> numbers_;
  std::vector<double> sums_;
};

/// What a block of nodes, or all of them, hold.
struct Census {
  std::uint64_t holes = 0;  ///< above the horizon
  std::uint64_t wild = 0;   ///< infinite or beyond the largest
  std::uint64_t first_bad = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t negative = 0;  ///< some channel below 0
  bool positive = false;

  void add(const Census& other) {
    holes += other.holes;
    wild += other.wild;
    first_bad = std::min(first_bad, other.first_bad);
    negative += other.negative;
    positive = positive || other.positive;
  }
};

class CensusTaker {
 public:
  CensusTaker(const DenseTable& table, const ValuePolicy& policy) : table_(table), policy_(policy) {}

  [[nodiscard]] Census take() const {
    const std::uint64_t total = table_.grid.node_count();
    std::vector<Census> blocks((total + kBlock - 1) / kBlock);
    parallel_for(blocks.size(),
                 [&](std::uint64_t k) { take_block(k * kBlock, std::min(total, (k + 1) * kBlock), blocks[k]); });
    Census all;
    for (const Census& block : blocks) all.add(block);
    return all;
  }

 private:
  void take_block(std::uint64_t first, std::uint64_t end, Census& census) const {
    const std::size_t channels = table_.channel_count;
    std::vector<GridNode> nodes(end - first);
    for (std::uint64_t k = first; k < end; ++k) nodes[k - first] = table_.grid.node(k);
    std::vector<double> values(nodes.size() * channels);
    table_.values->gather(nodes, values);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      add(nodes[n], first + n, std::span(values).subspan(n * channels, channels), census);
    }
  }

  void add(const GridNode& node, std::uint64_t index, std::span<const double> colour, Census& census) const {
    bool wild = false;
    bool negative = false;
    bool positive = false;
    for (const double value : colour) {
      wild = wild || std::abs(value) > kTableLargest;
      negative = negative || value < 0;
      positive = positive || value > 0;
    }
    const bool hole = is_hole(colour);
    if ((hole || wild) && census.first_bad > index) census.first_bad = index;
    if (hole && above_horizon(table_.grid.pair_of(node))) ++census.holes;
    if (wild) ++census.wild;
    if (hole || wild) return;
    if (negative) ++census.negative;
    const bool dropped = negative && policy_.negatives == Negatives::kUnmeasured;
    census.positive = census.positive || (positive && !dropped);
  }

  const DenseTable& table_;
  const ValuePolicy& policy_;
};

/// What has been left out is likely to be why.
Error nothing_positive(const Census& census, std::uint64_t total) {
  std::string message = "no value of the table is positive";
  const auto add = [&](std::uint64_t count, const std::string& what) {
    if (count > 0) message += fmt::format("; {} of {} nodes {}", count, total, what);
  };
  add(census.wild,
      fmt::format("have one that is infinite or beyond {:g} as f_r, and count as unmeasured", kTableLargest));
  add(census.holes, "above the horizon are unmeasured");
  add(census.negative, "have a negative one");
  return invalid_file(std::move(message));
}

std::vector<std::uint32_t> shape_of(const Grid& grid) {
  std::vector<std::uint32_t> shape;
  for (const GridAxis& axis : grid.axes) shape.push_back(axis.size());
  return shape;
}

}  // namespace

DenseSource::DenseSource(DenseTable table, DenseDescription description)
    : table_(std::move(table)), file_(std::move(description.file)) {
  traits_.format = std::move(description.format);
  traits_.description = std::move(description.description);
  traits_.channels = std::move(description.channels);
  traits_.isotropic = table_.grid.is_isotropic();
  traits_.reciprocal = table_.grid.is_reciprocal();
  traits_.theta_max_deg = std::min(table_.grid.theta_max_deg(), description.reach.theta_max_deg);
  traits_.slice_theta_max_deg = std::min(traits_.theta_max_deg, description.reach.slice_theta_max_deg);
  if (traits_.theta_max_deg < table_.grid.theta_max_deg()) {
    traits_.beyond_theta_max = std::move(description.reach.beyond_theta_max);
  } else if (traits_.theta_max_deg < 90) {
    const bool extrapolated = std::any_of(table_.grid.axes.begin(), table_.grid.axes.end(),
                                          [](const GridAxis& axis) { return axis.ends() == Ends::kExtrapolated; });
    traits_.beyond_theta_max =
        extrapolated ? "the table goes on in a straight line, held above 0" : "the table holds its last value";
  }
  traits_.findings = std::move(description.findings);
  traits_.shape = shape_of(table_.grid);
}

Result<std::unique_ptr<BrdfSource>> DenseSource::make(DenseTable table, DenseDescription description) {
  assert(description.channels.size() == table.channel_count);
  std::unique_ptr<DenseSource> source(new DenseSource(std::move(table), description));
  if (Status sound = source->examine(description); !sound) return sound.error();
  return std::unique_ptr<BrdfSource>(std::move(source));
}

Status DenseSource::examine(DenseDescription& description) {
  const ValuePolicy& policy = description.policy;
  const Census census = CensusTaker(table_, policy).take();
  const bool bad = census.first_bad != std::numeric_limits<std::uint64_t>::max();
  if (bad && policy.non_finite == NonFinite::kRefuse) {
    return invalid_file(fmt::format("a value is NaN, infinite or above {:g} as f_r, the first at {}", kTableLargest,
                                    table_.grid.node_text(table_.grid.node(census.first_bad))));
  }
  if (!census.positive) return nothing_positive(census, table_.grid.node_count());
  has_holes_ =
      census.holes > 0 || census.wild > 0 || (census.negative > 0 && policy.negatives == Negatives::kUnmeasured);
  const std::uint64_t total = table_.grid.node_count();
  const auto add = [&](std::string what, std::uint64_t count) {
    if (count > 0) traits_.findings.push_back({std::move(what), count, total});
  };
  add(description.unmeasured, census.holes);
  add(fmt::format("nodes with a value that is infinite or above {:g} as f_r, taken as unmeasured", kTableLargest),
      census.wild);
  const std::string negative = "nodes with some negative channel";
  add(policy.negatives == Negatives::kKeep    ? negative
      : policy.negatives == Negatives::kClamp ? negative + ", 0 in its place"
                                              : negative + ", taken as unmeasured",
      census.negative);
  if (census.wild > 0 || (census.negative > 0 && policy.negatives != Negatives::kKeep)) {
    table_.values = std::make_shared<PolicedValues>(table_.values, table_.channel_count, policy);
    file_ = nullptr;
  }
  return ok_status();
}

void DenseSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  interpolate_table(table_, pairs, values);
}

void interpolate_table(const DenseTable& table, std::span<const DirectionPair> pairs, std::span<float> values) {
  assert(values.size() == pairs.size() * table.channel_count);
  Interpolator(table).run(pairs, values);
}

void DenseSource::measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const {
  std::vector<double> colours(kCorners * table_.channel_count);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    flags[k] = 1;
    if (!has_holes_ || !above_horizon(pairs[k])) continue;
    const Corners corners = corners_of(table_.grid, pairs[k]);
    const std::size_t count = corners.count * table_.channel_count;
    table_.values->gather(std::span(corners.nodes).first(corners.count), std::span(colours).first(count));
    double balance = 0;
    for (std::size_t n = 0; n < corners.count; ++n) {
      const double weight = std::abs(corners.weights[n]);
      if (!is_hole(std::span(colours).subspan(n * table_.channel_count))) {
        balance += weight;
      } else if (above_horizon(table_.grid.pair_of(corners.nodes[n]))) {
        balance -= weight;
      }
    }
    flags[k] = balance >= 0 ? 1 : 0;
  }
}

std::optional<MaskGrid> DenseSource::mask_grid() const {
  if (!has_holes_) return std::nullopt;
  const auto& axes = table_.grid.axes;
  MaskGrid grid;
  switch (table_.grid.frame) {
    case GridFrame::kAngles:
      grid = {MaskFrame::kAngles, {axes[0].size(), axes[1].size(), axes[2].size(), axes[3].size()}};
      break;
    case GridFrame::kDifference:
      grid = {MaskFrame::kAngles, {axes[1].size(), axes[0].size(), axes[2].size(), axes[3].size()}};
      break;
    case GridFrame::kHalfDifference:
      grid = {MaskFrame::kHalfDifference, {axes[0].size(), axes[1].size(), axes[2].size(), axes[3].size()}};
      break;
    case GridFrame::kMirror:
      grid = {MaskFrame::kAngles, {45, axes[0].size() == 1 ? 1U : 72U, 45, 72}};
      break;
  }
  for (std::uint32_t& count : grid.counts) count = std::min(count, MaskGrid::kMostAlongAxis);
  while (!grid.is_valid()) {  // more cells than a mask can have
    for (std::uint32_t& count : grid.counts) count = (count + 1) / 2;
  }
  return grid;
}

namespace {

class SourceValues final : public NodeValues {
 public:
  SourceValues(const BrdfSource& source, Grid grid, std::function<void(std::span<double>)> change)
      : source_(source),
        grid_(std::move(grid)),
        change_(std::move(change)),
        has_holes_(source.mask_grid().has_value()) {}

  void gather(std::span<const GridNode> nodes, std::span<double> values) const override {
    const std::size_t channels = source_.channel_count();
    std::vector<DirectionPair> pairs(nodes.size());
    std::transform(nodes.begin(), nodes.end(), pairs.begin(),
                   [this](const GridNode& node) { return grid_.pair_of(node); });
    std::vector<float> floats(values.size());
    source_.evaluate(pairs, floats);
    std::vector<std::uint8_t> flags(nodes.size(), 1);
    if (has_holes_) source_.measured(pairs, flags);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const std::span<double> colour = values.subspan(n * channels, channels);
      std::copy_n(floats.begin() + static_cast<std::ptrdiff_t>(n * channels), channels, colour.begin());
      if (flags[n] == 0 || !above_horizon(pairs[n])) {
        std::fill(colour.begin(), colour.end(), std::numeric_limits<double>::quiet_NaN());
      }
      if (change_) change_(colour);
    }
  }

 private:
  const BrdfSource& source_;
  Grid grid_;
  std::function<void(std::span<double>)> change_;
  bool has_holes_;
};

}  // namespace

DenseTable table_of_source(const BrdfSource& source, Grid grid, std::function<void(std::span<double>)> change) {
  auto values = std::make_shared<SourceValues>(source, grid, std::move(change));
  return {std::move(grid), source.channel_count(), std::move(values), ValueType::kFloat32};
}

}  // namespace sbrdf::internal
