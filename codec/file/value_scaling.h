#pragma once

#include <cstdint>
#include <vector>

#include "codec/coding/quantizer.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// The scale of a file, and what its values become.
struct Scaled {
  Quantizer scale;
  std::vector<std::int32_t> crossing_steps;
  std::vector<std::int32_t> sample_steps;
  std::vector<float> crossing_values;
  std::vector<float> sample_values;
};

/// With the coarsest scale that keeps `precision` (a bound on the relative error) for every value; the lossless one for
/// 0, and where no other does. Guides are left out.
[[nodiscard]] Scaled scale_values(const SlicedBrdf& sliced, double precision);

/// What a file of that precision would give back, without making one: for judging an error before it is written.
void round_to_precision(SlicedBrdf& sliced, double precision);

}  // namespace sbrdf::internal
