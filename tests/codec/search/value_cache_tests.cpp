#include "codec/search/value_cache.h"

#include <array>
#include <atomic>
#include <vector>

#include <gtest/gtest.h>

#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kCachedChannels = 2;

std::array<float, kCachedChannels> value_at(const DirectionPair& pair) {
  return {static_cast<float>(pair.i.theta + 10 * pair.v.theta), static_cast<float>(pair.i.phi - pair.v.phi)};
}

std::vector<DirectionPair> some_pairs(std::size_t count) {
  std::vector<DirectionPair> pairs;
  for (std::size_t k = 0; k < count; ++k) {
    const double x = static_cast<double>(k);
    pairs.push_back({{0.001 * x, 1}, {0.5, 0.002 * x}});
  }
  return pairs;
}

class ValueCacheTest : public testing::Test {
 protected:
  std::atomic<std::size_t> measured_ = 0;
  const Measure measure_ = [this](std::span<const DirectionPair> pairs, std::span<float> values) {
    measured_ += pairs.size();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto row = value_at(pairs[k]);
      std::copy(row.begin(), row.end(), values.data() + k * kCachedChannels);
    }
    return ok_status();
  };

  static void expect_values(std::span<const DirectionPair> pairs, std::span<const float> values) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      EXPECT_EQ(values[k], value_at(pairs[k / kCachedChannels])[k % kCachedChannels]);
    }
  }
};

TEST_F(ValueCacheTest, MeasuresAPairOnce) {
  ValueCache cache(measure_, kCachedChannels);
  const std::vector<DirectionPair> pairs = some_pairs(1000);
  std::vector<float> values(pairs.size() * kCachedChannels);
  for (const std::size_t count : {300U, 1000U, 1000U}) {
    const auto part = std::span(pairs).first(count);
    ASSERT_TRUE(cache.measure(part, std::span(values).first(count * kCachedChannels)));
    expect_values(part, std::span(values).first(count * kCachedChannels));
  }
  EXPECT_EQ(measured_, 1000U);
}

TEST_F(ValueCacheTest, GivesTheRightValuesToSeveralThreadsAndBeyondItsRoom) {
  ValueCache cache(measure_, kCachedChannels);
  const std::vector<DirectionPair> pairs = some_pairs(2'000'000);
  parallel_for(8, [&](std::uint64_t k) {
    const auto part = std::span(pairs).subspan(k / 2 * 400'000, 800'000);
    std::vector<float> values(part.size() * kCachedChannels);
    ASSERT_TRUE(cache.measure(part, values));
    expect_values(part, values);
  });
}

TEST_F(ValueCacheTest, PassesErrorsOnAndForgetsThem) {
  bool fails = true;
  const Measure measure = [&](std::span<const DirectionPair> pairs, std::span<float> values) -> Status {
    return fails ? io_error("interrupted") : measure_(pairs, values);
  };
  ValueCache cache(measure, kCachedChannels);
  const std::vector<DirectionPair> pairs = some_pairs(10);
  std::vector<float> values(pairs.size() * kCachedChannels);
  EXPECT_FALSE(cache.measure(pairs, values));
  fails = false;
  ASSERT_TRUE(cache.measure(pairs, values));
  expect_values(pairs, values);
}

}  // namespace
}  // namespace sbrdf::internal
