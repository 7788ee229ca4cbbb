#include "converters/judge/compare.h"

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "converters/source/reciprocity.h"
#include "formats/core/parallel.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

double degrees(double radians) { return std::round(radians * 180 / kPi); }

CompareOptions coarse() {
  CompareOptions options;
  options.step_deg = 10;
  return options;
}

Comparison compare(const BrdfSource& reference, const BrdfSource& test, const CompareOptions& options) {
  return compare_sources(reference, test, options).value();
}

TEST(Compare, GivesTheFiguresThatFollowFromTheFormulas) {
  const FunctionSource reference([](const auto& pair, std::size_t) { return 1 + degrees(pair.i.theta); });
  const FunctionSource test(
      [](const auto& pair, std::size_t) { return 1 + degrees(pair.i.theta) + degrees(pair.v.theta); });
  const Comparison found = compare(reference, test, coarse());
  // theta is 0, 10, ..., 80: mean 40, mean of squares 100 x 204 / 9; |f - r| = theta_v, f = 1 + theta_i.
  double inverse = 0;
  for (int theta = 0; theta <= 80; theta += 10) inverse += 1.0 / (1 + theta) / 9;
  EXPECT_NEAR(found.mre_percent, 100 * 40 * inverse, 1e-9);
  EXPECT_NEAR(found.rel_l1_percent, 100 * 40.0 / 41, 1e-9);
  EXPECT_NEAR(found.rmse, std::sqrt(100 * 204 / 9.0), 1e-9);
  EXPECT_EQ(found.max_abs, 80);
  EXPECT_NEAR(found.psnr_db, 20 * std::log10(81 / std::sqrt(100 * 204 / 9.0)), 1e-9);
  EXPECT_EQ(found.directions, 9ULL * 9 * 36 * 36);
  EXPECT_EQ(found.grid_directions, found.directions);
  EXPECT_EQ(found.mre_left_out, 0U);
}

TEST(Compare, WeighsEveryAzimuthOfBothDirections) {
  const FunctionSource reference([](const auto&, std::size_t) { return 2.0; });
  const FunctionSource test([](const auto& pair, std::size_t) {
    return 2 + (degrees(pair.i.phi) == 30 ? 0.5 : 0) + (degrees(pair.v.phi) == 200 ? 0.25 : 0);
  });
  EXPECT_NEAR(compare(reference, test, coarse()).mre_percent, 100 * (0.5 + 0.25) / 36 / 2, 1e-12);
}

TEST(Compare, WeighsEveryChannel) {
  const FunctionSource reference([](const auto&, std::size_t c) { return c == 0 ? 1.0 : 4.0; },
                                 {.channels = {"a", "b"}});
  const FunctionSource test([](const auto&, std::size_t c) { return c == 0 ? 2.0 : 5.0; }, {.channels = {"a", "b"}});
  const Comparison found = compare(reference, test, coarse());
  EXPECT_NEAR(found.mre_percent, 100 * (1 + 0.25) / 2, 1e-12);
  EXPECT_NEAR(found.rel_l1_percent, 100 * 2.0 / 5, 1e-12);
}

TEST(Compare, CallsEqualSourcesEqual) {
  const FunctionSource source([](const auto& pair, std::size_t) { return analytic_brdf(pair, {}); });
  const Comparison found = compare(source, source, coarse());
  EXPECT_EQ(found.mre_percent, 0);
  EXPECT_EQ(found.rel_l1_percent, 0);
  EXPECT_EQ(found.rmse, 0);
  EXPECT_EQ(found.max_abs, 0);
  EXPECT_EQ(found.psnr_db, std::numeric_limits<double>::infinity());
}

TEST(Compare, HasTheDirectionsOfTheOptions) {
  const FunctionSource source([](const auto&, std::size_t) { return 1.0; });
  const FunctionSource isotropic([](const auto&, std::size_t) { return 1.0; }, {.isotropic = true});
  CompareOptions options;
  EXPECT_EQ(compare(isotropic, isotropic, options).directions, 41ULL * 41 * 180);
  EXPECT_EQ(compare(isotropic, isotropic, options).grid_directions, 54464400ULL);
  options.step_deg = 15;
  options.theta_max_deg = 90;
  EXPECT_EQ(compare(source, source, options).directions, 7ULL * 7 * 24 * 24);
  options.step_deg = 90;
  options.theta_max_deg = 0;
  EXPECT_EQ(compare(source, source, options).directions, 1ULL * 1 * 4 * 4);
  options.random_count = 12345;
  EXPECT_EQ(compare(source, source, options).directions, 12345U);
}

