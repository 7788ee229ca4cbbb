#include "codec/search/structure_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
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

// Starts of both frames, with each floor, with and without a guide.
std::vector<Structure> some_structures(const SearchOptions& options) {
  std::vector<Structure> structures;
  for (const Structure& start : regular_starts(options, 100)) {
    for (const int halvings : {2, 5, 10}) {
      for (const std::optional<double> ratio : {std::optional<double>{}, std::optional<double>{1}}) {
        structures.push_back(start);
        structures.back().floor_halvings = halvings;
        structures.back().guide_ratio = ratio;
      }
    }
  }
  return structures;
}

TEST(Moves, NeverLeadToWhereTheyBeganNorTwiceToTheSamePlace) {
  for (const bool isotropic : {false, true}) {
    SearchOptions options;
    options.symmetries.isotropic = isotropic;
    options.sampling.sample_count = 3000;
    for (const Structure& from : some_structures(options)) {
      const std::vector<Move> moves = moves_from(from, options);
      for (std::size_t k = 0; k < moves.size(); ++k) {
        EXPECT_FALSE(same(moves[k].to, from));
        EXPECT_EQ(moves[k].to.domain, from.domain);
        for (std::size_t other = 0; other < k; ++other) EXPECT_FALSE(same(moves[k].to, moves[other].to));
      }
    }
  }
}

TEST(Moves, MadeAloneLeadWhereTheySay) {
  SearchOptions options;
  options.sampling.sample_count = 1000;
  for (const Structure& from : some_structures(options)) {
    for (const Move& move : moves_from(from, options)) {
      EXPECT_TRUE(same(with_moves(from, std::span(&move, 1)), move.to));
    }
  }
}

TEST(Moves, ThatAreApartCanBeMadeInAnyOrder) {
  SearchOptions options;
  options.sampling.sample_count = 1000;
  std::size_t apart = 0;
  for (const Structure& from : some_structures(options)) {
    const std::vector<Move> moves = moves_from(from, options);
    for (std::size_t k = 0; k + 1 < moves.size(); ++k) {
      const Move& a = moves[k];
      const Move& b = moves[(k + moves.size() / 3) % moves.size()];
      EXPECT_FALSE(are_apart(a, a));
      EXPECT_EQ(are_apart(a, b), are_apart(b, a));
      if (!are_apart(a, b)) continue;
      ++apart;
      const std::vector<Move> there = {a, b};
      const std::vector<Move> back = {b, a};
      const Structure both = with_moves(from, there);
      EXPECT_TRUE(same(both, with_moves(from, back)));
      EXPECT_FALSE(same(both, a.to));
      EXPECT_FALSE(same(both, b.to));
      for (const std::vector<double>& list : both.outline.lists) EXPECT_TRUE(std::ranges::is_sorted(list));
    }
  }
  EXPECT_GT(apart, 1000U);
}

