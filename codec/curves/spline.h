#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "codec/frame/lattice.h"

namespace sbrdf::internal {

/// Solves for the second derivatives M_k of the C2 cubic spline through samples (x_k, y_k) of one slice. Together with
/// the samples they are all of the spline: see evaluate_segment. Takes time in proportion to the number of samples, and
/// keeps its working memory between calls, so one object serves one thread. Real is the arithmetic: double for use,
/// long double for judging it.
template <class Real>
class SplineSolver {
 public:
  /// `positions` [degrees] rise strictly and do not repeat the first sample of a periodic slice; `length` is the period
  /// there, and unused otherwise.
  /// `values[k * stride]` belongs to positions[k]; the second derivative [value per position unit squared] goes to
  /// `second[k * stride]`. Beyond the ends: periodic, or even (zero slope), or, for a bounded slice, a second
  /// derivative that is constant over the first and the last interval (specs/conventions.md). One sample is a constant;
  /// two on a bounded slice are a straight line.
  void solve(Boundary boundary, double length, std::span<const double> positions, const Real* values, Real* second,
             std::size_t stride);

 private:
  /// The samples as the equations see them.
  struct Samples {
    Boundary boundary;
    double length;
    std::span<const double> positions;
    const Real* values;
    std::size_t stride;

    [[nodiscard]] std::size_t size() const { return positions.size(); }
    /// h_k, from sample k to the next; of the last one to the first a period later.
    [[nodiscard]] Real gap(std::size_t k) const;
    /// d_k, of the straight line over that gap.
    [[nodiscard]] Real slope(std::size_t k) const;
  };

  void set_up(const Samples& samples);
  void set_up_end(const Samples& samples, std::size_t k);
  void solve_cyclic(std::size_t n, Real corner);
  void solve_tridiagonal(std::size_t n, std::vector<Real>& right);

  std::vector<Real> lower_, diagonal_, upper_, right_;  ///< of each equation; right_ becomes the solution
  std::vector<Real> unit_, factor_;
};

extern template class SplineSolver<double>;
extern template class SplineSolver<long double>;

/// Linear interpolation that is exact at both ends, and everywhere between equal values.
template <class Real>
[[nodiscard]] Real mix(Real t, Real a, Real b) {
  return t < Real(0.5) ? a + t * (b - a) : b - (Real(1) - t) * (b - a);
}

/// One segment between neighbouring samples. `t` in [0, 1] is the fraction of the way from the first to the second,
/// `sixth` is (distance between them)^2 / 6. With s = 1 - t:
///
///   y(t) = s y_0 + t y_1 - s t sixth ((1 + s) M_0 + (1 + t) M_1)
///
/// which is the only cubic with the values y and the second derivatives M at its ends. Exact at the ends, and
/// everywhere when both values are the same and both second derivatives are zero.
template <class Real>
[[nodiscard]] Real evaluate_segment(Real t, Real sixth, Real value0, Real value1, Real second0, Real second1) {
  const Real s = Real(1) - t;
  return mix(t, value0, value1) - s * t * sixth * ((Real(1) + s) * second0 + (Real(1) + t) * second1);
}

}  // namespace sbrdf::internal
