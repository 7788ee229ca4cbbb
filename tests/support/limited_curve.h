#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "tests/support/dense_spline.h"

namespace sbrdf::internal {

/// The curve through samples of a slice as specs/conventions.md words it: the spline, and where it swings too far out,
/// cubics with slopes cut down. In long double, from Hermite's basis, without regard to speed.
class LimitedCurve {
 public:
  LimitedCurve(Boundary boundary, long double length, std::vector<long double> positions,
               std::vector<long double> values)
      : positions_(positions), values_(values) {
    const std::size_t n = positions.size();
    const DenseSpline spline(boundary, length, positions, values);
    for (const long double x : positions) slopes_.push_back(spline(x, 1));
    if (n < 2) return;
    // One more sample on either side.
    std::vector<long double> x = positions;
    std::vector<long double> y = values;
    if (boundary == Boundary::kPeriodic) {
      x.push_back(x.front() + length), y.push_back(y.front());
      positions_ = x, values_ = y;
      x.push_back(positions[1] + length), y.push_back(values[1]);
      x.insert(x.begin(), positions[n - 1] - length), y.insert(y.begin(), values[n - 1]);
    } else {
      const long double sign = boundary == Boundary::kMirrored ? 1 : -1;  // even, or straight on
      const auto beyond = [&](std::size_t end, std::size_t inner) {
        return std::pair(2 * positions[end] - positions[inner],
                         sign > 0 ? values[inner] : 2 * values[end] - values[inner]);
      };
      const auto before = beyond(0, 1);
      const auto behind = beyond(n - 1, n - 2);
      x.insert(x.begin(), before.first), y.insert(y.begin(), before.second);
      x.push_back(behind.first), y.push_back(behind.second);
    }
    std::vector<bool> failed(positions_.size() - 1);
    while (true) {
      const std::vector<long double> given = slopes_;
      const std::vector<bool> failed_before = failed;
      for (std::size_t k = 0; k < failed.size(); ++k) {
        if (failed[k] || !leaves(&x[k], &y[k], given[k], given[(k + 1) % n])) continue;
        failed[k] = true;
        bring_into_ranges(&x[k], &y[k], slopes_[k], slopes_[(k + 1) % n]);
      }
      if (failed == failed_before) break;
    }
  }

  long double operator()(long double at) const {
    if (positions_.size() < 2) return values_.front();
    const auto after = std::upper_bound(positions_.begin() + 1, positions_.end() - 1, at);
    const auto k = static_cast<std::size_t>(after - positions_.begin()) - 1;
    const long double h = positions_[k + 1] - positions_[k];
    return hermite((at - positions_[k]) / h, h, values_[k], values_[k + 1], slopes_[k],
                   slopes_[(k + 1) % slopes_.size()]);
  }

 private:
  static long double hermite(long double t, long double h, long double y0, long double y1, long double m0,
                             long double m1) {
    return (1 + 2 * t) * (1 - t) * (1 - t) * y0 + t * (1 - t) * (1 - t) * h * m0 + t * t * (3 - 2 * t) * y1 +
           t * t * (t - 1) * h * m1;
  }

  /// x and y, here and below: the sample before the gap, its two ends, the sample behind it.
  static bool leaves(const long double* x, const long double* y, long double m0, long double m1) {
    const auto line = [&](int j) { return (y[j + 1] - y[j]) / (x[j + 1] - x[j]); };
    const long double h = x[2] - x[1];
    const long double slack = (*std::max_element(y, y + 4) - *std::min_element(y, y + 4)) / 10;
    bool found = false;
    const auto look = [&](long double t) {
      if (!(t > 0 && t < 1)) return;
      const long double here = hermite(t, h, y[1], y[2], m0, m1);
      const long double left = y[1] + line(0) * t * h;
      const long double right = y[2] - line(2) * (1 - t) * h;
      found = found || here > std::max({y[1], y[2], std::min(left, right)}) + slack ||
              here < std::min({y[1], y[2], std::max(left, right)}) - slack;
    };
    // Where the slope is 0: a t^2 + b t + c.
    const long double a = 3 * h * (m0 + m1) - 6 * (y[2] - y[1]);
    const long double b = 6 * (y[2] - y[1]) - 4 * h * m0 - 2 * h * m1;
    const long double c = h * m0;
    const long double root = std::sqrt(b * b - 4 * a * c);
    look((-b + root) / (2 * a));
    look((-b - root) / (2 * a));
    look(2 * c / (-b + root));  // the same two, where a is 0
    look(2 * c / (-b - root));
    return found;
  }

  static void bring_into_ranges(const long double* x, const long double* y, long double& m0, long double& m1) {
    const long double before = (y[1] - y[0]) / (x[1] - x[0]);
    const long double d = (y[2] - y[1]) / (x[2] - x[1]);
    const long double behind = (y[3] - y[2]) / (x[3] - x[2]);
    long double low0 = 0, high0 = 3 * d, low1 = 0, high1 = 3 * d;
    if (d < 0) std::swap(low0, high0), std::swap(low1, high1);
    if (before > d && d > behind) {  // crest
      low0 = d;
      high0 = std::max(0.0L, std::min(before, 3 * d - 2 * behind));
      low1 = std::min(0.0L, std::max(behind, 3 * d - 2 * before));
      high1 = d;
    }
    if (before < d && d < behind) {  // trough
      low0 = std::min(0.0L, std::max(before, 3 * d - 2 * behind));
      high0 = d;
      low1 = d;
      high1 = std::max(0.0L, std::min(behind, 3 * d - 2 * before));
    }
    const long double beyond = 0.4L * (*std::max_element(y, y + 4) - *std::min_element(y, y + 4)) / (x[2] - x[1]);
    m0 = std::max(low0 - beyond, std::min(m0, high0 + beyond));
    m1 = std::max(low1 - beyond, std::min(m1, high1 + beyond));
  }

  std::vector<long double> positions_;
  std::vector<long double> values_;
  std::vector<long double> slopes_;
};

}  // namespace sbrdf::internal
