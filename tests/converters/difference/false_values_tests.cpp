#include "converters/difference/false_values.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

const DirectionPair kPair = {direction_from_degrees(30, 40), direction_from_degrees(50, 100)};

FalseValues find(const BrdfSource& reference, const DirectionPair& pair, const std::vector<float>& r) {
  std::vector<float> f(reference.channel_count());
  reference.evaluate(std::span(&pair, 1), f);
  FalseValues found;
  find_false_values(reference, pair, f, r, FalseValueSearch::kAll, found);
  FalseValues far;
  find_false_values(reference, pair, f, r, FalseValueSearch::kFar, far);
  EXPECT_EQ(far.count, found.count);
  EXPECT_EQ(far.worst_factor, found.worst_factor);
  EXPECT_EQ(far.worst.channel, found.worst.channel);
  EXPECT_EQ(far.strict_count(), 0U);
  return found;
}

double degrees_between(const Direction& a, const Direction& b) {
  const auto va = vector_from_direction(a);
  const auto vb = vector_from_direction(b);
  return degrees_from_radians(std::acos(std::min(1.0, va.x * vb.x + va.y * vb.y + va.z * vb.z)));
}

TEST(FalseValues, AreThoseBeyondTheFactorsOfAConstantReference) {
  const FunctionSource one([](const auto&, std::size_t c) { return c == 1 ? 2.0 : 1.0; });
  const auto counts = [&](float r) {
    const FalseValues found = find(one, kPair, {r, 2, 1});
    return std::array<std::uint64_t, 3>{found.count, found.too_large, found.too_small};
  };
  using Counts = std::array<std::uint64_t, 3>;
  EXPECT_EQ(counts(1.49F), (Counts{0, 0, 0}));
  EXPECT_EQ(counts(1.51F), (Counts{0, 1, 0}));
  EXPECT_EQ(counts(5.99F), (Counts{0, 1, 0}));  // 3 times the largest of all channels
  EXPECT_EQ(counts(6.01F), (Counts{1, 1, 0}));
  EXPECT_EQ(counts(-6.01F), (Counts{1, 1, 0}));
  EXPECT_EQ(counts(0.67F), (Counts{0, 0, 0}));
  EXPECT_EQ(counts(0.66F), (Counts{0, 0, 1}));
  EXPECT_EQ(counts(-1.0F), (Counts{0, 0, 1}));
}

TEST(FalseValues, MayBeOneAndAHalfTimesANegativeReference) {
  const FunctionSource negative([](const auto&, std::size_t c) { return c == 0 ? -2.0 : 5.0; },
                                {.channels = {"a", "b"}});
  EXPECT_EQ(find(negative, kPair, {-2.9F, 5}).strict_count(), 0U);
  EXPECT_EQ(find(negative, kPair, {-3.1F, 5}).strict_count(), 1U);
  // Between 0 and the negative value there is room only up to the size that the reference has.
  EXPECT_EQ(find(negative, kPair, {2.9F, 5}).strict_count(), 0U);
  EXPECT_EQ(find(negative, kPair, {3.1F, 5}).too_large, 1U);
}

TEST(FalseValues, AreNotWhereTheReferenceIsAsLargeWithinThreeDegreesOfEitherDirection) {
  const auto spike_at = [](const DirectionPair& centre, double width_deg) {
    return FunctionSource(
        [=](const DirectionPair& pair, std::size_t) {
          const bool inside =
              degrees_between(pair.i, centre.i) < width_deg && degrees_between(pair.v, centre.v) < width_deg;
          return inside ? 100.0 : 1.0;
        },
        {.channels = {"Y"}});
  };
  const auto moved = [](double i_deg, double v_deg) {
    return DirectionPair{direction_from_degrees(30 + i_deg, 40), direction_from_degrees(50 + v_deg, 100)};
  };
  constexpr double kWidthDeg = 0.3;  // wider than half of what lies between the points that are looked at
  for (const double away : {0.0, 0.5, 1.2, 2.9}) {
    EXPECT_EQ(find(spike_at(moved(away, 0), kWidthDeg), kPair, {100}).strict_count(), 0U) << away;
    EXPECT_EQ(find(spike_at(moved(0, -away), kWidthDeg), kPair, {100}).strict_count(), 0U) << away;
  }
  for (const double away : {3.4, 10.0}) {
    EXPECT_EQ(find(spike_at(moved(away, 0), kWidthDeg), kPair, {100}).count, 1U) << away;
    EXPECT_EQ(find(spike_at(moved(0, -away), kWidthDeg), kPair, {100}).count, 1U) << away;
  }
  // One direction is moved, not both.
  EXPECT_EQ(find(spike_at(moved(2, 2), kWidthDeg), kPair, {100}).count, 1U);
}

