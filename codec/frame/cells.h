#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/frame/lattice.h"

namespace sbrdf {

/// Which cells of a padded lattice are meant: the unit in which a sliced BRDF can be loaded in part.
class CellSet {
 public:
  using Cell = std::array<std::uint32_t, kAxisCount>;  ///< node before the cell on each axis; 0 on an axis of one node

  /// No cell yet.
  explicit CellSet(const Lattice& lattice);

  void add(const Cell& cell) { inside_[index_of(cell)] = true; }
  void add_all() { inside_.assign(inside_.size(), true); }
  [[nodiscard]] bool contains(const Cell& cell) const { return inside_[index_of(cell)]; }
  [[nodiscard]] std::size_t size() const;

  /// Calls `visit(cell)` for each cell of the set.
  template <class Visit>
  void for_each(const Visit& visit) const {
    Cell cell{};
    std::size_t k = 0;
    for (cell[3] = 0; cell[3] < counts_[3]; ++cell[3])
      for (cell[2] = 0; cell[2] < counts_[2]; ++cell[2])
        for (cell[1] = 0; cell[1] < counts_[1]; ++cell[1])
          for (cell[0] = 0; cell[0] < counts_[0]; ++cell[0]) {
            if (inside_[k++]) visit(cell);
          }
  }

 private:
  [[nodiscard]] std::size_t index_of(const Cell& cell) const {
    return cell[0] + counts_[0] * (cell[1] + counts_[1] * (cell[2] + std::size_t{counts_[2]} * cell[3]));
  }

  Cell counts_{};
  std::vector<bool> inside_;
};

/// The cell that evaluation of a pair uses.
[[nodiscard]] CellSet::Cell cell_of(const Lattice& lattice, const DirectionPair& pair);

/// A box of directions [degrees]: from <= theta < to (the largest theta of the frame belongs to a box that ends at or
/// beyond it), and azimuths from `from` on, anticlockwise, to `to`; equal azimuths mean all.
struct DirectionBox {
  double theta_from = 0;
  double theta_to = 90;
  double phi_from = 0;
  double phi_to = 0;
};

/// The cells that hold any pair with one direction in `i` and the other in `v`, in either order; in the half/difference
/// frame a few more: those that a bound on the angles cannot rule out.
[[nodiscard]] CellSet cells_in(const Lattice& lattice, const DirectionBox& i, const DirectionBox& v);

/// The cells that the pairs lie in.
[[nodiscard]] CellSet cells_of(const Lattice& lattice, std::span<const DirectionPair> pairs);

/// Crossings and slices, each marked or not.
struct LatticeParts {
  std::vector<bool> crossings;
  std::vector<bool> slices;
};
/// What evaluation within some cells uses: their sixteen corners and thirty-two lines, and all crossings of these
/// lines.
[[nodiscard]] LatticeParts needs_of(const Lattice& lattice, const CellSet& cells);

}  // namespace sbrdf
