#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "codec/material/spline.h"

namespace sbrdf {

/// A guide made ready for evaluation in one arithmetic.
template <class Real>
class GuideCurve {
 public:
  GuideCurve() = default;
  GuideCurve(const Guide& guide, std::span<const double> theta_h_nodes, std::size_t channel_count);

  /// g at frame coordinates, for `values.size()` channels from `channel` on.
  void evaluate(const Coordinates& x, std::size_t channel, std::span<Real> values) const {
    evaluate_at(guide_angle_deg(ratio_, x), channel, values);
  }
  /// g at an angle of its own; beyond its ends the value there.
  void evaluate_at(double angle_deg, std::size_t channel, std::span<Real> values) const;

 private:
  double ratio_ = 1;
  std::size_t channels_ = 0;
  std::vector<double> positions_;
  std::vector<Real> values_;
  std::vector<Real> second_;
};

/// From f_r to what slices hold, and the position of a guide's sample.
[[nodiscard]] double guide_position_deg(std::span<const double> theta_h_nodes, const SamplePosition& place);

/// Maps measured values of a material to what its slices interpolate: the value domain, less the guide if there is one.
template <class Real>
class ValueMap {
 public:
  ValueMap() = default;
  ValueMap(const SlicedBrdf& sliced, const Lattice& lattice);

  /// `f` and `residual` have one entry per channel.
  void forward(const Coordinates& x, std::span<const float> f, std::span<Real> residual) const;
  /// For channels from `channel` on: f_r of a sum of slices, in place.
  void inverse(const Coordinates& x, std::size_t channel, std::span<Real> values) const;

 private:
  std::vector<DomainMap<Real>> maps_;
  std::vector<Real> least_;  ///< per channel: 0 where no sample is negative, so that no overshoot is either
  std::vector<Real> most_;   ///< per channel: 16 times the largest sample
  bool guided_ = false;
  GuideCurve<Real> guide_;
};

extern template class GuideCurve<float>;
extern template class GuideCurve<double>;
extern template class GuideCurve<long double>;
extern template class ValueMap<float>;
extern template class ValueMap<double>;
extern template class ValueMap<long double>;

}  // namespace sbrdf