TEST(FalseValues, AreNotBesideAMirrorHoweverNarrowItsHighlight) {
  const FunctionSource mirror(
      [](const DirectionPair& pair, std::size_t) {
        return degrees_from_radians(half_difference_from_pair(pair).theta_h) < 1e-6 ? 1000.0 : 1.0;
      },
      {.channels = {"Y"}});
  const DirectionPair beside = {direction_from_degrees(40, 10), direction_from_degrees(42.3, 191)};
  const DirectionPair far = {direction_from_degrees(40, 10), direction_from_degrees(43.5, 190)};
  EXPECT_EQ(find(mirror, beside, {900}).count, 0U);
  EXPECT_EQ(find(mirror, far, {900}).count, 1U);
}

TEST(FalseValues, LooksOnlyAboveTheHorizon) {
  const FunctionSource lit([](const DirectionPair& pair,
                              std::size_t) { return pair.i.theta >= kPi / 2 || pair.v.theta >= kPi / 2 ? 0.0 : 2.0; },
                           {.channels = {"Y"}});
  const DirectionPair grazing = {direction_from_degrees(88.8, 0), direction_from_degrees(20, 0)};
  EXPECT_EQ(find(lit, grazing, {1}).too_small, 1U);
}

TEST(FalseValues, CountsWhatIsNoNumber) {
  const FunctionSource one([](const auto&, std::size_t) { return 1.0; }, {.channels = {"Y"}});
  const FalseValues found = find(one, kPair, {std::numeric_limits<float>::quiet_NaN()});
  EXPECT_EQ(found.count, 1U);
  EXPECT_EQ(found.strict_count(), 1U);
  EXPECT_EQ(found.worst_factor, std::numeric_limits<double>::infinity());
}

TEST(FalseValues, KnowsTheWorst) {
  const FunctionSource one([](const auto&, std::size_t) { return 1.0; }, {.channels = {"a", "b"}});
  const DirectionPair other = {direction_from_degrees(10, 0), direction_from_degrees(5, 0)};
  FalseValues found = find(one, kPair, {4, 7});
  EXPECT_EQ(found.count, 2U);
  EXPECT_EQ(found.worst_factor, 7);
  EXPECT_EQ(found.worst.channel, 1U);
  EXPECT_EQ(found.worst.test, 7);
  EXPECT_EQ(found.worst.pair.i.theta, kPair.i.theta);
  found.add(find(one, other, {1, -9}));
  EXPECT_EQ(found.count, 3U);
  EXPECT_EQ(found.worst_factor, 9);
  EXPECT_EQ(found.worst.pair.i.theta, other.i.theta);
  EXPECT_EQ(found.strict_worst_at.test, -9);
  found.add(find(one, kPair, {9, 1}));
  EXPECT_EQ(found.worst.pair.i.theta, other.i.theta);  // the first of equals
}

TEST(FalseValues, LeavesTheReferenceAloneWhereNothingDiffersMuch) {
  int evaluations = 0;
  const FunctionSource counted([&](const auto&, std::size_t) { return ++evaluations, 1.0; }, {.channels = {"Y"}});
  FalseValues found;
  const std::vector<float> f = {1};
  const auto look = [&](float r, FalseValueSearch search) {
    find_false_values(counted, kPair, f, std::span(&r, 1), search, found);
  };
  for (const float r : {0.7F, 1.0F, 1.4F}) look(r, FalseValueSearch::kAll);
  for (const float r : {-2.9F, 0.1F, 2.9F}) look(r, FalseValueSearch::kFar);
  look(100, FalseValueSearch::kNone);
  EXPECT_EQ(evaluations, 0);
  EXPECT_EQ(found.strict_count(), 0U);
}

}  // namespace
}  // namespace sbrdf::internal
