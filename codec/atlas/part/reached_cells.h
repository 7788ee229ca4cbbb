#pragma once

#include "codec/atlas/atlas.h"
#include "codec/atlas/part/atlas_cells.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {

/// Finds the cells of an atlas that pairs of directions reach.
class ReachedCells {
 public:
  /// Of the layout the frame, its symmetries and the nodes are used.
  explicit ReachedCells(const AtlasLayout& layout);

  /// The cells of all pairs whose directions are both within `margin_deg` of those of `pair`, which lies above the
  /// horizon; with a margin some more, as the bounds on coordinates are not tight. A margin of 0 is taken as the
  /// rounding of single precision.
  void add(const DirectionPair& pair, double margin_deg);

  /// The cells of all pairs with both thetas up to `theta_max_deg`, and no others.
  void add_up_to(double theta_max_deg);

  /// What others have found for the same layout.
  void add_all(const AtlasCells& cells) { cells_.add_all(cells); }

  [[nodiscard]] const AtlasCells& cells() const { return cells_; }

 private:
  struct Range {
    double first = 0;
    double last = 0;
  };
  using Box = std::array<Range, kAxisCount>;

  /// Visits so many places of a box, evenly, that no cell between them is passed over.
  template <class Visit>
  void for_places(const Box& box, const Coordinates& narrowest, const Visit& visit) const;
  void add_half_difference(const DirectionPair& pair, double margin_deg);
  void add_elevation(const DirectionPair& pair, double margin_deg);

  AtlasLayout layout_;
  Coordinates narrowest_{};  ///< cell of each axis [degrees]
  AtlasCells cells_;
};

}  // namespace sbrdf::internal
