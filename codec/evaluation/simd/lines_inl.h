// From where a point lies to the lines that it needs: which knots, and what their values weigh. Included by kernel.cpp
// alone, for each set of instructions anew.
#if defined(SBRDF_LINES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SBRDF_LINES_INL_H
#undef SBRDF_LINES_INL_H
#else
#define SBRDF_LINES_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <hwy/highway.h>

#include "codec/evaluation/tables/slice_tables.h"

HWY_BEFORE_NAMESPACE();
namespace sbrdf::internal::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// In which form the curves are: splines, or straight between rows (see SliceTables).
struct Exact {};
struct Presampled {};

/// Lines that one point can need: those of its cell, four of each of two rings, and those of a guide, which are one and
/// the same four times.
constexpr std::size_t kMostLines = LatticeTables::kMostCellLines + 3 * kQuad + kQuad;

/// The lines of a point, lane by lane. The value on a line is
///
///   y = y_0 y_first + y_1 y_last + m_0 slope_first + m_1 slope_last
///
/// the cubic of specs/conventions.md, with numbers that are 0 and 1 at either knot, so that samples come out exactly.
/// Curves that are straight between rows have no slopes.
struct Lines {
  template <class T>
  using Lanes = std::array<T, kMostLines + 16>;  // vectors are read from any lane on

  alignas(64) Lanes<std::uint32_t> number;  ///< in words of SliceTables::lines
  alignas(64) Lanes<std::uint32_t> row;     ///< of the first knot, in SliceTables::row_values
  alignas(64) Lanes<float> y_0;
  alignas(64) Lanes<float> y_1;
  alignas(64) Lanes<float> m_0;
  alignas(64) Lanes<float> m_1;
};

/// What the corners and the lines of a cell weigh in their multilinear means.
struct Weights {
  alignas(64) std::array<float, 16 + 16> corners;
  alignas(64) std::array<float, LatticeTables::kMostCellLines + 16> lines;
};

/// A ring as the point meets it.
struct RingCell {
  std::array<std::array<std::uint32_t, 2>, 2> nodes;  ///< of LatticeTables::Ring::node_tables
  float t;                                            ///< between them
};

struct PointInCell {
  alignas(16) std::array<std::uint32_t, kAxisCount> index;  ///< of its cell, by axis
  alignas(16) std::array<float, kAxisCount> t;              ///< fraction of the way to the next node, likewise
};

/// Everything about a point that is the same for all channels.
struct Point : PointInCell {
  Lines lines;
  Weights weights;
  alignas(64) std::array<std::uint32_t, 16> corners;  ///< in LatticeTables::corners
  std::array<RingCell, 2> rings;
  std::array<bool, 2> on_ring;  ///< whether the point is in the first cell of the ring's polar axis
};

template <std::size_t D>
constexpr std::size_t kCellLines = D* lines_along(D);
/// With those of a guide, where these are found with them: three axes leave room for it in a vector.
template <std::size_t D>
constexpr std::size_t kLinesTogether = D == 3 ? LatticeTables::kLinesOfThree : kCellLines<D>;
template <std::size_t D>
constexpr std::size_t kGuideLine = kCellLines<D>;
template <std::size_t D>
constexpr std::size_t ring_line(std::size_t ring) {
  return kCellLines<D> + kQuad + ring * kQuad;
}

/// Which of the moving axes counts for a lane, and on which side of it the lane is.
template <std::size_t D, std::size_t kLaneCount>
struct Sides {
  std::array<std::array<float, kLaneCount>, D> fixed;  ///< the weight is fixed + slope t
  std::array<std::array<float, kLaneCount>, D> slope;
};

template <std::size_t D>
constexpr Sides<D, kCellLines<D>> line_sides() {
  Sides<D, kCellLines<D>> sides{};
  constexpr std::size_t kAlong = lines_along(D);
  for (std::size_t lane = 0; lane < kCellLines<D>; ++lane) {
    const bool again = lane % kAlong >= (std::size_t{1} << D) / 2;
    std::size_t bit = 0;
    for (std::size_t m = 0; m < D; ++m) {
      if (m == lane / kAlong || again) {
        sides.fixed[m][lane] = again ? 0.0F : 1.0F;
        continue;
      }
      const bool far = (lane % kAlong >> bit++ & 1U) != 0;
      sides.fixed[m][lane] = far ? 0.0F : 1.0F;
      sides.slope[m][lane] = far ? 1.0F : -1.0F;
    }
  }
  return sides;
}

