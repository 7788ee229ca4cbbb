#pragma once

#include <cstdint>
#include <vector>

#include "codec/level_scale.h"
#include "codec/sliced_brdf.h"

namespace sbrdf {

/// The scale of a file, and what its values become.
struct Scaled {
  LevelScale scale;
  std::vector<std::int32_t> crossing_levels;
  std::vector<std::int32_t> sample_levels;
  std::vector<float> crossing_values;
  std::vector<float> sample_values;
};

/// With the coarsest scale that keeps `precision` (a bound on the relative error) for every value; the lossless one for
/// 0, and where no other does. Guides are left out.
[[nodiscard]] Scaled scale_values(const SlicedBrdf& sliced, double precision);

}  // namespace sbrdf
