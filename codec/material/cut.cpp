#include "codec/material/cut.h"

#include <algorithm>
#include <map>
#include <utility>

#include "codec/frame/lattice_walk.h"

namespace sbrdf {
namespace {

using Point = std::array<std::uint32_t, kAxisCount>;

/// Where each slice of a lattice is met first: axis and index of the line.
std::vector<std::pair<std::size_t, Point>> first_lines(const Lattice& lattice) {
  std::vector<std::pair<std::size_t, Point>> first(lattice.slices.size(), {kAxisCount, {}});
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    Point p{};
    for (const LineReference& reference : lattice.lines[axis]) {
      if (!reference.is_constant() && first[reference.target].first == kAxisCount) first[reference.target] = {axis, p};
      for (std::size_t a = 0; a < kAxisCount; ++a) {
        if (a == axis) continue;
        if (++p[a] < lattice.nodes[a].size()) break;
        p[a] = 0;
      }
    }
  }
  return first;
}

std::uint32_t at(const Point& point, const Strides& strides) {
  std::uint32_t k = 0;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) k += point[axis] * strides[axis];
  return k;
}

}  // namespace

FrameSpec cut_frame(const FrameSpec& frame, double theta_max_deg) {
  FrameSpec cut = frame;
  for (const std::size_t axis : {kHorizontal, kVertical}) {
    std::vector<double>& nodes = cut.axes[axis].nodes_deg;
    const auto last = std::lower_bound(nodes.begin(), nodes.end(), theta_max_deg);
    if (last != nodes.end()) nodes.erase(last + 1, nodes.end());
  }
  return cut;
}

Result<SlicedBrdf> cut_sliced(const SlicedBrdf& sliced, const Lattice& lattice, const CutOptions& options) {
  if (!(options.theta_max_deg > 0)) return usage_error("theta_max must be above 0 degrees");
  SlicedBrdf cut;
  cut.frame = cut_frame(sliced.frame, options.theta_max_deg);
  cut.domain = sliced.domain;
  cut.channels = sliced.channels;
  cut.metadata = sliced.metadata;
  const Result<Lattice> smaller = build_lattice(cut.frame);
  if (!smaller) return smaller.error();
  const std::size_t channels = sliced.channel_count();

  // Azimuthal nodes are the same and polar ones the first few, so points and lines have the same indices in both.
  for (const Point& p : first_points(*smaller)) {
    const auto from = sliced.crossing_values.begin() +
                      static_cast<std::ptrdiff_t>(lattice.corners[at(p, lattice.corner_strides)] * channels);
    cut.crossing_values.insert(cut.crossing_values.end(), from, from + static_cast<std::ptrdiff_t>(channels));
  }
  std::vector<std::size_t> first_sample = {0};
  for (const std::uint32_t count : sliced.sample_counts) first_sample.push_back(first_sample.back() + count);
  const auto lines = first_lines(*smaller);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const auto& [axis, p] = lines[k];
    const std::uint32_t target = lattice.lines[axis][at(p, lattice.line_strides[axis])].target;
    const std::uint32_t intervals = smaller->slices[k].interval_count();
    std::uint32_t count = 0;
    for (std::size_t s = first_sample[target]; s < first_sample[target + 1]; ++s) {
      const SamplePosition& place = sliced.positions[s];
      if (place.interval >= intervals || depth_of(place.fraction) > options.max_depth) continue;
      ++count;
      cut.positions.push_back(place);
      const auto from = sliced.sample_values.begin() + static_cast<std::ptrdiff_t>(s * channels);
      cut.sample_values.insert(cut.sample_values.end(), from, from + static_cast<std::ptrdiff_t>(channels));
    }
    cut.sample_counts.push_back(count);
  }
  if (sliced.guide) {
    cut.guide.emplace();
    cut.guide->ratio = sliced.guide->ratio;
    const std::size_t nodes = smaller->nodes[kVertical].size();
    for (std::size_t s = 0; s < sliced.guide->places.size(); ++s) {
      const SamplePosition& place = sliced.guide->places[s];
      if (place.interval + (place.fraction == 0 ? 0 : 1) >= nodes) continue;
      cut.guide->places.push_back(place);
      const auto from = sliced.guide->values.begin() + static_cast<std::ptrdiff_t>(s * channels);
      cut.guide->values.insert(cut.guide->values.end(), from, from + static_cast<std::ptrdiff_t>(channels));
    }
  }
  if (Status status = check_sliced(cut, *smaller); !status) return status.error();
  return cut;
}

}  // namespace sbrdf
