#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "codec/atlas/atlas.h"
#include "codec/evaluation/vector_evaluator.h"
#include "codec/frame/lattice.h"
#include "codec/material/grey_shares.h"
#include "codec/material/sliced_brdf.h"
#include "codec/material/value_domain.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// What texels hold: a material in the value domain, guide and all, at frame coordinates. Three channels; one stands
/// for all three.
class SliceValues {
 public:
  using Value = std::array<double, 3>;

  /// `sliced` has passed check_sliced with the lattice and has one channel or three; neither is needed afterwards.
  SliceValues(const SlicedBrdf& sliced, const Lattice& lattice);

  /// As VectorEvaluator::evaluate_at: on a line of the lattice this is its slice.
  [[nodiscard]] Value at(const Coordinates& x) const;

 private:
  VectorEvaluator evaluator_;
  GreyShares shares_;
  std::size_t channels_;
  std::vector<DomainMap<double>> maps_;
};

/// What brings these values back.
[[nodiscard]] AtlasDomain domain_of(const SlicedBrdf& sliced, const Lattice& lattice);

/// kUnsupported where textures do not hold so many channels of a material: they hold three, or one for all three.
[[nodiscard]] Status check_atlas_channels(std::size_t channels);

}  // namespace sbrdf::internal
