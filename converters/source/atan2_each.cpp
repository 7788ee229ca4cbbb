#include "converters/source/atan2_each.h"

#include <cassert>
#include <cstddef>

#include "formats/core/directions.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "converters/source/atan2_each.cpp"  // NOLINT
#include <hwy/foreach_target.h>                                // IWYU pragma: keep
// After it, as every set of instructions has its own:
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sbrdf::internal {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, 4>;

// Of the quotient that is at most 1 the arc tangent is good to the last digits, however small or large the numbers.
HWY_INLINE hn::Vec<Lanes> atan2_of(hn::Vec<Lanes> y, hn::Vec<Lanes> x) {
  const Lanes d;
  const auto zero = hn::Zero(d);
  const auto high = hn::Abs(y);
  const auto wide = hn::Abs(x);
  const auto steep = hn::Gt(high, wide);
  const auto larger = hn::IfThenElse(steep, high, wide);
  const auto ratio =
      hn::Div(hn::IfThenElse(steep, wide, high), hn::IfThenElse(hn::Eq(larger, zero), hn::Set(d, 1.0), larger));
  auto angle = hn::Atan(d, ratio);
  angle = hn::IfThenElse(steep, hn::Sub(hn::Set(d, kPi / 2), angle), angle);
  angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(hn::Set(d, kPi), angle), angle);
  return hn::IfThenElse(hn::Lt(y, zero), hn::Neg(angle), angle);
}

void Atan2Each(const double* y, const double* x, double* angles, std::size_t count) {
  const Lanes d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t k = 0;
  for (; k + lanes <= count; k += lanes) {
    hn::StoreU(atan2_of(hn::LoadU(d, y + k), hn::LoadU(d, x + k)), d, angles + k);
  }
  if (k == count) return;
  HWY_ALIGN double rest_y[4] = {};
  HWY_ALIGN double rest_x[4] = {1, 1, 1, 1};
  for (std::size_t n = k; n < count; ++n) {
    rest_y[n - k] = y[n];
    rest_x[n - k] = x[n];
  }
  hn::Store(atan2_of(hn::Load(d, rest_y), hn::Load(d, rest_x)), d, rest_y);
  for (std::size_t n = k; n < count; ++n) angles[n] = rest_y[n - k];
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace sbrdf::internal
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sbrdf::internal {

HWY_EXPORT(Atan2Each);

void atan2_each(std::span<const double> y, std::span<const double> x, std::span<double> angles) {
  assert(y.size() == x.size() && y.size() == angles.size());
  HWY_DYNAMIC_DISPATCH(Atan2Each)(y.data(), x.data(), angles.data(), y.size());
}

}  // namespace sbrdf::internal
#endif
