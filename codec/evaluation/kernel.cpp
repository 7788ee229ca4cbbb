#include "codec/evaluation/kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "codec/frame/frame_geometries.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "codec/evaluation/kernel.cpp"  // NOLINT
#include <hwy/foreach_target.h>                           // IWYU pragma: keep
// After it, as every set of instructions has its own:
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sbrdf::internal {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kLanes = SliceTables::kLanes;
constexpr std::size_t kMostAxes = kAxisCount;
constexpr std::size_t kHalf = 8;  // lines along one axis of a cell, at most

using Channels = hn::FixedTag<float, kLanes>;  // a group of channels
using V = hn::Vec<Channels>;
using M = hn::Mask<Channels>;

HWY_INLINE V load(const float* from) { return hn::LoadU(Channels(), from); }
HWY_INLINE V all(float value) { return hn::Set(Channels(), value); }
// A candidate that is no number bounds nothing: comparisons with it are false. On x86 an instruction does just that.
HWY_INLINE V smaller(V candidate, V present) {
  if constexpr (HWY_ARCH_X86 != 0) return hn::Min(candidate, present);
  return hn::IfThenElse(hn::Lt(candidate, present), candidate, present);
}
HWY_INLINE V larger(V candidate, V present) {
  if constexpr (HWY_ARCH_X86 != 0) return hn::Max(candidate, present);
  return hn::IfThenElse(hn::Gt(candidate, present), candidate, present);
}

/// The lines that a point needs, four by four: which knots, and the weights of what stands there:
///
///   y = y_near + a (y_far - y_near) + b m_near + c m_far
///
/// the cubic of specs/conventions.md, seen from the nearer end, so that either end comes out exactly.
struct Lines {
  template <class T>
  using Each = std::array<T, SliceTables::kMostLines>;

  alignas(16) Each<std::uint32_t> near_knot;
  alignas(16) Each<std::uint32_t> far_knot;
  alignas(16) Each<float> a;
  alignas(16) Each<float> b;
  alignas(16) Each<float> c;
  Each<std::uint32_t> first_knot;
  std::size_t count = 0;
};
constexpr std::size_t kQuad = 4;
using QuadInts = hn::FixedTag<std::int32_t, kQuad>;

/// The last of the places at or before one.
HWY_INLINE std::uint32_t find_segment(const SliceTables& tables, const SliceTables::Search& search,
                                      std::int32_t place) {
  const hn::CappedTag<std::int32_t, 8> d;
  const std::int32_t* places = tables.places.data() + 1;
  const auto at = hn::Set(d, place);
  std::uint32_t segment =
      tables.buckets[search.first_bucket + (static_cast<std::uint32_t>(place) >> search.bucket_shift)];
  for (;;) {
    const std::intptr_t passed = hn::FindFirstTrue(d, hn::Gt(hn::LoadU(d, places + segment), at));
    if (HWY_LIKELY(passed >= 0)) return segment + static_cast<std::uint32_t>(passed);
    segment += static_cast<std::uint32_t>(hn::Lanes(d));
  }
}

HWY_INLINE std::int32_t place_on(const SliceTables::Line& line, std::uint64_t x) {
  const std::uint64_t turn = line.backwards ? ~std::uint64_t{0} : 0;
  const std::uint64_t at = ((x ^ turn) - turn + line.offset) << line.shift;
  constexpr std::uint64_t kRound = std::uint64_t{1} << 31U;
  const std::uint64_t half_way = line.mirrored ? std::min(at, ~at + 1) : at >> 1U;
  return static_cast<std::int32_t>(std::min<std::uint64_t>((half_way + kRound) >> 32U, kLastPlace));
}

// A vector of four numbers in memory that are not together: without a detour through memory of its own.
HWY_INLINE hn::Vec<QuadInts> together(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  const QuadInts q;
  const hn::FixedTag<std::int64_t, 2> pairs;
  const auto low = hn::InterleaveLower(q, hn::Set(q, a), hn::Set(q, b));
  const auto high = hn::InterleaveLower(q, hn::Set(q, c), hn::Set(q, d));
  return hn::BitCast(q, hn::InterleaveLower(pairs, hn::BitCast(pairs, low), hn::BitCast(pairs, high)));
}

HWY_INLINE void add_quad(const SliceTables& tables, const std::array<const SliceTables::Line*, kQuad>& quad,
                         const std::array<std::int32_t, kQuad>& place, Lines& lines) {
  std::array<std::uint32_t, kQuad> knot;
  for (std::size_t k = 0; k < kQuad; ++k) {
    knot[k] = find_segment(tables, quad[k]->knots, place[k]);
    lines.first_knot[lines.count + k] = quad[k]->first_knot;
  }
  const std::int32_t* at = tables.places.data();
  const QuadInts di;
  const Channels d;
  const auto from = together(at[knot[0]], at[knot[1]], at[knot[2]], at[knot[3]]);
  const auto to = together(at[knot[0] + 1], at[knot[1] + 1], at[knot[2] + 1], at[knot[3] + 1]);
  const auto met = together(place[0], place[1], place[2], place[3]);
  const V one = hn::Set(d, 1.0F);
  const V width = hn::Max(hn::ConvertTo(d, hn::Sub(to, from)), one);  // two samples in one place leave none
  const V t = hn::Div(hn::ConvertTo(d, hn::Sub(met, from)), width);
  const M near_is_first = hn::Lt(t, hn::Set(d, 0.5F));
  const V u = hn::IfThenElse(near_is_first, t, hn::Sub(one, t));  // of the way from the near end to the far one
  const V s = hn::Sub(one, u);
  const V su = hn::Mul(s, u);
  const V ahead = hn::Mul(width, hn::Set(d, 1.0F / kWidthUnit));
  const V reach = hn::Mul(su, hn::IfThenElse(near_is_first, ahead, hn::Neg(ahead)));
  hn::Store(hn::MulAdd(su, hn::Sub(u, s), u), d, lines.a.data() + lines.count);
  hn::Store(hn::Mul(reach, s), d, lines.b.data() + lines.count);
  hn::Store(hn::Neg(hn::Mul(reach, u)), d, lines.c.data() + lines.count);
  const hn::FixedTag<std::uint32_t, kQuad> du;
  const auto first = together(static_cast<std::int32_t>(knot[0]), static_cast<std::int32_t>(knot[1]),
                              static_cast<std::int32_t>(knot[2]), static_cast<std::int32_t>(knot[3]));
  const auto second = hn::Add(first, hn::Set(di, 1));
  const auto is_first = hn::RebindMask(di, near_is_first);
  hn::Store(hn::BitCast(du, hn::IfThenElse(is_first, first, second)), du, lines.near_knot.data() + lines.count);
  hn::Store(hn::BitCast(du, hn::IfThenElse(is_first, second, first)), du, lines.far_knot.data() + lines.count);
  lines.count += kQuad;
}

/// How far from the near side of an axis to the far one a point is. Mixed from the near side, in at most one half of
/// the way, either side comes out exactly.
HWY_INLINE V mixed(V way, V near_side, V far_side) { return hn::MulAdd(way, hn::Sub(far_side, near_side), near_side); }
using Ways = std::array<V, kMostAxes>;

// The same from whichever side is nearer.
HWY_INLINE V mixed_between(float t, V first, V second) {
  return t < 0.5F ? mixed(all(t), first, second) : mixed(all(1.0F - t), second, first);
}

/// The point in its cell.
struct Cell {
  std::array<std::uint32_t, kAxisCount> index{};  // the node before the point, by axis
  Coordinates x{};                                // [degrees] within the lattice, by axis
  std::array<std::int32_t, kAxisCount> place{};   // the same as a place of its axis
  std::array<float, kMostAxes> t{};               // fraction of the way to the next node, by moving axis
  // Seen from the nearer node, by moving axis:
  std::array<std::uint32_t, kMostAxes> near_side{};  // 0 or 1: which of the two nodes that is
  std::array<float, kMostAxes> way{};                // the fraction from there
};

HWY_INLINE void locate(const SliceTables& tables, const Coordinates& x, Cell& cell) {
  const double longest = longest_period_deg(tables.frame);
  const std::int32_t* places = tables.places.data();
  for (std::size_t m = 0; m < tables.axes.size(); ++m) {
    const SliceTables::MovingAxis& axis = tables.axes[m];
    const double given = x[axis.axis];
    const double within = given > 0 ? std::min(given, axis.last_deg) : 0;  // no number: 0
    const std::int32_t place = axis.azimuth ? axis_place(within, longest) : polar_place(within);
    const std::uint32_t node = std::min(find_segment(tables, axis.nodes, place), axis.last_cell);
    const float t = static_cast<float>(place - places[node]) / static_cast<float>(places[node + 1] - places[node]);
    cell.x[axis.axis] = within;
    cell.place[axis.axis] = place;
    cell.index[axis.axis] = node - axis.first_node;
    cell.t[m] = t;
    const bool from_next = t >= 0.5F;
    cell.near_side[m] = from_next ? 1 : 0;
    cell.way[m] = from_next ? 1.0F - t : t;
  }
}

// Of the 2^n points around one on the moving axes but `left_out`, numbered with strides of a table: the nearest first;
// bit k of their order tells the near and the far side of the k-th of these axes apart.
template <std::size_t D, std::size_t N>
HWY_INLINE void number_points(const SliceTables& tables, const Cell& cell, const Strides& strides, std::size_t left_out,
                              std::array<std::uint32_t, N>& numbers) {
  std::uint32_t nearest = 0;
  std::size_t count = 1;
  for (std::size_t m = 0; m < D; ++m) {
    const std::uint32_t axis = tables.axes[m].axis;
    nearest += (cell.index[axis] + (m == left_out ? 0 : cell.near_side[m])) * strides[axis];
  }
  numbers[0] = nearest;
  for (std::size_t m = 0; m < D; ++m) {
    if (m == left_out) continue;
    const std::uint32_t stride = strides[tables.axes[m].axis];
    const std::uint32_t step = cell.near_side[m] != 0 ? 0 - stride : stride;
    for (std::size_t k = 0; k < count; ++k) numbers[count + k] = numbers[k] + step;
    count *= 2;
  }
  for (; count < N; ++count) numbers[count] = nearest;
}

/// Lines along one axis of a cell, in whole quads.
constexpr std::size_t lines_along(std::size_t moving) {
  const std::size_t needed = (std::size_t{1} << moving) / 2;
  return moving == 0 ? 0 : std::max(kQuad, needed);
}

// Lines along each axis of a cell, axis by axis; where there are fewer than a quad, the first is there again.
template <std::size_t D>
HWY_INLINE void add_cell_lines(const SliceTables& tables, const Cell& cell, Lines& lines) {
  constexpr std::size_t kCount = lines_along(D);
  for (std::size_t along = 0; along < D; ++along) {
    const SliceTables::MovingAxis& axis = tables.axes[along];
    std::array<std::uint32_t, kCount> numbers;
    number_points<D>(tables, cell, axis.line_strides, along, numbers);
    const SliceTables::Line* all_lines = axis.lines.data();
    const std::uint64_t x = axis.azimuth ? azimuth_units(cell.x[axis.axis], longest_period_deg(tables.frame)) : 0;
    for (std::size_t first = 0; first < kCount; first += kQuad) {
      std::array<const SliceTables::Line*, kQuad> quad;
      std::array<std::int32_t, kQuad> place;
      for (std::size_t k = 0; k < kQuad; ++k) {
        quad[k] = all_lines + numbers[first + k];
        place[k] = axis.azimuth ? place_on(*quad[k], x) : cell.place[axis.axis];
      }
      add_quad(tables, quad, place, lines);
    }
  }
}

/// A ring as the point meets it.
struct RingCell {
  std::array<PoleRing::Node, 2> nodes;
  float t = 0;            // between them
  std::size_t lines = 0;  // the first of four: two along the ring, two along the other axis
};

RingCell add_ring_lines(const SliceTables& tables, const PoleRing& ring, const Cell& cell, Lines& lines) {
  RingCell on;
  const double position = ring.position_deg(cell.x);
  const std::size_t before = ring.node_before(position);
  on.nodes = {ring.nodes[before], ring.nodes[before + 1]};
  on.t =
      static_cast<float>((position - on.nodes[0].position_deg) / (on.nodes[1].position_deg - on.nodes[0].position_deg));
  on.lines = lines.count;
  const SliceTables::MovingAxis& along_ring = tables.axes[ring.merging.ring_axis];
  const SliceTables::MovingAxis& other = tables.axes[ring.along];
  const std::uint64_t x = azimuth_units(position, longest_period_deg(tables.frame));
  const std::uint32_t step = along_ring.line_strides[ring.along];
  const SliceTables::Line* first = along_ring.lines.data() + cell.index[ring.along] * step;
  const std::array<const SliceTables::Line*, kQuad> quad = {first, first + step, other.lines.data() + on.nodes[0].line,
                                                            other.lines.data() + on.nodes[1].line};
  const std::int32_t place = cell.place[ring.along];
  add_quad(tables, quad, {place_on(*quad[0], x), place_on(*quad[1], x), place, place}, lines);
  return on;
}

/// A group of channels of what the slices say.
struct Bounded {
  V value;
  V least;
  V most;
};

/// m_1 + ... + m_d - (d - 1) c as c + (m_1 - c) + ... + (m_d - c), with one change: the mean that differs most from the
/// corners is taken as it is and only the others by their differences. At a sample only one of the means differs, so
/// the sample comes back to the last bit; c + (m - c) would round twice.
class Sum {
 public:
  explicit Sum(V corner_mean)
      : corners_(corner_mean),
        best_(corner_mean),
        others_(hn::Zero(Channels())),
        least_(all(std::numeric_limits<float>::max())),
        most_(all(std::numeric_limits<float>::lowest())) {}

  HWY_INLINE void note(V line) {
    least_ = smaller(line, least_);
    most_ = larger(line, most_);
  }

  HWY_INLINE void add(V mean) {
    const V difference = hn::Sub(mean, corners_);
    const V best_difference = hn::Sub(best_, corners_);
    const M farther = hn::Gt(hn::Abs(difference), hn::Abs(best_difference));
    others_ = hn::Add(others_, hn::IfThenElse(farther, best_difference, difference));
    best_ = hn::IfThenElse(farther, mean, best_);
  }

  /// Kept at or above the least slice and, where asked for, at or below the greatest.
  [[nodiscard]] HWY_INLINE Bounded bounded(bool below, bool above) const {
    Bounded result;
    result.least = below ? least_ : all(std::numeric_limits<float>::lowest());
    result.most = above ? most_ : all(std::numeric_limits<float>::max());
    const V sum = hn::Add(best_, others_);
    result.value = smaller(result.most, larger(result.least, sum));
    return result;
  }

 private:
  V corners_;
  V best_;
  V others_;
  V least_;
  V most_;
};

/// Everything about a point that is the same for all channels.
struct Point {
  Cell cell;
  Lines lines;
  Ways ways;
  std::array<std::uint32_t, 2 * kHalf> corners;  // their crossings
  std::array<RingCell, 2> rings;
  std::size_t guide_line = 0;
};

HWY_INLINE V line_value(const SliceTables& tables, const Lines& lines, std::size_t line, std::size_t channel) {
  const std::size_t channels = tables.channels;
  const float* values = tables.knot_values.data() + channel;
  const std::size_t row = 2 * channels;
  const float* near_row = values + lines.near_knot[line] * row;
  const float* far_row = values + lines.far_knot[line] * row;
  const V near_value = load(near_row);
  V y = hn::MulAdd(all(lines.a[line]), hn::Sub(load(far_row), near_value), near_value);
  y = hn::MulAdd(all(lines.b[line]), load(near_row + channels), y);
  return hn::MulAdd(all(lines.c[line]), load(far_row + channels), y);
}

HWY_INLINE V crossing_value(const SliceTables& tables, std::uint32_t crossing, std::size_t channel) {
  return load(tables.crossing_values.data() + crossing * tables.channels + channel);
}

// The multilinear mean of 2^D points; halves them axis by axis, the last first, whose sides lie farthest apart. Those
// of lines lack the axis `left_out`.
template <std::size_t D>
HWY_INLINE V mean(std::array<V, 2 * kHalf>& points, const Ways& ways, std::size_t left_out) {
  std::size_t count = std::size_t{1} << (left_out < D ? D - 1 : D);
  for (std::size_t m = D; m-- > 0;) {
    if (m == left_out) continue;
    count /= 2;
    for (std::size_t k = 0; k < count; ++k) points[k] = mixed(ways[m], points[k], points[k + count]);
  }
  return points[0];
}

// The values of a group of channels at what a cell consists of.
template <std::size_t D>
struct CellValues {
  std::array<V, std::size_t{1} << D> corners;
  std::array<V, D * lines_along(D)> lines;
};

template <std::size_t D>
HWY_INLINE Bounded sum_in_cell(const CellValues<D>& values, const Ways& ways, bool above) {
  constexpr std::size_t kLinesEach = (std::size_t{1} << D) / 2;
  std::array<V, 2 * kHalf> points;
  std::copy(values.corners.begin(), values.corners.end(), points.begin());
  Sum sum(mean<D>(points, ways, kMostAxes));
  for (std::size_t along = 0; along < D; ++along) {
    for (std::size_t k = 0; k < kLinesEach; ++k) {
      points[k] = values.lines[along * lines_along(D) + k];
      sum.note(points[k]);
    }
    sum.add(mean<D>(points, ways, along));
  }
  return sum.bounded(D > 0, D > 0 && above);
}

// The same sum on a ring, where two coordinates are left: corners and slices of the cell of these two.
Bounded sum_on_ring(const SliceTables& tables, const PoleRing& ring, const Point& point, const RingCell& on,
                    std::size_t channel) {
  const std::uint32_t stride = tables.corner_strides[ring.along];
  std::array<V, 4> corners;  // bit 0: along the ring, bit 1: along the other polar axis
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t at = point.cell.index[ring.along] + (k >> 1U);
    corners[k] = crossing_value(tables, tables.corners[on.nodes[k & 1U].corner + at * stride], channel);
  }
  const auto over_other = [&](V first, V second)
                              HWY_ATTR { return mixed_between(point.cell.t[ring.along], first, second); };
  const auto over_ring = [&](V first, V second) HWY_ATTR { return mixed_between(on.t, first, second); };
  Sum sum(over_ring(over_other(corners[0], corners[2]), over_other(corners[1], corners[3])));
  std::array<V, 4> lines;
  for (std::size_t k = 0; k < 4; ++k) {
    lines[k] = line_value(tables, point.lines, on.lines + k, channel);
    sum.note(lines[k]);
  }
  sum.add(over_other(lines[0], lines[1]));
  sum.add(over_ring(lines[2], lines[3]));
  return sum.bounded(true, tables.log);
}

