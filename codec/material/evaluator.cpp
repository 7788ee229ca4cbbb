#include "codec/material/evaluator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "codec/material/slice_samples.h"
#include "codec/material/spline.h"

namespace sbrdf {

template <class Real>
BasicEvaluator<Real>::BasicEvaluator(const SlicedBrdf& sliced, const Lattice& lattice)
    : frame_(geometry(lattice.spec.id)),
      channels_(sliced.channel_count()),
      clamp_above_(sliced.domain.kind == DomainKind::kLog),
      nodes_(lattice.nodes),
      corners_(lattice.corners),
      corner_strides_(lattice.corner_strides),
      lines_(lattice.lines),
      line_strides_(lattice.line_strides) {
  map_ = ValueMap<Real>(sliced, lattice);
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const double extent = nodes_[axis].back();
    cells_per_degree_[axis] = extent > 0 ? static_cast<double>(nodes_[axis].size() - 1) / extent : 0;
  }
  const ValueMap<Wide> map(sliced, lattice);
  add_corners(sliced, lattice, map);
  add_curves(sliced, lattice, map);
}

template <class Real>
void BasicEvaluator<Real>::add_corners(const SlicedBrdf& sliced, const Lattice& lattice, const ValueMap<Wide>& map) {
  std::vector<Wide> residual(channels_);
  for (std::size_t k = 0; k < lattice.crossings.size(); ++k) {
    map.forward(lattice.crossings[k], std::span(sliced.crossing_values).subspan(k * channels_, channels_), residual);
    for (const Wide v : residual) corner_values_.push_back(static_cast<Real>(v));
  }
}

template <class Real>
void BasicEvaluator<Real>::add_curves(const SlicedBrdf& sliced, const Lattice& lattice, const ValueMap<Wide>& map) {
  const std::vector<SliceSamples> slices = gather_slices(sliced, lattice);
  SplineSolver<Wide> solver;
  std::vector<Wide> values;
  std::vector<Wide> second;
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const Slice& slice = lattice.slices[k];
    const std::size_t n = slices[k].size();
    values.resize(n * channels_);
    second.resize(n * channels_);
    for (std::size_t v = 0; v < n; ++v) {
      map.forward(coordinates_on(slice, slices[k].positions_deg[v]),
                  std::span(slices[k].values).subspan(v * channels_, channels_),
                  std::span(values).subspan(v * channels_, channels_));
    }
    for (std::size_t c = 0; c < channels_; ++c) {
      solver.solve(slice.boundary, slice.length_deg, slices[k].positions_deg, values.data() + c, second.data() + c,
                   channels_);
    }
    Curve curve;
    curve.boundary = slice.boundary;
    curve.start = slice.start_deg;
    curve.length = slice.length_deg;
    curve.first_knot = static_cast<std::uint32_t>(knots_.size());
    const std::size_t knots = slice.boundary == Boundary::kPeriodic ? n + 1 : n;
    for (std::size_t s = 0; s < knots; ++s) {
      const std::size_t sample = s % n;
      knots_.push_back(s < n ? slices[k].positions_deg[s] : slice.start_deg + slice.length_deg);
      for (std::size_t c = 0; c < channels_; ++c) {
        knot_values_.push_back(static_cast<Real>(values[sample * channels_ + c]));
      }
      for (std::size_t c = 0; c < channels_; ++c) {
        knot_values_.push_back(static_cast<Real>(second[sample * channels_ + c]));
      }
    }
    add_buckets(curve);
    curves_.push_back(curve);
  }
}

