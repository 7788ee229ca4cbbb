#include "converters/difference/log_histogram.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

// Of a sorted list, by its definition.
double exact_quantile(std::vector<double> values, double part) {
  std::sort(values.begin(), values.end());
  std::size_t rank = 1;
  while (static_cast<double>(rank) < part * static_cast<double>(values.size()) - 1e-9) ++rank;
  return values[rank - 1];
}

std::vector<double> spread_values(std::size_t count) {
  std::mt19937_64 random(5);
  std::vector<double> values;
  for (std::size_t k = 0; k < count; ++k) {
    values.push_back(std::pow(10, -8 + 14 * static_cast<double>(random() >> 11U) * 0x1p-53));
  }
  return values;
}

TEST(LogHistogram, HasTheQuantilesOfASortedList) {
  for (const std::size_t count : {1U, 2U, 100U, 1000U, 20011U}) {
    const std::vector<double> values = spread_values(count);
    LogHistogram histogram;
    for (const double value : values) histogram.add(value);
    for (const double part : {0.001, 0.25, 0.5, 0.9, 0.99, 0.999, 1.0}) {
      const double exact = exact_quantile(values, part);
      EXPECT_NEAR(histogram.quantile(part) / exact, 1, 0.004) << count << " values, " << part;
    }
  }
}

TEST(LogHistogram, TakesTheValueOfTheRankAndNotTheNext) {
  LogHistogram histogram;
  for (int k = 1; k <= 100; ++k) histogram.add(k <= 99 ? 1 : 1000);
  EXPECT_NEAR(histogram.quantile(0.99), 1, 0.004);
  EXPECT_NEAR(histogram.quantile(0.991), 1000, 4);
  for (int k = 0; k < 50; ++k) histogram.add(1000);
  EXPECT_NEAR(histogram.quantile(0.66), 1, 0.004);
  EXPECT_NEAR(histogram.quantile(0.67), 1000, 4);
}

TEST(LogHistogram, WeighsValues) {
  LogHistogram histogram;
  histogram.add(1, 3);
  histogram.add(2, 0.5);
  histogram.add(4, 0.5);
  EXPECT_NEAR(histogram.quantile(0.75), 1, 0.004);
  EXPECT_NEAR(histogram.quantile(0.76), 2, 0.008);
  EXPECT_NEAR(histogram.quantile(0.88), 4, 0.016);
}

TEST(LogHistogram, IsExactForEqualValuesAndForZeros) {
  LogHistogram histogram;
  for (int k = 0; k < 10; ++k) histogram.add(0.3);
  EXPECT_EQ(histogram.quantile(0.99), 0.3);
  LogHistogram zeros;
  zeros.add(0);
  EXPECT_EQ(zeros.quantile(0.5), 0);
}

TEST(LogHistogram, KnowsWhatIsBeyondItsCells) {
  LogHistogram histogram;
  histogram.add(1e-20);
  histogram.add(1);
  histogram.add(1e300);
  histogram.add(std::numeric_limits<double>::infinity());
  EXPECT_EQ(histogram.quantile(0.25), 1e-20);
  EXPECT_NEAR(histogram.quantile(0.5), 1, 0.004);
  EXPECT_EQ(histogram.quantile(0.75), std::numeric_limits<double>::infinity());
}

TEST(LogHistogram, ShowsANanAndThatNothingWasAdded) {
  LogHistogram histogram;
  EXPECT_TRUE(std::isnan(histogram.quantile(0.5)));
  histogram.add(1);
  EXPECT_EQ(histogram.quantile(0.5), 1);
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(std::isnan(histogram.quantile(0.5)));
}

TEST(LogHistogram, AddsUpInAnyOrder) {
  const std::vector<double> values = spread_values(999);
  std::vector<LogHistogram> parts(3);
  LogHistogram whole;
  for (std::size_t k = 0; k < values.size(); ++k) {
    parts[k % 3].add(values[k], 1 + 0.1 * static_cast<double>(k % 7));
    whole.add(values[k], 1 + 0.1 * static_cast<double>(k % 7));
  }
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, std::array{2, 0, 1}}) {
    LogHistogram sum;
    for (const int part : {a, b, c}) sum.add(parts[part]);
    for (const double part : {0.1, 0.5, 0.99}) EXPECT_EQ(sum.quantile(part), whole.quantile(part));
  }
}

}  // namespace
}  // namespace sbrdf::internal
