#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "codec/sampling/adaptive_sampling.h"

namespace sbrdf::internal {

/// f_r of one channel.
using TestFunction = std::function<double(const DirectionPair& pair, std::size_t channel)>;

inline Measure measure_of(const TestFunction& function, std::size_t channels) {
  return [function, channels](std::span<const DirectionPair> pairs, std::span<float> values) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = static_cast<float>(function(pairs[k / channels], k % channels));
    }
    return ok_status();
  };
}

struct SampledBrdf {
  Lattice lattice;
  SlicedBrdf sliced;
};

inline std::vector<std::string> channel_names(std::size_t channels) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < channels; ++c) names.push_back("channel " + std::to_string(c));
  return names;
}

/// `extra` samples beside the crossings.
inline SampledBrdf sample_function(const FrameSpec& spec, std::uint64_t extra, DomainKind domain,
                                   const TestFunction& function, std::size_t channels = 1) {
  SampledBrdf made;
  made.lattice = build_lattice(spec).value();
  SamplingOptions options;
  options.sample_count = made.lattice.crossings.size() + extra;
  options.domain = domain;
  made.sliced = sample_slices(made.lattice, channel_names(channels), measure_of(function, channels), options).value();
  return made;
}

/// Where a sample lies on its slice, from the definition of SamplePosition.
inline double place_in_degrees(const Lattice& lattice, const Slice& slice, const SamplePosition& place) {
  const auto nodes = lattice.nodes_of(slice);
  const double left = nodes[place.interval].position_deg;
  const double right =
      place.interval + 1 < nodes.size() ? nodes[place.interval + 1].position_deg : slice.start_deg + slice.length_deg;
  return left + (right - left) * place.fraction / 65536.0;
}

}  // namespace sbrdf::internal
