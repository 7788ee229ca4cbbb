#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/frame/lattice_walk.h"

namespace sbrdf::internal {

/// Where two nodes are on the two polar axes (2, then 3). The index past the last node stands for a line along that
/// axis; not for both at once.
using PolarPair = std::array<std::uint32_t, 2>;

/// Calls `visit(pair)` for the pairs of the first `horizontal` and the first `vertical` nodes in the order of the
/// lattice.
template <class Visit>
void walk_polar_pairs(std::uint32_t horizontal, std::uint32_t vertical, const Visit& visit) {
  walk_grid({1, 1, horizontal, vertical}, [&](const LatticePoint& p) { visit(PolarPair{p[2], p[3]}); });
}

/// A node of a slice, at the lattice point of the azimuths where it is met first.
struct PatternNode {
  double position_deg = 0;   ///< on the slice
  std::uint32_t corner = 0;  ///< in Lattice::corners, from the point of the polar pair on
  bool exchanged = false;    ///< the polar pair to add is the slice's own with both members exchanged
};

/// Slices along an azimuth, all but their fixed polar coordinates and crossings.
struct PatternSlice {
  Slice slice;                     ///< node_begin and node_count are not set
  std::vector<PatternNode> nodes;  ///< by rising position, one at each
};

/// What all polar pairs of one kind have for their own.
struct PolarKind {
  std::vector<Coordinates> crossings;  ///< only their azimuths are meant
  std::vector<PatternSlice> slices;    ///< along either azimuth
};

/// Where the azimuth points, or the lines along one azimuth, at a polar pair belong.
struct Pattern {
  std::size_t home = 0;    ///< the kind of the pair that has the crossings or slices
  bool exchanged = false;  ///< that pair is this one with both members exchanged
  /// Axis 0 fastest. The target is a number within the home, or kConstant + 0 where nothing varies.
  std::vector<LineReference> references;
};

/// Folds the lattice: finds which of its points are one measurement, and which of its lines lie on one slice.
///
/// The symmetries do the same to the azimuths at all polar pairs of a kind: the same members are at a pole, and the
/// same member is the larger. So there is no need to fold each point of the lattice by itself: the azimuths of a few
/// kinds are folded (at most 12), and all pairs follow from them.
class SymmetryFolding {
 public:
  /// Of the lattice, which must outlive this, its spec, nodes and corner_strides count.
  explicit SymmetryFolding(const Lattice& lattice);

  /// For a line along a polar axis too: all its points lie alike.
  [[nodiscard]] const Pattern& points(const PolarPair& pair) const { return patterns_[kPoints][kind_of(pair)]; }
  /// `axis` is one of the azimuths, with more than one node.
  [[nodiscard]] const Pattern& lines(std::size_t axis, const PolarPair& pair) const {
    return patterns_[axis][kind_of(pair)];
  }
  /// What a pattern's targets are numbers of; `home` as in Pattern.
  [[nodiscard]] const PolarKind& kind(std::size_t home) const { return kinds_[home]; }

 private:
  static constexpr std::size_t kPoints = kHorizontal;  ///< behind the two azimuths
  static constexpr std::size_t kKindCount = 12;

  class Folding;
  [[nodiscard]] double polar_deg(const PolarPair& pair, std::size_t axis) const;
  [[nodiscard]] std::size_t kind_of(const PolarPair& pair) const;

  const Lattice& lattice_;
  std::array<std::array<Pattern, kKindCount>, kPoints + 1> patterns_;
  std::array<PolarKind, kKindCount> kinds_;
};

}  // namespace sbrdf::internal