// The near side of an axis for the far one.
void exchange_sides(std::size_t axis, CellValues<4>& values) {
  const auto exchange = [](V* points, std::size_t count, std::size_t bit) HWY_ATTR {
    for (std::size_t k = 0; k < count; ++k) {
      if ((k >> bit & 1U) == 0) std::swap(points[k], points[k | std::size_t{1} << bit]);
    }
  };
  exchange(values.corners.data(), values.corners.size(), axis);
  for (std::size_t along = 0; along < kAxisCount; ++along) {
    if (along != axis) exchange(values.lines.data() + along * kHalf, kHalf, axis < along ? axis : axis - 1);
  }
}

// On the face at which the azimuths are one, the sum in the cell depends on both, since it blends slices of different
// places on the ring. What is wrong there is known, and is taken out of the whole cell, the less the farther from the
// face. On all slices it is 0, so that samples stay samples. On the face lines along the other axes are what they are
// in the cell; those along the polar axis are met at their beginnings.
void correct_at_pole(const SliceTables& tables, const PoleRing& ring, const Point& point, const RingCell& on,
                     std::size_t channel, CellValues<4> values, Bounded& sum) {
  const std::size_t polar = ring.merging.polar_axis;
  if (point.cell.near_side[polar] != 0) exchange_sides(polar, values);
  for (std::size_t k = polar * kHalf; k < (polar + 1) * kHalf; ++k) {
    const float* start = tables.knot_values.data() + point.lines.first_knot[k] * 2 * tables.channels;
    values.lines[k] = load(start + channel);
  }
  Ways ways = point.ways;
  ways[polar] = hn::Zero(Channels());
  const Bounded wrong = sum_in_cell<4>(values, ways, tables.log);
  const Bounded right = sum_on_ring(tables, ring, point, on, channel);
  const V nearness = all(1.0F - point.cell.t[polar]);
  sum.value = hn::MulAdd(nearness, hn::Sub(right.value, wrong.value), sum.value);
  sum.least = smaller(right.least, sum.least);
  sum.most = larger(right.most, sum.most);
}