template <std::size_t D>
constexpr Sides<D, 16> corner_sides() {
  Sides<D, 16> sides{};
  for (std::size_t corner = 0; corner < 16; ++corner) {
    const bool again = corner >= (std::size_t{1} << D);
    for (std::size_t m = 0; m < D; ++m) {
      const bool far = (corner >> m & 1U) != 0;
      sides.fixed[m][corner] = far || again ? 0.0F : 1.0F;
      sides.slope[m][corner] = again ? 0.0F : far ? 1.0F : -1.0F;
    }
  }
  return sides;
}

template <std::size_t D>
struct CellSides {
  alignas(64) static constexpr Sides<D, kCellLines<D>> kLines = line_sides<D>();
  alignas(64) static constexpr Sides<D, 16> kCorners = corner_sides<D>();
};

template <std::size_t D, std::size_t kLaneCount>
HWY_INLINE void weigh_lanes(const Sides<D, kLaneCount>& sides, const std::uint32_t* axes,
                            const std::array<float, kAxisCount>& t, float* weights) {
  constexpr std::size_t kStep = kLaneCount % 16 == 0 ? 16 : kLaneCount % 8 == 0 ? 8 : 4;
  const hn::CappedTag<float, kStep> d;
  for (std::size_t lane = 0; lane < kLaneCount; lane += hn::Lanes(d)) {
    auto weight = hn::MulAdd(hn::LoadU(d, sides.slope[0].data() + lane), hn::Set(d, t[axes[0]]),
                             hn::LoadU(d, sides.fixed[0].data() + lane));
    for (std::size_t m = 1; m < D; ++m) {
      weight = hn::Mul(weight, hn::MulAdd(hn::LoadU(d, sides.slope[m].data() + lane), hn::Set(d, t[axes[m]]),
                                          hn::LoadU(d, sides.fixed[m].data() + lane)));
    }
    hn::Store(weight, d, weights + lane);
  }
}

template <std::size_t D>
HWY_INLINE void weigh_corners(const LatticeTables& lattice, const std::array<float, kAxisCount>& t, float* weights) {
  if constexpr (D > 0) {
    weigh_lanes<D>(CellSides<D>::kCorners, lattice.axes.data(), t, weights);
  } else {
    weights[0] = 1;
    for (std::size_t k = 1; k < kQuad; ++k) weights[k] = 0;
  }
}
template <std::size_t D>
HWY_INLINE void weigh(const LatticeTables& lattice, const std::array<float, kAxisCount>& t, Weights& weights) {
  if constexpr (D > 0) weigh_lanes<D>(CellSides<D>::kLines, lattice.axes.data(), t, weights.lines.data());
  weigh_corners<D>(lattice, t, weights.corners.data());
}

// What was stored at an address, so that compilers read it there: taking numbers out of a vector costs more.
template <class T, std::size_t N>
HWY_INLINE const T* stored(const std::array<T, N>& values) {
  const T* at = values.data();
#if HWY_COMPILER_GCC || HWY_COMPILER_CLANG
  __asm__ volatile("" : "+r"(at) : "m"(values));
#endif
  return at;
}
/// Numbers on their way to addresses.
using Numbers = std::array<std::uint32_t, 16>;

// N records of 4 words or less, every fourth of the numbers, each in a block of a vector.
template <std::size_t N>
HWY_INLINE hn::Vec<hn::FixedTag<std::uint32_t, 4 * N>> load_blocks(const std::uint32_t* words,
                                                                   const std::uint32_t* numbers) {
  const hn::FixedTag<std::uint32_t, 4 * N> d;
  if constexpr (N == 1) {
    return hn::LoadU(d, words + *numbers);
  } else {
    return hn::Combine(d, load_blocks<N / 2>(words, numbers + 2 * N), load_blocks<N / 2>(words, numbers));
  }
}

