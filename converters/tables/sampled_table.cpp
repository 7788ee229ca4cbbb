#include "converters/tables/sampled_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "codec/frame/frame.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Nodes that are worked on at a time.
constexpr std::uint64_t kBatchNodes = std::uint64_t{1} << 17U;
/// Nodes of a task.
constexpr std::size_t kTask = 256;

void add_up(TableLosses& all, const TableLosses& part) {
  all.below_horizon += part.below_horizon;
  all.unmeasured += part.unmeasured;
  all.non_finite += part.non_finite;
  all.some_negative += part.some_negative;
  all.all_negative += part.all_negative;
  all.clamped += part.clamped;
  all.beyond_theta_max += part.beyond_theta_max;
  all.positive = all.positive || part.positive;
}

/// What the policy makes of one node's values, and counts.
class NodeRule {
 public:
  explicit NodeRule(const TableRequest& request) : request_(request) {}

  /// False where a value is refused.
  bool apply(std::span<double> colour, TableLosses& losses) const {
    const bool finite =
        std::all_of(colour.begin(), colour.end(), [](double v) { return std::abs(v) <= kTableLargest; });
    if (!finite) {
      ++losses.non_finite;
      std::fill(colour.begin(), colour.end(), kNaN);
      return request_.policy.non_finite == NonFinite::kUnmeasured;
    }
    const auto negative = std::count_if(colour.begin(), colour.end(), [](double v) { return v < 0; });
    if (negative > 0) ++(negative == std::ssize(colour) ? losses.all_negative : losses.some_negative);
    if (negative > 0 && request_.policy.negatives == Negatives::kUnmeasured) {
      std::fill(colour.begin(), colour.end(), kNaN);
      return true;
    }
    hold(colour, losses);
    losses.positive = losses.positive || std::any_of(colour.begin(), colour.end(), [](double v) { return v > 0; });
    return true;
  }

 private:
  void hold(std::span<double> colour, TableLosses& losses) const {
    const double least = request_.policy.negatives == Negatives::kClamp ? 0 : -request_.largest;
    bool clamped = false;
    for (double& value : colour) {
      clamped = clamped || std::abs(value) > request_.largest;
      value = std::clamp(value, least, request_.largest);
    }
    if (clamped) ++losses.clamped;
  }

  const TableRequest& request_;
};

class Sampler {
 public:
  Sampler(const BrdfSource& source, const TableRequest& request)
      : source_(source),
        request_(request),
        rule_(request_),
        channels_(source.channel_count()),
        theta_max_(radians_from_degrees(source.traits().theta_max_deg) + 1e-12),
        has_holes_(source.mask_grid().has_value()) {
    losses_.nodes = request_.grid.node_count();
    losses_.copied = is_table_of(source, request_.grid);
  }

  Result<TableLosses> run(std::array<std::uint32_t, 4> extent, const TakeBlock& take, const Progress& progress) {
    ProgressCounter counter(progress, losses_.nodes);
    std::vector<TableBlock> batch;
    std::uint64_t batch_nodes = 0;
    TableBlock block;
    bool more = true;
    while (more) {
      for (std::size_t axis = 0; axis < 4; ++axis) {
        block.count[axis] = std::min(extent[axis], request_.grid.axes[axis].size() - block.first[axis]);
      }
      batch.push_back(block);
      batch_nodes += block.node_count();
      more = advance(block, extent);
      if (more && batch_nodes < kBatchNodes) continue;
      if (Status done = work(batch, take, counter); !done) return done.error();
      batch.clear();
      batch_nodes = 0;
    }
    if (!losses_.positive) return invalid_file("no value of the source is positive: nothing reads such a table");
    return losses_;
  }

 private:
  // To the next block in C order; false behind the last.
  bool advance(TableBlock& block, const std::array<std::uint32_t, 4>& extent) const {
    for (std::size_t axis = 4; axis-- > 0;) {
      block.first[axis] += extent[axis];
      if (block.first[axis] < request_.grid.axes[axis].size()) return true;
      block.first[axis] = 0;
    }
    return false;
  }