// A value within its bounds. Where samples lie near the end of what a float holds, slices between them may be no
// number: these bound nothing, and where none is one, the bounds stand in the wrong order. The lower one is then the
// answer.
V held(const Bounded& sum) {
  const V not_below = hn::IfThenElse(hn::Ge(sum.value, sum.least), sum.value, smaller(sum.least, sum.most));
  return hn::IfThenElse(hn::Gt(sum.value, sum.most), sum.most, not_below);
}

// From the value domain to f_r: see DomainMap::inverse, whose branches are chosen lane by lane.
V inverse(const SliceTables::Group& group, bool log, V v) {
  const V least = load(group.least.data());
  const V most = load(group.most.data());
  if (log) {
    const V reference = load(group.reference.data());
    const V floor = load(group.floor.data());
    const V at_floor = load(group.at_floor.data());
    const V at_zero = load(group.at_zero.data());
    const V half_range = all(64.0F);  // exp(v) alone may be infinite
    const M above = hn::Ge(v, at_floor);
    const M far = hn::Gt(v, half_range);
    const V below_mirror = hn::Sub(hn::Sub(at_zero, all(1.0F)), v);
    const V exponent = hn::IfThenElse(above, hn::IfThenElse(far, hn::Mul(v, all(0.5F)), v), below_mirror);
    const V most_exponent = all(88.7F);
    const V power = hn::IfThenElse(hn::Gt(exponent, most_exponent), all(std::numeric_limits<float>::infinity()),
                                   hn::Exp(Channels(), smaller(exponent, most_exponent)));
    const V once = hn::Mul(reference, power);
    const V straight = hn::Mul(floor, hn::Sub(all(1.0F), hn::Sub(at_floor, v)));
    const M near_zero = hn::Gt(v, hn::Sub(at_zero, all(1.0F)));
    V below = hn::IfThenElse(near_zero, straight, hn::Neg(hn::Mul(floor, power)));
    below = hn::IfThenZeroElse(hn::Eq(v, at_zero), below);
    v = hn::IfThenElse(above, hn::IfThenElse(far, hn::Mul(once, power), once), below);
  }
  return smaller(most, larger(least, v));
}