/// The words of the records at `numbers`, each in a vector of its own.
template <class D>
struct Words {
  std::array<hn::Vec<D>, 4> word;
};
template <class D>
HWY_INLINE Words<D> load_records(D d, const std::uint32_t* words, hn::Vec<D> at) {
  constexpr std::size_t kBlocks = hn::MaxLanes(D()) / 4;
  const hn::Repartition<std::uint64_t, D> pairs;
  alignas(64) Numbers numbers;
  hn::Store(at, d, numbers.data());
  const std::uint32_t* from = stored(numbers);
  const auto a = load_blocks<kBlocks>(words, from);
  const auto b = load_blocks<kBlocks>(words, from + 1);
  const auto c = load_blocks<kBlocks>(words, from + 2);
  const auto e = load_blocks<kBlocks>(words, from + 3);
  const auto low_ab = hn::BitCast(pairs, hn::InterleaveLower(d, a, b));
  const auto low_ce = hn::BitCast(pairs, hn::InterleaveLower(d, c, e));
  const auto high_ab = hn::BitCast(pairs, hn::InterleaveUpper(d, a, b));
  const auto high_ce = hn::BitCast(pairs, hn::InterleaveUpper(d, c, e));
  return {hn::BitCast(d, hn::InterleaveLower(pairs, low_ab, low_ce)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, low_ab, low_ce)),
          hn::BitCast(d, hn::InterleaveLower(pairs, high_ab, high_ce)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, high_ab, high_ce))};
}

// Pairs of words at places of an array, N of them.
template <std::size_t N>
HWY_INLINE hn::Vec<hn::FixedTag<std::uint64_t, N>> load_pairs(const std::uint32_t* words,
                                                              const std::uint32_t* numbers) {
  if constexpr (N == 1) {
    const hn::FixedTag<std::uint32_t, 2> d2;
    return hn::BitCast(hn::FixedTag<std::uint64_t, 1>(), hn::LoadU(d2, words + *numbers));
  } else {
    return hn::Combine(hn::FixedTag<std::uint64_t, N>(), load_pairs<N / 2>(words, numbers + N / 2),
                       load_pairs<N / 2>(words, numbers));
  }
}
/// As vectors of the first and of the second words.
template <class D>
HWY_INLINE void load_pairs(D d, const std::uint32_t* words, const std::uint32_t* numbers, hn::Vec<D>& first,
                           hn::Vec<D>& second) {
  constexpr std::size_t kHalf = hn::MaxLanes(D()) / 2;
  const auto low = hn::BitCast(d, load_pairs<kHalf>(words, numbers));
  const auto high = hn::BitCast(d, load_pairs<kHalf>(words, numbers + kHalf));
  first = hn::ConcatEven(d, high, low);
  second = hn::ConcatOdd(d, high, low);
}

/// The cell of each axis that holds a point, and how far through it.
HWY_INLINE void find_cells(const LatticeTables& lattice, const std::uint32_t* x, PointInCell& point) {
  const hn::FixedTag<std::uint32_t, kAxisCount> d;
  const hn::FixedTag<std::int32_t, kAxisCount> di;
  const hn::FixedTag<float, kAxisCount> df;
  const auto last = hn::Set(d, static_cast<std::uint32_t>(kLastPlace));
  const auto place = hn::Min(hn::ShiftRight<1>(hn::Load(d, x)), last);
  const auto bucket =
      hn::Add(hn::Load(d, lattice.first_bucket.data()), hn::Shr(place, hn::Load(d, lattice.bucket_shift.data())));
  alignas(16) std::array<std::uint32_t, kAxisCount> numbers;
  hn::Store(hn::Add(bucket, bucket), d, numbers.data());
  hn::Vec<decltype(d)> cell, split;
  load_pairs(d, &lattice.cell_buckets.data()->first, stored(numbers), cell, split);
  const auto passed = hn::Not(hn::Lt(hn::BitCast(di, place), hn::BitCast(di, split)));
  cell = hn::Sub(cell, hn::BitCast(d, hn::VecFromMask(di, passed)));  // comparisons give -1
  const std::uint32_t* words = reinterpret_cast<const std::uint32_t*>(lattice.cells.data());
  for (;;) {
    const auto found = load_records(d, words, hn::Add(cell, hn::Add(cell, cell)));
    const auto behind = hn::Lt(hn::BitCast(di, place), hn::BitCast(di, found.word[1]));
    if (HWY_LIKELY(hn::AllTrue(di, behind))) {
      const auto way = hn::ConvertTo(df, hn::BitCast(di, hn::Sub(place, found.word[0])));
      hn::Store(hn::Div(way, hn::BitCast(df, found.word[2])), df, point.t.data());
      break;
    }
    cell = hn::Sub(cell, hn::BitCast(d, hn::VecFromMask(di, hn::Not(behind))));
  }
  hn::Store(hn::Sub(cell, hn::Load(d, lattice.first_cell.data())), d, point.index.data());
}

