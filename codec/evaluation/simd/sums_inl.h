// From the lines of a point to its values. Included by kernel.cpp alone, for each set of instructions anew.
#if defined(SBRDF_SUMS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SBRDF_SUMS_INL_H
#undef SBRDF_SUMS_INL_H
#else
#define SBRDF_SUMS_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "codec/evaluation/simd/lines_inl.h"
#include "codec/evaluation/simd/spots_inl.h"
#include "codec/evaluation/tables/slice_tables.h"

HWY_BEFORE_NAMESPACE();
namespace sbrdf::internal::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kLanes = SliceTables::kLanes;
using Channels = hn::FixedTag<float, kLanes>;  ///< a group of channels
using V = hn::Vec<Channels>;
using Wide = hn::CappedTag<float, 4 * kLanes>;  ///< a group of channels of several lines, or points, at once
constexpr std::size_t kAtOnce = hn::MaxLanes(Wide()) / kLanes;

constexpr float kGreatest = std::numeric_limits<float>::max();

// A candidate that is no number bounds nothing: comparisons with it are false. On x86 an instruction does just that.
template <class Vec>
HWY_INLINE Vec smaller(Vec candidate, Vec present) {
  if constexpr (HWY_ARCH_X86 != 0) return hn::Min(candidate, present);
  return hn::IfThenElse(hn::Lt(candidate, present), candidate, present);
}
template <class Vec>
HWY_INLINE Vec larger(Vec candidate, Vec present) {
  if constexpr (HWY_ARCH_X86 != 0) return hn::Max(candidate, present);
  return hn::IfThenElse(hn::Gt(candidate, present), candidate, present);
}

// Combines the groups of a vector, half by half.
template <class D, class Combine>
HWY_INLINE V fold(D /*d*/, hn::Vec<D> v, const Combine& combine) {
  if constexpr (hn::MaxLanes(D()) == kLanes) {
    return v;
  } else {
    const hn::Half<D> half;
    return fold(half, combine(hn::LowerHalf(half, v), hn::UpperHalf(half, v)), combine);
  }
}

// Numbers k, k + 1, ... for all channels of the first line, the second one, ...
template <class D>
HWY_INLINE hn::Vec<D> spread(D d, const float* numbers) {
  if constexpr (hn::MaxLanes(D()) == kLanes) {
    return hn::Set(d, *numbers);
  } else {
    alignas(64) static constexpr std::array<std::int32_t, 16> kGroups = {0, 0, 0, 0, 1, 1, 1, 1,
                                                                         2, 2, 2, 2, 3, 3, 3, 3};
    return hn::TableLookupLanes(hn::LoadU(d, numbers), hn::SetTableIndices(d, kGroups.data()));
  }
}

// A group of channels at several places of a table.
template <class D>
HWY_INLINE hn::Vec<D> load_rows(D d, const float* table, const std::uint32_t* rows) {
  if constexpr (hn::MaxLanes(D()) == kLanes) {
    return hn::LoadU(d, table + *rows);
  } else {
    const hn::Half<D> half;
    constexpr std::size_t kHere = hn::MaxLanes(D()) / kLanes / 2;
    return hn::Combine(d, load_rows(half, table, rows + kHere), load_rows(half, table, rows));
  }
}

// Here and in what follows products are rounded before they are added, and always in the same order: values do not
// depend on whether a processor fuses both, nor on how wide its vectors are.
template <class D>
HWY_INLINE hn::Vec<D> line_values(Exact /*form*/, D d, const SliceTables& tables, const Lines& lines, std::size_t lane,
                                  std::size_t channel) {
  const std::size_t channels = tables.channels;
  const float* values = tables.row_values.data() + channel;
  const std::uint32_t* rows = lines.row.data() + lane;
  const auto y_0 = hn::Mul(spread(d, lines.y_0.data() + lane), load_rows(d, values, rows));
  const auto y_1 = hn::Mul(spread(d, lines.y_1.data() + lane), load_rows(d, values + 2 * channels, rows));
  const auto m_0 = hn::Mul(spread(d, lines.m_0.data() + lane), load_rows(d, values + channels, rows));
  const auto m_1 = hn::Mul(spread(d, lines.m_1.data() + lane), load_rows(d, values + 3 * channels, rows));
  return hn::Add(hn::Add(y_0, y_1), hn::Add(m_0, m_1));
}

