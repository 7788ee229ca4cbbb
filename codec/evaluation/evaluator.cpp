#include "codec/evaluation/evaluator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "codec/curves/slope_limits.h"
#include "codec/curves/spline.h"
#include "codec/frame/cells.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kNoAxis = kAxisCount;

/// Where a slice is met, as a distance from its start within [0, length]: by period, reflection or clamping.
double distance_from_start(Boundary boundary, double length, double distance) {
  if (boundary == Boundary::kBounded) return std::clamp(distance, 0.0, length);
  const double period = boundary == Boundary::kMirrored ? 2 * length : length;
  distance -= period * std::floor(distance / period);
  return distance > length ? std::max(0.0, period - distance) : distance;
}

/// The multilinear mean of the points of a cell, whose bit m of the index tells the two sides of the m-th axis apart;
/// points of lines lack the axis `left_out`. Halves the points axis by axis, the last first, whose sides lie farthest
/// apart, and destroys them.
template <class Real, std::size_t N>
std::array<Real, N> mean(std::array<std::array<Real, N>, 16>& points, const std::array<Real, kAxisCount>& fraction,
                         std::size_t axis_count, std::size_t left_out) {
  std::size_t count = std::size_t{1} << (left_out < kAxisCount ? axis_count - 1 : axis_count);
  for (std::size_t m = axis_count; m-- > 0;) {
    if (m == left_out) continue;
    count /= 2;
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t c = 0; c < N; ++c) points[k][c] = mix(fraction[m], points[k][c], points[k + count][c]);
    }
  }
  return points[0];
}

/// m_1 + ... + m_d - (d - 1) c as c + (m_1 - c) + ... + (m_d - c), with one change: the mean that differs most from the
/// corners is taken as it is and only the others by their differences. At a sample only one of the means differs, so
/// the sample comes back to the last bit; c + (m - c) would round twice.
template <class Real, std::size_t N>
class SliceSum {
 public:
  using Values = std::array<Real, N>;

  explicit SliceSum(const Values& corner_mean) : corner_mean_(corner_mean), best_(corner_mean) {
    least_.fill(std::numeric_limits<Real>::max());
    most_.fill(std::numeric_limits<Real>::lowest());
  }

  /// Slice values between whose least and greatest the sum may have to stay.
  void note_range(std::span<const Values> lines) {
    for (const Values& line : lines) {
      for (std::size_t c = 0; c < N; ++c) {
        least_[c] = std::min(least_[c], line[c]);
        most_[c] = std::max(most_[c], line[c]);
      }
    }
  }

  void add(const Values& slice_mean) {
    for (std::size_t c = 0; c < N; ++c) {
      const Real difference = slice_mean[c] - corner_mean_[c];
      const Real best_difference = best_[c] - corner_mean_[c];
      const bool larger = std::abs(difference) > std::abs(best_difference);
      others_[c] += larger ? best_difference : difference;
      if (larger) best_[c] = slice_mean[c];
    }
  }

  /// The sum, kept within the range of the slices on the sides that are asked for, and that range.
  template <class Bounded>
  [[nodiscard]] Bounded bounded(bool below, bool above) const {
    Bounded result;
    for (std::size_t c = 0; c < N; ++c) {
      result.least[c] = below ? least_[c] : std::numeric_limits<Real>::lowest();
      result.most[c] = above ? most_[c] : std::numeric_limits<Real>::max();
      result.value[c] = std::min(std::max(best_[c] + others_[c], result.least[c]), result.most[c]);
    }
    return result;
  }

 private:
  Values corner_mean_;
  Values best_;
  Values others_{};
  Values least_;
  Values most_;
};

/// A value within its bounds. Where samples lie near the end of what Real holds, slices between them may be no number:
/// these bound nothing, and where none is one, the bounds stand in the wrong order. The lower one is then the answer.
template <class Real>
Real held(Real value, Real least, Real most) {
  if (value > most) return most;
  return value >= least ? value : std::min(least, most);
}

}  // namespace

