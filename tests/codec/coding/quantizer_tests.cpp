#include "codec/coding/quantizer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

constexpr std::array kBounds = {1e-6, 1e-3, 0.01, 0.5};
constexpr float kLeast = 0x1p-126F;  // the smallest magnitude for which a bound is kept
constexpr float kMost = 1e38F;

std::uint32_t bits_of(float f) { return std::bit_cast<std::uint32_t>(f); }

/// Magnitudes from kLeast to kMost, evenly over the exponents, rising.
std::vector<float> magnitudes(std::size_t count) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-126, std::log2(1e38));
  std::vector<float> values = {
      kLeast, std::nextafter(kLeast, 1.0F), 1.0F, std::nextafter(1.0F, 0.0F), std::nextafter(1.0F, 2.0F), 2.0F, kMost};
  while (values.size() < count)
    values.push_back(std::clamp(static_cast<float>(std::exp2(exponent(random))), kLeast, kMost));
  std::sort(values.begin(), values.end());
  return values;
}

Quantizer scale_from_least(double bound) {
  Quantizer scale(bound);
  scale.begin_at_smallest({std::array{kLeast}});
  return scale;
}

/// Section 4 of the specification, as it is written there.
float specified_value(const Quantizer& scale, std::int32_t step) {
  const auto n = static_cast<std::int64_t>(scale.per_octave());
  const std::int64_t m = std::abs(static_cast<std::int64_t>(step)) - 1 + scale.lowest();
  const std::int64_t octave = m >= 0 ? m / n : -((-m + n - 1) / n);
  double t = 1;
  for (std::int64_t k = 0; k < m - octave * n; ++k) t *= scale.ratio();
  const auto f = static_cast<float>(std::ldexp(t, static_cast<int>(octave)));
  return step < 0 ? -f : f;
}