template <class D>
HWY_INLINE hn::Vec<D> line_values(Presampled /*form*/, D d, const SliceTables& tables, const Lines& lines,
                                  std::size_t lane, std::size_t channel) {
  const float* values = tables.row_values.data() + channel;
  const std::uint32_t* rows = lines.row.data() + lane;
  return hn::Add(hn::Mul(spread(d, lines.y_0.data() + lane), load_rows(d, values, rows)),
                 hn::Mul(spread(d, lines.y_1.data() + lane), load_rows(d, values + tables.channels, rows)));
}

/// A group of channels of what the slices say in a cell: the multilinear means of the corners and of the lines along
/// each axis, and between what the lines lie.
template <class Vec>
struct Means {
  Vec corners;
  std::array<Vec, kAxisCount> lines;  ///< by moving axis
  Vec least;
  Vec most;
};

/// A group of channels of all corners and lines of a cell.
template <std::size_t D>
struct CellValues {
  alignas(64) std::array<float, kCornerLanes<D> * kLanes> corners;
  alignas(64) std::array<float, std::max<std::size_t>(1, kCellLines<D>) * kLanes> lines;
};

template <std::size_t D, class Form>
HWY_INLINE void load_cell(Form form, const SliceTables& tables, const Point& point, std::size_t channel,
                          CellValues<D>& values) {
  const Wide d;
  const auto channels = static_cast<std::uint32_t>(tables.channels);
  alignas(64) std::array<std::uint32_t, kCornerLanes<D>> rows;
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = tables.lattice->corners[point.corners[k]] * channels;
  for (std::size_t k = 0; k < rows.size(); k += kAtOnce) {
    hn::Store(load_rows(d, tables.crossing_values.data() + channel, rows.data() + k), d,
              values.corners.data() + k * kLanes);
  }
  for (std::size_t lane = 0; lane < kCellLines<D>; lane += kAtOnce) {
    hn::Store(line_values(form, d, tables, point.lines, lane, channel), d, values.lines.data() + lane * kLanes);
  }
}

// The sum of rows, a multiple of four: of every fourth one, then of these four sums. `rows_from` gives as many as a
// vector holds.
template <class D, class RowsFrom>
HWY_INLINE V sum_rows(D d, std::size_t count, const RowsFrom& rows_from) {
  std::array<hn::Vec<D>, kQuad / kAtOnce> sums;
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k] = rows_from(k * kAtOnce);
  for (std::size_t first = kQuad; first < count; first += kQuad) {
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] = hn::Add(sums[k], rows_from(first + k * kAtOnce));
  }
  for (std::size_t left = sums.size() / 2; left > 0; left /= 2) {
    for (std::size_t k = 0; k < left; ++k) sums[k] = hn::Add(sums[k], sums[k + left]);
  }
  return fold(d, sums[0], [](auto a, auto b) HWY_ATTR { return hn::Add(a, b); });
}

// Where all but two weights are 0, the order does not count either, and the means of corners and of lines that all end
// there are the same to the last bit.
template <class D>
HWY_INLINE V weighted_sum(D d, const float* values, const float* weights, std::size_t count) {
  return sum_rows(d, count, [&](std::size_t k) HWY_ATTR {
    return hn::Mul(spread(d, weights + k), hn::Load(d, values + k * kLanes));
  });
}

template <std::size_t D>
HWY_INLINE void find_means(const CellValues<D>& values, const Weights& weights, Means<V>& means) {
  constexpr std::size_t kAlong = lines_along(D);
  const Wide d;
  means.corners = weighted_sum(d, values.corners.data(), weights.corners.data(), kCornerLanes<D>);
  auto least = hn::Set(d, kGreatest);
  auto most = hn::Set(d, -kGreatest);
  for (std::size_t m = 0; m < D; ++m) {
    const float* along = values.lines.data() + m * kAlong * kLanes;
    for (std::size_t k = 0; k < kAlong * kLanes; k += hn::Lanes(d)) {
      least = smaller(hn::Load(d, along + k), least);
      most = larger(hn::Load(d, along + k), most);
    }
    means.lines[m] = weighted_sum(d, along, weights.lines.data() + m * kAlong, kAlong);
  }
  means.least = fold(d, least, [](auto a, auto b) HWY_ATTR { return smaller(a, b); });
  means.most = fold(d, most, [](auto a, auto b) HWY_ATTR { return larger(a, b); });
}

/// A group of channels of a reconstruction, and between what it may lie.
template <class Vec>
struct Bounded {
  Vec value;
  Vec least;
  Vec most;
};

