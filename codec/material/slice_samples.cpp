#include "codec/material/slice_samples.h"

namespace sbrdf::internal {
namespace {

double interval_width(std::span<const SliceNode> nodes, const Slice& slice, std::uint32_t interval) {
  const double end =
      interval + 1 < nodes.size() ? nodes[interval + 1].position_deg : slice.start_deg + slice.length_deg;
  return end - nodes[interval].position_deg;
}

}  // namespace

double position_deg(const Lattice& lattice, const Slice& slice, const SamplePosition& place) {
  const auto nodes = lattice.nodes_of(slice);
  const double from = nodes[place.interval].position_deg;
  if (place.fraction == 0) return from;
  return from +
         interval_width(nodes, slice, place.interval) * (static_cast<double>(place.fraction) / SamplePosition::kOne);
}

std::size_t gap_count(const Slice& slice, const SliceSamples& samples) {
  return slice.boundary == Boundary::kPeriodic ? samples.size() : samples.size() - 1;
}

Gap gap_after(const Lattice& lattice, const Slice& slice, const SliceSamples& samples, std::size_t left) {
  const bool last = left + 1 == samples.size();
  const SamplePosition& place = samples.places[left];
  // The right end as a fraction of the same interval: a crossing there is its full length.
  const std::uint32_t right = !last && samples.places[left + 1].interval == place.interval
                                  ? samples.places[left + 1].fraction
                                  : SamplePosition::kOne;
  const double end = last ? slice.start_deg + slice.length_deg : samples.positions_deg[left + 1];
  Gap gap;
  gap.width_deg = end - samples.positions_deg[left];
  if (right - place.fraction >= 2) {
    gap.middle = {place.interval, (place.fraction + right) / 2};
    gap.middle_deg = position_deg(lattice, slice, gap.middle);
  }
  return gap;
}

// Both lists, crossings of a slice and its own samples, rise along it; they are merged interval by interval.
void gather_slice(const SlicedBrdf& sliced, const Lattice& lattice, std::size_t slice, std::size_t first,
                  SliceSamples& samples) {
  const std::size_t channels = sliced.channel_count();
  samples.positions_deg.clear();
  samples.places.clear();
  samples.values.clear();
  const auto append = [&](double position, SamplePosition place, const float* values) {
    samples.positions_deg.push_back(position);
    samples.places.push_back(place);
    samples.values.insert(samples.values.end(), values, values + channels);
  };
  const auto nodes = lattice.nodes_of(lattice.slices[slice]);
  const std::size_t end = first + sliced.sample_counts[slice];
  for (std::uint32_t node = 0; node < nodes.size(); ++node) {
    append(nodes[node].position_deg, {node, 0}, sliced.crossing_values.data() + nodes[node].crossing * channels);
    for (; first < end && sliced.positions[first].interval == node; ++first) {
      append(position_deg(lattice, lattice.slices[slice], sliced.positions[first]), sliced.positions[first],
             sliced.sample_values.data() + first * channels);
    }
  }
}

std::vector<SliceSamples> gather_slices(const SlicedBrdf& sliced, const Lattice& lattice) {
  std::vector<SliceSamples> slices(lattice.slices.size());
  std::size_t next = 0;
  for (std::size_t k = 0; k < slices.size(); ++k) {
    gather_slice(sliced, lattice, k, next, slices[k]);
    next += sliced.sample_counts[k];
  }
  return slices;
}

void scatter_slices(std::span<const SliceSamples> slices, SlicedBrdf& sliced) {
  const std::size_t channels = sliced.channel_count();
  sliced.sample_counts.assign(slices.size(), 0);
  sliced.positions.clear();
  sliced.sample_values.clear();
  for (std::size_t k = 0; k < slices.size(); ++k) {
    for (std::size_t sample = 0; sample < slices[k].size(); ++sample) {
      if (slices[k].places[sample].fraction == 0) continue;
      ++sliced.sample_counts[k];
      sliced.positions.push_back(slices[k].places[sample]);
      const auto first = slices[k].values.begin() + static_cast<std::ptrdiff_t>(sample * channels);
      sliced.sample_values.insert(sliced.sample_values.end(), first, first + static_cast<std::ptrdiff_t>(channels));
    }
  }
}

}  // namespace sbrdf::internal