TEST(Compare, FindsTheSameForIsotropicSourcesAsOnTheFullGrid) {
  const Symmetries symmetries = {.isotropic = true};
  const auto f = [&](const DirectionPair& pair, std::size_t c) {
    return analytic_brdf(pair, symmetries) + static_cast<double>(c);
  };
  const auto r = [&](const DirectionPair& pair, std::size_t c) {
    return f(pair, c) * (1 + 0.1 * std::sin(pair.i.phi - pair.v.phi));
  };
  for (const double step : {10.0, 24.0, 50.0}) {
    CompareOptions options = coarse();
    options.step_deg = step;
    const Comparison full = compare(FunctionSource(f), FunctionSource(r), options);
    const Comparison quick =
        compare(FunctionSource(f, {.isotropic = true}), FunctionSource(r, {.isotropic = true}), options);
    EXPECT_NEAR(quick.mre_percent / full.mre_percent, 1, 1e-6) << step;
    EXPECT_NEAR(quick.rel_l1_percent / full.rel_l1_percent, 1, 1e-6) << step;
    EXPECT_NEAR(quick.rmse / full.rmse, 1, 1e-6) << step;
    EXPECT_NEAR(quick.max_abs / full.max_abs, 1, 1e-5) << step;
    EXPECT_NEAR(quick.psnr_db, full.psnr_db, 1e-5) << step;
    EXPECT_EQ(quick.grid_directions, full.grid_directions) << step;
  }
}

TEST(Compare, TakesTheFullGridWhereOnlyOneSourceIsIsotropic) {
  const FunctionSource flat([](const auto&, std::size_t) { return 1.0; }, {.isotropic = true});
  const FunctionSource lined([](const auto& pair, std::size_t) { return degrees(pair.v.phi) == 0 ? 2.0 : 1.0; });
  EXPECT_NEAR(compare(flat, lined, coarse()).mre_percent, 100 / 36.0, 1e-12);
}

CompareOptions drawn(CompareDirections directions, std::uint64_t count) {
  CompareOptions options;
  options.directions = directions;
  options.random_count = count;
  return options;
}

std::vector<double> figures(const ErrorFigures& found) {
  return {found.mre_percent,
          found.rel_l1_percent,
          found.cosine_rel_l1_percent,
          found.rmse,
          found.max_abs,
          found.max_abs_at.pair.v.phi,
          found.max_relative_percent,
          found.max_relative_at.pair.i.phi,
          found.relative_p99_percent,
          found.relative_p999_percent,
          found.psnr_db};
}

std::vector<double> figures(const Comparison& found) {
  std::vector<double> all = figures(static_cast<const ErrorFigures&>(found));
  for (const ErrorFigures& channel : found.channels) {
    for (const double figure : figures(channel)) all.push_back(figure);
  }
  const FalseValues& spikes = found.false_values;
  for (const std::uint64_t count : {spikes.count, spikes.too_large, spikes.too_small}) {
    all.push_back(static_cast<double>(count));
  }
  all.insert(all.end(), {spikes.worst_factor, spikes.worst.pair.i.phi, spikes.strict_worst, found.floor});
  return all;
}