/// Where the lines at `number` are met on their curves at these turns: a place, and the bucket that it is in.
template <class D>
struct Met {
  hn::Vec<D> place;
  hn::Vec<D> bucket;
  hn::Vec<D> bucket_shift;
};
template <class D>
HWY_INLINE Met<D> meet(D d, const SliceTables& tables, hn::Vec<D> number, hn::Vec<D> turn) {
  const hn::RebindToSigned<D> di;
  const Words<D> line = load_records(d, &tables.lines.data()->first_bucket, number);
  const auto shape = line.word[2];
  const auto sign = hn::BitCast(d, hn::ShiftRight<31>(hn::BitCast(di, shape)));
  const auto low_bits = hn::Set(d, 31U);
  const auto own = hn::Shl(hn::Add(hn::Sub(hn::Xor(turn, sign), sign), line.word[1]),
                           hn::And(hn::ShiftRight<SliceTables::kTurnShift>(shape), low_bits));
  const auto mirrored = hn::Ne(hn::And(shape, hn::Set(d, SliceTables::kMirrored)), hn::Zero(d));
  const auto folded = hn::IfThenElse(mirrored, hn::Min(own, hn::Sub(hn::Zero(d), own)), hn::ShiftRight<1>(own));
  Met<D> met;
  met.place = hn::Min(folded, hn::Set(d, static_cast<std::uint32_t>(kLastPlace)));
  met.bucket_shift = hn::And(shape, low_bits);
  met.bucket = hn::Add(line.word[0], hn::Shr(met.place, met.bucket_shift));
  return met;
}

/// The knots and weights of a vector of lines, given by their numbers and where they are met.
template <class D>
HWY_INLINE void add_lines(Exact /*form*/, D d, const SliceTables& tables, hn::Vec<D> number, hn::Vec<D> turn,
                          std::size_t lane, Lines& lines) {
  const hn::RebindToSigned<D> di;
  const hn::RebindToFloat<D> df;
  const Met<D> met = meet(d, tables, number, turn);
  const auto place = hn::BitCast(di, met.place);
  const Words<D> bucket = load_records(d, &tables.knot_buckets.data()->knot, hn::ShiftLeft<2>(met.bucket));
  const auto before_split = hn::RebindMask(d, hn::Lt(place, hn::BitCast(di, bucket.word[2])));
  auto knot = hn::IfThenElse(before_split, bucket.word[0], hn::Add(bucket.word[0], hn::Set(d, 1U)));
  auto from = hn::IfThenElse(before_split, bucket.word[1], bucket.word[2]);
  auto to = hn::IfThenElse(before_split, bucket.word[2], bucket.word[3]);
  for (;;) {
    const auto behind = hn::Lt(place, hn::BitCast(di, to));
    if (HWY_LIKELY(hn::AllTrue(di, behind))) break;
    knot = hn::Sub(knot, hn::BitCast(d, hn::VecFromMask(di, hn::Not(behind))));  // comparisons give -1
    alignas(64) Numbers numbers;
    hn::Store(knot, d, numbers.data());
    load_pairs(d, reinterpret_cast<const std::uint32_t*>(tables.places.data()), stored(numbers), from, to);
  }
  hn::Store(hn::Mul(knot, hn::Set(d, tables.row_size)), d, lines.row.data() + lane);
  const auto one = hn::Set(df, 1.0F);
  const auto width = hn::Max(hn::ConvertTo(df, hn::BitCast(di, hn::Sub(to, from))), one);  // 0 if two are in one place
  const auto t = hn::Div(hn::ConvertTo(df, hn::BitCast(di, hn::Sub(met.place, from))), width);
  const auto s = hn::Sub(one, t);
  const auto reach = hn::Mul(hn::Mul(s, t), hn::Mul(width, hn::Set(df, 1.0F / kWidthUnit)));
  const auto last = hn::Mul(hn::Mul(t, t), hn::Sub(hn::Set(df, 3.0F), hn::Add(t, t)));
  hn::Store(hn::Sub(one, last), df, lines.y_0.data() + lane);
  hn::Store(last, df, lines.y_1.data() + lane);
  hn::Store(hn::Mul(reach, s), df, lines.m_0.data() + lane);
  hn::Store(hn::Neg(hn::Mul(reach, t)), df, lines.m_1.data() + lane);
}

