#pragma once

#include <span>

#include "codec/atlas/atlas.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {

/// Evaluates an atlas as its shader does: bilinear look-ups in float32, the same sums in the same order. Immutable
/// after construction; no allocation per evaluation.
class AtlasEvaluator {
 public:
  /// `atlas` must outlive this. Its layout is one that lay_out made or check_atlas accepted.
  explicit AtlasEvaluator(const Atlas& atlas);

  /// f_r [1/sr] of one pair, RGB; 0 where a direction lies below the horizon, kLeftOutColour in cells left out.
  void evaluate(const DirectionPair& pair, std::span<float, 3> values) const;
  /// At frame coordinates [degrees] as FrameGeometry::coordinates gives them: azimuths within the padded lattice, and
  /// in the elevation frame theta_i not above theta_v. Of others it only reads other texels than it should.
  void evaluate_at(const Coordinates& x, std::span<float, 3> values) const;
  /// Whether the cell of a pair above the horizon is held.
  [[nodiscard]] bool holds(const DirectionPair& pair) const;

 private:
  using Rgb = std::array<float, 3>;
  using Places = std::array<AtlasPlace, kAxisCount>;

  [[nodiscard]] Rgb read(double x, double y, const AtlasScale& scale) const;
  [[nodiscard]] Rgb sum_of_table(std::size_t number, const Places& places) const;
  [[nodiscard]] Rgb on_ring(const AtlasPole& pole, const Coordinates& x, const Places& places) const;

  const Atlas& atlas_;
  std::vector<AtlasPole> poles_;
};

/// f_r of v, per channel, shares taken off: what stands at the end of an evaluation.
void bring_back(const AtlasDomain& domain, std::span<const float, 3> v, std::span<float, 3> values);

}  // namespace sbrdf::internal
