#include "codec/file/parameter_choice.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "codec/entropy/distribution_choice.h"

namespace sbrdf::internal {

void choose_parameters(SampleRecorder& recorder, SlicedIndex& index) {
  constexpr std::size_t kFewSamples = 500;
  constexpr std::size_t kMostTried = 3;
  const bool on_slices = index.adaptive_count >= kFewSamples;
  // Activities grow with the number of steps to an octave; lossless ones are the bits of a float.
  const std::vector<std::uint32_t> shifts =
      index.scale.lossless() ? std::vector<std::uint32_t>{8, 10, 12, 14} : std::vector<std::uint32_t>{0, 2};
  index.base_channel = 0;
  index.activity_shift = shifts.front();
  // Slices are predicted from crossings.
  if (on_slices) (void)recorder.record_crossings(index.coding());
  SlicedIndex best = index;
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  const auto try_out = [&](std::uint32_t base, std::uint32_t shift) {
    index.base_channel = base;
    index.activity_shift = shift;
    const std::vector<ChunkEvents> events =
        on_slices ? recorder.record_some_slices(index.coding()) : recorder.record_crossings(index.coding());
    const std::uint64_t cost = choose_distributions(events).cost_256;
    if (cost >= least) return;
    least = cost;
    best.base_channel = base;
    best.activity_shift = shift;
  };
  const auto candidates = static_cast<std::uint32_t>(std::min(index.channels.size(), kMostTried));
  for (std::uint32_t base = 0; base < candidates; ++base) try_out(base, shifts.front());
  for (std::size_t k = 1; k < shifts.size(); ++k) try_out(best.base_channel, shifts[k]);
  index.base_channel = best.base_channel;
  index.activity_shift = best.activity_shift;
}

}  // namespace sbrdf::internal
