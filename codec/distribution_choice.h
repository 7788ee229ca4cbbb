#pragma once

#include <cstdint>
#include <vector>

#include "codec/sliced_index.h"

namespace sbrdf {

/// What a chunk holds, before the distributions are known.
struct Event {
  std::int64_t value = 0;  ///< a residual, or 0 and 1 for a flag
  std::uint8_t context = 0;
  bool flag = false;
};

/// Gives every context that occurs the distribution, or the probability, with which it takes the fewest bits, and
/// stores them in `index`. Returns those bits, times 256.
std::uint64_t choose_distributions(const std::vector<std::vector<Event>>& chunks, SlicedIndex& index);

}  // namespace sbrdf