/// m_1 + ... + m_d - (d - 1) c as c + (m_1 - c) + ... + (m_d - c), with one change: the mean that differs most from the
/// corners is taken as it is and only the others by their differences. At a sample only one of the means differs, so
/// the sample comes back to the last bit; c + (m - c) would round twice. The sum is kept at or above the least slice
/// and, where asked for, at or below the greatest.
template <std::size_t N, class D>
HWY_INLINE Bounded<hn::Vec<D>> sum_of(D d, const Means<hn::Vec<D>>& means, bool above) {
  const auto corners = means.corners;
  auto best = corners;
  auto best_difference = hn::Zero(d);
  auto others = hn::Zero(d);
  for (std::size_t m = 0; m < N; ++m) {
    const auto difference = hn::Sub(means.lines[m], corners);
    const auto farther = hn::Gt(hn::Abs(difference), hn::Abs(best_difference));
    others = hn::Add(others, hn::IfThenElse(farther, best_difference, difference));
    best = hn::IfThenElse(farther, means.lines[m], best);
    best_difference = hn::IfThenElse(farther, difference, best_difference);
  }
  Bounded<hn::Vec<D>> result;
  result.least = N > 0 ? means.least : hn::Set(d, -kGreatest);
  result.most = N > 0 && above ? means.most : hn::Set(d, kGreatest);
  result.value = smaller(result.most, larger(result.least, hn::Add(best, others)));
  return result;
}

// The same sum on a ring, where two coordinates are left: corners and slices of the cell of these two.
template <class Form>
Bounded<V> sum_on_ring(Form form, const SliceTables& tables, std::size_t r, const Point& point, std::size_t channel) {
  const Channels d;
  const LatticeTables& lattice = *tables.lattice;
  const LatticeTables::Ring& ring = lattice.rings[r];
  const RingCell& on = point.rings[r];
  const auto mixed = [&](float t, V first, V second) HWY_ATTR {
    return hn::Add(hn::Mul(hn::Set(d, 1.0F - t), first), hn::Mul(hn::Set(d, t), second));
  };
  const float across = point.t[ring.along];
  const std::uint32_t stride = lattice.corner_strides[ring.along];
  std::array<V, 4> corners;  // bit 0: along the ring, bit 1: along the other polar axis
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t at = on.nodes[k & 1U][0] + (point.index[ring.along] + (k >> 1U)) * stride;
    corners[k] = hn::LoadU(d, tables.crossing_values.data() + lattice.corners[at] * tables.channels + channel);
  }
  Means<V> means;
  means.corners = mixed(on.t, mixed(across, corners[0], corners[2]), mixed(across, corners[1], corners[3]));
  std::array<V, kQuad> lines;
  means.least = hn::Set(d, kGreatest);
  means.most = hn::Set(d, -kGreatest);
  for (std::size_t k = 0; k < kQuad; ++k) {
    lines[k] = line_values(form, d, tables, point.lines, ring_line<kAxisCount>(r) + k, channel);
    means.least = smaller(lines[k], means.least);
    means.most = larger(lines[k], means.most);
  }
  means.lines[0] = mixed(across, lines[0], lines[1]);
  means.lines[1] = mixed(on.t, lines[2], lines[3]);
  return sum_of<2>(d, means, tables.log);
}

HWY_INLINE std::size_t first_row(Exact /*form*/, const SliceTables& tables, std::uint32_t bucket) {
  return tables.knot_buckets[bucket].knot;
}
HWY_INLINE std::size_t first_row(Presampled /*form*/, const SliceTables& tables, std::uint32_t bucket) {
  return tables.row_buckets[bucket].row;
}

// The sum of the cell where the polar axis of the ring is 0: lines along the other axes are what they are in the cell,
// those along the polar axis are met at their beginnings.
template <class Form>
Bounded<V> sum_on_face(Form form, const SliceTables& tables, std::size_t polar, const Point& point, std::size_t channel,
                       CellValues<kAxisCount> values) {
  constexpr std::size_t kAlong = lines_along(kAxisCount);
  for (std::size_t lane = polar * kAlong; lane < (polar + 1) * kAlong; ++lane) {
    const SliceTables::Line& line = tables.lines[point.lines.number[lane] / LatticeTables::kLineWords];
    const float* first = tables.row_values.data() + first_row(form, tables, line.first_bucket) * tables.row_size;
    hn::Store(hn::LoadU(Channels(), first + channel), Channels(), values.lines.data() + lane * kLanes);
  }
  std::array<float, kAxisCount> t = point.t;
  t[polar] = 0;
  Weights weights;
  weigh<kAxisCount>(*tables.lattice, t, weights);
  Means<V> means;
  find_means<kAxisCount>(values, weights, means);
  return sum_of<kAxisCount>(Channels(), means, tables.log);
}

