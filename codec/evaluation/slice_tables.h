#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/evaluation/pole_ring.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// A sliced BRDF as the flat arrays that the kernel of the VectorEvaluator reads: what specs/conventions.md calls
/// reconstruction, with all that does not depend on the point worked out. Immutable once it is made; a plain struct,
/// since the kernel is compiled once for each set of instructions and looks at everything.
///
/// Places along slices and axes are whole numbers: 2^31 of them along a turn or between two mirrors, or along the 90
/// degrees of a polar axis, so at most 3.4e-7 degrees each. So a sample is met exactly where it lies, a turn is an
/// overflow, and a place takes four bytes. Azimuths on their way to a place are 2^64 to the longest period of the
/// frame.
///
/// Values are those of the value domain less the guide, as float32. Channels are worked out in groups of kLanes; what
/// the last group reads beyond the last channel means nothing.
struct SliceTables {
  static constexpr std::size_t kLanes = 4;
  /// Lines that one point can need, in quads: 8 of its cell, one of each of two rings, and one for the guide.
  static constexpr std::size_t kMostLines = 44;

  /// Places that rise, and where to begin to look for one: see find_segment in the kernel. Behind the last stands
  /// kBeyond, so that nothing is found after it.
  struct Search {
    std::uint32_t first_bucket = 0;  ///< in `buckets`
    std::uint8_t bucket_shift = 0;   ///< log2 of the places in a bucket
  };

  /// How a line of the lattice lies on the curve of its slice; all that finding a segment takes. Along an azimuth x:
  /// the place of sign x + offset.
  struct Line {
    std::uint64_t offset = 0;
    Search knots;
    std::uint8_t shift = 0;  ///< azimuths: log2 of the slice's periods in the frame's longest
    bool mirrored = false;
    bool backwards = false;  ///< sign is -1
    std::uint32_t first_knot = 0;
  };

  /// One axis with two nodes or more.
  struct MovingAxis {
    std::uint32_t axis = 0;
    bool azimuth = false;
    Strides line_strides{};  ///< of the lines along this axis
    double last_deg = 0;     ///< the last node, padded
    Search nodes;
    std::uint32_t first_node = 0;  ///< in `places`
    std::uint32_t last_cell = 0;   ///< the node before it, likewise
    std::vector<Line> lines;       ///< along this axis
  };

  /// What brings a group of channels back from the value domain, per channel.
  struct Group {
    std::array<float, kLanes> reference{};
    std::array<float, kLanes> floor{};
    std::array<float, kLanes> at_floor{};  ///< v of the floor; in linear values below all of them
    std::array<float, kLanes> at_zero{};   ///< v of 0
    std::array<float, kLanes> least{};
    std::array<float, kLanes> most{};
  };

  SliceTables(const SlicedBrdf& sliced, const Lattice& lattice);

  [[nodiscard]] std::size_t bytes() const;

  FrameId frame = FrameId::kElevation;
  std::size_t channels = 0;
  bool log = false;
  bool guided = false;
  double guide_ratio = 1;
  std::vector<MovingAxis> axes;  ///< rising
  std::vector<PoleRing> rings;   ///< where all four axes move
  GreyShares grey_shares;
  std::vector<Group> groups;
  std::vector<std::uint32_t> corners;  ///< the crossing at each point of the padded lattice
  Strides corner_strides{};
  std::vector<float> crossing_values;  ///< per crossing, channel fastest
  std::vector<std::int32_t> places;    ///< of the knots of all curves, then of the nodes of the axes
  std::vector<float> knot_values;      ///< per knot: the values of all channels, then their slopes [1/kWidthUnit]
  std::vector<std::uint32_t> buckets;  ///< the beginning of the segment that holds the bucket's first place
  Line guide;
  std::int32_t guide_end = 0;  ///< the place of its last sample

 private:
  class Maker;
};

/// The last place of a turn, between mirrors, and of 90 degrees.
inline constexpr std::int32_t kLastPlace = 0x7FFFFFFE;
inline constexpr std::int32_t kBeyond = 0x7FFFFFFF;
/// Widths of segments are counted in so many places where slopes are concerned: about a degree, so that slopes keep
/// their exponents.
inline constexpr float kWidthUnit = 8388608.0F;

/// The place of a polar angle in [0, 90].
inline constexpr double kPlacesPerPolarDegree = 2147483648.0 / 90.0;
[[nodiscard]] inline std::int32_t polar_place(double degrees) {
  return static_cast<std::int32_t>(std::min(degrees * kPlacesPerPolarDegree + 0.5, double{kLastPlace}));
}

/// An azimuth in [0, longest period of the frame] in 2^-64 of that period; the whole of it is 0 again.
[[nodiscard]] inline double longest_period_deg(FrameId frame) { return frame == FrameId::kElevation ? 720.0 : 360.0; }
[[nodiscard]] inline std::uint64_t azimuth_units(double degrees, double longest_deg) {
  constexpr double kUnits = 4611686018427387904.0;  // 2^62: the whole period still fits a signed number
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(degrees * (kUnits / longest_deg))) << 2U;
}
/// The place of an azimuth on an axis of the lattice.
[[nodiscard]] inline std::int32_t axis_place(double degrees, double longest_deg) {
  return static_cast<std::int32_t>(std::min(degrees * (2147483648.0 / longest_deg) + 0.5, double{kLastPlace}));
}

}  // namespace sbrdf::internal
