#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/frame/lattice.h"

namespace sbrdf::internal {

/// The face of the padded lattice on which one polar axis is 0 and the two azimuths are one: the light (or the viewer)
/// on the normal in the elevation frame, the half vector there in the half/difference frame. It has two coordinates,
/// the other polar angle and the ring's (see Merging), and slices of its own along both, at more places along the
/// ring than either azimuth has nodes: at all their sums or differences.
struct PoleRing {
  /// Where a slice along `along` meets the ring.
  struct Node {
    double position_deg = 0;   ///< along the ring, rising from 0 to its period
    std::uint32_t corner = 0;  ///< index in Lattice::corners of the point with 0 on both polar axes
    std::uint32_t line = 0;    ///< index in Lattice::lines[along] of the line there
  };

  Merging merging;
  std::size_t along = 0;    ///< the other polar axis
  std::vector<Node> nodes;  ///< two or more

  /// The azimuth that is 0 on the ring.
  [[nodiscard]] std::size_t other_azimuth() const { return merging.ring_axis == kAxial ? kDiagonal : kAxial; }
  /// The place on the ring of frame coordinates, in [0, period).
  [[nodiscard]] double position_deg(const Coordinates& x) const;
  /// The last node at or before a place, but never the last of all.
  [[nodiscard]] std::size_t node_before(double position_deg) const;
};

/// The rings of a lattice: none where one of the azimuths does not matter anyway, or a polar axis has a single node.
[[nodiscard]] std::vector<PoleRing> pole_rings(const Lattice& lattice);

}  // namespace sbrdf::internal
