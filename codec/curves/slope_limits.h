#pragma once

#include <cstddef>
#include <span>

#include "codec/frame/lattice.h"

namespace sbrdf::internal {

/// Makes the second derivatives of a slice's spline (see SplineSolver, whose arguments these are) slopes at its
/// samples, and sees to it that the curve with these slopes stays near its samples: where it is steep beside a plateau,
/// a spline swings far beyond both, and the exponential of the log domain makes that a false highlight.
///
/// The curve may leave the values at the two ends of a gap as far as the straight lines through the samples on either
/// side allow, both of them: a crest whose slope falls all the way, or a trough, is left whole. To this comes a
/// tenth of the range of the four samples around. Where the spline leaves more, the slopes at both ends of the gap
/// are brought to the nearest that keep the curve within this, whatever the samples: about the sign of the gap's
/// straight line and at most three times as steep, where the crest or trough is real what keeps it below the lines on
/// both sides. That is tried again with the slopes found, until no gap leaves what it may. Other slopes stay those of
/// the spline, so that smooth data lose nothing.
///
/// `second[k * stride]` becomes the slope [value per degree] at positions[k].
template <class Real>
void slopes_within_limits(Boundary boundary, double length, std::span<const double> positions, const Real* values,
                          Real* second, std::size_t stride);

extern template void slopes_within_limits(Boundary, double, std::span<const double>, const double*, double*,
                                          std::size_t);
extern template void slopes_within_limits(Boundary, double, std::span<const double>, const long double*, long double*,
                                          std::size_t);

/// Makes second derivatives the slopes that the spline itself has at its samples, whatever it does between them.
void slopes_of_spline(Boundary boundary, double length, std::span<const double> positions, const double* values,
                      double* second, std::size_t stride);

/// The cubic between neighbouring samples with these values and slopes at its ends, `width` [degrees] apart; `t` in [0,
/// 1] is the fraction of the way. With s = 1 - t and D = y_1 - y_0:
///
///   y(t) = y_0 + t D + s t (s (width m_0 - D) + t (D - width m_1))
///
/// Exact at the ends, and everywhere when both values are the same and both slopes are zero.
template <class Real>
[[nodiscard]] Real evaluate_cubic(Real t, Real width, Real value0, Real value1, Real slope0, Real slope1) {
  const Real s = Real(1) - t;
  const Real difference = value1 - value0;
  const Real straight = t < Real(0.5) ? value0 + t * difference : value1 - s * difference;
  return straight + s * t * (s * (width * slope0 - difference) + t * (difference - width * slope1));
}

}  // namespace sbrdf::internal
