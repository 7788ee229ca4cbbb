#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "codec/evaluation/pole_ring.h"
#include "codec/frame/lattice.h"
#include "codec/material/slice_samples.h"
#include "codec/material/sliced_brdf.h"
#include "codec/material/value_map.h"

namespace sbrdf::internal {

/// Evaluates a sliced BRDF (specs/conventions.md): splines along each slice, then the sum of four slices less three
/// times the corners, clamped from below by the least of the slices. In the log domain it is clamped from above by the
/// greatest of them, too: beside a deep valley the sum would be far above, and the exponential makes that a false
/// highlight. A channel without a negative sample never comes out negative. Immutable after construction, so one object
/// serves any number of threads; no allocation per evaluation.
///
/// Real is the arithmetic: float for use, long double for judging it. All places (coordinates, positions of samples)
/// are double in both, so that both find the same cell and the same segment.
template <class Real>
class BasicEvaluator {
 public:
  /// `sliced` must have passed check_sliced with this lattice; neither is needed afterwards.
  BasicEvaluator(const SlicedBrdf& sliced, const Lattice& lattice);

  [[nodiscard]] std::size_t channel_count() const { return channels_; }

  /// f_r [1/sr] of one pair; `values` has one entry per channel. Exchanging i and v gives the same bits. Directions
  /// beyond the largest theta of the frame take the value at it; where one lies below the horizon, all values are 0.
  void evaluate(const DirectionPair& pair, std::span<Real> values) const;

  /// What the slices give at frame coordinates [degrees], azimuths within the padded lattice (see
  /// FrameGeometry::coordinates). The horizon plays no part: in the half/difference frame slices run on below it.
  void evaluate_at(const Coordinates& x, std::span<Real> values) const;

 private:
  using Wide = std::conditional_t<std::is_same_v<Real, float>, double, Real>;  ///< for the work done once

  /// A slice made ready: its samples are knots, the first one of a periodic slice again at its end, and buckets of
  /// equal width lead to the segment between two of them.
  struct Curve {
    Boundary boundary = Boundary::kBounded;
    double start = 0;   ///< [degrees], as in Slice
    double length = 0;  ///< [degrees]
    double buckets_per_degree = 0;
    std::uint32_t first_knot = 0;    ///< in knots_
    std::uint32_t first_bucket = 0;  ///< in buckets_
    std::uint32_t bucket_count = 0;  ///< 1 or more
  };
  /// The part of a slice between two knots, and a place on it.
  struct Segment {
    std::uint32_t knot = 0;  ///< the one before, in knots_
    Real t = 0;              ///< fraction of the way to the next, in [0, 1]
    Real width = 0;          ///< distance of the two [degrees]
  };
  /// The cell that holds a point, and the point in it.
  struct Cell {
    std::array<std::uint32_t, kAxisCount> index{};  ///< the node before the point, by axis
    std::array<Real, kAxisCount> fraction{};        ///< of the way to the next node, by moving axis
  };
  /// N channels of a reconstruction, and between what it may lie.
  template <std::size_t N>
  struct Bounded {
    std::array<Real, N> value;
    std::array<Real, N> least;
    std::array<Real, N> most;
  };
  /// N channels at the corners, or on the lines along one axis, of a cell. Bit m of the index says on which side of the
  /// m-th moving axis (lines: of those that remain): clear at the node before the point, set at the next.
  template <std::size_t N>
  using Points = std::array<std::array<Real, N>, std::size_t{1} << kAxisCount>;

  void add_corners(const SlicedBrdf& sliced, const Lattice& lattice, const ValueMap<Wide>& map);
  void add_curves(const SlicedBrdf& sliced, const Lattice& lattice, const ValueMap<Wide>& map);
  void add_curve(const Slice& slice, const SliceSamples& samples, std::span<const Wide> values,
                 std::span<const Wide> slopes);
  void add_buckets(Curve& curve);

  [[nodiscard]] Cell locate(const Coordinates& x) const;
  [[nodiscard]] Segment segment_at(const Curve& curve, double position) const;
  template <std::size_t N>
  void reconstruct(const Cell& cell, const Coordinates& x, std::size_t channel, Real* values) const;
  template <std::size_t N>
  [[nodiscard]] Bounded<N> sum_in_cell(const Cell& cell, const Coordinates& x, std::size_t channel) const;
  template <std::size_t N>
  [[nodiscard]] Bounded<N> sum_on_ring(const PoleRing& ring, const Cell& cell, const Coordinates& x,
                                       std::size_t channel) const;
  template <std::size_t N>
  void correct_at_pole(const PoleRing& ring, const Cell& cell, const Coordinates& x, std::size_t channel,
                       Bounded<N>& sum) const;
  template <std::size_t N>
  void read_corners(const Cell& cell, std::size_t channel, Points<N>& points) const;
  template <std::size_t N>
  void read_lines(const Cell& cell, std::size_t along, double x, std::size_t channel, Points<N>& points) const;
  template <std::size_t N>
  void along_line(const LineReference& reference, double x, std::size_t channel, Real* values) const;

  const FrameGeometry& frame_;
  std::size_t channels_ = 0;
  GreyShares grey_shares_;
  bool clamp_above_ = false;
  ValueMap<Real> map_;
  std::array<std::vector<double>, kAxisCount> nodes_;  ///< as in Lattice
  std::array<double, kAxisCount> cells_per_degree_{};
  std::array<std::size_t, kAxisCount> moving_{};  ///< the axes with two nodes or more, rising
  std::size_t moving_count_ = 0;
  std::vector<std::uint32_t> corners_;  ///< this and the next three as in Lattice
  Strides corner_strides_{};
  std::array<std::vector<LineReference>, kAxisCount> lines_;
  std::array<Strides, kAxisCount> line_strides_{};
  std::vector<PoleRing> rings_;
  std::vector<Real> corner_values_;     ///< in the value domain, per crossing, channel fastest
  std::vector<Curve> curves_;           ///< by number of slice
  std::vector<double> knots_;           ///< positions of samples [degrees]
  std::vector<Real> knot_values_;       ///< per knot: the values of all channels, then their slopes
  std::vector<std::uint32_t> buckets_;  ///< the first knot of the segment that holds the bucket's start
};

extern template class BasicEvaluator<float>;
extern template class BasicEvaluator<long double>;

using Evaluator = BasicEvaluator<float>;

}  // namespace sbrdf::internal