template <std::size_t D>
HWY_INLINE V reconstruct(const SliceTables& tables, const Point& point, std::size_t channel) {
  CellValues<D> values;
  for (std::size_t k = 0; k < values.corners.size(); ++k) {
    values.corners[k] = crossing_value(tables, point.corners[k], channel);
  }
  for (std::size_t k = 0; k < values.lines.size(); ++k) values.lines[k] = line_value(tables, point.lines, k, channel);
  Bounded sum = sum_in_cell<D>(values, point.ways, tables.log);
  if constexpr (D == kAxisCount) {
    for (std::size_t r = 0; r < tables.rings.size(); ++r) {
      const PoleRing& ring = tables.rings[r];
      if (point.cell.index[ring.merging.polar_axis] == 0) {
        correct_at_pole(tables, ring, point, point.rings[r], channel, values, sum);
      }
    }
  }
  return held(sum);
}

template <std::size_t D>
void evaluate_moving(const SliceTables& tables, const Coordinates& x, double guide_angle_deg, float* out) {
  Point point;
  locate(tables, x, point.cell);
  for (std::size_t m = 0; m < D; ++m) point.ways[m] = all(point.cell.way[m]);
  std::array<std::uint32_t, std::size_t{1} << D> corners;
  number_points<D>(tables, point.cell, tables.corner_strides, kMostAxes, corners);
  for (std::size_t k = 0; k < corners.size(); ++k) point.corners[k] = tables.corners[corners[k]];

  add_cell_lines<D>(tables, point.cell, point.lines);
  if constexpr (D == kAxisCount) {
    for (std::size_t r = 0; r < tables.rings.size(); ++r) {
      const PoleRing& ring = tables.rings[r];
      if (point.cell.index[ring.merging.polar_axis] == 0) {
        point.rings[r] = add_ring_lines(tables, ring, point.cell, point.lines);
      }
    }
  }
  if (tables.guided) {
    const double angle = guide_angle_deg > 0 ? std::min(guide_angle_deg, 90.0) : 0.0;
    const std::int32_t place = std::min(polar_place(angle), tables.guide_end);
    point.guide_line = point.lines.count;
    const SliceTables::Line* guide = &tables.guide;
    add_quad(tables, {guide, guide, guide, guide}, {place, place, place, place}, point.lines);
  }

  for (std::size_t g = 0; g < tables.groups.size(); ++g) {
    const std::size_t channel = g * kLanes;
    V v = reconstruct<D>(tables, point, channel);
    if (tables.guided) v = hn::Add(v, line_value(tables, point.lines, point.guide_line, channel));
    v = inverse(tables.groups[g], tables.log, v);
    alignas(16) std::array<float, kLanes> lanes;
    hn::Store(v, Channels(), lanes.data());
    std::copy_n(lanes.data(), std::min(kLanes, tables.channels - channel), out + channel);
  }
}

