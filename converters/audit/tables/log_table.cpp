#include "converters/audit/tables/log_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "converters/tables/dense_source.h"
#include "converters/tables/sampled_table.h"

namespace sbrdf::internal {
namespace {

constexpr double kUnitShare = 1e-2;  // of the floor of relative errors, which is a hundredth of the mean

/// Nodes along phi_d that its mirror image does not repeat; the ring begins at 0.
std::uint32_t kept_of_ring(std::uint32_t count) { return count / 2 + 1; }

/// The node of a kept place.
std::size_t index_in(const std::array<std::uint32_t, 4>& counts, const GridNode& node) {
  return ((std::size_t{node[0]} * counts[1] + node[1]) * counts[2] + node[2]) * counts[3] + node[3];
}

template <class Visit>
void for_each_node(const std::array<std::uint32_t, 4>& counts, const Visit& visit) {
  GridNode node{};
  for (node[0] = 0; node[0] < counts[0]; ++node[0]) {
    for (node[1] = 0; node[1] < counts[1]; ++node[1]) {
      for (node[2] = 0; node[2] < counts[2]; ++node[2]) {
        for (node[3] = 0; node[3] < counts[3]; ++node[3]) visit(node);
      }
    }
  }
}

/// NaN where nothing is: of what lies at the next smaller theta_d, or theta_h.
void fill_holes(std::vector<float>& plane, const std::array<std::uint32_t, 4>& counts) {
  for_each_node(counts, [&](GridNode node) {
    float& value = plane[index_in(counts, node)];
    if (!std::isnan(value)) return;
    if (node[2] > 0) {
      --node[2];
    } else if (node[1] > 0) {
      --node[1];
    } else {
      value = 0;
      return;
    }
    value = plane[index_in(counts, node)];
  });
}

}  // namespace

double LogScale::log_of(double f) const { return std::asinh(f / (2 * unit)); }

double LogScale::value_of(double log) const {
  constexpr double kMost = 80;  // its value is beyond what a float holds only with units that no material has
  return 2 * unit * std::sinh(std::clamp(log, -kMost, kMost));
}

LogTable without_numbers(const LogTable& table) {
  return {table.grid, table.counts, table.scale, table.holes, Planes(table.planes.size())};
}

Result<LogTable> make_log_table(const AuditSubject& subject, const Grid& grid, const Progress& progress) {
  const std::size_t channels = subject.channel_count();
  std::vector<float> all(grid.node_count() * channels, std::numeric_limits<float>::quiet_NaN());
  const auto take = [&](const TableBlock& block, std::span<const double> values) {
    std::size_t from = 0;
    for_each_node(block.count, [&](GridNode node) {
      for (std::size_t axis = 0; axis < node.size(); ++axis) node[axis] += block.first[axis];
      const std::size_t to = grid.index(node) * channels;
      for (std::size_t c = 0; c < channels; ++c) all[to + c] = static_cast<float>(values[from++]);
    });
    return ok_status();
  };
  const Result<TableLosses> sampled = sample_table(subject.source(), {grid}, rows_of(grid), take, progress);
  if (!sampled) return sampled.error();

  LogTable table;
  table.grid = grid;
  for (std::size_t axis = 0; axis < table.counts.size(); ++axis) table.counts[axis] = grid.axes[axis].size();
  const Symmetries symmetries = subject.symmetries();
  if (symmetries.isotropic && symmetries.mirror_x) table.counts[3] = kept_of_ring(table.counts[3]);
  table.scale.unit = std::max(kUnitShare * mre_floor(subject.judged()), 1e-30);
  table.holes.resize(grid.node_count());
  for (std::size_t k = 0; k < table.holes.size(); ++k) table.holes[k] = std::isnan(all[k * channels]);
  table.planes.assign(channels, std::vector<float>(table.node_count()));
  for_each_node(table.counts, [&](const GridNode& node) {
    const std::size_t to = index_in(table.counts, node);
    const std::size_t from = grid.index(node) * channels;
    const auto log_of = [&](std::size_t c) {
      const float f = all[from + c];
      return std::isnan(f) ? f : static_cast<float>(table.scale.log_of(static_cast<double>(f)));
    };
    const float base = log_of(table.base());
    for (std::size_t c = 0; c < channels; ++c) table.planes[c][to] = c == table.base() ? base : log_of(c) - base;
  });
  for (std::vector<float>& plane : table.planes) fill_holes(plane, table.counts);
  return table;
}

DenseTable dense_table_of(const LogTable& like, const Planes& planes) {
  const std::size_t channels = planes.size();
  std::vector<float> values(like.grid.node_count() * channels);
  std::array<std::uint32_t, 4> counts{};
  for (std::size_t axis = 0; axis < counts.size(); ++axis) counts[axis] = like.grid.axes[axis].size();
  for_each_node(counts, [&](const GridNode& node) {
    GridNode kept = node;
    if (kept[3] >= like.counts[3]) kept[3] = counts[3] - kept[3];
    const std::size_t from = index_in(like.counts, kept);
    const std::size_t index = like.grid.index(node);
    const std::size_t to = index * channels;
    const float base = planes[like.base()][from];
    for (std::size_t c = 0; c < channels; ++c) {
      const float log = c == like.base() ? base : base + planes[c][from];
      values[to + c] = like.holes[index] ? std::numeric_limits<float>::quiet_NaN()
                                         : static_cast<float>(like.scale.value_of(static_cast<double>(log)));
    }
  });
  return table_in_memory(like.grid, channels, std::move(values));
}

double few_percent_of(const AuditSubject& subject, const DenseTable& table) {
  std::vector<float> values(subject.few().values.size());
  interpolate_table(table, subject.few().pairs, values);
  return subject.few_percent(values);
}

}  // namespace sbrdf::internal
