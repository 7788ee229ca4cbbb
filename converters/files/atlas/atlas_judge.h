#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "codec/atlas/part/atlas_cells.h"
#include "codec/file/encoder.h"
#include "codec/search/held_back.h"
#include "converters/source/brdf_source.h"
#include "formats/core/directions.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// On directions drawn densely around highlights.
struct AtlasErrors {
  double mre_percent = 0;
  double rel_l1_percent = 0;
  std::uint64_t directions = 0;
};

/// How far textures are off what they were made of. The same directions for all textures of a material.
class AtlasJudge {
 public:
  using Evaluate = std::function<void(const DirectionPair&, std::span<float, 3>)>;
  struct Errors {
    AtlasErrors to_slices, to_source;
  };

  /// `source` is what the slices were made of, or they themselves. Only directions in `cells` of an atlas of these
  /// slices count. Errors as of draw_held_back.
  [[nodiscard]] static Result<AtlasJudge> make(const DecodedSliced& sliced, const BrdfSource& source,
                                               const AtlasCells& cells = {});

  /// `evaluate` is called from many threads.
  [[nodiscard]] Errors errors(const Evaluate& evaluate) const;

 private:
  HeldBack from_source_;
  HeldBack from_slices_;  ///< the same directions
  std::size_t channels_ = 3;
};

}  // namespace sbrdf::internal
