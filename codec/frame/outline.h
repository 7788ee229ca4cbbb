#pragma once

#include <array>
#include <vector>

#include "codec/frame/frame.h"

namespace sbrdf::internal {

/// A frame by the shortest lists that give it: azimuthal lists are mirrored (and turned) until they fill their period,
/// so that every symmetry finds nodes at its mirror planes. All that a search may change about a frame.
struct FrameOutline {
  FrameId id = FrameId::kElevation;
  Symmetries symmetries;
  /// In the order of SliceKind, each beginning with 0. Azimuthal lists end at the mirror plane, `outline_end`.
  /// Elevation frame: theta_i follows theta_v, its list stays empty. Isotropic: the axial list is {0}. Degrees, rising.
  std::array<std::vector<double>, kAxisCount> lists;
  double theta_max_deg = kPaperThetaMaxDeg;  ///< see FrameSpec; in the elevation frame the last elevation
};

/// Where an azimuthal list of an outline ends: s, u: 180; phi_h: 90; phi_d: 90. 0 for polar axes, which end where they
/// like.
[[nodiscard]] double outline_end(FrameId id, std::size_t axis);

/// The frame in full. What the lists leave open is not checked here but by check_frame and build_lattice.
[[nodiscard]] FrameSpec expand_outline(const FrameOutline& outline);

}  // namespace sbrdf::internal