TEST(Moves, OfOneAxisThatShareANodeAreNotApart) {
  Structure from;
  from.outline = {FrameId::kHalfDifference, {.isotropic = true}, {{{0}, {0, 90}, {0, 40, 80}, {0, 10, 30, 60, 80}}}};
  SearchOptions options;
  options.symmetries.isotropic = true;
  const std::vector<Move> moves = moves_from(from, options);
  const auto move_to = [&](const std::vector<double>& theta_h) {
    return *std::ranges::find_if(moves, [&](const Move& move) { return move.to.outline.lists[kVertical] == theta_h; });
  };
  const Move insert_5 = move_to({0, 5, 10, 30, 60, 80});
  const Move insert_20 = move_to({0, 10, 20, 30, 60, 80});
  const Move erase_10 = move_to({0, 30, 60, 80});
  const Move erase_60 = move_to({0, 10, 30, 80});
  EXPECT_TRUE(are_apart(insert_5, insert_20));
  EXPECT_FALSE(are_apart(insert_20, erase_10));
  EXPECT_FALSE(are_apart(insert_5, erase_10));
  EXPECT_TRUE(are_apart(erase_10, erase_60));
  const std::vector<Move> three = {erase_60, insert_20, insert_5};
  EXPECT_EQ(with_moves(from, three).outline.lists[kVertical], (std::vector<double>{0, 5, 10, 20, 30, 80}));
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

const Measure kElevation = [](std::span<const DirectionPair> pairs, std::span<float> values) {
  for (std::size_t k = 0; k < pairs.size(); ++k) values[k] = static_cast<float>(pairs[k].i.theta);
  return ok_status();
};

TEST(HeldBack, LeavesOutWhatWasNotMeasuredAndGoesUpToThetaMax) {
  const double limit = radians_from_degrees(60);
  const auto is_measured = [&](const DirectionPair& pair) { return pair.i.theta < limit / 2; };
  HeldBackDraw draw = {.count = 2000, .theta_max_deg = 60};
  draw.measured = [&](std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) {
    for (std::size_t k = 0; k < pairs.size(); ++k) flags[k] = is_measured(pairs[k]) ? 1 : 0;
  };
  const HeldBack held_back = draw_held_back(draw, 1, kElevation).value();
  EXPECT_TRUE(std::ranges::all_of(held_back.pairs, is_measured));
  EXPECT_GE(held_back.pairs.size(), 1600U);  // of 4,000, some are certain to be kept
  EXPECT_LE(held_back.pairs.size(), 2000U);
  EXPECT_EQ(held_back.values.size(), held_back.pairs.size());
  for (std::size_t k = 0; k < held_back.pairs.size(); ++k) {
    EXPECT_EQ(held_back.values[k], static_cast<float>(held_back.pairs[k].i.theta));
    EXPECT_LE(held_back.pairs[k].v.theta, limit);
  }
  EXPECT_NEAR(std::accumulate(held_back.weights.begin(), held_back.weights.end(), 0.0), 1, 1e-12);
}

// Also where the source is far larger in some places than in others, which are then drawn more often.
TEST(HeldBack, HasTheMeansOfTheUniformDraw) {
  for (const double exponent : {0.0, 1.0, 4.0}) {
    const Measure measure = [&](std::span<const DirectionPair> pairs, std::span<float> values) {
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        values[k] = static_cast<float>(std::pow(std::cos(pairs[k].v.theta), exponent));
      }
      return ok_status();
    };
    const HeldBack held_back = draw_held_back({.count = 40'000}, 1, measure).value();
    std::vector<double> means(4);
    for (std::size_t k = 0; k < held_back.pairs.size(); ++k) {
      const DirectionPair& pair = held_back.pairs[k];
      means[0] += held_back.weights[k] * degrees_from_radians(pair.i.theta) / 80;
      means[1] += held_back.weights[k] * degrees_from_radians(pair.v.theta) / 80;
      means[2] += held_back.weights[k] * std::pow(std::sin(pair.i.phi), 2);
      means[3] += held_back.weights[k] * std::pow(std::sin(pair.i.phi - pair.v.phi), 2);
    }
    for (const double mean : means) EXPECT_NEAR(mean, 0.5, 0.012) << exponent;
  }
}

// In a uniform draw one pair of a million would lie within.
TEST(HeldBack, SeesAHighlightAFiftiethOfADegreeWide) {
  const double width = radians_from_degrees(0.02);
  const auto inside = [&](const DirectionPair& pair) { return half_difference_from_pair(pair).theta_h < width; };
  const Measure measure = [&](std::span<const DirectionPair> pairs, std::span<float> values) {
    for (std::size_t k = 0; k < pairs.size(); ++k) values[k] = inside(pairs[k]) ? 1e6F : 1;
    return ok_status();
  };
  const HeldBack held_back = draw_held_back({.count = 12'000}, 1, measure).value();
  EXPECT_GT(std::ranges::count_if(held_back.pairs, inside), 200);
}

TEST(HeldBack, AtAGlanceIsAnEvenPart) {
  const HeldBack all = draw_held_back({.count = 5000}, 1, kElevation).value();
  const HeldBack few = first_of(all, 1000);
  EXPECT_EQ(few.pairs.size(), 1000U);
  EXPECT_EQ(few.values.size(), 1000U);
  EXPECT_NEAR(std::accumulate(few.weights.begin(), few.weights.end(), 0.0), 1, 1e-12);
  EXPECT_NEAR(mre_floor(few), mre_floor(all), 0.05 * mre_floor(all));
  EXPECT_EQ(first_of(all, 10'000).pairs.size(), all.pairs.size());
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