void EvaluateCoordinates(const SliceTables& tables, const Coordinates& x, double guide_angle_deg, float* values) {
  switch (tables.axes.size()) {
    case 0:
      evaluate_moving<0>(tables, x, guide_angle_deg, values);
      break;
    case 1:
      evaluate_moving<1>(tables, x, guide_angle_deg, values);
      break;
    case 2:
      evaluate_moving<2>(tables, x, guide_angle_deg, values);
      break;
    case 3:
      evaluate_moving<3>(tables, x, guide_angle_deg, values);
      break;
    default:
      evaluate_moving<4>(tables, x, guide_angle_deg, values);
      break;
  }
  tables.grey_shares.take_off(std::span(values, tables.channels));
}

// From here on doubles: angles of pairs of vectors.

constexpr std::size_t kBlock = 16;  // pairs whose angles are worked out together

/// Numbers of the pairs of a block, one array for each; those beyond the last pair mean nothing.
using Column = std::array<double, kBlock>;
struct Vectors {
  alignas(64) std::array<Column, 3> i;
  alignas(64) std::array<Column, 3> v;
};
/// Four angles of each pair as arguments of atan2, which become the angles [degrees], and for half vectors what a guide
/// asks for beside them.
struct Angles {
  alignas(64) std::array<Column, 5> y;
  alignas(64) std::array<Column, 5> x;
};

