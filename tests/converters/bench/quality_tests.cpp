#include "converters/bench/quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

double smooth(const DirectionPair& pair, std::size_t channel) {
  return 0.1 * static_cast<double>(channel + 1) + 0.2 * std::cos(pair.i.theta) * std::cos(pair.v.theta);
}

/// What a test makes of the values of the function above; knows how many pairs a call has.
class ChangedContender final : public Contender {
 public:
  using Change = std::function<float(float value, std::size_t calls_pairs, std::size_t index)>;
  explicit ChangedContender(Change change, std::size_t channels = 3)
      : change_(std::move(change)), channels_(channels) {}

  [[nodiscard]] std::size_t channel_count() const override { return channels_; }
  [[nodiscard]] bool is_reciprocal() const override { return true; }
  void evaluate(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                std::span<float> values) const override {
    source_.evaluate_vectors(w_i, w_v, values);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = change_(values[k], w_i.size(), k);
  }

 private:
  FunctionSource source_{smooth, {.reciprocal = true}};
  Change change_;
  std::size_t channels_;
};

Status verified(const Contender& contender) {
  const FunctionSource source(smooth, {.reciprocal = true});
  return verify(contender, source, draw_vector_pairs(2000, 80));
}

void expect_refused(const Status& status, const char* fragment) {
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kDifference);
  EXPECT_THAT(status.error().message, HasSubstr(fragment));
}

TEST(BenchVerification, TakesWhatIsNearItsSource) {
  EXPECT_TRUE(verified(ChangedContender([](float v, auto, auto) { return v; })).ok());
  EXPECT_TRUE(verified(ChangedContender([](float v, auto, auto) { return 1.9F * v; })).ok()) << "poor, but not wild";
}

TEST(BenchVerification, RefusesWildValuesAndSaysWhere) {
  expect_refused(verified(ChangedContender([](float v, auto, auto) { return 2.1F * v; })), "theta_i");
  const ChangedContender black([](float v, auto, auto) { return -0.01F * v; });
  expect_refused(verified(black), "off by more than 101 %");
  const FunctionSource source(smooth, {.reciprocal = true});
  EXPECT_TRUE(verify(black, source, draw_vector_pairs(2000, 80), 102).ok()) << "a method may have its own limit";
}

TEST(BenchVerification, RefusesASingleValueThatIsNotFinite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const ChangedContender contender([bad](float v, auto, std::size_t k) { return k == 4003 ? bad : v; });
    expect_refused(verified(contender), "a value is not finite: G at");
  }
}

TEST(BenchVerification, RefusesBatchesWithOtherBitsThanSingleCalls) {
  const auto next = [](float v) { return std::nextafter(v, 1e9F); };
  expect_refused(verified(ChangedContender([&](float v, std::size_t pairs, auto) { return pairs == 1 ? next(v) : v; })),
                 "a batch of 1 pairs gives other bits");
  expect_refused(verified(ChangedContender(
                     [&](float v, std::size_t pairs, std::size_t k) { return pairs == 16 && k == 40 ? next(v) : v; })),
                 "a batch of 16 pairs gives other bits");
}

TEST(BenchVerification, RefusesAnotherNumberOfChannels) {
  expect_refused(verified(ChangedContender([](float v, auto, auto) { return v; }, 1)),
                 "has 1 channels where the source has 3");
}

TEST(BenchVerification, HoldsWhatIsReciprocalAgainstTheMeanOfBothOrders) {
  // 0.3 times 1 +- d: the mean is a constant, which the contender has, and no value of the source is near it.
  const auto skewed = [](const DirectionPair& pair, std::size_t) {
    return pair.i.theta > pair.v.theta ? 0.3 * 2.5 : 0.3 * -0.5;
  };
  class Constant final : public Contender {
   public:
    explicit Constant(bool reciprocal) : reciprocal_(reciprocal) {}
    [[nodiscard]] std::size_t channel_count() const override { return 3; }
    [[nodiscard]] bool is_reciprocal() const override { return reciprocal_; }
    void evaluate(std::span<const glm::vec3>, std::span<const glm::vec3>, std::span<float> values) const override {
      std::fill(values.begin(), values.end(), 0.3F);
    }

   private:
    bool reciprocal_;
  };
  const FunctionSource source(skewed);
  const Result<Quality> held = measure_quality(Constant(true), source, {2000, 80}, {});
  ASSERT_TRUE(held.ok());
  EXPECT_LT(held->off_grid_rel_l1_percent, 1e-4);
  const Result<Quality> plain = measure_quality(Constant(false), source, {2000, 80}, {});
  ASSERT_TRUE(plain.ok());
  EXPECT_GT(plain->off_grid_rel_l1_percent, 50);
}

TEST(BenchQuality, IsTheRelativeErrorOfAScaledCopyOnAndOffTheGrid) {
  const FunctionSource source(smooth, {.reciprocal = true});
  const ChangedContender contender([](float v, auto, auto) { return 1.02F * v; });
  const Result<Quality> quality = measure_quality(contender, source, {3000, 80}, {});
  ASSERT_TRUE(quality.ok());
  EXPECT_NEAR(quality->grid_mre_percent, 2, 1e-3);
  EXPECT_NEAR(quality->grid_rel_l1_percent, 2, 1e-3);
  EXPECT_NEAR(quality->off_grid_mre_percent, 2, 1e-3);
  EXPECT_NEAR(quality->off_grid_rel_l1_percent, 2, 1e-3);
}

}  // namespace
}  // namespace sbrdf::internal
