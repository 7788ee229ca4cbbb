#pragma once

#include <cstdint>
#include <vector>

#include "codec/coding/quantizer.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// The scale of a file, and what its values become. All lists are ordered as those of SlicedBrdf.
struct Scaled {
  Quantizer scale;
  std::vector<std::int32_t> crossing_steps;  ///< what is coded
  std::vector<std::int32_t> sample_steps;
  std::vector<std::int32_t> reference_steps;  ///< log domain only, per channel
  std::vector<float> crossing_values;         ///< what a reader gets back for them [1/sr]
  std::vector<float> sample_values;
  std::vector<float> references;
};

/// With the coarsest scale that keeps `precision` (a bound on the relative error) for every value; the lossless one for
/// 0, and where no other does. Guides are left out.
[[nodiscard]] Scaled scale_values(const SlicedBrdf& sliced, double precision);

/// Makes the steps of samples those that are coded: less the guide's, where there is one. The guide counts as it will
/// come back.
void take_off_guide(const SlicedBrdf& sliced, const Lattice& lattice, Scaled& scaled);

/// What a file of that precision would give back, without making one: for judging an error before it is written.
void round_to_precision(SlicedBrdf& sliced, double precision);

}  // namespace sbrdf::internal