/// atan2 [degrees] in (-180, 180]; 0 where both are 0.
template <class D>
HWY_INLINE hn::Vec<D> atan2_degrees(D d, hn::Vec<D> y, hn::Vec<D> x) {
  const auto zero = hn::Zero(d);
  const auto ratio = hn::Div(hn::Abs(y), hn::Abs(x));  // infinite: 90 degrees
  auto angle = hn::Mul(hn::Atan(d, ratio), hn::Set(d, 180 / kPi));
  angle = hn::IfThenElse(hn::Eq(y, zero), zero, angle);
  angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(hn::Set(d, 180), angle), angle);
  return hn::IfThenElse(hn::Lt(y, zero), hn::Neg(angle), angle);
}

template <class D>
HWY_INLINE hn::Vec<D> length_of(hn::Vec<D> x, hn::Vec<D> y, hn::Vec<D> z) {
  return hn::Sqrt(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)));
}

/// Half and difference angles, in the order of the frame: phi_h, phi_d, theta_d, theta_h. With h = i + v and e = i - v,
/// theta_d is between their lengths, and e turned by -phi_h about z and by -theta_h about y points to (phi_d, 90). All
/// times lengths, which do not matter. Exchanging i and v negates e, which phi_d does not see.
template <class D>
HWY_INLINE void half_difference_arguments(D d, const Vectors& pairs, std::size_t k, double guide_ratio,
                                          Angles& angles) {
  const auto one = hn::Set(d, 1.0);
  std::array<hn::Vec<D>, 3> i;
  std::array<hn::Vec<D>, 3> v;
  for (std::size_t c = 0; c < 3; ++c) {
    i[c] = hn::Load(d, pairs.i[c].data() + k);
    v[c] = hn::Load(d, pairs.v[c].data() + k);
  }
  const auto i_scale = hn::Div(one, length_of<D>(i[0], i[1], i[2]));
  const auto v_scale = hn::Div(one, length_of<D>(v[0], v[1], v[2]));
  std::array<hn::Vec<D>, 3> h;
  std::array<hn::Vec<D>, 3> e;
  for (std::size_t c = 0; c < 3; ++c) {
    i[c] = hn::Mul(i[c], i_scale);
    v[c] = hn::Mul(v[c], v_scale);
    h[c] = hn::Add(i[c], v[c]);
    e[c] = hn::Sub(i[c], v[c]);
  }
  const auto h_flat2 = hn::Add(hn::Mul(h[0], h[0]), hn::Mul(h[1], h[1]));
  const auto h_flat = hn::Sqrt(h_flat2);
  const auto h_length = hn::Sqrt(hn::Add(h_flat2, hn::Mul(h[2], h[2])));
  // A half vector on the normal has the azimuth 0.
  const auto on_normal = hn::Eq(h_flat2, hn::Zero(d));
  const auto h_x = hn::IfThenElse(on_normal, one, h[0]);
  const auto along = hn::Add(hn::Mul(e[0], h_x), hn::Mul(e[1], h[1]));
  auto across = hn::Mul(hn::Sub(hn::Mul(e[1], h_x), hn::Mul(e[0], h[1])), h_length);
  auto ahead = hn::Sub(hn::Mul(along, h[2]), hn::Mul(e[2], h_flat2));
  // One of the two directions of e, always the same one.
  const auto zero = hn::Zero(d);
  const auto turn = hn::Or(hn::Lt(across, zero), hn::And(hn::Eq(across, zero), hn::Lt(ahead, zero)));
  across = hn::IfThenElse(turn, hn::Neg(across), across);
  ahead = hn::IfThenElse(turn, hn::Neg(ahead), ahead);
  hn::Store(h[1], d, angles.y[kAxial].data() + k);
  hn::Store(h_x, d, angles.x[kAxial].data() + k);
  hn::Store(across, d, angles.y[kDiagonal].data() + k);
  hn::Store(ahead, d, angles.x[kDiagonal].data() + k);
  hn::Store(length_of<D>(e[0], e[1], e[2]), d, angles.y[kHorizontal].data() + k);
  hn::Store(h_length, d, angles.x[kHorizontal].data() + k);
  hn::Store(h_flat, d, angles.y[kVertical].data() + k);
  hn::Store(h[2], d, angles.x[kVertical].data() + k);
  if (guide_ratio == 1) return;
  const auto x = hn::Mul(h[0], hn::Set(d, std::min(1.0, guide_ratio)));
  const auto y = hn::Mul(h[1], hn::Set(d, 1 / std::max(1.0, guide_ratio)));
  hn::Store(hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y))), d, angles.y[kAxisCount].data() + k);
  hn::Store(h[2], d, angles.x[kAxisCount].data() + k);
}