/// Sums of a group of channels of the points of a block, and what the rings change.
struct Sums {
  template <class T>
  using Each = std::array<T, kBlock * kLanes>;

  alignas(64) Each<float> corners;
  alignas(64) std::array<Each<float>, kAxisCount> lines;
  alignas(64) Each<float> least;
  alignas(64) Each<float> most;
  alignas(64) Each<float> guide;
  alignas(64) std::array<Each<float>, 2> ring_shift;
  alignas(64) Each<float> ring_least;
  alignas(64) Each<float> ring_most;
};

// On the face at which the azimuths are one, the sum in the cell depends on both, since it blends slices of different
// places on the ring. What is wrong there is known, and is taken out of the whole cell, the less the farther from the
// face. On all slices it is 0, so that samples stay samples.
template <class Form>
HWY_INLINE void add_rings(Form form, const SliceTables& tables, const Point& point,
                          const CellValues<kAxisCount>& values, std::size_t channel, std::size_t at, Sums& sums) {
  const Channels d;
  V least = hn::Set(d, kGreatest);
  V most = hn::Set(d, -kGreatest);
  for (std::size_t r = 0; r < tables.lattice->rings.size(); ++r) {
    V shift = hn::Zero(d);
    if (point.on_ring[r]) {
      const std::size_t polar = tables.lattice->rings[r].polar_axis;
      const Bounded<V> wrong = sum_on_face(form, tables, polar, point, channel, values);
      const Bounded<V> right = sum_on_ring(form, tables, r, point, channel);
      shift = hn::Mul(hn::Set(d, 1.0F - point.t[polar]), hn::Sub(right.value, wrong.value));
      least = smaller(right.least, least);
      most = larger(right.most, most);
    }
    hn::Store(shift, d, sums.ring_shift[r].data() + at);
  }
  hn::Store(least, d, sums.ring_least.data() + at);
  hn::Store(most, d, sums.ring_most.data() + at);
}

template <std::size_t D, class Form>
HWY_INLINE void add_sums(Form form, const SliceTables& tables, const Point& point, std::size_t channel,
                         std::size_t pair, Sums& sums) {
  const Channels d;
  const std::size_t at = pair * kLanes;
  CellValues<D> values;
  load_cell<D>(form, tables, point, channel, values);
  Means<V> means;
  find_means<D>(values, point.weights, means);
  hn::Store(means.corners, d, sums.corners.data() + at);
  for (std::size_t m = 0; m < D; ++m) hn::Store(means.lines[m], d, sums.lines[m].data() + at);
  hn::Store(means.least, d, sums.least.data() + at);
  hn::Store(means.most, d, sums.most.data() + at);
  if (tables.guided)
    hn::Store(line_values(form, d, tables, point.lines, kGuideLine<D>, channel), d, sums.guide.data() + at);
  if constexpr (D == kAxisCount) {
    if (!tables.lattice->rings.empty()) add_rings(form, tables, point, values, channel, at, sums);
  }
}

// A value within its bounds. Where samples lie near the end of what a float holds, slices between them may be no
// number: these bound nothing, and where none is one, the bounds stand in the wrong order. The lower one is then the
// answer.
template <class Vec>
HWY_INLINE Vec held(const Bounded<Vec>& sum) {
  const Vec not_below = hn::IfThenElse(hn::Ge(sum.value, sum.least), sum.value, smaller(sum.least, sum.most));
  return hn::IfThenElse(hn::Gt(sum.value, sum.most), sum.most, not_below);
}

// From the value domain to f_r: see DomainMap::inverse, whose branches are chosen lane by lane.
template <class D>
HWY_INLINE hn::Vec<D> inverse(D d, const SliceTables::Group& group, bool log, hn::Vec<D> v) {
  const auto all = [&](float value) HWY_ATTR { return hn::Set(d, value); };
  if (log) {
    const auto reference = hn::LoadDup128(d, group.reference.data());
    const auto floor = hn::LoadDup128(d, group.floor.data());
    const auto at_floor = hn::LoadDup128(d, group.at_floor.data());
    const auto at_zero = hn::LoadDup128(d, group.at_zero.data());
    const auto half_range = all(64.0F);  // exp(v) alone may be infinite
    const auto above = hn::Ge(v, at_floor);
    const auto far = hn::Gt(v, half_range);
    const auto below_mirror = hn::Sub(hn::Sub(at_zero, all(1.0F)), v);
    const auto exponent = hn::IfThenElse(above, hn::IfThenElse(far, hn::Mul(v, all(0.5F)), v), below_mirror);
    const auto most_exponent = all(88.7F);
    const auto power = hn::IfThenElse(hn::Gt(exponent, most_exponent), all(std::numeric_limits<float>::infinity()),
                                      hn::Exp(d, smaller(exponent, most_exponent)));
    const auto once = hn::Mul(reference, power);
    const auto straight = hn::Mul(floor, hn::Sub(all(1.0F), hn::Sub(at_floor, v)));
    const auto near_zero = hn::Gt(v, hn::Sub(at_zero, all(1.0F)));
    auto below = hn::IfThenElse(near_zero, straight, hn::Neg(hn::Mul(floor, power)));
    below = hn::IfThenZeroElse(hn::Eq(v, at_zero), below);
    v = hn::IfThenElse(above, hn::IfThenElse(far, hn::Mul(once, power), once), below);
  }
  return smaller(hn::LoadDup128(d, group.most.data()), larger(hn::LoadDup128(d, group.least.data()), v));
}

