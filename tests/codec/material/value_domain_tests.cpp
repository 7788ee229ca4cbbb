#include "codec/material/value_domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

ValueDomain log_domain(float reference, int floor_halvings) { return {DomainKind::kLog, {reference}, floor_halvings}; }

/// The definition, in the widest arithmetic.
long double log_value(long double f, long double reference, long double floor) {
  if (f >= floor) return std::log(f / reference);
  return std::log(floor / reference) - 1 + std::max(f, 0.0L) / floor;
}

TEST(LinearDomain, LeavesEveryValueAsItIs) {
  const DomainMap<float> map(ValueDomain{}, 0);
  for (const float f : {-3.5F, -0.0F, 0.0F, 1e-30F, 0.1F, 1e12F}) {
    EXPECT_EQ(map.forward(f), f);
    EXPECT_EQ(map.inverse(f), f);
  }
}

TEST(LogDomain, IsTheLogarithmAboveTheFloorAndItsTangentBelow) {
  const DomainMap<double> map(log_domain(0.25F, 8), 0);
  for (const float f : {0.0F, 1e-9F, 0.0005F, 0.000999F, 0.001F, 0.00101F, 0.01F, 0.25F, 7.0F, 1e12F}) {
    EXPECT_NEAR(map.forward(f), static_cast<double>(log_value(f, 0.25F, 0x1p-10F)), 1e-14) << f;
  }
}

TEST(LogDomain, SendsTheReferenceToExactlyZeroAndBack) {
  for (const float reference : {1e-30F, 0.0123F, 1.0F, 3.3F, 1e12F}) {
    const DomainMap<float> map(log_domain(reference, 20), 0);
    EXPECT_EQ(map.forward(reference), 0);
    EXPECT_EQ(map.inverse(0), reference);
  }
}

TEST(LogDomain, SendsZeroBackToZero) {
  for (const float reference : {1e-20F, 0.0123F, 1.0F, 3.3F, 1e12F}) {
    const DomainMap<float> map(log_domain(reference, 20), 0);
    EXPECT_EQ(map.inverse(map.forward(0)), 0);
    EXPECT_EQ(map.inverse(map.forward(-0.0F)), 0);
  }
}

TEST(LogDomain, KeepsNegativeValues) {
  const DomainMap<double> map(log_domain(1, 7), 0);
  for (const double f : {-1e-30, -1e-3, -0.01, -0.5, -1e12}) {
    EXPECT_NEAR(map.inverse(map.forward(f)), f, 1e-12 * std::abs(f) + 1e-16);
    EXPECT_LE(map.forward(f), map.forward(0.0));
  }
}

TEST(LogDomain, IsOddAboutTheValueOfZero) {
  const DomainMap<double> map(log_domain(1, 7), 0);
  const double zero = map.forward(0.0);
  for (const double f : {1e-6, 5e-3, 0.02, 3.0, 1e9}) {
    EXPECT_NEAR(map.forward(f) - zero, zero - map.forward(-f), 1e-12);
  }
}

TEST(LogDomain, IsContinuousWithItsSlopeAtTheFloor) {
  const double floor = 0.015625;
  const DomainMap<double> map(log_domain(2, 7), 0);
  const double step = floor * 1e-6;
  const double above = (map.forward(floor + step) - map.forward(floor)) / step;
  const double below = (map.forward(floor) - map.forward(floor - step)) / step;
  EXPECT_NEAR(map.forward(floor - 1e-14), map.forward(floor), 1e-11);
  EXPECT_NEAR(above * floor, 1, 1e-6);
  EXPECT_NEAR(below * floor, 1, 1e-6);
}

TEST(LogDomain, RisesWithTheValueInBothDirections) {
  const DomainMap<double> map(log_domain(0.7F, 9), 0);
  double last_f = -1;
  double last_v = map.forward(0) - 1;
  for (int k = 0; k <= 4000; ++k) {
    const double f = k == 0 ? 0 : 1e-6 * std::exp(k * 0.01);
    const double v = map.forward(f);
    ASSERT_GT(v, last_v);
    ASSERT_GT(map.inverse(v), last_f);
    last_v = v;
    last_f = map.inverse(v);
  }
}

TEST(LogDomain, ComesBackWithinRoundingOverFortyOrders) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-69, 27);  // 1e-30 .. 1e12
  const DomainMap<float> narrow(log_domain(1e-6F, 80), 0);
  const DomainMap<long double> wide(log_domain(1e-6F, 80), 0);
  for (int k = 0; k < 2000; ++k) {
    const auto f = static_cast<float>(std::exp(exponent(random)));
    ASSERT_EQ(static_cast<float>(wide.inverse(wide.forward(f))), f);
    const float v = narrow.forward(f);
    ASSERT_NEAR(narrow.inverse(v) / f, 1, 1e-6 + std::abs(v) * 1.2e-7);
  }
}

TEST(LogDomain, HoldsTheLargestValueBesideAReferenceFortyOrdersBelow) {
  const DomainMap<float> map(log_domain(1e-30F, 20), 0);
  EXPECT_NEAR(map.forward(1e12F), std::log(1e42), 1e-5);
  EXPECT_NEAR(map.inverse(map.forward(1e12F)) / 1e12F, 1, 2e-5);
}

TEST(LogDomain, KeepsTheChannelsApart) {
  const ValueDomain domain = {DomainKind::kLog, {1, 4}, 1};
  EXPECT_EQ(DomainMap<float>(domain, 0).forward(1), 0);
  EXPECT_EQ(DomainMap<float>(domain, 1).forward(4), 0);
}

TEST(ChooseLogDomain, TakesTheMedianOfThePositiveValuesOfEachChannel) {
  const std::vector<float> values = {5, 0, 1, -2, 9, 0, 2, 0.5F, 7, -1, 0, 0};
  const ValueDomain domain = choose_log_domain(values, 2, 3);
  EXPECT_EQ(domain.kind, DomainKind::kLog);
  EXPECT_EQ(domain.reference, (std::vector<float>{5, 0.5F}));
  EXPECT_EQ(domain.floor(0), 5.0F / 8);
  EXPECT_EQ(domain.floor(1), 0.5F / 8);
}

TEST(ChooseLogDomain, TakesOneWhereNothingIsPositive) {
  const std::vector<float> values = {0, -1, 0, -5};
  const ValueDomain domain = choose_log_domain(values, 1, 10);
  EXPECT_EQ(domain.reference, std::vector<float>{1});
  EXPECT_EQ(domain.floor(0), 0x1p-10F);
}

TEST(ChooseLogDomain, KeepsTheFloorANormalNumberAtMostTheReference) {
  for (const float value : {1e-33F, 1e-37F, 1e-40F, std::numeric_limits<float>::denorm_min()}) {
    const ValueDomain domain = choose_log_domain(std::vector<float>{value}, 1, kDefaultFloorHalvings);
    EXPECT_GT(domain.floor(0), 0);
    EXPECT_LE(domain.floor(0), domain.reference[0]) << value;
    EXPECT_EQ(DomainMap<float>(domain, 0).inverse(DomainMap<float>(domain, 0).forward(value)), value);
  }
}

TEST(ChooseLogDomain, DoesNotDependOnTheOrderOfTheValues) {
  std::vector<float> values = {3, 1, 4, 1.5F, 9, 2.6F, 5};
  const ValueDomain expected = choose_log_domain(values, 1, 20);
  std::sort(values.begin(), values.end());
  EXPECT_EQ(choose_log_domain(values, 1, 20), expected);
}

}  // namespace
}  // namespace sbrdf::internal