template <class Real>
BasicEvaluator<Real>::BasicEvaluator(const SlicedBrdf& sliced, const Lattice& lattice)
    : frame_(geometry(lattice.spec.id)),
      channels_(sliced.channel_count()),
      grey_shares_(sliced.grey_shares),
      clamp_above_(sliced.domain.kind == DomainKind::kLog),
      nodes_(lattice.nodes),
      corners_(lattice.corners),
      corner_strides_(lattice.corner_strides),
      lines_(lattice.lines),
      line_strides_(lattice.line_strides),
      rings_(pole_rings(lattice)) {
  map_ = ValueMap<Real>(sliced, lattice);
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    cells_per_degree_[axis] = cells_per_degree(nodes_[axis]);
    if (nodes_[axis].size() > 1) moving_[moving_count_++] = axis;
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
  std::vector<Wide> slopes;  // second derivatives, until their limits make them slopes
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const Slice& slice = lattice.slices[k];
    map.forward(slice, slices[k], values);
    slopes.resize(values.size());
    for (std::size_t c = 0; c < channels_; ++c) {
      solver.solve(slice.boundary, slice.length_deg, slices[k].positions_deg, values.data() + c, slopes.data() + c,
                   channels_);
      slopes_within_limits(slice.boundary, slice.length_deg, slices[k].positions_deg, values.data() + c,
                           slopes.data() + c, channels_);
    }
    add_curve(slice, slices[k], values, slopes);
  }
}

template <class Real>
void BasicEvaluator<Real>::add_curve(const Slice& slice, const SliceSamples& samples, std::span<const Wide> values,
                                     std::span<const Wide> slopes) {
  Curve curve;
  curve.boundary = slice.boundary;
  curve.start = slice.start_deg;
  curve.length = slice.length_deg;
  curve.first_knot = static_cast<std::uint32_t>(knots_.size());
  const std::size_t n = samples.size();
  const std::size_t knots = slice.boundary == Boundary::kPeriodic ? n + 1 : n;
  for (std::size_t knot = 0; knot < knots; ++knot) {
    knots_.push_back(knot < n ? samples.positions_deg[knot] : slice.start_deg + slice.length_deg);
    for (const std::span<const Wide> row : {values, slopes}) {
      for (const Wide v : row.subspan(knot % n * channels_, channels_)) knot_values_.push_back(static_cast<Real>(v));
    }
  }
  add_buckets(curve);
  curves_.push_back(curve);
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
  if (above_horizon(pair)) {
    evaluate_at(frame_.coordinates(pair), values);
  } else {
    std::fill(values.begin(), values.end(), Real(0));
  }
}

template <class Real>
void BasicEvaluator<Real>::evaluate_at(const Coordinates& x, std::span<Real> values) const {
  constexpr std::size_t kMany = ValueMap<Real>::kMostChannels;
  const Cell cell = locate(x);
  std::size_t c = 0;
  for (; c + kMany <= channels_; c += kMany) reconstruct<kMany>(cell, x, c, values.data() + c);
  for (; c < channels_; ++c) reconstruct<1>(cell, x, c, values.data() + c);
  grey_shares_.take_off(values);
}

template <class Real>
typename BasicEvaluator<Real>::Cell BasicEvaluator<Real>::locate(const Coordinates& x) const {
  Cell cell;
  for (std::size_t m = 0; m < moving_count_; ++m) {
    const std::size_t axis = moving_[m];
    const std::vector<double>& nodes = nodes_[axis];
    const auto [index, clamped] = cell_on_axis(nodes, cells_per_degree_[axis], x[axis]);
    cell.index[axis] = index;
    cell.fraction[m] = static_cast<Real>((static_cast<Wide>(clamped) - nodes[index]) /
                                         (static_cast<Wide>(nodes[index + 1]) - nodes[index]));
  }
  return cell;
}

template <class Real>
inline typename BasicEvaluator<Real>::Segment BasicEvaluator<Real>::segment_at(const Curve& curve,
                                                                               double position) const {
  const double from_start = distance_from_start(curve.boundary, curve.length, position - curve.start);
  const std::uint32_t bucket =
      std::min(static_cast<std::uint32_t>(from_start * curve.buckets_per_degree), curve.bucket_count - 1);
  const double at = curve.start + from_start;
  const double end = curve.start + curve.length;
  std::uint32_t knot = buckets_[curve.first_bucket + bucket];
  while (knots_[knot] > at && knot > curve.first_knot) --knot;
  while (knots_[knot + 1] < at && knots_[knot + 1] < end) ++knot;
  const double width = knots_[knot + 1] - knots_[knot];
  return {knot, static_cast<Real>(std::clamp((at - knots_[knot]) / width, 0.0, 1.0)), static_cast<Real>(width)};
}