/// The values of as many points as fit into a vector.
template <std::size_t N, class D>
HWY_INLINE void finish(D d, const SliceTables& tables, const SliceTables::Group& group, const Sums& sums,
                       std::size_t pair, float* values) {
  const std::size_t at = pair * kLanes;
  Means<hn::Vec<D>> means;
  means.corners = hn::Load(d, sums.corners.data() + at);
  for (std::size_t m = 0; m < N; ++m) means.lines[m] = hn::Load(d, sums.lines[m].data() + at);
  means.least = hn::Load(d, sums.least.data() + at);
  means.most = hn::Load(d, sums.most.data() + at);
  Bounded<hn::Vec<D>> sum = sum_of<N>(d, means, tables.log);
  if constexpr (N == kAxisCount) {
    const std::size_t rings = tables.lattice->rings.size();
    for (std::size_t r = 0; r < rings; ++r) sum.value = hn::Add(sum.value, hn::Load(d, sums.ring_shift[r].data() + at));
    if (rings > 0) {
      sum.least = smaller(hn::Load(d, sums.ring_least.data() + at), sum.least);
      sum.most = larger(hn::Load(d, sums.ring_most.data() + at), sum.most);
    }
  }
  auto v = held(sum);
  if (tables.guided) v = hn::Add(v, hn::Load(d, sums.guide.data() + at));
  hn::Store(inverse(d, group, tables.log, v), d, values + at);
}

// A group of channels of a block to where all channels of each point stand together.
HWY_INLINE void spread_out(const SliceTables& tables, const float* block, std::size_t group, std::size_t count,
                           float* values) {
  const std::size_t channel = group * kLanes;
  const std::size_t here = std::min(kLanes, tables.channels - channel);
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t c = 0; c < here; ++c) values[k * tables.channels + channel + c] = block[k * kLanes + c];
  }
}
HWY_INLINE void take_off_shares(const SliceTables& tables, std::size_t count, float* values) {
  if (!tables.grey_shares.active()) return;
  for (std::size_t k = 0; k < count; ++k) {
    tables.grey_shares.take_off(std::span(values + k * tables.channels, tables.channels));
  }
}

/// What is left to do for the points of a block from `k` on, as many at once as a vector holds; a single one by itself.
template <class Finish>
HWY_INLINE void finish_block(std::size_t count, const Finish& finish_from) {
  if (count == 1) return finish_from(Channels(), 0);
  for (std::size_t k = 0; k < count; k += kAtOnce) finish_from(Wide(), k);
}

/// The values of the first points of a block; `values` has a row for each.
template <std::size_t D, class Form>
HWY_INLINE void evaluate_points(Form form, const SliceTables& tables, const Spots& spots, std::size_t count,
                                float* values) {
  std::array<Point, kBlock> points;
  for (std::size_t k = 0; k < count; ++k) find_lines<D>(form, tables, spots.x[k].data(), spots.guide[k], points[k]);
  for (std::size_t g = 0; g < tables.groups.size(); ++g) {
    const std::size_t channel = g * kLanes;
    Sums sums;
    alignas(64) std::array<float, kBlock * kLanes> block;
    for (std::size_t k = 0; k < count; ++k) add_sums<D>(form, tables, points[k], channel, k, sums);
    finish_block(
        count, [&](auto d, std::size_t k) HWY_ATTR { finish<D>(d, tables, tables.groups[g], sums, k, block.data()); });
    spread_out(tables, block.data(), g, count, values);
  }
  take_off_shares(tables, count, values);
}

}  // namespace
}  // namespace sbrdf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
