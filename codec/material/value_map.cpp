#include "codec/material/value_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <type_traits>

namespace sbrdf::internal {
namespace {

// A spline that overshoots in the log domain could pass the range of float.
constexpr float kHeadroom = 16;

}  // namespace

double guide_position_deg(std::span<const double> theta_h_nodes, const SamplePosition& place) {
  const double from = theta_h_nodes[place.interval];
  if (place.fraction == 0) return from;
  return from +
         (theta_h_nodes[place.interval + 1] - from) * (static_cast<double>(place.fraction) / SamplePosition::kOne);
}

template <class Real>
GuideCurve<Real>::GuideCurve(const Guide& guide, std::span<const double> theta_h_nodes, std::size_t channel_count)
    : ratio_(guide.ratio), channels_(channel_count) {
  using Wide = std::conditional_t<std::is_same_v<Real, float>, double, Real>;
  for (const SamplePosition& place : guide.places) positions_.push_back(guide_position_deg(theta_h_nodes, place));
  const std::vector<Wide> values(guide.values.begin(), guide.values.end());
  std::vector<Wide> second(values.size());
  SplineSolver<Wide> solver;
  for (std::size_t c = 0; c < channels_; ++c) {
    solver.solve(Boundary::kBounded, 0, positions_, values.data() + c, second.data() + c, channels_);
  }
  for (const Wide v : values) values_.push_back(static_cast<Real>(v));
  for (const Wide v : second) second_.push_back(static_cast<Real>(v));
}

template <class Real>
void GuideCurve<Real>::evaluate_at(double angle_deg, std::size_t channel, std::span<Real> values) const {
  if (positions_.size() < 2) {
    std::copy_n(values_.data() + channel, values.size(), values.data());
    return;
  }
  const double angle = std::clamp(angle_deg, positions_.front(), positions_.back());
  const auto after = std::upper_bound(positions_.begin() + 1, positions_.end() - 1, angle);
  const auto left = static_cast<std::size_t>(after - positions_.begin()) - 1;
  const double width = positions_[left + 1] - positions_[left];
  const Real t = static_cast<Real>((angle - positions_[left]) / width);
  const Real sixth = static_cast<Real>(width * width / 6);
  for (std::size_t c = 0; c < values.size(); ++c) {
    const std::size_t k = left * channels_ + channel + c;
    values[c] = evaluate_segment(t, sixth, values_[k], values_[k + channels_], second_[k], second_[k + channels_]);
  }
}

template <class Real>
ValueMap<Real>::ValueMap(const SlicedBrdf& sliced, const Lattice& lattice) : guided_(sliced.guide.has_value()) {
  const std::size_t channels = sliced.channel_count();
  const std::vector<ValueRange> ranges = value_ranges(sliced);
  for (std::size_t c = 0; c < channels; ++c) {
    maps_.emplace_back(sliced.domain, c);
    const float largest = std::max(std::abs(ranges[c].least), std::abs(ranges[c].most));
    const float most = std::min(largest, std::numeric_limits<float>::max() / kHeadroom) * kHeadroom;
    most_.push_back(static_cast<Real>(most));
    least_.push_back(ranges[c].least < 0 ? -most_.back() : Real(0));
  }
  if (guided_) guide_ = GuideCurve<Real>(*sliced.guide, lattice.nodes[kVertical], sliced.channel_count());
}

// Slices hold v(f) - g. Splines and the sum R of Section 7 are linear in what they are given (but for its bounds), so
// what comes back at a point is R(v - g) + g = R(v) + (g - R(g)): the error that R makes on the peak of g is taken out.
template <class Real>
void ValueMap<Real>::forward(const Coordinates& x, std::span<const float> f, std::span<Real> residual) const {
  std::fill(residual.begin(), residual.end(), Real(0));
  if (guided_) guide_.evaluate(x, 0, residual);
  for (std::size_t c = 0; c < maps_.size(); ++c) residual[c] = maps_[c].forward(static_cast<Real>(f[c])) - residual[c];
}

template <class Real>
void ValueMap<Real>::forward(const Slice& slice, const SliceSamples& samples, std::vector<Real>& residuals) const {
  residuals.resize(samples.values.size());
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const std::size_t row = s * maps_.size();
    forward(coordinates_on(slice, samples.positions_deg[s]), std::span(samples.values).subspan(row, maps_.size()),
            std::span(residuals).subspan(row, maps_.size()));
  }
}

template <class Real>
void ValueMap<Real>::inverse(const Coordinates& x, std::size_t channel, std::span<Real> values) const {
  assert(values.size() <= kMostChannels && channel + values.size() <= maps_.size());
  if (guided_) {
    std::array<Real, kMostChannels> guide;
    guide_.evaluate(x, channel, std::span(guide).first(values.size()));
    for (std::size_t c = 0; c < values.size(); ++c) values[c] += guide[c];
  }
  for (std::size_t c = 0; c < values.size(); ++c) {
    values[c] = std::clamp(maps_[channel + c].inverse(values[c]), least_[channel + c], most_[channel + c]);
  }
}

template class GuideCurve<float>;
template class GuideCurve<double>;
template class GuideCurve<long double>;
template class ValueMap<float>;
template class ValueMap<double>;
template class ValueMap<long double>;

}  // namespace sbrdf::internal
