#include "codec/curves/slope_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sbrdf::internal {
namespace {

constexpr double kSlack = 0.1;     // of the range of the four samples around a gap, beyond what is allowed anyway
constexpr double kSteepest = 3.0;  // times the straight line: a cubic within that has no turning point

/// The samples of a slice as its gaps see them: with what lies beyond the ends.
template <class Real>
class Gaps {
 public:
  Gaps(Boundary boundary, double length, std::span<const double> positions, const Real* values, std::size_t stride)
      : boundary_(boundary), count_(positions.size() - (boundary == Boundary::kPeriodic ? 0 : 1)) {
    const std::size_t n = positions.size();
    for (std::size_t k = 0; k < count_; ++k) {
      const double next = k + 1 < n ? positions[k + 1] : positions[0] + length;
      widths_.push_back(static_cast<Real>(next) - static_cast<Real>(positions[k]));
      lines_.push_back((values[(k + 1) % n * stride] - values[k * stride]) / widths_[k]);
    }
  }

  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] Real width(std::size_t k) const { return widths_[k]; }
  /// Slope of the straight line over gap k.
  [[nodiscard]] Real line(std::size_t k) const { return lines_[k]; }

  /// The gap before gap k (side 0) or behind it (side 1): its straight line and width. Beyond the end of a bounded
  /// slice the line of gap k itself goes on.
  struct Beside {
    Real line;
    Real width;
  };
  [[nodiscard]] Beside beside(std::size_t k, int side) const {
    const bool at_end = side == 0 ? k == 0 : k + 1 == count_;
    if (!at_end || boundary_ == Boundary::kPeriodic) {
      const std::size_t other = side == 0 ? (k == 0 ? count_ - 1 : k - 1) : (k + 1 == count_ ? 0 : k + 1);
      return {lines_[other], widths_[other]};
    }
    return {boundary_ == Boundary::kMirrored ? -lines_[k] : lines_[k], widths_[k]};
  }

 private:
  Boundary boundary_;
  std::size_t count_;
  std::vector<Real> widths_;
  std::vector<Real> lines_;
};

/// One gap with its neighbours: values less that of its left end, positions less that of its left end.
template <class Real>
struct Surroundings {
  Real width, line, before, behind;  // the straight lines before, within and behind
  Real least, most;                  // of the four samples

  Surroundings(const Gaps<Real>& gaps, std::size_t k) : width(gaps.width(k)), line(gaps.line(k)) {
    const auto left = gaps.beside(k, 0);
    const auto right = gaps.beside(k, 1);
    before = left.line;
    behind = right.line;
    const std::array<Real, 4> samples = {-left.line * left.width, Real(0), line * width,
                                         line * width + right.line * right.width};
    least = *std::min_element(samples.begin(), samples.end());
    most = *std::max_element(samples.begin(), samples.end());
  }

  struct Range {
    Real least, most;
    [[nodiscard]] Real nearest(Real value) const { return std::clamp(value, least, most); }
  };
  struct Ranges {
    Range slope0, slope1;
  };

  // With slopes in these ranges the cubic leaves no more than the slack: with p = m_0 - line and q = line - m_1 it is
  // s t w (s p + t q) above its line, so that kSlack of the range is reached by 4 kSlack range / w more on both slopes.
  // Without that it stays between the values at its ends or, on a crest, below the lines on both sides, which are
  // a t w and b s w above its own, a = before - line and b = line - behind: no less if p <= min(a, 2 b) and
  // q <= min(b, 2 a). A trough is the same turned over. What two gaps allow at the sample between them always overlaps:
  // in 0, or in one of their lines.
  [[nodiscard]] Ranges ranges() const {
    const Real from_behind = line + 2 * (line - behind);
    const Real from_before = line - 2 * (before - line);
    if (before > line && line > behind) {
      return {around(line, std::max(Real(0), std::min(before, from_behind))),
              around(line, std::min(Real(0), std::max(behind, from_before)))};
    }
    if (before < line && line < behind) {
      return {around(line, std::min(Real(0), std::max(before, from_behind))),
              around(line, std::max(Real(0), std::min(behind, from_before)))};
    }
    const Range rising = around(Real(0), static_cast<Real>(kSteepest) * line);
    return {rising, rising};
  }

