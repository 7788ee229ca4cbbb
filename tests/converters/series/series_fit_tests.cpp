#include "converters/series/series_fit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "codec/series/series_file.h"
#include "converters/files/sliced/series_source.h"
#include "converters/judge/compare.h"
#include "formats/core/interrupted.h"
#include "formats/core/parallel.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

/// Lambert and a lobe of GGX, each channel with a base of its own.
FunctionSource glossy(double blue) {
  const std::array<double, 3> bases = {0.05, 0.2, blue};
  return FunctionSource(
      [bases](const DirectionPair& pair, std::size_t channel) {
        const double x = std::sin(pair.i.theta) * std::cos(pair.i.phi) + std::sin(pair.v.theta) * std::cos(pair.v.phi);
        const double y = std::sin(pair.i.theta) * std::sin(pair.i.phi) + std::sin(pair.v.theta) * std::sin(pair.v.phi);
        const double z = std::cos(pair.i.theta) + std::cos(pair.v.theta);
        const double tangent = z > 0 ? (x * x + y * y) / (z * z) : 1e9;
        const double narrow = 1 + tangent / 0.04;
        return bases[channel] + 0.2 / (narrow * narrow);
      },
      {.isotropic = true, .reciprocal = true});
}

FunctionSource grey(const std::function<double(const DirectionPair&)>& function) {
  return FunctionSource([function](const DirectionPair& pair, std::size_t) { return function(pair); },
                        {.isotropic = true, .reciprocal = true, .channels = {"Y"}});
}

SliceOptions with_target(double percent) {
  SliceOptions options;
  options.stop = TargetRelL1{percent};
  return options;
}

double rel_l1(const BrdfSource& reference, const SeriesBrdf& brdf) {
  const auto source = open_series(std::make_shared<MemorySource>(encode_series(brdf)), {});
  EXPECT_TRUE(source);
  CompareOptions options;
  options.directions = CompareDirections::kHighlight;
  options.random_count = 20'000;
  options.seed = 99;
  const Result<Comparison> error = compare_sources(reference, **source, options);
  EXPECT_TRUE(error);
  return error->rel_l1_percent;
}

TEST(SeriesFit, ReachesItsTargetOnOtherDirections) {
  const FunctionSource source = glossy(0.1);
  std::size_t before = 0;
  for (const double target : {8.0, 2.0, 0.5}) {
    const Result<SeriesFit> fit = fit_series(source, with_target(target));
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_LE(fit->report.error.rel_l1_percent, 1.1 * target);
    EXPECT_LE(rel_l1(source, fit->brdf), 1.25 * target);
    EXPECT_TRUE(fit->brdf.symmetries.mirror_x && fit->brdf.symmetries.isotropic);
    const std::size_t bytes = encode_series(fit->brdf).size();
    EXPECT_GT(bytes, before);
    EXPECT_LT(bytes, 400U);
    before = bytes;
  }
}

TEST(SeriesFit, KeepsValuesBelowZero) {
  const FunctionSource source = glossy(-0.03);
  const Result<SeriesFit> fit = fit_series(source, with_target(2));
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_TRUE(fit->brdf.negative);
  EXPECT_LE(rel_l1(source, fit->brdf), 2.5);
}

TEST(SeriesFit, AConstantTakesNoCoefficients) {
  const FunctionSource source = grey([](const DirectionPair&) { return 0.25; });
  const Result<SeriesFit> fit = fit_series(source, with_target(2));
  ASSERT_TRUE(fit) << fit.error().message;
  SeriesBrdf bare = fit->brdf;
  bare.metadata.clear();
  EXPECT_LE(encode_series(bare).size(), 40U);
  EXPECT_LE(fit->report.error.rel_l1_percent, 2);
}

TEST(SeriesFit, StaysWithinItsBytes) {
  const FunctionSource source = glossy(0.1);
  double before = 1e9;
  for (const std::uint64_t most : {80U, 120U}) {
    SliceOptions options;
    options.stop = MaxBytes{most};
    const Result<SeriesFit> fit = fit_series(source, options);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_LE(encode_series(fit->brdf).size(), most);
    EXPECT_LT(fit->report.error.rel_l1_percent, before);
    before = fit->report.error.rel_l1_percent;
  }
  SliceOptions options;
  options.stop = MaxBytes{12};
  EXPECT_EQ(fit_series(source, options).error().code, ErrorCode::kDifference);
}

TEST(SeriesFit, AnyNumberOfThreadsGivesTheSameBytes) {
  const FunctionSource source = glossy(0.1);
  std::vector<std::byte> one;
  {
    const ThreadLimit limit(1);
    one = encode_series(fit_series(source, with_target(4))->brdf);
  }
  EXPECT_EQ(encode_series(fit_series(source, with_target(4))->brdf), one);
}

TEST(SeriesFit, RefusesWhatIsNoReflectance) {
  EXPECT_EQ(fit_series(grey([](const DirectionPair&) { return 0.0; }), with_target(2)).error().code,
            ErrorCode::kInvalidFile);
  const FunctionSource broken =
      grey([](const DirectionPair& pair) { return pair.i.theta > 1 ? std::numeric_limits<double>::quiet_NaN() : 1.0; });
  EXPECT_EQ(fit_series(broken, with_target(2)).error().code, ErrorCode::kInvalidFile);
}

TEST(SeriesFit, CanBeInterrupted) {
  const FunctionSource source = glossy(0.1);
  EXPECT_EQ(fit_series(source, with_target(2), {[](double) { return false; }}).error().message,
            interrupted_error().message);
}

}  // namespace
}  // namespace sbrdf::internal