// The value of the slice on which a line lies, where the coordinate along it is x.
template <class Real>
template <std::size_t N>
void BasicEvaluator<Real>::along_line(const LineReference& reference, double x, std::size_t channel,
                                      Real* values) const {
  if (reference.is_constant()) {
    std::copy_n(corner_values_.data() + reference.crossing() * channels_ + channel, N, values);
    return;
  }
  const Segment segment = segment_at(curves_[reference.target], reference.sign * x + reference.offset_deg);
  const Real* left = knot_values_.data() + segment.knot * 2 * channels_ + channel;
  const Real* right = left + 2 * channels_;
  for (std::size_t c = 0; c < N; ++c) {
    values[c] = evaluate_cubic(segment.t, segment.width, left[c], right[c], left[channels_ + c], right[channels_ + c]);
  }
}

template <class Real>
template <std::size_t N>
void BasicEvaluator<Real>::read_corners(const Cell& cell, std::size_t channel, Points<N>& points) const {
  std::uint32_t first = 0;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) first += cell.index[axis] * corner_strides_[axis];
  for (std::uint32_t bits = 0; bits < (1U << moving_count_); ++bits) {
    std::uint32_t corner = first;
    for (std::size_t m = 0; m < moving_count_; ++m) corner += ((bits >> m) & 1U) * corner_strides_[moving_[m]];
    std::copy_n(corner_values_.data() + corners_[corner] * channels_ + channel, N, points[bits].data());
  }
}

template <class Real>
template <std::size_t N>
void BasicEvaluator<Real>::read_lines(const Cell& cell, std::size_t along, double x, std::size_t channel,
                                      Points<N>& points) const {
  const std::size_t axis = moving_[along];
  const Strides& strides = line_strides_[axis];
  std::uint32_t first = 0;
  for (std::size_t a = 0; a < kAxisCount; ++a) first += cell.index[a] * strides[a];
  for (std::uint32_t bits = 0; bits < (1U << (moving_count_ - 1)); ++bits) {
    std::uint32_t line = first;
    for (std::size_t m = 0, bit = 0; m < moving_count_; ++m) {
      if (m != along) line += ((bits >> bit++) & 1U) * strides[moving_[m]];
    }
    along_line<N>(lines_[axis][line], x, channel, points[bits].data());
  }
}

// Section 7 of the paper. Let d axes move in the cell that holds the point, which lies the fractions t_1 ... t_d of the
// way along its sides. A corner weighs the product of t_a or 1 - t_a over all axes, a line along axis a the same
// product over the others:
//
//   c   = sum over the 2^d corners         of weight x value
//   m_a = sum over the 2^(d-1) lines along a of weight x value of the slice there      (p, q, s, t in the paper)
//   r   = max(m_1 + ... + m_d - (d - 1) c, least of all those slice values)            (d = 4: p + q + s + t - 3 c)
//
// On a line along axis a, one weight of m_a is 1; every other slice of the cell is met at its end, a corner, so that
// the other m_b are c, and r is the slice. In the log domain all of this happens in v, and r stays below the greatest
// slice.
template <class Real>
template <std::size_t N>
typename BasicEvaluator<Real>::template Bounded<N> BasicEvaluator<Real>::sum_in_cell(const Cell& cell,
                                                                                     const Coordinates& x,
                                                                                     std::size_t channel) const {
  Points<N> points;
  read_corners<N>(cell, channel, points);
  SliceSum<Real, N> sum(mean(points, cell.fraction, moving_count_, kNoAxis));
  for (std::size_t along = 0; along < moving_count_; ++along) {
    read_lines<N>(cell, along, x[moving_[along]], channel, points);
    sum.note_range(std::span(points).first(std::size_t{1} << (moving_count_ - 1)));
    sum.add(mean(points, cell.fraction, moving_count_, along));
  }
  return sum.template bounded<Bounded<N>>(moving_count_ > 0, moving_count_ > 0 && clamp_above_);
}