TEST(AnyNumberOfThreads, GivesTheSameBitsOfAComparison) {
  const FunctionSource f([](const auto& pair, std::size_t) { return analytic_brdf(pair, {}); });
  const FunctionSource r([](const auto& pair, std::size_t c) {
    return analytic_brdf(pair, {.mirror_x = true}) + 0.1 * static_cast<double>(c);
  });
  // More blocks than are added up at a time, and the last of them not full.
  CompareOptions some_of_grid = coarse();
  some_of_grid.random_count = 30'000;
  for (const CompareOptions& options : {coarse(), some_of_grid, drawn(CompareDirections::kRandom, 300'000),
                                        drawn(CompareDirections::kHighlight, 30'001)}) {
    std::vector<std::vector<double>> found;
    for (const std::size_t threads : {1U, 2U, 7U}) {
      const ThreadLimit control(threads);
      found.push_back(figures(compare(f, r, options)));
    }
    EXPECT_EQ(found[1], found[0]);
    EXPECT_EQ(found[2], found[0]);
  }
}

TEST(Compare, GivesTheFiguresOfEachChannel) {
  // Channel c is 1 + c percent too large everywhere.
  const FunctionSource f([](const auto& pair, std::size_t) { return 1 + degrees(pair.i.theta); });
  const FunctionSource r([](const auto& pair, std::size_t c) {
    return (1 + degrees(pair.i.theta)) * (1.01 + 0.01 * static_cast<double>(c));
  });
  for (const CompareOptions& options :
       {coarse(), drawn(CompareDirections::kRandom, 5000), drawn(CompareDirections::kHighlight, 5000)}) {
    const Comparison found = compare(f, r, options);
    ASSERT_EQ(found.channels.size(), 3U);
    for (std::size_t c = 0; c < 3; ++c) {
      const ErrorFigures& channel = found.channels[c];
      const double percent = 1 + static_cast<double>(c);
      for (const double figure :
           {channel.mre_percent, channel.rel_l1_percent, channel.cosine_rel_l1_percent, channel.relative_p99_percent,
            channel.relative_p999_percent, channel.max_relative_percent}) {
        EXPECT_NEAR(figure, percent, 1e-4);  // values are floats
      }
    }
    EXPECT_NEAR(found.mre_percent, 2, 1e-4);
    EXPECT_NEAR(found.rel_l1_percent, 2, 1e-4);
    EXPECT_NEAR(found.relative_p99_percent, 3, 0.004 * 3);
    EXPECT_EQ(found.max_relative_at.channel, 2U);
    EXPECT_EQ(found.false_values.strict_count(), 0U);
  }
}

TEST(Compare, WeighsWithBothCosines) {
  const FunctionSource f([](const auto&, std::size_t) { return 1.0; });
  const FunctionSource r([](const auto& pair, std::size_t) { return degrees(pair.v.theta) < 45 ? 1.5 : 1.0; });
  double below = 0;
  double all = 0;
  for (int theta = 0; theta <= 80; theta += 10) {
    all += std::cos(theta * kPi / 180);
    if (theta < 45) below += std::cos(theta * kPi / 180);
  }
  const Comparison found = compare(f, r, coarse());
  EXPECT_NEAR(found.cosine_rel_l1_percent, 50 * below / all, 1e-9);
  EXPECT_NEAR(found.rel_l1_percent, 50 * 5.0 / 9, 1e-9);
}

TEST(Compare, TellsWhereTheErrorsAreLargest) {
  const FunctionSource f([](const auto& pair, std::size_t) { return degrees(pair.i.theta) < 45 ? 1.0 : 10.0; });
  const FunctionSource r([](const auto& pair, std::size_t c) {
    const bool at = degrees(pair.i.phi) == 70 && degrees(pair.v.theta) == 20 && degrees(pair.v.phi) == 340;
    const double base = degrees(pair.i.theta) < 45 ? 1.0 : 10.0;
    if (at && c == 1 && degrees(pair.i.theta) == 50) return base + 2.0;
    if (at && c == 2 && degrees(pair.i.theta) == 10) return base + 0.75;
    return base;
  });
  const Comparison found = compare(f, r, coarse());
  EXPECT_EQ(found.max_abs, 2);
  EXPECT_EQ(degrees(found.max_abs_at.pair.i.theta), 50);
  EXPECT_EQ(degrees(found.max_abs_at.pair.i.phi), 70);
  EXPECT_EQ(degrees(found.max_abs_at.pair.v.theta), 20);
  EXPECT_EQ(degrees(found.max_abs_at.pair.v.phi), 340);
  EXPECT_EQ(found.max_abs_at.channel, 1U);
  EXPECT_EQ(found.max_abs_at.reference, 10);
  EXPECT_EQ(found.max_abs_at.test, 12);
  EXPECT_EQ(found.max_relative_percent, 75);
  EXPECT_EQ(degrees(found.max_relative_at.pair.i.theta), 10);
  EXPECT_EQ(found.max_relative_at.channel, 2U);
  EXPECT_EQ(found.channels[0].max_abs, 0);
  EXPECT_EQ(found.channels[2].max_abs, 0.75);
}

TEST(Compare, HasThePercentilesOfAllRelativeErrors) {
  // The relative error is the number of the azimuth phi_v in percent, 0 to 35, each as often as any other.
  const FunctionSource f([](const auto&, std::size_t) { return 1.0; });
  const FunctionSource r([](const auto& pair, std::size_t) { return 1 + degrees(pair.v.phi) / 1000; });
  const Comparison found = compare(f, r, coarse());
  EXPECT_NEAR(found.relative_p99_percent, 35, 1e-4);
  const FunctionSource rare([](const auto& pair, std::size_t) {
    return 1 + (degrees(pair.v.phi) == 10 && degrees(pair.i.theta) == 30 ? 0.5 : 0.01);  // 1 of 324
  });
  const Comparison spiky = compare(f, rare, coarse());
  EXPECT_NEAR(spiky.relative_p99_percent, 1, 0.005);
  EXPECT_NEAR(spiky.relative_p999_percent, 50, 0.2);
}

TEST(Compare, DrawsDirectionsBetweenTheNodesOfTheGrid) {
  const FunctionSource one([](const auto&, std::size_t) { return 1.0; });
  const FunctionSource right_on_grid([](const DirectionPair& pair, std::size_t) {
    const double theta = pair.v.theta * 180 / kPi;
    return std::abs(theta - 2 * std::round(theta / 2)) < 0.01 ? 1.0 : 2.0;
  });
  CompareOptions grid;
  grid.random_count = 5000;
  EXPECT_EQ(compare(one, right_on_grid, grid).mre_percent, 0);
  for (const auto directions : {CompareDirections::kRandom, CompareDirections::kHighlight}) {
    EXPECT_GT(compare(one, right_on_grid, drawn(directions, 5000)).mre_percent, 95);
  }
}

TEST(Compare, HasTheSameMeansWithRandomDirectionsHoweverDrawn) {
  const FunctionSource f([](const auto& pair, std::size_t) { return analytic_brdf(pair, {}); });
  const FunctionSource r([](const auto& pair, std::size_t) { return analytic_brdf(pair, {.mirror_x = true}); });
  const Comparison random = compare(f, r, drawn(CompareDirections::kRandom, 200'000));
  const Comparison highlight = compare(f, r, drawn(CompareDirections::kHighlight, 200'000));
  EXPECT_NEAR(highlight.mre_percent / random.mre_percent, 1, 0.02);
  EXPECT_NEAR(highlight.rel_l1_percent / random.rel_l1_percent, 1, 0.02);
  EXPECT_NEAR(highlight.cosine_rel_l1_percent / random.cosine_rel_l1_percent, 1, 0.02);
  EXPECT_NEAR(highlight.rmse / random.rmse, 1, 0.02);
  EXPECT_NEAR(highlight.relative_p99_percent / random.relative_p99_percent, 1, 0.04);
  EXPECT_NEAR(highlight.floor / random.floor, 1, 0.02);
}

TEST(Compare, SeesAHighlightThatTheGridMisses) {
  // A tenth of a degree wide, beside the mirror direction: between all nodes of the grid.
  const FunctionSource one([](const auto&, std::size_t) { return 1.0; });
  const FunctionSource ridge([](const DirectionPair& pair, std::size_t) {
    const double theta = (pair.v.theta - pair.i.theta) * 180 / kPi - 0.1;
    const double phi = std::remainder((pair.v.phi - pair.i.phi) * 180 / kPi - 180.1, 360.0);
    return std::abs(theta) < 0.05 && std::abs(phi) < 0.05 ? 5.0 : 1.0;
  });
  EXPECT_EQ(compare(one, ridge, coarse()).max_abs, 0);
  const Comparison found = compare(one, ridge, drawn(CompareDirections::kHighlight, 300'000));
  EXPECT_EQ(found.max_abs, 4);
  EXPECT_GT(found.false_values.count, 100U);
  EXPECT_EQ(found.false_values.worst_factor, 5);
  // 4 on a part of (0.1 / 80) (0.1 / 360) of all pairs
  EXPECT_NEAR(found.mre_percent / (100 * 4 * 0.1 / 80 * 0.1 / 360), 1, 0.2);
}

TEST(Compare, TakesAHundredthOfTheMeanAsFloorOfRandomDirections) {
  const FunctionSource f(
      [](const auto& pair, std::size_t c) { return (pair.i.phi < kPi ? 0.0 : 2.0) * (c == 0 ? 1 : 4); },
      {.channels = {"a", "b"}});
  const FunctionSource r(
      [](const auto& pair, std::size_t c) { return (pair.i.phi < kPi ? 0.01 : 2.0) * (c == 0 ? 1 : 4); },
      {.channels = {"a", "b"}});
  for (const auto directions : {CompareDirections::kRandom, CompareDirections::kHighlight}) {
    CompareOptions options = drawn(directions, 40'000);
    const Comparison found = compare(f, r, options);
    EXPECT_NEAR(found.floor, 0.01 * (1 + 4) / 2, 0.001);  // half of the pairs are 0
    EXPECT_EQ(found.mre_left_out, 0U);
    EXPECT_NEAR(found.max_relative_percent, 100 * 0.04 / found.floor, 1e-3);
    options.floor = 0.5;
    EXPECT_EQ(compare(f, r, options).floor, 0.5);
    EXPECT_NEAR(compare(f, r, options).max_relative_percent, 8, 1e-5);
  }
  EXPECT_EQ(compare(f, r, coarse()).floor, 0);
}

TEST(Compare, CountsFalseValuesBesideTheSymmetrisedReference) {
  // The highlight is on one side only; its mean with the dark side is half as high.
  const FunctionSource one_sided(
      [](const auto& pair, std::size_t) { return pair.i.theta < pair.v.theta ? 10.0 : 0.0; });
  const FunctionSource nine([](const auto&, std::size_t) { return 9.0; });
  CompareOptions options = drawn(CompareDirections::kRandom, 300);
  EXPECT_GT(compare(one_sided, nine, options).false_values.count, 300U);  // of 900 values half are 0
  options.symmetrise = true;
  EXPECT_EQ(compare(one_sided, nine, options).false_values.too_large, 3U * 300);
  EXPECT_EQ(compare(one_sided, nine, options).false_values.count, 0U);
}

TEST(Compare, StopsLookingForFalseValuesWhenEnoughWereFound) {
  const FunctionSource one([](const auto&, std::size_t) { return 1.0; }, {.channels = {"Y"}});
  const FunctionSource four([](const auto&, std::size_t) { return 4.0; }, {.channels = {"Y"}});
  const Comparison few = compare(one, four, drawn(CompareDirections::kRandom, 900));
  EXPECT_TRUE(few.false_values.complete);
  EXPECT_EQ(few.false_values.count, 900U);
  const Comparison many = compare(one, four, drawn(CompareDirections::kRandom, 400'000));
  EXPECT_FALSE(many.false_values.complete);
  EXPECT_EQ(many.false_values.count, 64U * 1000);  // in each of the blocks that are looked at together
  EXPECT_NEAR(many.mre_percent, 300, 1e-9);
}

TEST(Compare, LooksForFalseValuesOnlyWhereItIsAskedTo) {
  std::atomic<int> evaluated = 0;
  const FunctionSource one(
      [&](const auto&, std::size_t) {
        ++evaluated;
        return 1.0;
      },
      {.channels = {"Y"}});
  const FunctionSource four([](const auto&, std::size_t) { return 4.0; }, {.channels = {"Y"}});
  CompareOptions options = drawn(CompareDirections::kRandom, 900);
  options.floor = 0.01;
  options.false_values = FalseValueSearch::kNone;
  const Comparison unasked = compare(one, four, options);
  EXPECT_EQ(evaluated, 900);
  EXPECT_EQ(unasked.false_values.strict_count(), 0U);
  EXPECT_FALSE(unasked.false_values.complete);
  options.false_values = FalseValueSearch::kAll;
  const Comparison asked = compare(one, four, options);
  EXPECT_EQ(asked.false_values.count, 900U);
  EXPECT_EQ(figures(static_cast<const ErrorFigures&>(asked)), figures(static_cast<const ErrorFigures&>(unasked)));
}

/// 1 where it was measured, with a hole at theta_i above 40 degrees that it calls black.
class HoleySource final : public BrdfSource {
 public:
  HoleySource() {
    traits_.channels = {"grey"};
    traits_.isotropic = traits_.reciprocal = true;
  }
  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    for (std::size_t k = 0; k < pairs.size(); ++k) values[k] = is_hole(pairs[k]) ? 0.0F : 1.0F;
  }
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    for (std::size_t k = 0; k < pairs.size(); ++k) flags[k] = is_hole(pairs[k]) ? 0 : 1;
  }
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override {
    return MaskGrid{MaskFrame::kAngles, {9, 1, 9, 36}};
  }

 private:
  static bool is_hole(const DirectionPair& pair) { return pair.i.theta > radians_from_degrees(41); }
  SourceTraits traits_;
};

TEST(Compare, LeavesOutWhatOneOfTheTwoDidNotMeasureAndCountsIt) {
  const FunctionSource test([](const DirectionPair&, std::size_t) { return 1.25; },
                            {.isotropic = true, .reciprocal = true, .channels = {"grey"}});
  CompareOptions options;
  options.step_deg = 20;
  options.theta_max_deg = 80;
  const Comparison result = compare_sources(HoleySource(), test, options).value();
  EXPECT_NEAR(result.mre_percent, 25, 1e-9);
  EXPECT_NEAR(result.rel_l1_percent, 25, 1e-9);
  EXPECT_EQ(result.directions, 3U * 5 * 18) << "of theta_i 0, 20, 40";
  EXPECT_EQ(result.unmeasured, 2U * 5 * 18);
  const Comparison exchanged = compare_sources(test, HoleySource(), options).value();
  EXPECT_NEAR(exchanged.mre_percent, 20, 1e-9) << "what the test did not measure is no error of it";
  EXPECT_EQ(exchanged.unmeasured, result.unmeasured);
  options.floor = 0.5;
  EXPECT_EQ(compare_sources(test, test, options).value().unmeasured, 0U);
}

TEST(Compare, DrawsRandomPairsOfTheGridByTheSeed) {
  const FunctionSource f([](const auto& pair, std::size_t) { return analytic_brdf(pair, {}); });
  const FunctionSource r([](const auto& pair, std::size_t) { return analytic_brdf(pair, {.mirror_x = true}); });
  CompareOptions options = coarse();
  const Comparison full = compare(f, r, options);
  options.random_count = 40000;
  const Comparison once = compare(f, r, options);
  EXPECT_EQ(figures(compare(f, r, options)), figures(once));
  EXPECT_NEAR(once.mre_percent / full.mre_percent, 1, 0.03);
  EXPECT_NEAR(once.rel_l1_percent / full.rel_l1_percent, 1, 0.03);
  options.seed = 2;
  EXPECT_NE(figures(compare(f, r, options)), figures(once));
}

TEST(Compare, DrawsOnlyPairsOfTheGrid) {
  const FunctionSource one([](const auto&, std::size_t) { return 1.0; });
  const FunctionSource marks_others([](const DirectionPair& pair, std::size_t) {
    const auto off = [](double radians) { return std::abs(std::remainder(radians * 180 / kPi, 10.0)) > 1e-9; };
    return off(pair.i.theta) || off(pair.i.phi) || off(pair.v.theta) || off(pair.v.phi) || pair.i.theta > 1.4 ? 2.0
                                                                                                              : 1.0;
  });
  CompareOptions options = coarse();
  options.random_count = 20000;
  EXPECT_EQ(compare(one, marks_others, options).max_abs, 0);
}

TEST(Compare, SymmetrisesTheReferenceOnly) {
  const FunctionSource one_sided([](const auto& pair, std::size_t) { return 1 + degrees(pair.i.theta); });
  const FunctionSource mean(
      [](const auto& pair, std::size_t) { return 1 + (degrees(pair.i.theta) + degrees(pair.v.theta)) / 2; });
  CompareOptions options = coarse();
  EXPECT_GT(compare(one_sided, mean, options).mre_percent, 10);
  options.symmetrise = true;
  EXPECT_EQ(compare(one_sided, mean, options).mre_percent, 0);
  EXPECT_GT(compare(mean, one_sided, options).mre_percent, 10);
}

TEST(Compare, DividesByTheFloorWhereTheReferenceIsBelowIt) {
  const FunctionSource reference([](const auto& pair, std::size_t) { return pair.i.theta == 0 ? 0.25 : 2.0; });
  const FunctionSource test([](const auto& pair, std::size_t) { return pair.i.theta == 0 ? 0.75 : 3.0; });
  CompareOptions options = coarse();
  EXPECT_NEAR(compare(reference, test, options).mre_percent, 100 * (2.0 / 9 + 0.5 * 8 / 9), 1e-10);
  options.floor = 1;
  EXPECT_NEAR(compare(reference, test, options).mre_percent, 100 * (0.5 / 9 + 0.5 * 8 / 9), 1e-10);
}

TEST(Compare, LeavesZerosOutOfTheRelativeErrorAndCountsThem) {
  const FunctionSource reference([](const auto& pair, std::size_t) { return pair.i.theta == 0 ? 0.0 : 2.0; });
  const FunctionSource test([](const auto&, std::size_t) { return 3.0; });
  CompareOptions options = coarse();
  const Comparison found = compare(reference, test, options);
  EXPECT_NEAR(found.mre_percent, 50, 1e-10);
  EXPECT_EQ(found.mre_left_out, 3ULL * 9 * 36 * 36);
  EXPECT_NEAR(found.rel_l1_percent, 100 * (3.0 / 9 + 8.0 / 9) / (2 * 8.0 / 9), 1e-10);
  options.floor = 0.5;
  const Comparison floored = compare(reference, test, options);
  EXPECT_EQ(floored.mre_left_out, 0U);
  EXPECT_NEAR(floored.mre_percent, 100 * (6.0 / 9 + 0.5 * 8 / 9), 1e-10);
}

TEST(Compare, HasNoRelativeErrorWhereEveryReferenceIsZero) {
  const FunctionSource black([](const auto&, std::size_t) { return 0.0; });
  const FunctionSource test([](const auto&, std::size_t) { return 3.0; });
  const Comparison found = compare(black, test, coarse());
  EXPECT_TRUE(std::isnan(found.mre_percent));
  EXPECT_EQ(found.mre_values, 0U);
  EXPECT_EQ(found.mre_left_out, 3ULL * 9 * 9 * 36 * 36);
  EXPECT_EQ(compare(black, black, coarse()).rel_l1_percent, 0);
}

TEST(Compare, TakesTheSizeOfNegativeReferencesAsDenominator) {
  const FunctionSource reference([](const auto&, std::size_t) { return -2.0; });
  const FunctionSource test([](const auto&, std::size_t) { return -1.0; });
  const Comparison found = compare(reference, test, coarse());
  EXPECT_NEAR(found.mre_percent, 50, 1e-12);
  EXPECT_NEAR(found.rel_l1_percent, 50, 1e-12);
}

TEST(Compare, ShowsASingleNanInEveryFigureThatItSpoils) {
  const FunctionSource good([](const auto&, std::size_t) { return 1.0; });
  const FunctionSource spoilt([](const auto& pair, std::size_t c) {
    const bool bad = degrees(pair.i.theta) == 50 && degrees(pair.v.theta) == 20 && degrees(pair.i.phi) == 70 &&
                     degrees(pair.v.phi) == 340 && c == 1;
    return bad ? std::numeric_limits<double>::quiet_NaN() : 1.25;
  });
  for (const auto& [reference, test] : {std::pair(&good, &spoilt), std::pair(&spoilt, &good)}) {
    const Comparison found = compare(*reference, *test, coarse());
    EXPECT_TRUE(std::isnan(found.mre_percent));
    EXPECT_TRUE(std::isnan(found.rel_l1_percent));
    EXPECT_TRUE(std::isnan(found.rmse));
    EXPECT_TRUE(std::isnan(found.max_abs));
    EXPECT_TRUE(std::isnan(found.psnr_db));
    EXPECT_TRUE(std::isnan(found.cosine_rel_l1_percent));
    EXPECT_TRUE(std::isnan(found.relative_p99_percent));
    EXPECT_TRUE(std::isnan(found.max_relative_percent));
    EXPECT_EQ(degrees(found.max_abs_at.pair.i.theta), 50);
    EXPECT_FALSE(std::isnan(found.channels[0].mre_percent));
  }
}

TEST(Compare, RefusesSourcesWithDifferentNumbersOfChannels) {
  const FunctionSource three([](const auto&, std::size_t) { return 1.0; });
  const FunctionSource one([](const auto&, std::size_t) { return 1.0; }, {.channels = {"Y"}});
  const auto result = compare_sources(three, one, coarse());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kUnsupported);
}

TEST(Compare, RefusesOptionsOutOfRange) {
  const FunctionSource source([](const auto&, std::size_t) { return 1.0; });
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_refused = [&](const CompareOptions& options) {
    const auto result = compare_sources(source, source, options);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::kUsage);
  };
  const auto with = [](auto member, double value) {
    CompareOptions options;
    options.*member = value;
    return options;
  };
  for (const double step : {-1.0, 0.0, 0.01, 91.0, nan}) expect_refused(with(&CompareOptions::step_deg, step));
  for (const double theta_max : {-1.0, 91.0, nan}) expect_refused(with(&CompareOptions::theta_max_deg, theta_max));
  for (const double floor : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
    expect_refused(with(&CompareOptions::floor, floor));
  }
  for (const auto directions : {CompareDirections::kRandom, CompareDirections::kHighlight}) {
    expect_refused(drawn(directions, 0));
    CompareOptions flat = drawn(directions, 9);
    flat.theta_max_deg = 0;
    expect_refused(flat);
  }
}

TEST(Compare, EndsSoonWhenAskedToStop) {
  const FunctionSource source([](const auto&, std::size_t) { return 1.0; });
  for (const CompareOptions& options : {coarse(), drawn(CompareDirections::kRandom, 100'000)}) {
    const auto result = compare_sources(source, source, options, {[](double) { return false; }});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, interrupted_error().message);
  }
}

TEST(SymmetrisedSource, IsTheMeanOfBothOrdersAndReciprocalToTheLastBit) {
  const FunctionSource source(
      [](const auto& pair, std::size_t c) { return pair.i.theta + 3 * pair.v.phi + static_cast<double>(c); });
  const SymmetrisedSource symmetrised(source);
  EXPECT_TRUE(symmetrised.traits().reciprocal);
  // More than one of the blocks in which pairs are exchanged.
  std::vector<DirectionPair> pairs;
  std::vector<DirectionPair> exchanged;
  for (int k = 0; k < 700; ++k) {
    pairs.push_back({{0.001 * k, 0.002 * k}, {0.5, 0.1}});
    exchanged.push_back({pairs.back().v, pairs.back().i});
  }
  std::vector<float> there(2100);
  std::vector<float> back(2100);
  symmetrised.evaluate(pairs, there);
  symmetrised.evaluate(exchanged, back);
  EXPECT_EQ(there, back);
  for (std::size_t k = 0; k < 2100; ++k) {
    const auto& [i, v] = pairs[k / 3];
    const double expected = (i.theta + v.theta + 3 * (i.phi + v.phi)) / 2 + static_cast<double>(k % 3);
    EXPECT_NEAR(there[k], expected, 1e-6);
  }
}

TEST(ReciprocityResidual, IsTheMeanDifferenceOverTheMeanValue) {
  const FunctionSource source([](const auto& pair, std::size_t) { return 1 + degrees(pair.i.theta); });
  // theta_i, theta_v in 0, 5, ..., 80 with theta_v <= theta_i.
  double difference = 0;
  double sum = 0;
  for (int theta_i = 0; theta_i <= 80; theta_i += 5) {
    for (int theta_v = 0; theta_v <= theta_i; theta_v += 5) {
      difference += theta_i - theta_v;
      sum += 1 + (theta_i + theta_v) / 2.0;
    }
  }
  EXPECT_NEAR(reciprocity_difference_percent(source), 100 * difference / sum, 1e-9);
}

TEST(ReciprocityResidual, IsZeroForReciprocalAndForDarkSources) {
  EXPECT_EQ(reciprocity_difference_percent(FunctionSource([](const auto&, std::size_t) { return 0.0; })), 0);
  EXPECT_EQ(reciprocity_difference_percent(
                FunctionSource([](const auto& pair, std::size_t) { return pair.i.theta; }, {.reciprocal = true})),
            0);
  EXPECT_LT(reciprocity_difference_percent(
                FunctionSource([](const auto& pair, std::size_t) { return analytic_brdf(pair, {}); })),
            1e-5);
}

}  // namespace
}  // namespace sbrdf::internal
