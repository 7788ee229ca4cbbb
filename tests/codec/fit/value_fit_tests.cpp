#include "codec/fit/value_fit.h"

#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {
HeldBack directions_of(const TestFunction& function, std::size_t count, std::uint64_t seed) {
  return draw_held_back({.count = count, .seed = seed}, 1, measure_of(function, 1)).value();
}

TEST(ValueFit, MovesValuesSoThatTheErrorBetweenThemIsLess) {
  const auto smooth = [](const DirectionPair& pair, std::size_t) { return analytic_brdf(pair, {}); };
  for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
    const auto [lattice, sliced] = sample_function(elevation_frame(40, 90, {}).value(), 50, domain, smooth);
    const SlicedBrdf fitted = fit_values(sliced, lattice, directions_of(smooth, 3000, 1), Objective::kBoth);
    const HeldBack fresh = directions_of(smooth, 3000, 2);
    const HeldBackError before = judge(Evaluator(sliced, lattice), fresh);
    const HeldBackError after = judge(Evaluator(fitted, lattice), fresh);
    EXPECT_LT(after.rel_l1_percent, 0.95 * before.rel_l1_percent);
    EXPECT_LT(after.mre_percent, 0.95 * before.mre_percent);
    EXPECT_EQ(fitted.positions, sliced.positions);
  }
}

// No error of such a source has a size, so that nothing could be weighed. With three axes rounding leaves residuals.
TEST(ValueFit, LeavesWhatIsZeroEverywhereAsItIs) {
  const auto zero = [](const DirectionPair&, std::size_t) { return 0.0; };
  for (const bool isotropic : {false, true}) {
    for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
      const FrameSpec spec = elevation_frame(40, 180, {.isotropic = isotropic}).value();
      const auto [lattice, sliced] = sample_function(spec, 30, domain, zero);
      const SlicedBrdf fitted = fit_values(sliced, lattice, directions_of(zero, 1000, 1), Objective::kBoth);
      EXPECT_EQ(fitted.crossing_values, sliced.crossing_values);
      EXPECT_EQ(fitted.sample_values, sliced.sample_values);
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
