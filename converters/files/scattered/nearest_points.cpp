#include "converters/files/scattered/nearest_points.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kLeaf = 8;

double square_distance(const SamplePlace& a, const SamplePlace& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

}  // namespace

struct NearestPoints::Search {
  const SamplePlace& place;
  std::size_t most;
  std::vector<Neighbour>& found;  // a heap, the farthest on top
  std::span<const std::uint32_t> groups;
  std::uint32_t group;

  [[nodiscard]] bool wants(double square) const { return found.size() < most || square <= found.front().square; }

  void offer(const Neighbour& candidate) {
    if (!groups.empty() && groups[candidate.point] == group) return;
    if (found.size() == most) {
      if (!(candidate < found.front())) return;
      std::pop_heap(found.begin(), found.end());
      found.pop_back();
    }
    found.push_back(candidate);
    std::push_heap(found.begin(), found.end());
  }
};

NearestPoints::NearestPoints(std::vector<SamplePlace> points) : points_(std::move(points)), order_(points_.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  if (!points_.empty()) build(0, static_cast<std::uint32_t>(points_.size()));
}

std::uint32_t NearestPoints::build(std::uint32_t first, std::uint32_t count) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({first, count, 0, 0, 0, 0});
  if (count <= kLeaf) return index;
  SamplePlace low = points_[order_[first]];
  SamplePlace high = low;
  for (std::uint32_t k = first; k < first + count; ++k) {
    for (std::size_t axis = 0; axis < low.size(); ++axis) {
      low[axis] = std::min(low[axis], points_[order_[k]][axis]);
      high[axis] = std::max(high[axis], points_[order_[k]][axis]);
    }
  }
  std::size_t widest = 0;
  for (std::size_t axis = 1; axis < low.size(); ++axis) {
    if (high[axis] - low[axis] > high[widest] - low[widest]) widest = axis;
  }
  const std::uint32_t half = count / 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    return points_[a][widest] != points_[b][widest] ? points_[a][widest] < points_[b][widest] : a < b;
  });
  const double split = points_[order_[first + half]][widest];
  const std::uint32_t below = build(first, half);
  const std::uint32_t above = build(first + half, count - half);
  nodes_[index].low = below;
  nodes_[index].high = above;
  nodes_[index].axis = static_cast<std::uint8_t>(widest);
  nodes_[index].split = split;
  return index;
}

void NearestPoints::visit(std::uint32_t node_index, Search& search) const {
  const Node& node = nodes_[node_index];
  if (node.low == 0) {
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
      search.offer({square_distance(points_[order_[k]], search.place), order_[k]});
    }
    return;
  }
  const double beyond = search.place[node.axis] - node.split;
  visit(beyond < 0 ? node.low : node.high, search);
  if (search.wants(beyond * beyond)) visit(beyond < 0 ? node.high : node.low, search);
}

void NearestPoints::find(const SamplePlace& place, std::size_t most, std::vector<Neighbour>& found,
                         std::span<const std::uint32_t> groups, std::uint32_t group) const {
  found.clear();
  if (points_.empty() || most == 0) return;
  Search search{place, most, found, groups, group};
  visit(0, search);
  std::sort_heap(found.begin(), found.end());
}

}  // namespace sbrdf::internal