// About one bucket a segment, so that a look-up ends after a step or two wherever the samples crowd.
template <class Real>
void BasicEvaluator<Real>::add_buckets(Curve& curve) {
  const auto segments = static_cast<std::uint32_t>(knots_.size() - curve.first_knot - 1);
  curve.first_bucket = static_cast<std::uint32_t>(buckets_.size());
  curve.bucket_count = std::max(1U, segments);
  curve.buckets_per_degree = curve.bucket_count / curve.length;
  std::uint32_t segment = 0;
  for (std::uint32_t bucket = 0; bucket < curve.bucket_count; ++bucket) {
    const double from = curve.start + bucket / curve.buckets_per_degree;
    while (segment + 1 < segments && knots_[curve.first_knot + segment + 1] <= from) ++segment;
    buckets_.push_back(curve.first_knot + segment);
  }
}

template <class Real>
void BasicEvaluator<Real>::evaluate(const DirectionPair& pair, std::span<Real> values) const {
  evaluate_at(frame_.coordinates(pair), values);
}

template <class Real>
void BasicEvaluator<Real>::evaluate_at(const Coordinates& x, std::span<Real> values) const {
  const Cell cell = locate(x);
  std::size_t c = 0;
  for (; c + 3 <= channels_; c += 3) reconstruct<3>(cell, x, c, values.data() + c);
  for (; c < channels_; ++c) reconstruct<1>(cell, x, c, values.data() + c);
}

template <class Real>
typename BasicEvaluator<Real>::Cell BasicEvaluator<Real>::locate(const Coordinates& x) const {
  Cell cell;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const std::vector<double>& nodes = nodes_[axis];
    if (nodes.size() < 2) continue;
    // Written so that a NaN ends at the first node.
    const double clamped = x[axis] > nodes.front() ? std::min(x[axis], nodes.back()) : nodes.front();
    const auto last_cell = static_cast<std::uint32_t>(nodes.size() - 2);
    std::uint32_t index = std::min(static_cast<std::uint32_t>(clamped * cells_per_degree_[axis]), last_cell);
    while (index > 0 && nodes[index] > clamped) --index;
    while (index < last_cell && nodes[index + 1] <= clamped) ++index;
    cell.index[axis] = index;
    cell.fraction[axis] = static_cast<Real>((static_cast<Wide>(clamped) - nodes[index]) /
                                            (static_cast<Wide>(nodes[index + 1]) - nodes[index]));
  }
  return cell;
}

template <class Real>
template <std::size_t N>
void BasicEvaluator<Real>::along_line(const LineReference& reference, double x, std::size_t channel,
                                      Real* values) const {
  if (reference.is_constant()) {
    const Real* corner = corner_values_.data() + reference.crossing() * channels_ + channel;
    std::copy(corner, corner + N, values);
    return;
  }
  const Curve& curve = curves_[reference.target];
  double from_start = reference.sign * x + reference.offset_deg - curve.start;
  if (curve.boundary == Boundary::kBounded) {
    from_start = std::clamp(from_start, 0.0, curve.length);
  } else {
    const double period = curve.boundary == Boundary::kMirrored ? 2 * curve.length : curve.length;
    from_start -= period * std::floor(from_start / period);
    if (from_start > curve.length) from_start = std::max(0.0, period - from_start);
  }
  const std::uint32_t bucket =
      std::min(static_cast<std::uint32_t>(from_start * curve.buckets_per_degree), curve.bucket_count - 1);
  const double position = curve.start + from_start;
  std::uint32_t knot = buckets_[curve.first_bucket + bucket];
  while (knots_[knot] > position && knot > curve.first_knot) --knot;
  const double end = curve.start + curve.length;
  while (knots_[knot + 1] < position && knots_[knot + 1] < end) ++knot;
  const double width = knots_[knot + 1] - knots_[knot];
  const Real t = static_cast<Real>(std::clamp((position - knots_[knot]) / width, 0.0, 1.0));
  const Real sixth = static_cast<Real>(width * width / 6);
  const Real* left = knot_values_.data() + knot * 2 * channels_ + channel;
  const Real* right = left + 2 * channels_;
  for (std::size_t c = 0; c < N; ++c) {
    values[c] = evaluate_segment(t, sixth, left[c], right[c], left[channels_ + c], right[channels_ + c]);
  }
}

