#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "codec/frame/lattice.h"

namespace sbrdf::internal {

/// The C2 cubic spline through samples, found by Gaussian elimination over the four coefficients of every segment at
/// once: each condition of its definition is one row.
class DenseSpline {
 public:
  DenseSpline(Boundary boundary, long double length, std::vector<long double> positions,
              std::vector<long double> values)
      : positions_(std::move(positions)), constant_(values.front()) {
    if (boundary == Boundary::kPeriodic) {
      positions_.push_back(positions_.front() + length);
      values.push_back(values.front());
    }
    segments_ = positions_.size() - 1;
    if (segments_ == 0) return;
    for (std::size_t k = 0; k < segments_; ++k) {
      row({{at(k, 0), 1}}, values[k]);
      row({{at(k, 0), 1}, {at(k, 1), 1}, {at(k, 2), 1}, {at(k, 3), 1}}, values[k + 1]);
      if (k + 1 < segments_) join(k, k + 1);
    }
    const std::size_t last = segments_ - 1;
    switch (boundary) {
      case Boundary::kPeriodic:
        join(last, 0);
        break;
      case Boundary::kMirrored:
        row({{at(0, 1), 1}}, 0);
        row({{at(last, 1), 1}, {at(last, 2), 2}, {at(last, 3), 3}}, 0);
        break;
      case Boundary::kBounded:
        row({{at(0, 3), 1}}, 0);
        row({{at(last, segments_ == 1 ? 2U : 3U), 1}}, 0);
        break;
    }
    eliminate();
  }

  /// The value, or its first or second derivative, where `position` lies between the first and the last sample.
  long double operator()(long double position, int derivative = 0) const {
    if (segments_ == 0) return derivative == 0 ? constant_ : 0;
    const auto after = std::upper_bound(positions_.begin() + 1, positions_.end() - 1, position);
    const auto k = static_cast<std::size_t>(after - positions_.begin()) - 1;
    const long double h = width(k);
    const long double t = (position - positions_[k]) / h;
    const long double b = rows_[at(k, 1)].back();
    const long double c = rows_[at(k, 2)].back();
    const long double d = rows_[at(k, 3)].back();
    if (derivative == 1) return (b + t * (2 * c + t * 3 * d)) / h;
    if (derivative == 2) return (2 * c + t * 6 * d) / (h * h);
    return rows_[at(k, 0)].back() + t * (b + t * (c + t * d));
  }

 private:
  using Term = std::pair<std::size_t, long double>;

  static std::size_t at(std::size_t segment, std::size_t power) { return 4 * segment + power; }
  [[nodiscard]] long double width(std::size_t k) const { return positions_[k + 1] - positions_[k]; }

  void row(const std::vector<Term>& terms, long double right) {
    std::vector<long double> row(4 * segments_ + 1);
    for (const auto& [column, factor] : terms) row[column] += factor;
    row.back() = right;
    rows_.push_back(std::move(row));
  }

  void join(std::size_t a, std::size_t b) {
    const long double h = width(a);
    const long double g = width(b);
    row({{at(a, 1), 1 / h}, {at(a, 2), 2 / h}, {at(a, 3), 3 / h}, {at(b, 1), -1 / g}}, 0);
    row({{at(a, 2), 2 / (h * h)}, {at(a, 3), 6 / (h * h)}, {at(b, 2), -2 / (g * g)}}, 0);
  }

  void eliminate() {
    const std::size_t n = rows_.size();
    for (std::size_t column = 0; column < n; ++column) {
      const auto larger = [&](const auto& a, const auto& b) { return std::abs(a[column]) < std::abs(b[column]); };
      const auto pivot = rows_.begin() + static_cast<std::ptrdiff_t>(column);
      std::swap(*pivot, *std::max_element(pivot, rows_.end(), larger));
      const long double scale = 1 / (*pivot)[column];
      for (long double& entry : *pivot) entry *= scale;
      for (std::size_t k = 0; k < n; ++k) {
        const long double factor = rows_[k][column];
        if (k == column || factor == 0) continue;
        for (std::size_t entry = column; entry <= n; ++entry) rows_[k][entry] -= factor * (*pivot)[entry];
      }
    }
  }

  std::vector<long double> positions_;
  long double constant_;
  std::size_t segments_ = 0;
  std::vector<std::vector<long double>> rows_;
};

}  // namespace sbrdf::internal
