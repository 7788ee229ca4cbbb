#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "codec/frame/frame.h"

namespace sbrdf::internal {

/// How the function continues beyond the ends of a slice.
enum class Boundary : std::uint8_t {
  kPeriodic,  ///< the end is the start again; it has no node of its own
  kMirrored,  ///< even about both ends, each of which is a node
  kBounded,   ///< nothing beyond the ends, each of which is a node
};

/// One stored slice: a line of frame coordinates of which every symmetric twin has been folded onto it.
struct Slice {
  SliceKind kind = kAxial;
  Boundary boundary = Boundary::kBounded;
  double start_deg = 0;          ///< position of the first node, in degrees of the slice's own coordinate
  double length_deg = 0;         ///< from the first node to the end
  double gap_scale = 1;          ///< degrees of the slice's parameter (the paper's t) per degree of position
  Coordinates fixed{};           ///< the other three coordinates; the entry of `kind` is unused
  std::uint32_t node_begin = 0;  ///< its crossings in Lattice::slice_nodes, by rising position
  std::uint32_t node_count = 0;

  /// Intervals between neighbouring nodes; a periodic slice has one more, back to its first node.
  [[nodiscard]] std::uint32_t interval_count() const {
    return boundary == Boundary::kPeriodic ? node_count : node_count - 1;
  }
};

/// A crossing as it lies on a slice.
struct SliceNode {
  double position_deg = 0;
  std::uint32_t crossing = 0;
};

/// Where the values of a line of the lattice come from: position on the slice = sign * coordinate + offset, brought
/// into the slice by `fold`. A line on which nothing varies is one crossing.
struct LineReference {
  static constexpr std::uint32_t kConstant = 0x80000000U;
  std::uint32_t target = 0;  ///< a slice, or kConstant + a crossing
  std::int32_t sign = 1;
  double offset_deg = 0;

  [[nodiscard]] bool is_constant() const { return (target & kConstant) != 0; }
  [[nodiscard]] std::uint32_t crossing() const { return target & ~kConstant; }
};

/// Strides of a 4-D table with one axis left out have 0 there.
using Strides = std::array<std::uint32_t, kAxisCount>;

/// Everything that follows from a FrameSpec: which crossings and slices are distinct, and where each cell of the 4-D
/// lattice finds its corners and its slices. The order of crossings and slices is part of the file format: both are
/// numbered as they are first met when the padded lattice is walked with axis 0 fastest, slices by kind first.
struct Lattice {
  FrameSpec spec;
  /// Nodes of each axis with the turn of an azimuthal axis closed: s over [0, 720], u over [0, 360], phi_h over
  /// [0, 360], phi_d over [0, 180]. An axis with a single node keeps just that: nothing varies along it.
  std::array<std::vector<double>, kAxisCount> nodes;
  std::vector<Coordinates> crossings;  ///< one representative for each unique crossing
  std::vector<std::uint32_t> corners;  ///< crossing at each padded lattice point; strides in corner_strides
  Strides corner_strides{};
  std::array<std::vector<LineReference>, kAxisCount> lines;  ///< per axis; strides in line_strides[axis]
  std::array<Strides, kAxisCount> line_strides{};
  std::vector<Slice> slices;
  std::vector<SliceNode> slice_nodes;

  [[nodiscard]] std::span<const SliceNode> nodes_of(const Slice& slice) const {
    return std::span(slice_nodes).subspan(slice.node_begin, slice.node_count);
  }
};

/// Refuses lists that break the rules at Axis, symmetries whose mirror planes hold no node, and lattices of more than
/// 2^21 points.
[[nodiscard]] Result<Lattice> build_lattice(const FrameSpec& spec);

/// Brings a position into [start, start + length], by period and reflection.
[[nodiscard]] double fold(const Slice& slice, double position_deg);

/// The coordinates of a point on a slice.
[[nodiscard]] Coordinates coordinates_on(const Slice& slice, double position_deg);

}  // namespace sbrdf::internal
