#include "codec/material/spline.h"

namespace sbrdf {

template <class Real>
void SplineSolver<Real>::solve(Boundary boundary, double length, std::span<const double> positions, const Real* values,
                               Real* second, std::size_t stride) {
  const std::size_t n = positions.size();
  const bool periodic = boundary == Boundary::kPeriodic;
  for (std::size_t k = 0; k < n; ++k) second[k * stride] = 0;
  if (n < 2 || (n == 2 && boundary == Boundary::kBounded)) return;
  const auto gap = [&](std::size_t k) {
    return k + 1 < n ? static_cast<Real>(positions[k + 1]) - static_cast<Real>(positions[k])
                     : static_cast<Real>(positions[0]) + static_cast<Real>(length) - static_cast<Real>(positions[k]);
  };
  const auto slope = [&](std::size_t k) {
    const std::size_t next = k + 1 < n ? k + 1 : 0;
    return (values[next * stride] - values[k * stride]) / gap(k);
  };
  if (periodic && n == 2) {
    // Both neighbours of a sample are the other one: M0 = -M1 = 6 (slope0 - slope1) / (h0 + h1).
    second[0] = 6 * (slope(0) - slope(1)) / (gap(0) + gap(1));
    second[stride] = -second[0];
    return;
  }
  lower_.assign(n, 0);
  diagonal_.assign(n, 1);
  upper_.assign(n, 0);
  right_.assign(n, 0);
  for (std::size_t k = 0; k < n; ++k) {
    const bool first = k == 0;
    const bool last = k + 1 == n;
    if (boundary == Boundary::kBounded && (first || last)) {
      (first ? upper_ : lower_)[k] = -1;
    } else if (boundary == Boundary::kMirrored && (first || last)) {
      const std::size_t interval = first ? 0 : k - 1;
      diagonal_[k] = 2 * gap(interval);
      (first ? upper_ : lower_)[k] = gap(interval);
      right_[k] = 6 * (first ? slope(0) : -slope(interval));
    } else {
      const std::size_t before = first ? n - 1 : k - 1;
      lower_[k] = gap(before);
      upper_[k] = gap(k);
      diagonal_[k] = 2 * (gap(before) + gap(k));
      right_[k] = 6 * (slope(k) - slope(before));
    }
  }
  if (periodic) {
    solve_cyclic(n, lower_[0]);
  } else {
    solve_tridiagonal(n, right_);
  }
  for (std::size_t k = 0; k < n; ++k) second[k * stride] = right_[k];
}

// Sherman-Morrison: the two corner entries, both `corner`, are a rank-one change of a tridiagonal matrix.
template <class Real>
void SplineSolver<Real>::solve_cyclic(std::size_t n, Real corner) {
  const Real gamma = -diagonal_[0];
  diagonal_[0] -= gamma;
  diagonal_[n - 1] -= corner * corner / gamma;
  unit_.assign(n, 0);
  unit_[0] = gamma;
  unit_[n - 1] = corner;
  solve_tridiagonal(n, right_);
  solve_tridiagonal(n, unit_);
  const Real ratio = corner / gamma;
  const Real scale = (right_[0] + ratio * right_[n - 1]) / (1 + unit_[0] + ratio * unit_[n - 1]);
  for (std::size_t k = 0; k < n; ++k) right_[k] -= scale * unit_[k];
}

// Thomas' algorithm; the matrices here are diagonally dominant, the bounded one after its first step.
template <class Real>
void SplineSolver<Real>::solve_tridiagonal(std::size_t n, std::vector<Real>& right) {
  factor_.assign(n, 0);
  Real pivot = diagonal_[0];
  right[0] /= pivot;
  for (std::size_t k = 1; k < n; ++k) {
    factor_[k] = upper_[k - 1] / pivot;
    pivot = diagonal_[k] - lower_[k] * factor_[k];
    right[k] = (right[k] - lower_[k] * right[k - 1]) / pivot;
  }
  for (std::size_t k = n - 1; k-- > 0;) right[k] -= factor_[k + 1] * right[k + 1];
}

template class SplineSolver<double>;
template class SplineSolver<long double>;

}  // namespace sbrdf