/// theta_i, theta_v, phi_i, phi_v.
template <class D>
HWY_INLINE void elevation_arguments(D d, const Vectors& pairs, std::size_t k, Angles& angles) {
  for (std::size_t side = 0; side < 2; ++side) {
    const std::array<Column, 3>& w = side == 0 ? pairs.i : pairs.v;
    const auto x = hn::Load(d, w[0].data() + k);
    const auto y = hn::Load(d, w[1].data() + k);
    hn::Store(hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y))), d, angles.y[side].data() + k);
    hn::Store(hn::Load(d, w[2].data() + k), d, angles.x[side].data() + k);
    hn::Store(y, d, angles.y[2 + side].data() + k);
    hn::Store(x, d, angles.x[2 + side].data() + k);
  }
}

template <class D>
HWY_INLINE void find_arguments(D d, const SliceTables& tables, const Vectors& pairs, std::size_t k, Angles& angles) {
  if (tables.frame == FrameId::kHalfDifference) {
    half_difference_arguments(d, pairs, k, tables.guide_ratio, angles);
  } else {
    elevation_arguments(d, pairs, k, angles);
  }
}

/// A guide that is as wide both ways, or none, asks for no angle of its own.
std::size_t angle_count(const SliceTables& tables) { return tables.guide_ratio == 1 ? kAxisCount : kAxisCount + 1; }

