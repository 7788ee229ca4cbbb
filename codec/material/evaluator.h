#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "codec/material/value_map.h"

namespace sbrdf {

/// Evaluates a sliced BRDF (specs/conventions.md): splines along each slice, then the sum of four slices less three
/// times the corners, clamped from below by the least of the slices. In the log domain it is clamped from above by the
/// greatest of them, too: beside a deep valley the sum would be far above, and the exponential makes that a false
/// highlight. A channel without a negative sample never comes out negative. Immutable after construction, so one object
/// serves any number of threads; no allocation per evaluation.
///
/// Real is the arithmetic: float for use, long double for judging it. Directions beyond the largest theta of the frame
/// take the value at it.
template <class Real>
class BasicEvaluator {
 public:
  /// `sliced` must have passed check_sliced with this lattice; neither is needed afterwards.
  BasicEvaluator(const SlicedBrdf& sliced, const Lattice& lattice);

  [[nodiscard]] std::size_t channel_count() const { return channels_; }

  /// f_r [1/sr] of one pair; `values` has one entry per channel.
  void evaluate(const DirectionPair& pair, std::span<Real> values) const;

  /// The same at frame coordinates [degrees], azimuths within the padded lattice (see FrameGeometry::coordinates).
  void evaluate_at(const Coordinates& x, std::span<Real> values) const;

 private:
  using Wide = std::conditional_t<std::is_same_v<Real, float>, double, Real>;  ///< for the work done once

  struct Curve {  ///< a slice made ready: samples with the period closed, and buckets that lead to the segment
    Boundary boundary = Boundary::kBounded;
    double start = 0;
    double length = 0;
    double buckets_per_degree = 0;
    std::uint32_t first_knot = 0;
    std::uint32_t first_bucket = 0;
    std::uint32_t bucket_count = 0;
  };
  struct Cell {
    std::array<std::uint32_t, kAxisCount> index{};
    std::array<Real, kAxisCount> fraction{};
  };

  void add_corners(const SlicedBrdf& sliced, const Lattice& lattice, const ValueMap<Wide>& map);
  void add_curves(const SlicedBrdf& sliced, const Lattice& lattice, const ValueMap<Wide>& map);
  void add_buckets(Curve& curve);
  [[nodiscard]] Cell locate(const Coordinates& x) const;
  template <std::size_t N>
  void reconstruct(const Cell& cell, const Coordinates& x, std::size_t channel, Real* values) const;
  template <std::size_t N>
  void along_line(const LineReference& reference, double x, std::size_t channel, Real* values) const;

  const FrameGeometry& frame_;
  std::size_t channels_ = 0;
  bool clamp_above_ = false;
  ValueMap<Real> map_;
  std::array<std::vector<double>, kAxisCount> nodes_;
  std::array<double, kAxisCount> cells_per_degree_{};
  std::vector<std::uint32_t> corners_;
  Strides corner_strides_{};
  std::array<std::vector<LineReference>, kAxisCount> lines_;
  std::array<Strides, kAxisCount> line_strides_{};
  std::vector<Real> corner_values_;  ///< in the value domain, per crossing, channel fastest
  std::vector<Curve> curves_;
  std::vector<double> knots_;           ///< positions of samples
  std::vector<Real> knot_values_;       ///< per knot: the values of all channels, then their second derivatives
  std::vector<std::uint32_t> buckets_;  ///< the first knot of the segment that holds the bucket's start
};

extern template class BasicEvaluator<float>;
extern template class BasicEvaluator<long double>;

using Evaluator = BasicEvaluator<float>;

}  // namespace sbrdf
