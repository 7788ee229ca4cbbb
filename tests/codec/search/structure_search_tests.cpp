#include "codec/search/structure_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "codec/search/moves.h"
#include "codec/search/starts.h"

namespace sbrdf::internal {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(Standard, TakesTheMeanOfBothErrorsOrTheOneThatATargetNames) {
  const HeldBackError error = {2, 8};
  EXPECT_DOUBLE_EQ(Standard{.objective = Objective::kBoth}.value_of(error), 4);
  EXPECT_EQ(Standard{.objective = Objective::kMre}.value_of(error), 2);
  EXPECT_EQ(Standard{.objective = Objective::kRelL1}.value_of(error), 8);
}

TEST(Standard, RefusesWhatIsWorseByOneErrorHoweverGoodByTheOther) {
  const Standard both = {.objective = Objective::kBoth, .ceiling = {2, 8}};
  EXPECT_EQ(both.value_of({2, 8}), 4);
  EXPECT_LT(both.value_of({2, 0.5}), 4);
  EXPECT_LT(both.value_of({0.5, 8}), 4);
  EXPECT_EQ(both.value_of({2.001, 0.001}), kInfinite);
  EXPECT_EQ(both.value_of({0.001, 8.001}), kInfinite);
}

TEST(Standard, LooksAtOneErrorAloneWhereATargetNamesIt) {
  EXPECT_EQ((Standard{.objective = Objective::kMre, .ceiling = {2, 8}}.value_of({1, 9})), 1);
  EXPECT_EQ((Standard{.objective = Objective::kRelL1, .ceiling = {2, 8}}.value_of({3, 7})), 7);
}

bool same(const Structure& a, const Structure& b) {
  return a.outline.id == b.outline.id && a.outline.lists == b.outline.lists && a.domain == b.domain &&
         a.floor_halvings == b.floor_halvings && a.guide_ratio == b.guide_ratio && a.value_exponent == b.value_exponent;
}

TEST(Moves, NeverLeadToWhereTheyBeganNorTwiceToTheSamePlace) {
  for (const bool isotropic : {false, true}) {
    SearchOptions options;
    options.symmetries.isotropic = isotropic;
    options.sampling.sample_count = 3000;
    for (const Structure& start : regular_starts(options, 100)) {
      for (const int halvings : {2, 5, 10}) {
        for (const std::optional<double> ratio : {std::optional<double>{}, std::optional<double>{1}}) {
          Structure from = start;
          from.floor_halvings = halvings;
          from.guide_ratio = ratio;
          const Moves moves = moves_from(from, options);
          // The present floor and, where there may be one, the present guide.
          EXPECT_EQ(moves.known, from.outline.id == FrameId::kHalfDifference ? 2U : 1U);
          for (std::size_t k = 0; k < moves.structures.size(); ++k) {
            EXPECT_FALSE(same(moves.structures[k], from));
            for (std::size_t other = 0; other < k; ++other) {
              EXPECT_FALSE(same(moves.structures[k], moves.structures[other]));
            }
          }
        }
      }
    }
  }
}

TEST(Moves, KeepToTheDomainThatWasAskedFor) {
  SearchOptions options;
  options.sampling.sample_count = 1000;
  const Structure start = regular_starts(options, 1).front();
  const auto changes_domain = [&](const Structure& move) { return move.domain != start.domain; };
  const Moves open = moves_from(start, options);
  EXPECT_EQ(std::count_if(open.structures.begin(), open.structures.end(), changes_domain), 1);
  options.domain = start.domain;
  const Moves fixed = moves_from(start, options);
  EXPECT_EQ(std::count_if(fixed.structures.begin(), fixed.structures.end(), changes_domain), 0);
}

TEST(RegularStarts, EndAtThetaMax) {
  for (const double theta_max : {5.0, 40.0, 62.25, 80.0, 90.0}) {
    SearchOptions options;
    options.theta_max_deg = theta_max;
    options.sampling.sample_count = 100'000;
    for (const bool isotropic : {false, true}) {
      options.symmetries.isotropic = isotropic;
      for (const Structure& start : regular_starts(options, 1000)) {
        const FrameSpec spec = expand_outline(start.outline);
        EXPECT_TRUE(check_frame(spec)) << theta_max;
        EXPECT_EQ(spec.theta_max_deg, theta_max);
        EXPECT_EQ(spec.axes[kHorizontal].nodes_deg.back(), theta_max);
        EXPECT_EQ(spec.axes[kVertical].nodes_deg.back(), theta_max);
      }
    }
  }
}

// By the share of the draws that were measured; the weights still add up to the whole.
TEST(HeldBack, LeavesOutWhatWasNotMeasuredAndGoesUpToThetaMax) {
  const Measure measure = [](auto pairs, auto values) {
    for (std::size_t k = 0; k < pairs.size(); ++k) values[k] = static_cast<float>(pairs[k].i.theta);
    return ok_status();
  };
  HeldBackDraw draw = {.count = 2000, .theta_max_deg = 60};
  const HeldBack all = draw_held_back(draw, 1, measure).value();
  const double limit = radians_from_degrees(60);
  const auto is_measured = [&](const DirectionPair& pair) { return pair.i.theta < limit / 2; };
  draw.measured = [&](std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) {
    for (std::size_t k = 0; k < pairs.size(); ++k) flags[k] = is_measured(pairs[k]) ? 1 : 0;
  };
  const HeldBack some = draw_held_back(draw, 1, measure).value();
  double greatest = 0;
  double share = 0;
  std::vector<float> expected;
  for (std::size_t k = 0; k < all.pairs.size(); ++k) {
    greatest = std::max({greatest, all.pairs[k].i.theta, all.pairs[k].v.theta});
    if (!is_measured(all.pairs[k])) continue;
    share += all.weights[k];
    expected.push_back(all.values[k]);
  }
  EXPECT_LE(greatest, limit);
  EXPECT_GT(greatest, 0.98 * limit);
  EXPECT_EQ(some.values, expected);
  EXPECT_NEAR(share, 0.5, 0.05);
  EXPECT_NEAR(std::accumulate(some.weights.begin(), some.weights.end(), 0.0), 1, 1e-12);
}

TEST(RegularStarts, FitTheBudgetAndAreNoMoreThanAskedFor) {
  for (const std::uint64_t samples : {300U, 3000U}) {
    for (const std::size_t most : {1U, 5U, 1000U}) {
      SearchOptions options;
      options.sampling.sample_count = samples;
      const std::vector<Structure> starts = regular_starts(options, most);
      EXPECT_FALSE(starts.empty());
      EXPECT_LE(starts.size(), most);
      for (const Structure& start : starts) {
        const Lattice lattice = build_lattice(expand_outline(start.outline)).value();
        EXPECT_TRUE(fits_budget(lattice.crossings.size(), samples));
      }
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
