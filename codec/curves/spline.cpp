#include "codec/curves/spline.h"

namespace sbrdf::internal {

// Between two samples the second derivative runs straight from M_k to M_(k+1), so the curve and its slope follow from
// the values and the M. With the gaps h_k = x_(k+1) - x_k and the slopes d_k = (y_(k+1) - y_k) / h_k of the straight
// lines between samples, the curve begins and ends a gap with the slopes
//
//   d_k - h_k (2 M_k + M_(k+1)) / 6        and        d_k + h_k (M_k + 2 M_(k+1)) / 6
//
// The slope is continuous at x_k where the end of gap k - 1 and the beginning of gap k agree:
//
//   h_(k-1) M_(k-1) + 2 (h_(k-1) + h_k) M_k + h_k M_(k+1) = 6 (d_k - d_(k-1))
//
// One equation for each sample within the slice; the boundary gives those of the ends.

template <class Real>
Real SplineSolver<Real>::Samples::gap(std::size_t k) const {
  return k + 1 < size() ? static_cast<Real>(positions[k + 1]) - static_cast<Real>(positions[k])
                        : static_cast<Real>(positions[0]) + static_cast<Real>(length) - static_cast<Real>(positions[k]);
}

template <class Real>
Real SplineSolver<Real>::Samples::slope(std::size_t k) const {
  const std::size_t next = k + 1 < size() ? k + 1 : 0;
  return (values[next * stride] - values[k * stride]) / gap(k);
}

template <class Real>
void SplineSolver<Real>::solve(Boundary boundary, double length, std::span<const double> positions, const Real* values,
                               Real* second, std::size_t stride) {
  const Samples samples = {boundary, length, positions, values, stride};
  const std::size_t n = positions.size();
  for (std::size_t k = 0; k < n; ++k) second[k * stride] = 0;
  if (n < 2 || (n == 2 && boundary == Boundary::kBounded)) return;
  if (boundary == Boundary::kPeriodic && n == 2) {
    // Both neighbours of a sample are the other one, so that lower and upper entry fall together and the matrix is
    // (2 1; 1 2) (h_0 + h_1). Its solution: M_0 = -M_1 = 6 (d_0 - d_1) / (h_0 + h_1).
    second[0] = 6 * (samples.slope(0) - samples.slope(1)) / (samples.gap(0) + samples.gap(1));
    second[stride] = -second[0];
    return;
  }
  set_up(samples);
  if (boundary == Boundary::kPeriodic) {
    solve_cyclic(n, lower_[0]);
  } else {
    solve_tridiagonal(n, right_);
  }
  for (std::size_t k = 0; k < n; ++k) second[k * stride] = right_[k];
}

// Periodic: the neighbour before the first sample is the last one, and the other way round, so all equations are alike
// and two entries stand in the corners of the matrix:
//
//   ( 2 (h_(n-1) + h_0)   h_0                                     h_(n-1)             )
//   ( h_0                 2 (h_0 + h_1)   h_1                                         )
//   (                     h_1             ...                     h_(n-2)             )
//   ( h_(n-1)                             h_(n-2)                 2 (h_(n-2) + h_(n-1)) )
//
// lower_[0] and upper_[n - 1] hold the corners, which are equal.
template <class Real>
void SplineSolver<Real>::set_up(const Samples& samples) {
  const std::size_t n = samples.size();
  lower_.assign(n, 0);
  diagonal_.assign(n, 1);
  upper_.assign(n, 0);
  right_.assign(n, 0);
  for (std::size_t k = 0; k < n; ++k) {
    const bool at_end = k == 0 || k + 1 == n;
    if (at_end && samples.boundary != Boundary::kPeriodic) {
      set_up_end(samples, k);
      continue;
    }
    const std::size_t before = k == 0 ? n - 1 : k - 1;
    lower_[k] = samples.gap(before);
    upper_[k] = samples.gap(k);
    diagonal_[k] = 2 * (samples.gap(before) + samples.gap(k));
    right_[k] = 6 * (samples.slope(k) - samples.slope(before));
  }
}

// Bounded: the second derivative is constant over the first gap, M_0 - M_1 = 0, and over the last. No third derivative
// there makes the ends parabolas, which needs no slope to be known.
//
// Mirrored: the function is even about its ends, so the slope there is 0: 2 h_0 M_0 + h_0 M_1 = 6 d_0 at the start, and
// h_(n-2) M_(n-2) + 2 h_(n-2) M_(n-1) = -6 d_(n-2) at the end.
template <class Real>
void SplineSolver<Real>::set_up_end(const Samples& samples, std::size_t k) {
  const bool first = k == 0;
  Real& inwards = first ? upper_[k] : lower_[k];
  if (samples.boundary == Boundary::kBounded) {
    inwards = -1;
    return;
  }
  const std::size_t interval = first ? 0 : k - 1;
  diagonal_[k] = 2 * samples.gap(interval);
  inwards = samples.gap(interval);
  right_[k] = 6 * (first ? samples.slope(0) : -samples.slope(interval));
}

// Sherman-Morrison. With both corner entries b and any g (here minus the first entry of the diagonal, so that nothing
// cancels), the matrix is T + u w^T, where u = (g, 0, ..., 0, b), w = (1, 0, ..., 0, b / g), and T is tridiagonal: the
// same without its corners, and g taken off its first, b^2 / g off its last diagonal entry. From T z = r and T q = u:
//
//   M = z - q (w . z) / (1 + w . q)
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

// Thomas' algorithm: elimination from above, then substitution from below. Stable without exchanging rows, since the
// matrices are diagonally dominant: 2 (h + h') against h + h' within a slice, 2 h against h at a mirror; the bounded
// one is after its first step, which adds h_0 to the second diagonal entry.
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

}  // namespace sbrdf::internal