// The same sum on a ring, where two coordinates are left: corners and slices of the cell of these two.
template <class Real>
template <std::size_t N>
typename BasicEvaluator<Real>::template Bounded<N> BasicEvaluator<Real>::sum_on_ring(const PoleRing& ring,
                                                                                     const Cell& cell,
                                                                                     const Coordinates& x,
                                                                                     std::size_t channel) const {
  const double position = ring.position_deg(x);
  const std::size_t before = ring.node_before(position);
  const std::span<const PoleRing::Node, 2> nodes(ring.nodes.data() + before, 2);
  const std::array<Real, kAxisCount> fraction = {
      static_cast<Real>((static_cast<Wide>(position) - nodes[0].position_deg) /
                        (static_cast<Wide>(nodes[1].position_deg) - nodes[0].position_deg)),
      cell.fraction[ring.along]};
  const std::size_t ring_axis = ring.merging.ring_axis;
  Points<N> points;  // bit 0: along the ring, bit 1: along the other polar axis
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t at = cell.index[ring.along] + (k >> 1U);
    const std::uint32_t corner = nodes[k & 1U].corner + at * corner_strides_[ring.along];
    std::copy_n(corner_values_.data() + corners_[corner] * channels_ + channel, N, points[k].data());
  }
  SliceSum<Real, N> sum(mean(points, fraction, 2, kNoAxis));
  for (std::uint32_t k = 0; k < 2; ++k) {
    const std::uint32_t line = (cell.index[ring.along] + k) * line_strides_[ring_axis][ring.along];
    along_line<N>(lines_[ring_axis][line], position, channel, points[k].data());
  }
  sum.note_range(std::span(points).first(2));
  sum.add(mean(points, fraction, 2, 0));
  for (std::uint32_t k = 0; k < 2; ++k) {
    along_line<N>(lines_[ring.along][nodes[k].line], x[ring.along], channel, points[k].data());
  }
  sum.note_range(std::span(points).first(2));
  sum.add(mean(points, fraction, 2, 1));
  return sum.template bounded<Bounded<N>>(true, clamp_above_);
}

// On the face at which the azimuths are one, the sum in the cell depends on both, since it blends slices of different
// places on the ring. What is wrong there is known, and is taken out of the whole cell, the less the farther from the
// face. On all slices it is 0, so that samples stay samples.
template <class Real>
template <std::size_t N>
void BasicEvaluator<Real>::correct_at_pole(const PoleRing& ring, const Cell& cell, const Coordinates& x,
                                           std::size_t channel, Bounded<N>& sum) const {
  const std::size_t axis = ring.merging.polar_axis;
  Cell on_face = cell;
  on_face.fraction[axis] = 0;
  Coordinates at_face = x;
  at_face[axis] = 0;
  const Bounded<N> wrong = sum_in_cell<N>(on_face, at_face, channel);
  const Bounded<N> right = sum_on_ring<N>(ring, cell, x, channel);
  for (std::size_t c = 0; c < N; ++c) {
    sum.value[c] += (Real(1) - cell.fraction[axis]) * (right.value[c] - wrong.value[c]);
    sum.least[c] = std::min(sum.least[c], right.least[c]);
    sum.most[c] = std::max(sum.most[c], right.most[c]);
  }
}

template <class Real>
template <std::size_t N>
void BasicEvaluator<Real>::reconstruct(const Cell& cell, const Coordinates& x, std::size_t channel,
                                       Real* values) const {
  Bounded<N> sum = sum_in_cell<N>(cell, x, channel);
  for (const PoleRing& ring : rings_) {
    if (cell.index[ring.merging.polar_axis] == 0) correct_at_pole<N>(ring, cell, x, channel, sum);
  }
  for (std::size_t c = 0; c < N; ++c) values[c] = held(sum.value[c], sum.least[c], sum.most[c]);
  map_.inverse(x, channel, std::span(values, N));
}

template class BasicEvaluator<float>;
template class BasicEvaluator<long double>;

}  // namespace sbrdf::internal