// Section 7 of the paper: r = max(p + q + s + t - 3 c, min), where p, q, s, t are the multilinear means of the eight
// slices of each kind and c of the sixteen corners.
template <class Real>
template <std::size_t N>
void BasicEvaluator<Real>::reconstruct(const Cell& cell, const Coordinates& x, std::size_t channel,
                                       Real* values) const {
  using Values = std::array<Real, N>;
  std::array<std::size_t, kAxisCount> moving{};
  std::size_t moving_count = 0;
  std::uint32_t first_corner = 0;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    first_corner += cell.index[axis] * corner_strides_[axis];
    if (nodes_[axis].size() > 1) moving[moving_count++] = axis;
  }
  std::array<Values, 16> points;
  for (std::uint32_t bits = 0; bits < (1U << moving_count); ++bits) {
    std::uint32_t corner = first_corner;
    for (std::size_t m = 0; m < moving_count; ++m) corner += ((bits >> m) & 1U) * corner_strides_[moving[m]];
    std::copy_n(corner_values_.data() + corners_[corner] * channels_ + channel, N, points[bits].data());
  }
  // Halves the points axis by axis; the last axis lies farthest apart.
  const auto mean = [&](std::size_t left_out) {
    std::size_t count = std::size_t{1} << (left_out < kAxisCount ? moving_count - 1 : moving_count);
    for (std::size_t m = moving_count; m-- > 0;) {
      if (moving[m] == left_out) continue;
      count /= 2;
      for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t c = 0; c < N; ++c) {
          points[k][c] = mix(cell.fraction[moving[m]], points[k][c], points[k + count][c]);
        }
      }
    }
    return points[0];
  };
  const Values corner_mean = mean(kAxisCount);

  Values least;
  Values most;
  least.fill(std::numeric_limits<Real>::max());
  most.fill(std::numeric_limits<Real>::lowest());
  // The mean of the slices that differs most from the corners is taken as it is and the others by their differences, so
  // that a sample comes back to the last bit: there only one of the means differs.
  Values best = corner_mean;
  Values others{};
  for (std::size_t along = 0; along < moving_count; ++along) {
    const std::size_t axis = moving[along];
    std::uint32_t first_line = 0;
    for (std::size_t a = 0; a < kAxisCount; ++a) first_line += cell.index[a] * line_strides_[axis][a];
    for (std::uint32_t bits = 0; bits < (1U << (moving_count - 1)); ++bits) {
      std::uint32_t line = first_line;
      for (std::size_t m = 0, bit = 0; m < moving_count; ++m) {
        if (m != along) line += ((bits >> bit++) & 1U) * line_strides_[axis][moving[m]];
      }
      along_line<N>(lines_[axis][line], x[axis], channel, points[bits].data());
      for (std::size_t c = 0; c < N; ++c) {
        least[c] = std::min(least[c], points[bits][c]);
        most[c] = std::max(most[c], points[bits][c]);
      }
    }
    const Values slice_mean = mean(axis);
    for (std::size_t c = 0; c < N; ++c) {
      const Real difference = slice_mean[c] - corner_mean[c];
      const Real best_difference = best[c] - corner_mean[c];
      const bool larger = std::abs(difference) > std::abs(best_difference);
      others[c] += larger ? best_difference : difference;
      if (larger) best[c] = slice_mean[c];
    }
  }
  for (std::size_t c = 0; c < N; ++c) {
    Real value = best[c] + others[c];
    if (moving_count > 0) value = std::max(value, least[c]);
    if (moving_count > 0 && clamp_above_) value = std::min(value, most[c]);
    values[c] = value;
  }
  map_.inverse(x, channel, std::span(values, N));
}

template class BasicEvaluator<float>;
template class BasicEvaluator<long double>;

}  // namespace sbrdf