/// The same for curves that are straight between rows: a bucket says which row it begins with and, as the log2 of
/// places, how far its rows are apart.
template <class D>
HWY_INLINE void add_lines(Presampled /*form*/, D d, const SliceTables& tables, hn::Vec<D> number, hn::Vec<D> turn,
                          std::size_t lane, Lines& lines) {
  const hn::RebindToSigned<D> di;
  const hn::RebindToFloat<D> df;
  const Met<D> met = meet(d, tables, number, turn);
  alignas(64) Numbers numbers;
  hn::Store(hn::Add(met.bucket, met.bucket), d, numbers.data());
  hn::Vec<D> first, step_shift;
  load_pairs(d, &tables.row_buckets.data()->row, stored(numbers), first, step_shift);
  const auto one = hn::Set(d, 1U);
  const auto in_bucket = hn::And(met.place, hn::Sub(hn::Shl(one, met.bucket_shift), one));
  const auto row = hn::Add(first, hn::Shr(in_bucket, step_shift));
  hn::Store(hn::Mul(row, hn::Set(d, tables.row_size)), d, lines.row.data() + lane);
  const auto in_step = hn::And(in_bucket, hn::Sub(hn::Shl(one, step_shift), one));
  const auto per_place = hn::BitCast(df, hn::ShiftLeft<23>(hn::Sub(hn::Set(d, 127U), step_shift)));  // 2^-step_shift
  const auto t = hn::Mul(hn::ConvertTo(df, hn::BitCast(di, in_step)), per_place);
  hn::Store(hn::Sub(hn::Set(df, 1.0F), t), df, lines.y_0.data() + lane);
  hn::Store(t, df, lines.y_1.data() + lane);
}

using QuadTag = hn::FixedTag<std::uint32_t, kQuad>;

HWY_INLINE hn::Vec<QuadTag> quad_of(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t e) {
  const hn::FixedTag<std::uint32_t, 1> d;
  const hn::FixedTag<std::uint32_t, 2> d2;
  return hn::Combine(QuadTag(), hn::Combine(d2, hn::Set(d, e), hn::Set(d, c)),
                     hn::Combine(d2, hn::Set(d, b), hn::Set(d, a)));
}

template <std::size_t D, class Form>
HWY_INLINE void add_cell_lines(Form form, const SliceTables& tables, const std::uint32_t* x, Point& point) {
  constexpr std::size_t kStep = kLinesTogether<D> % 16 == 0 ? 16 : kLinesTogether<D> % 8 == 0 ? 8 : 4;
  const hn::CappedTag<std::uint32_t, kStep> d;
  const LatticeTables& lattice = *tables.lattice;
  const auto four_turns = hn::LoadDup128(d, x);
  for (std::size_t lane = 0; lane < kLinesTogether<D>; lane += hn::Lanes(d)) {
    auto number = hn::Load(d, lattice.lane_first.data() + lane);
    for (std::size_t m = 0; m < D; ++m) {
      const std::uint32_t axis = lattice.axes[m];
      number = hn::Add(number,
                       hn::Mul(hn::Set(d, point.index[axis]), hn::Load(d, lattice.lane_strides[axis].data() + lane)));
    }
    hn::Store(number, d, point.lines.number.data() + lane);
    const auto turn = hn::TableLookupLanes(four_turns, hn::SetTableIndices(d, lattice.lane_axis.data() + lane));
    add_lines(form, d, tables, number, turn, lane, point.lines);
  }
}

// Rings have many nodes, but are rarely asked.
HWY_INLINE std::uint32_t find_ring_cell(const LatticeTables& lattice, const LatticeTables::Ring& ring,
                                        std::int32_t place, float& t) {
  const std::uint32_t bucket =
      ring.search.first_bucket + (static_cast<std::uint32_t>(place) >> ring.search.bucket_shift);
  std::uint32_t cell = lattice.cell_buckets[bucket].first;
  while (lattice.cells[cell].end <= place) ++cell;
  t = static_cast<float>(place - lattice.cells[cell].begin) / lattice.cells[cell].width;
  return cell - ring.first_cell;
}