  Status work(const std::vector<TableBlock>& batch, const TakeBlock& take, ProgressCounter& counter) {
    nodes_.clear();
    for (const TableBlock& block : batch) list_nodes(block);
    values_.resize(nodes_.size() * channels_);
    std::vector<TableLosses> parts((nodes_.size() + kTask - 1) / kTask);
    std::vector<std::uint64_t> first_bad(parts.size(), kNone);
    parallel_for(parts.size(), [&](std::uint64_t k) {
      if (counter.stopped()) return;
      const std::size_t first = k * kTask;
      const std::size_t count = std::min(kTask, nodes_.size() - first);
      first_bad[k] = sample(first, count, parts[k]);
      counter.advance(count);
    });
    if (counter.stopped()) return interrupted_error();
    for (const TableLosses& part : parts) add_up(losses_, part);
    const std::uint64_t bad = *std::min_element(first_bad.begin(), first_bad.end());
    if (bad != kNone) {
      return invalid_file(fmt::format("the source gives a NaN, an infinity or a value above {:g} at {}", kTableLargest,
                                      request_.grid.node_text(nodes_[bad])));
    }
    std::size_t at = 0;
    for (const TableBlock& block : batch) {
      const std::size_t count = block.node_count() * channels_;
      if (Status taken = take(block, std::span(values_).subspan(at, count)); !taken) return taken;
      at += count;
    }
    return ok_status();
  }

  void list_nodes(const TableBlock& block) {
    const auto& [a, b, c, d] = block.count;
    for (std::uint32_t i = 0; i < a; ++i) {
      for (std::uint32_t j = 0; j < b; ++j) {
        for (std::uint32_t k = 0; k < c; ++k) {
          for (std::uint32_t l = 0; l < d; ++l) {
            nodes_.push_back({block.first[0] + i, block.first[1] + j, block.first[2] + k, block.first[3] + l});
          }
        }
      }
    }
  }

  // The first node, of all in the batch, whose value is refused.
  std::uint64_t sample(std::size_t first, std::size_t count, TableLosses& losses) {
    std::vector<DirectionPair> pairs(count);
    for (std::size_t n = 0; n < count; ++n) pairs[n] = request_.grid.pair_of(nodes_[first + n]);
    const std::span<double> values = std::span(values_).subspan(first * channels_, count * channels_);
    std::vector<std::uint8_t> measured(count, 1);
    if (losses_.copied) {
      source_.table()->values->gather(std::span(nodes_).subspan(first, count), values);
      for (std::size_t n = 0; n < count; ++n) measured[n] = std::isnan(values[n * channels_]) ? 0 : 1;
    } else {
      std::vector<float> floats(values.size());
      source_.evaluate(pairs, floats);
      std::copy(floats.begin(), floats.end(), values.begin());
      if (has_holes_) source_.measured(pairs, measured);
    }
    std::uint64_t bad = kNone;
    for (std::size_t n = 0; n < count; ++n) {
      const std::span<double> colour = values.subspan(n * channels_, channels_);
      if (!keep(pairs[n], measured[n] != 0, colour, losses) && bad == kNone) bad = first + n;
    }
    return bad;
  }

  // False where a value is refused.
  bool keep(const DirectionPair& pair, bool measured, std::span<double> colour, TableLosses& losses) const {
    const bool above = above_horizon(pair);
    if (!above) ++losses.below_horizon;
    // What a table holds below the horizon is copied, by the same rule but uncounted.
    if (!above && losses_.copied) {
      TableLosses uncounted;
      rule_.apply(colour, uncounted);
      return true;
    }
    if (!above || !measured) {
      if (above) ++losses.unmeasured;
      std::fill(colour.begin(), colour.end(), kNaN);
      return true;
    }
    if (std::max(pair.i.theta, pair.v.theta) > theta_max_) ++losses.beyond_theta_max;
    return rule_.apply(colour, losses);
  }

  const BrdfSource& source_;
  const TableRequest& request_;
  NodeRule rule_;
  std::size_t channels_;
  double theta_max_;
  bool has_holes_;
  TableLosses losses_;
  std::vector<GridNode> nodes_;
  std::vector<double> values_;
};

}  // namespace

bool is_table_of(const BrdfSource& source, const Grid& grid) {
  return source.table() != nullptr && source.table()->grid == grid;
}

std::array<std::uint32_t, 4> rows_of(const Grid& grid) {
  const std::array<std::uint32_t, 4> size = {grid.axes[0].size(), grid.axes[1].size(), grid.axes[2].size(),
                                             grid.axes[3].size()};
  const bool two = std::uint64_t{size[2]} * size[3] <= kBatchNodes;
  return {1, 1, two ? size[2] : 1, size[3]};
}

Result<TableLosses> sample_table(const BrdfSource& source, const TableRequest& request,
                                 std::array<std::uint32_t, 4> block, const TakeBlock& take, const Progress& progress) {
  return Sampler(source, request).run(block, take, progress);
}

}  // namespace sbrdf::internal
