#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "codec/curves/spline.h"
#include "codec/frame/lattice.h"
#include "codec/material/slice_samples.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// A guide made ready for evaluation in one arithmetic: a bounded spline over its angle, like that of a slice, between
/// samples at the places that the guide lists. Immutable.
template <class Real>
class GuideCurve {
 public:
  /// No guide; to be assigned to.
  GuideCurve() = default;
  /// `theta_h_nodes` are those of the lattice; the guide has passed check_sliced with it.
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
  std::vector<double> positions_;  ///< angles of the samples [degrees], rising
  std::vector<Real> values_;       ///< g at them, channel fastest
  std::vector<Real> second_;       ///< second derivatives there, likewise
};

/// The angle [degrees] of a guide's sample on the theta_h axis.
[[nodiscard]] double guide_position_deg(std::span<const double> theta_h_nodes, const SamplePosition& place);

/// Maps measured values of a material to what its slices interpolate, and back: v(f) - g, the value domain less the
/// guide if there is one. Immutable, so one object serves any number of threads.
template <class Real>
class ValueMap {
 public:
  /// How many channels `inverse` takes at once: it keeps a guide's values without allocating.
  static constexpr std::size_t kMostChannels = 3;

  /// Of no channel; to be assigned to.
  ValueMap() = default;
  /// `sliced` gives domain, guide, and the range of values that `inverse` keeps to; neither is needed afterwards.
  ValueMap(const SlicedBrdf& sliced, const Lattice& lattice);

  [[nodiscard]] std::size_t channel_count() const { return maps_.size(); }

  /// Between these `inverse` keeps the values of a channel.
  [[nodiscard]] Real least(std::size_t channel) const { return least_[channel]; }
  [[nodiscard]] Real most(std::size_t channel) const { return most_[channel]; }

  /// What slices hold for f_r = `f` at frame coordinates `x`; both have one entry per channel.
  void forward(const Coordinates& x, std::span<const float> f, std::span<Real> residual) const;
  /// The same for all samples of a slice: `residuals` becomes samples.size() x channels, channel fastest.
  void forward(const Slice& slice, const SliceSamples& samples, std::vector<Real>& residuals) const;
  /// f_r [1/sr] of sums of slices at `x`, in place: `values` belongs to the channels from `channel` on, all of which
  /// must exist, and holds at most kMostChannels of them (both asserted). The result lies within 16 times the largest
  /// sample, and is not negative where no sample of the channel is: sums may overshoot.
  void inverse(const Coordinates& x, std::size_t channel, std::span<Real> values) const;

 private:
  std::vector<DomainMap<Real>> maps_;  ///< per channel
  std::vector<Real> least_;            ///< per channel: 0 where no sample is negative, so that no overshoot is either
  std::vector<Real> most_;             ///< per channel: 16 times the largest sample
  bool guided_ = false;
  GuideCurve<Real> guide_;
};

extern template class GuideCurve<float>;
extern template class GuideCurve<double>;
extern template class GuideCurve<long double>;
extern template class ValueMap<float>;
extern template class ValueMap<double>;
extern template class ValueMap<long double>;

}  // namespace sbrdf::internal