/// The lines that a ring needs: two along the ring, two along the other axis, at the nodes around the point.
HWY_INLINE hn::Vec<QuadTag> find_ring(const LatticeTables& lattice, const LatticeTables::Ring& ring, std::uint32_t turn,
                                      const Point& point, RingCell& on) {
  const std::uint32_t node = find_ring_cell(lattice, ring, place_of_turn(turn << ring.turn_shift), on.t);
  on.nodes = {ring.node_tables[node], ring.node_tables[node + 1]};
  const std::uint32_t step = lattice.line_strides[ring.ring_axis][ring.along];
  const std::uint32_t first = lattice.first_line[ring.ring_axis] + point.index[ring.along] * step;
  return quad_of(first, first + step, on.nodes[0][1], on.nodes[1][1]);
}
HWY_INLINE std::uint32_t turn_on_ring(const LatticeTables::Ring& ring, const std::uint32_t* x) {
  const std::uint32_t other = x[ring.other_azimuth];
  return ring.difference ? x[ring.ring_axis] - other : x[ring.ring_axis] + other;
}

template <std::size_t D>
constexpr std::size_t kCornerLanes = std::max(kQuad, std::size_t{1} << D);

/// The corners of a cell, in LatticeTables::corners.
template <std::size_t D>
HWY_INLINE void number_corners(const LatticeTables& lattice, const PointInCell& point, std::uint32_t* corners) {
  const QuadTag d;
  std::uint32_t first = 0;
  for (std::size_t m = 0; m < D; ++m) {
    const std::uint32_t axis = lattice.axes[m];
    first += point.index[axis] * lattice.corner_strides[axis];
  }
  for (std::size_t k = 0; k < kCornerLanes<D>; k += kQuad) {
    hn::Store(hn::Add(hn::Set(d, first), hn::Load(d, lattice.corner_steps.data() + k)), d, corners + k);
  }
}

/// What a point needs, for tables that hold nothing else.
template <std::size_t D>
HWY_INLINE void add_needs(const LatticeTables& lattice, const std::uint32_t* x, SliceTables::Needs& needs) {
  Point point;
  find_cells(lattice, x, point);
  number_corners<D>(lattice, point, point.corners.data());
  needs.corners.insert(needs.corners.end(), point.corners.begin(), point.corners.begin() + kCornerLanes<D>);
  for (std::size_t lane = 0; lane < kCellLines<D>; ++lane) {
    std::uint32_t number = lattice.lane_first[lane];
    for (const std::uint32_t axis : lattice.axes) number += point.index[axis] * lattice.lane_strides[axis][lane];
    needs.lines.push_back(number);
  }
  if constexpr (D == kAxisCount) {
    for (const LatticeTables::Ring& ring : lattice.rings) {
      if (point.index[ring.polar_axis] != 0) continue;
      RingCell on;
      alignas(16) std::array<std::uint32_t, kQuad> numbers;
      hn::Store(find_ring(lattice, ring, turn_on_ring(ring, x), point, on), QuadTag(), numbers.data());
      needs.lines.insert(needs.lines.end(), numbers.begin(), numbers.end());
      const std::uint32_t stride = lattice.corner_strides[ring.along];
      for (std::uint32_t k = 0; k < 4; ++k) {
        needs.corners.push_back(on.nodes[k & 1U][0] + (point.index[ring.along] + (k >> 1U)) * stride);
      }
    }
  }
}

/// `x`: four turns, aligned; `guide`: of its angle.
template <std::size_t D, class Form>
HWY_INLINE void find_lines(Form form, const SliceTables& tables, const std::uint32_t* x, std::uint32_t guide,
                           Point& point) {
  const LatticeTables& lattice = *tables.lattice;
  find_cells(lattice, x, point);
  weigh<D>(lattice, point.t, point.weights);
  number_corners<D>(lattice, point, point.corners.data());
  const QuadTag d;
  add_cell_lines<D>(form, tables, x, point);
  if (tables.guided && (D != 3 || tables.guide_ratio != 1)) {
    add_lines(form, d, tables, hn::Set(d, lattice.guide_line), hn::Set(d, guide), kGuideLine<D>, point.lines);
  }
  if constexpr (D == kAxisCount) {
    for (std::size_t r = 0; r < lattice.rings.size(); ++r) {
      const LatticeTables::Ring& ring = lattice.rings[r];
      point.on_ring[r] = point.index[ring.polar_axis] == 0;
      if (!point.on_ring[r]) continue;
      const std::uint32_t turn = turn_on_ring(ring, x);
      const std::uint32_t along = x[ring.along];
      const auto numbers = find_ring(lattice, ring, turn, point, point.rings[r]);
      add_lines(form, d, tables, numbers, quad_of(turn, turn, along, along), ring_line<D>(r), point.lines);
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
