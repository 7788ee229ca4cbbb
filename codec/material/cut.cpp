#include "codec/material/cut.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "codec/frame/lattice_walk.h"

namespace sbrdf::internal {
namespace {

/// What is cut, and its lattice before and after. Azimuthal nodes are the same in both and polar ones the first few, so
/// points and lines have the same indices in both.
struct Cutting {
  const SlicedBrdf& whole;
  const Lattice& lattice;
  const Lattice& smaller;
  int max_depth;
};

// Row `row` of a table with one value per channel.
void append_row(const std::vector<float>& from, std::size_t row, std::size_t channels, std::vector<float>& to) {
  const auto first = from.begin() + static_cast<std::ptrdiff_t>(row * channels);
  to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(channels));
}

void cut_crossings(const Cutting& cut, SlicedBrdf& out) {
  for (const LatticePoint& p : first_points(cut.smaller)) {
    const std::uint32_t crossing = cut.lattice.corners[index_at(p, cut.lattice.corner_strides)];
    append_row(cut.whole.crossing_values, crossing, cut.whole.channel_count(), out.crossing_values);
  }
}

// A slice that ends earlier has its first intervals left; the last ones are gone.
void cut_slices(const Cutting& cut, SlicedBrdf& out) {
  std::vector<std::size_t> first_sample = {0};
  for (const std::uint32_t count : cut.whole.sample_counts) first_sample.push_back(first_sample.back() + count);
  const std::vector<LatticeLine> lines = first_lines(cut.smaller);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const auto& [axis, p] = lines[k];
    const std::uint32_t target = cut.lattice.lines[axis][index_at(p, cut.lattice.line_strides[axis])].target;
    const std::uint32_t intervals = cut.smaller.slices[k].interval_count();
    const std::size_t before = out.positions.size();
    for (std::size_t s = first_sample[target]; s < first_sample[target + 1]; ++s) {
      const SamplePosition& place = cut.whole.positions[s];
      if (place.interval >= intervals || depth_of(place.fraction) > cut.max_depth) continue;
      out.positions.push_back(place);
      append_row(cut.whole.sample_values, s, cut.whole.channel_count(), out.sample_values);
    }
    out.sample_counts.push_back(static_cast<std::uint32_t>(out.positions.size() - before));
  }
}

// A guide ends where theta_h does. All of its depths are kept: without it, no value comes out right.
void cut_guide(const Cutting& cut, SlicedBrdf& out) {
  if (!cut.whole.guide) return;
  const Guide& whole = *cut.whole.guide;
  Guide& guide = out.guide.emplace();
  guide.ratio = whole.ratio;
  const std::size_t nodes = cut.smaller.nodes[kVertical].size();
  for (std::size_t s = 0; s < whole.places.size(); ++s) {
    const SamplePosition& place = whole.places[s];
    if (place.interval + (place.fraction == 0 ? 0 : 1) >= nodes) continue;
    guide.places.push_back(place);
    append_row(whole.values, s, cut.whole.channel_count(), guide.values);
  }
}

}  // namespace

FrameSpec cut_frame(const FrameSpec& frame, double theta_max_deg) {
  FrameSpec cut = frame;
  for (const std::size_t axis : {kHorizontal, kVertical}) {
    std::vector<double>& nodes = cut.axes[axis].nodes_deg;
    const auto last = std::lower_bound(nodes.begin(), nodes.end(), theta_max_deg);
    if (last != nodes.end()) nodes.erase(last + 1, nodes.end());
  }
  if (frame.id == FrameId::kElevation) {
    cut.theta_max_deg = cut.axes[kVertical].nodes_deg.back();
  } else {
    // Beyond what was asked for, cells may be missing.
    cut.theta_max_deg = std::min(frame.theta_max_deg, std::max(1.0, std::floor(theta_max_deg * 100)) / 100);
  }
  return cut;
}

Result<SlicedBrdf> cut_sliced(const SlicedBrdf& sliced, const Lattice& lattice, const CutOptions& options) {
  if (!(options.theta_max_deg > 0)) return usage_error("theta_max must be above 0 degrees");
  SlicedBrdf cut;
  cut.frame = cut_frame(sliced.frame, options.theta_max_deg);
  cut.domain = sliced.domain;
  cut.channels = sliced.channels;
  cut.grey_shares = sliced.grey_shares;
  cut.metadata = sliced.metadata;
  cut.mask = sliced.mask;
  const Result<Lattice> smaller = build_lattice(cut.frame);
  if (!smaller) return smaller.error();
  const Cutting cutting = {sliced, lattice, *smaller, options.max_depth};
  cut_crossings(cutting, cut);
  cut_slices(cutting, cut);
  cut_guide(cutting, cut);
  if (Status status = check_sliced(cut, *smaller); !status) return status.error();
  return cut;
}

}  // namespace sbrdf::internal
