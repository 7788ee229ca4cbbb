// The values of points from a table without slices. Included by kernel.cpp alone, for each set of instructions anew.
#if defined(SBRDF_DENSE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SBRDF_DENSE_INL_H
#undef SBRDF_DENSE_INL_H
#else
#define SBRDF_DENSE_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "codec/evaluation/simd/lines_inl.h"
#include "codec/evaluation/simd/sums_inl.h"

HWY_BEFORE_NAMESPACE();
namespace sbrdf::internal::HWY_NAMESPACE {
namespace {

/// A form without lines: the multilinear mean of the corners is all.
struct Dense {};

template <std::size_t D>
HWY_INLINE void evaluate_points(Dense /*form*/, const SliceTables& tables, const Spots& spots, std::size_t count,
                                float* values) {
  const LatticeTables& lattice = *tables.lattice;
  const auto channels = static_cast<std::uint32_t>(tables.channels);
  const Wide d;
  alignas(64) std::array<std::array<std::uint32_t, kCornerLanes<D>>, kBlock> rows;
  alignas(64) std::array<std::array<float, 16 + 16>, kBlock> weights;  // vectors are read from any corner on
  for (std::size_t k = 0; k < count; ++k) {
    PointInCell point;
    find_cells(lattice, spots.x[k].data(), point);
    weigh_corners<D>(lattice, point.t, weights[k].data());
    const QuadTag quad;
    number_corners<D>(lattice, point, rows[k].data());
    for (std::size_t c = 0; c < kCornerLanes<D>; c += kQuad) {
      hn::Store(hn::Mul(hn::Load(quad, rows[k].data() + c), hn::Set(quad, channels)), quad, rows[k].data() + c);
    }
  }
  for (std::size_t g = 0; g < tables.groups.size(); ++g) {
    const float* table = tables.crossing_values.data() + g * kLanes;
    alignas(64) std::array<float, kBlock * kLanes> block;
    for (std::size_t k = 0; k < count; ++k) {
      const auto sum = sum_rows(d, kCornerLanes<D>, [&](std::size_t c) HWY_ATTR {
        return hn::Mul(spread(d, weights[k].data() + c), load_rows(d, table, rows[k].data() + c));
      });
      hn::Store(sum, Channels(), block.data() + k * kLanes);
    }
    finish_block(count, [&](auto lanes, std::size_t k) HWY_ATTR {
      float* at = block.data() + k * kLanes;
      hn::Store(inverse(lanes, tables.groups[g], tables.log, hn::Load(lanes, at)), lanes, at);
    });
    spread_out(tables, block.data(), g, count, values);
  }
  take_off_shares(tables, count, values);
}

}  // namespace
}  // namespace sbrdf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