TEST(BoundedScale, KeepsTheBoundForEveryMagnitudeAndBothSigns) {
  for (const double bound : kBounds) {
    const Quantizer scale = scale_from_least(bound);
    for (const float magnitude : magnitudes(20'000)) {
      for (const float v : {magnitude, -magnitude}) {
        const double back = scale.value(scale.step(v));
        ASSERT_LE(std::abs(back - v), bound * std::abs(static_cast<double>(v))) << v << " within " << bound;
      }
    }
  }
}

TEST(BoundedScale, KeepsTheBoundWhereItIsHardestHalfWayBetweenSteps) {
  for (const double bound : kBounds) {
    const Quantizer scale = scale_from_least(bound);
    const std::int32_t last = scale.step(kMost) - 1;
    double worst = 0;
    for (int k = 0; k < 2000; ++k) {
      const auto step = static_cast<std::int32_t>(1 + static_cast<std::int64_t>(k) * (last - 1) / 2000);
      const double low = scale.value(step);
      const double high = scale.value(step + 1);
      float v = static_cast<float>(0.5 * (low + high));
      for (int nudge = 0; nudge < 3; ++nudge) v = std::nextafter(v, 0.0F);
      for (int nudge = 0; nudge < 7; ++nudge, v = std::nextafter(v, kMost)) {
        const double off = std::abs(scale.value(scale.step(v)) - static_cast<double>(v)) / static_cast<double>(v);
        ASSERT_LE(off, bound) << v;
        worst = std::max(worst, off);
      }
    }
    EXPECT_GT(worst, (bound < 0.1 ? 0.9 : 0.6) * bound);  // what was tried is hard, and nothing is wasted
  }
}

TEST(Scale, KeepsZeroAndHasNoNegativeOne) {
  for (const Quantizer& scale : {Quantizer(), Quantizer(0.001), scale_from_least(0.5)}) {
    EXPECT_EQ(scale.step(0.0F), 0);
    EXPECT_EQ(scale.step(-0.0F), 0);
    EXPECT_EQ(bits_of(scale.value(0)), 0U);
  }
}

TEST(Scale, RisesWithTheValueAndIsOppositeForNegatives) {
  for (const Quantizer& scale : {Quantizer(), scale_from_least(1e-6), scale_from_least(0.01), scale_from_least(0.5)}) {
    std::int32_t last = 0;
    for (const float v : magnitudes(5000)) {
      const std::int32_t step = scale.step(v);
      EXPECT_GT(step, 0) << v;
      EXPECT_GE(step, last) << v;
      EXPECT_EQ(scale.step(-v), -step) << v;
      EXPECT_EQ(scale.value(-step), -scale.value(step)) << v;
      last = step;
    }
  }
}

TEST(BoundedScale, HasStepsThatRiseStrictlyAndComeBackFromTheirValues) {
  for (const double bound : kBounds) {
    const Quantizer scale = scale_from_least(bound);
    const std::int32_t last = scale.step(kMost);
    const std::int32_t stride = std::max(1, last / 20'000);
    for (std::int32_t step = 1; step < last; step += stride) {
      EXPECT_LT(scale.value(step), scale.value(step + 1)) << step;
      EXPECT_EQ(scale.step(scale.value(step)), step);
      EXPECT_EQ(scale.step(scale.value(-step)), -step);
    }
  }
}

TEST(BoundedScale, GivesTheNearestStep) {
  for (const double bound : kBounds) {
    const Quantizer scale = scale_from_least(bound);
    for (const float v : magnitudes(5000)) {
      const std::int32_t step = scale.step(v);
      const double off = std::abs(static_cast<double>(scale.value(step)) - v);
      for (const std::int32_t other : {step - 1, step + 1}) {
        const double other_off = std::abs(static_cast<double>(scale.value(other)) - v);
        EXPECT_LE(off, other_off + static_cast<double>(v) * 0x1p-22) << v << " within " << bound;
      }
    }
  }
}

TEST(BoundedScale, HasTheValuesOfTheSpecification) {
  std::mt19937 random(3);
  for (const double bound : {1e-5, 1e-3, 0.01, 0.5}) {
    const Quantizer scale = scale_from_least(bound);
    std::uniform_int_distribution<std::int32_t> steps(1, scale.step(kMost));
    for (int k = 0; k < 300; ++k) {
      const std::int32_t step = steps(random);
      EXPECT_EQ(bits_of(scale.value(step)), bits_of(specified_value(scale, step))) << step;
      EXPECT_EQ(bits_of(scale.value(-step)), bits_of(specified_value(scale, -step))) << step;
    }
  }
}

TEST(BoundedScale, TakesTheFewestStepsThatCanKeepTheBound) {
  for (double bound = 1e-6; bound <= 0.5; bound *= 1.37) {
    const Quantizer scale(bound);
    const double left = bound - 0x1p-24;  // the rest goes to rounding to float32
    const double fewest = std::ceil(std::log(2.0) / std::log((1 + left) / (1 - left)));
    EXPECT_NEAR(scale.per_octave(), fewest, 1) << bound;
    EXPECT_NEAR(scale.per_octave() * std::log2(scale.ratio()), 1, 1e-9) << bound;
    EXPECT_EQ(scale.steps_per_octave(), scale.per_octave());
    EXPECT_EQ(scale.bound(), bound);
    EXPECT_FALSE(scale.lossless());
  }
  EXPECT_EQ(Quantizer(0.5).per_octave(), 1U);
  EXPECT_EQ(Quantizer(0.001).per_octave(), 347U);
  EXPECT_EQ(Quantizer(0.01).per_octave(), 35U);
}

TEST(BoundedScale, BeginsAtTheSmallestMagnitude) {
  for (const double bound : kBounds) {
    for (const float smallest : {kLeast, 1e-30F, 0.37F, 1.0F, 1e30F}) {
      Quantizer scale(bound);
      const std::array values = {0.0F, 4 * smallest, -smallest, 2 * smallest, -0.0F};
      scale.begin_at_smallest({values});
      EXPECT_EQ(scale.step(smallest), 1);
      EXPECT_EQ(scale.step(-smallest), -1);
      EXPECT_EQ(scale.step(4 * smallest), 1 + 2 * static_cast<std::int32_t>(scale.per_octave()));
      EXPECT_NEAR(scale.value(1), smallest, bound * static_cast<double>(smallest));
      // A second time changes nothing.
      const std::int32_t lowest = scale.lowest();
      scale.begin_at_smallest({values});
      EXPECT_EQ(scale.lowest(), lowest);
    }
  }
}

TEST(BoundedScale, MayBeginAtNothing) {
  Quantizer scale(0.01);
  scale.begin_at_smallest({std::array{0.0F, -0.0F}});
  EXPECT_EQ(scale.step(0.0F), 0);
  scale.begin_at_smallest({});
  EXPECT_EQ(scale.step(0.0F), 0);
}

TEST(BoundedScale, IsTheSameWhenMadeFromWhatAFileHolds) {
  for (const double bound : kBounds) {
    const Quantizer made = scale_from_least(bound);
    const Quantizer read(bound_of(millionths_of(made.bound())), made.lowest());
    EXPECT_EQ(read.bound(), made.bound());
    for (const float v : magnitudes(2000)) {
      const std::int32_t step = made.step(v);
      EXPECT_EQ(read.step(v), step);
      EXPECT_EQ(bits_of(read.value(step)), bits_of(made.value(step)));
    }
  }
}

TEST(BoundedScale, BeginsEveryOctaveAtAPowerOfTwo) {
  // Step counts for which the reciprocal alone would be off by one.
  for (const auto& [bound, per_octave] : {std::pair{0.5, 1}, {0.007073, 49}, {0.001, 347}, {0.0001, 3468}}) {
    const Quantizer scale(bound, -100 * per_octave);
    ASSERT_EQ(scale.per_octave(), static_cast<std::uint32_t>(per_octave));
    for (int octave = -100; octave <= 100; ++octave) {
      EXPECT_EQ(scale.value((octave + 100) * per_octave + 1), std::ldexp(1.0F, octave)) << per_octave;
    }
  }
}

TEST(BoundedScale, GivesSomethingForEveryStepOfAnyScaleThatAFileMayHold) {
  constexpr std::int32_t kLargest = std::numeric_limits<std::int32_t>::max();
  for (const std::uint32_t millionths : {1U, 20'000U, 500'000U}) {
    for (const std::int32_t lowest : {-(1 << 29), 0, 1 << 29}) {
      const Quantizer scale(bound_of(millionths), lowest);
      for (const std::int32_t step : {1, 1000, kLargest}) {
        EXPECT_GE(scale.value(step), 0) << step;
        EXPECT_LE(scale.value(-step), 0) << step;
      }
    }
  }
}

TEST(MillionthsOf, GivesDecimalFractionsBackAndNeverMoreThanTheBound) {
  for (std::uint32_t k = 1; k <= 500'000; k += k < 2000 ? 1 : 997) {
    ASSERT_EQ(millionths_of(static_cast<double>(k) / 1e4 / 100), k) << "as a percentage";
    ASSERT_EQ(millionths_of(bound_of(k)), k);
    ASSERT_EQ(millionths_of(bound_of(k) * 1.0000001), k);
  }
  EXPECT_EQ(millionths_of(0.0000019), 1U);
}

TEST(LosslessScale, GivesBackEveryBit) {
  const Quantizer scale;
  EXPECT_TRUE(scale.lossless());
  EXPECT_EQ(scale.bound(), 0);
  std::vector<float> values = {std::numeric_limits<float>::denorm_min(),
                               std::numeric_limits<float>::max(),
                               std::numeric_limits<float>::min(),
                               std::nextafter(kLeast, 0.0F),
                               1.0F,
                               1e-40F};
  std::mt19937 random(11);
  while (values.size() < 50'000) {
    const auto v = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (std::isfinite(v) && v != 0) values.push_back(v);
  }
  for (const float v : values) {
    ASSERT_EQ(bits_of(scale.value(scale.step(v))), bits_of(v)) << v;
    ASSERT_EQ(bits_of(scale.value(scale.step(-v))), bits_of(-v)) << v;
  }
}

TEST(LosslessScale, HasTheBitsAsStepsWhateverTheSmallestValue) {
  Quantizer scale;
  scale.begin_at_smallest({std::array{3.0F}});
  EXPECT_TRUE(scale.lossless());
  EXPECT_EQ(scale.step(1.0F), 0x3F800000);
  EXPECT_EQ(scale.step(-1.0F), -0x3F800000);
  EXPECT_EQ(scale.step(std::numeric_limits<float>::denorm_min()), 1);
  EXPECT_EQ(scale.step(std::numeric_limits<float>::max()), 0x7F7FFFFF);
  EXPECT_EQ(scale.steps_per_octave(), std::exp2(23));
}

}  // namespace
}  // namespace sbrdf::internal
