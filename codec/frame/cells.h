#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/frame/lattice_walk.h"

namespace sbrdf::internal {

/// A cell of one axis of the padded lattice.
struct AxisCell {
  std::uint32_t index = 0;  ///< the node before it
  double x = 0;             ///< [degrees] the coordinate that was looked up, within the axis
};

/// As many cells as an axis has, by its length [degrees]: tells about where cell_on_axis finds a coordinate. 0 for an
/// axis of one node.
[[nodiscard]] inline double cells_per_degree(std::span<const double> nodes) {
  return nodes.back() > 0 ? static_cast<double>(nodes.size() - 1) / nodes.back() : 0;
}

/// The cell that holds a coordinate: the last one whose node lies at or before it, so a node belongs to the cell that
/// it begins, and the end of the axis to the last cell. What lies outside the axis is moved to its end, a NaN to its
/// first node. `per_degree` is cells_per_degree(nodes). Nothing is snapped: rounding beside a node decides between two
/// cells that agree there. `nodes` has two members or more.
[[nodiscard]] inline AxisCell cell_on_axis(std::span<const double> nodes, double per_degree, double x) {
  const double clamped = x > nodes.front() ? std::min(x, nodes.back()) : nodes.front();
  const auto last = static_cast<std::uint32_t>(nodes.size() - 2);
  std::uint32_t index = std::min(static_cast<std::uint32_t>(clamped * per_degree), last);
  while (index > 0 && nodes[index] > clamped) --index;
  while (index < last && nodes[index + 1] <= clamped) ++index;
  return {index, clamped};
}

/// Which cells of a padded lattice are meant: the unit in which a sliced BRDF can be loaded in part.
class CellSet {
 public:
  using Cell = LatticePoint;  ///< node before the cell on each axis; 0 on an axis of one node

  /// No cell yet.
  explicit CellSet(const Lattice& lattice);

  void add(const Cell& cell) { inside_[index_of(cell)] = true; }
  void add_all() { inside_.assign(inside_.size(), true); }
  [[nodiscard]] bool contains(const Cell& cell) const { return inside_[index_of(cell)]; }
  /// How many cells it holds.
  [[nodiscard]] std::size_t size() const;

  /// Calls `visit(cell)` for each cell of the set, axis 0 fastest.
  template <class Visit>
  void for_each(const Visit& visit) const {
    std::size_t k = 0;
    walk_grid(counts_, [&](const Cell& cell) {
      if (inside_[k++]) visit(cell);
    });
  }

 private:
  [[nodiscard]] std::size_t index_of(const Cell& cell) const {
    return cell[0] + counts_[0] * (cell[1] + counts_[1] * (cell[2] + std::size_t{counts_[2]} * cell[3]));
  }

  Cell counts_{};             ///< cells of each axis, 1 where there is one node
  std::vector<bool> inside_;  ///< axis 0 fastest
};

/// The cell that evaluation of a pair uses, above the horizon or not.
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

}  // namespace sbrdf::internal
