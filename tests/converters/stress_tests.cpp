#include "converters/stress/stress.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

class StressTopic : public testing::TestWithParam<std::string> {};

TEST_P(StressTopic, Passes) {
  const std::vector<StressRow> rows = run_stress(1, {}, {.distort = {}, .topic = GetParam()});
  EXPECT_GE(rows.size(), 2U);
  for (const StressRow& row : rows) {
    EXPECT_TRUE(row.passed) << row.name << ": " << row.what << " " << row.worst << ", limit " << row.limit;
    EXPECT_GE(row.cases, 100U) << row.name;
  }
}

TEST_P(StressTopic, FailsWhereValuesAreNoNumbers) {
  const auto broken = [](float) { return std::numeric_limits<float>::quiet_NaN(); };
  for (const StressRow& row : run_stress(1, {}, {.distort = broken, .topic = GetParam()})) {
    EXPECT_FALSE(row.passed) << row.name;
  }
}

TEST_P(StressTopic, FailsWhereValuesAreOffByAThousandthHereAndThere) {
  const std::set<std::string> only_signs = {"range", "zeros", "spikes"};
  int calls = 0;
  const auto noisy = [&calls](float value) { return ++calls % 3 == 0 ? value * 1.001F : value; };
  for (const StressRow& row : run_stress(1, {}, {.distort = noisy, .topic = GetParam()})) {
    EXPECT_EQ(row.passed, only_signs.contains(GetParam())) << row.name;
  }
}

std::string parameter_name(const testing::TestParamInfo<std::string>& parameter) {
  std::string name = parameter.param;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, StressTopic, testing::ValuesIn(stress_topics()), parameter_name);

TEST(Stress, FailsWhereZerosAndSpikesComeOutNegative) {
  for (const char* topic : {"range", "zeros", "spikes"}) {
    for (const StressRow& row : run_stress(1, {}, {.distort = [](float f) { return f - 1e-3F; }, .topic = topic})) {
      EXPECT_FALSE(row.passed) << row.name;
    }
  }
}

TEST(Stress, StopsWhenAsked) {
  const Progress stop = {[](double) { return false; }};
  EXPECT_EQ(run_stress(1, stop, {.distort = {}, .topic = "constants"}).size(), 0U);
}

TEST(Stress, GivesTheSameRowsForTheSameSeed) {
  const auto first = run_stress(3, {}, {.distort = {}, .topic = "theta"});
  const auto second = run_stress(3, {}, {.distort = {}, .topic = "theta"});
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) EXPECT_EQ(first[k].worst, second[k].worst);
}

}  // namespace
}  // namespace sbrdf::internal