  // Whether the cubic with these slopes leaves what is allowed anywhere. It is furthest out where its slope is zero.
  [[nodiscard]] bool leaves(Real slope0, Real slope1) const {
    // y'(t) width = w m_0 + 2 b t + 3 a t^2
    const Real d = line * width;
    const Real a = width * (slope0 + slope1) - 2 * d;
    const Real b = 3 * d - width * (2 * slope0 + slope1);
    const Real root = b * b - 3 * a * width * slope0;
    if (!(root >= 0)) return false;
    const Real q = -(b + std::copysign(std::sqrt(root), b));
    return beyond(q / (3 * a), slope0, slope1) || beyond(width * slope0 / q, slope0, slope1);
  }

 private:
  [[nodiscard]] Range around(Real a, Real b) const {
    const Real more = static_cast<Real>(4 * kSlack) * (most - least) / width;
    return {std::min(a, b) - more, std::max(a, b) + more};
  }

  [[nodiscard]] bool beyond(Real t, Real slope0, Real slope1) const {
    if (!(t > 0 && t < 1)) return false;
    const Real d = line * width;
    const Real y = evaluate_cubic(t, width, Real(0), d, slope0, slope1);
    const Real from_left = before * t * width;  // both lines through the samples beside, at t
    const Real from_right = d - behind * (1 - t) * width;
    const Real slack = static_cast<Real>(kSlack) * (most - least);
    const Real high = std::max({Real(0), d, std::min(from_left, from_right)}) + slack;
    const Real low = std::min({Real(0), d, std::max(from_left, from_right)}) - slack;
    return y > high || y < low;
  }
};

// Brings the slopes of every gap that leaves what is allowed into its ranges. A slope that was cut may let the gap on
// its other side swing out, so that the rest is tried again; a gap that was cut once stays within its ranges.
template <class Real>
void limit(const Gaps<Real>& gaps, std::vector<Real>& slopes) {
  std::vector<bool> cut(gaps.size());
  for (bool again = true; again;) {
    again = false;
    const std::vector<Real> tried = slopes;
    for (std::size_t k = 0; k < gaps.size(); ++k) {
      const std::size_t next = (k + 1) % slopes.size();
      const Surroundings<Real> here(gaps, k);
      if (cut[k] || !here.leaves(tried[k], tried[next])) continue;
      cut[k] = again = true;
      slopes[k] = here.ranges().slope0.nearest(slopes[k]);
      slopes[next] = here.ranges().slope1.nearest(slopes[next]);
    }
  }
}

template <class Real>
std::vector<Real> spline_slopes(const Gaps<Real>& gaps, std::size_t n, const Real* second, std::size_t stride) {
  std::vector<Real> slopes;
  slopes.reserve(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Real at = second[k * stride];
    if (k < gaps.size()) {
      slopes.push_back(gaps.line(k) - gaps.width(k) * (2 * at + second[(k + 1) % n * stride]) / 6);
    } else {
      slopes.push_back(gaps.line(k - 1) + gaps.width(k - 1) * (second[(k - 1) * stride] + 2 * at) / 6);
    }
  }
  return slopes;
}

template <class Real>
void second_to_slopes(Boundary boundary, double length, std::span<const double> positions, const Real* values,
                      Real* second, std::size_t stride, bool limited) {
  const std::size_t n = positions.size();
  if (n < 2) {
    for (std::size_t k = 0; k < n; ++k) second[k * stride] = 0;
    return;
  }
  const Gaps<Real> gaps(boundary, length, positions, values, stride);
  std::vector<Real> slopes = spline_slopes(gaps, n, second, stride);
  if (limited) limit(gaps, slopes);
  for (std::size_t k = 0; k < n; ++k) second[k * stride] = slopes[k];
}

}  // namespace

template <class Real>
void slopes_within_limits(Boundary boundary, double length, std::span<const double> positions, const Real* values,
                          Real* second, std::size_t stride) {
  second_to_slopes(boundary, length, positions, values, second, stride, true);
}

void slopes_of_spline(Boundary boundary, double length, std::span<const double> positions, const double* values,
                      double* second, std::size_t stride) {
  second_to_slopes(boundary, length, positions, values, second, stride, false);
}

template void slopes_within_limits(Boundary, double, std::span<const double>, const double*, double*, std::size_t);
template void slopes_within_limits(Boundary, double, std::span<const double>, const long double*, long double*,
                                   std::size_t);

}  // namespace sbrdf::internal
