#include "codec/evaluation/simd/kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "codec/evaluation/simd/kernel.cpp"  // NOLINT
#include <hwy/foreach_target.h>                                // IWYU pragma: keep
// After it, as every set of instructions has its own:
#include <hwy/highway.h>

#include "codec/evaluation/simd/dense_inl.h"
#include "codec/evaluation/simd/lines_inl.h"
#include "codec/evaluation/simd/spots_inl.h"
#include "codec/evaluation/simd/sums_inl.h"

HWY_BEFORE_NAMESPACE();
namespace sbrdf::internal::HWY_NAMESPACE {
namespace {

using EvaluatePoints = void (*)(const SliceTables&, const Spots&, std::size_t, float*);

template <std::size_t D, class Form>
void evaluate_moving(const SliceTables& tables, const Spots& spots, std::size_t count, float* values) {
  evaluate_points<D>(Form(), tables, spots, count, values);
}

template <class Form>
constexpr std::array<EvaluatePoints, kAxisCount + 1> kByMovingAxes = {
    evaluate_moving<0, Form>, evaluate_moving<1, Form>, evaluate_moving<2, Form>, evaluate_moving<3, Form>,
    evaluate_moving<4, Form>};

EvaluatePoints kernel_for(const SliceTables& tables) {
  const std::size_t axes = tables.lattice->axes.size();
  switch (tables.form) {
    case SliceTables::Form::kExact:
      return kByMovingAxes<Exact>[axes];
    case SliceTables::Form::kPresampled:
      return kByMovingAxes<Presampled>[axes];
    case SliceTables::Form::kDense:
      break;
  }
  return kByMovingAxes<Dense>[axes];
}

using AddNeeds = void (*)(const LatticeTables&, const std::uint32_t*, SliceTables::Needs&);
template <std::size_t D>
void add_needs_moving(const LatticeTables& lattice, const std::uint32_t* x, SliceTables::Needs& needs) {
  add_needs<D>(lattice, x, needs);
}

void FindNeeds(const SliceTables& tables, const float* w_i, const float* w_v, SliceTables::Needs& needs) {
  static constexpr std::array<AddNeeds, kAxisCount + 1> kEach = {
      add_needs_moving<0>, add_needs_moving<1>, add_needs_moving<2>, add_needs_moving<3>, add_needs_moving<4>};
  Vectors pairs;
  Spots spots;
  take_first(w_i, w_v, pairs);
  find_first_spot(tables, pairs, spots);
  kEach[tables.lattice->axes.size()](*tables.lattice, spots.x[0].data(), needs);
}

void EvaluateCoordinates(const SliceTables& tables, const Coordinates& x, double guide_angle_deg, float* values) {
  const LatticeTables& lattice = *tables.lattice;
  const double longest = longest_period_deg(lattice.frame);
  const auto within = [](double degrees) { return degrees > 0 ? std::min(degrees, 90.0) : 0.0; };  // no number: 0
  Spots spots;
  for (std::size_t a = 0; a < kAxisCount; ++a) {
    std::uint32_t turn = 0;
    if (a >= kHorizontal) {
      turn = polar_turn(within(x[a]));
    } else if (x[a] > 0) {
      turn = x[a] < longest ? azimuth_turn(x[a], longest) : 0xFFFFFFFFU;
    }
    spots.x[0][a] = std::min(turn, lattice.last_turn[a]);
  }
  spots.guide[0] = polar_turn(within(guide_angle_deg));
  kernel_for(tables)(tables, spots, 1, values);
}

void EvaluateVectors(const SliceTables& tables, const float* w_i, const float* w_v, std::size_t count, float* values) {
  const EvaluatePoints evaluate = kernel_for(tables);
  Vectors pairs;
  Spots spots;
  for (std::size_t first = 0; first < count; first += kBlock) {
    const std::size_t size = std::min(kBlock, count - first);
    unsigned above;
    if (size == 1) {
      above = take_first(w_i + 3 * first, w_v + 3 * first, pairs);
      find_first_spot(tables, pairs, spots);
    } else {
      above = take(w_i + 3 * first, w_v + 3 * first, size, pairs);
      find_spots(tables, pairs, spots);
    }
    float* out = values + first * tables.channels;
    evaluate(tables, spots, size, out);
    if (HWY_LIKELY(above == (1U << size) - 1)) continue;
    for (std::size_t k = 0; k < size; ++k) {
      if ((above >> k & 1U) == 0) std::fill_n(out + k * tables.channels, tables.channels, 0.0F);
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sbrdf::internal {

HWY_EXPORT(EvaluateCoordinates);
HWY_EXPORT(EvaluateVectors);
HWY_EXPORT(FindNeeds);

void evaluate_coordinates(const SliceTables& tables, const Coordinates& x, double guide_angle_deg, float* values) {
  HWY_DYNAMIC_DISPATCH(EvaluateCoordinates)(tables, x, guide_angle_deg, values);
}

void evaluate_vectors(const SliceTables& tables, const float* w_i, const float* w_v, std::size_t count, float* values) {
  HWY_DYNAMIC_DISPATCH(EvaluateVectors)(tables, w_i, w_v, count, values);
}

void find_needs(const SliceTables& tables, const float* w_i, const float* w_v, SliceTables::Needs& needs) {
  HWY_DYNAMIC_DISPATCH(FindNeeds)(tables, w_i, w_v, needs);
}

}  // namespace sbrdf::internal
#endif