template <class D>
HWY_INLINE void find_angles(D d, const SliceTables& tables, const Vectors& pairs, std::size_t count, Angles& angles) {
  for (std::size_t k = 0; k < count; k += hn::Lanes(d)) find_arguments(d, tables, pairs, k, angles);
  for (std::size_t column = 0; column < angle_count(tables); ++column) {
    for (std::size_t k = 0; k < count; k += hn::Lanes(d)) {
      const auto y = hn::Load(d, angles.y[column].data() + k);
      const auto x = hn::Load(d, angles.x[column].data() + k);
      hn::Store(atan2_degrees(d, y, x), d, angles.y[column].data() + k);
    }
  }
}

// One pair: its four angles in one vector, which are the same to the last bit.
void find_angles_of_one(const SliceTables& tables, const Vectors& pairs, Angles& angles) {
  find_arguments(hn::CappedTag<double, 1>(), tables, pairs, 0, angles);
  const std::size_t columns = angle_count(tables);
  const hn::CappedTag<double, 4> d4;
  alignas(64) std::array<double, 8> y{};
  alignas(64) std::array<double, 8> x{};
  for (std::size_t column = 0; column < columns; ++column) {
    y[column] = angles.y[column][0];
    x[column] = angles.x[column][0];
  }
  for (std::size_t k = 0; k < columns; k += hn::Lanes(d4)) {
    hn::Store(atan2_degrees(d4, hn::Load(d4, y.data() + k), hn::Load(d4, x.data() + k)), d4, y.data() + k);
  }
  for (std::size_t column = 0; column < columns; ++column) angles.y[column][0] = y[column];
}

Coordinates coordinates_of(const SliceTables& tables, const Angles& angles, std::size_t k) {
  const auto turned = [](double degrees) { return degrees < 0 ? degrees + 360 : degrees; };
  if (tables.frame == FrameId::kHalfDifference) {
    return {turned(angles.y[kAxial][k]), angles.y[kDiagonal][k], angles.y[kHorizontal][k], angles.y[kVertical][k]};
  }
  return elevation_coordinates(angles.y[0][k], turned(angles.y[2][k]), angles.y[1][k], turned(angles.y[3][k]));
}

/// Whether both vectors are directions above the horizon; says what stands in their place where not.
bool take(const float* w, std::size_t pair, std::size_t k, std::array<Column, 3>& into) {
  const float* at = w + 3 * pair;
  const bool finite = std::isfinite(at[0]) && std::isfinite(at[1]) && std::isfinite(at[2]);
  const bool usable = finite && at[2] >= 0 && (at[0] != 0 || at[1] != 0 || at[2] != 0);
  for (std::size_t c = 0; c < 3; ++c) into[c][k] = usable ? static_cast<double>(at[c]) : 1.0;
  return usable;
}

void EvaluateVectors(const SliceTables& tables, const float* w_i, const float* w_v, std::size_t count, float* values) {
  Vectors pairs;
  Angles angles;
  std::array<bool, kBlock> above{};
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t size = std::min(kBlock, count - first);
    for (std::size_t k = 0; k < kBlock; ++k) {
      const std::size_t pair = first + std::min(k, size - 1);
      const bool i_above = take(w_i, pair, k, pairs.i);
      const bool v_above = take(w_v, pair, k, pairs.v);
      above[k] = i_above && v_above;
      if (size == 1) break;
    }
    if (size == 1) {
      find_angles_of_one(tables, pairs, angles);
    } else {
      find_angles(hn::CappedTag<double, 8>(), tables, pairs, size, angles);
    }
    for (std::size_t k = 0; k < size; ++k) {
      float* out = values + (first + k) * tables.channels;
      if (above[k]) {
        const double guide_angle = tables.guide_ratio == 1 ? angles.y[kVertical][k] : angles.y[kAxisCount][k];
        EvaluateCoordinates(tables, coordinates_of(tables, angles, k), guide_angle, out);
      } else {
        std::fill_n(out, tables.channels, 0.0F);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace sbrdf::internal
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sbrdf::internal {

HWY_EXPORT(EvaluateCoordinates);
HWY_EXPORT(EvaluateVectors);

void evaluate_coordinates(const SliceTables& tables, const Coordinates& x, double guide_angle_deg, float* values) {
  HWY_DYNAMIC_DISPATCH(EvaluateCoordinates)(tables, x, guide_angle_deg, values);
}

void evaluate_vectors(const SliceTables& tables, const float* w_i, const float* w_v, std::size_t count, float* values) {
  HWY_DYNAMIC_DISPATCH(EvaluateVectors)(tables, w_i, w_v, count, values);
}

}  // namespace sbrdf::internal
#endif
