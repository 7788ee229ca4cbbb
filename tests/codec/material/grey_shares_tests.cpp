#include "codec/material/grey_shares.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Ge;

template <class Real>
void take_off_each(const GreyShares& shares, std::span<Real> values, std::size_t channels) {
  for (std::size_t k = 0; k < values.size(); k += channels) shares.take_off(values.subspan(k, channels));
}

/// A highlight outside the gamut: red far below zero beside it and far above in it.
std::vector<float> out_of_gamut() {
  return {0.5F, 0.7F, 0.9F, -3.0F, 9.0F, 12.0F, 40.0F, 11.0F, 9.0F, -0.1F, 0.3F, 0.5F};
}

TEST(GreyShares, AddTheShareOfTheMeanOfAllChannels) {
  // Grey 4 and -2.
  std::vector<float> values = {-3, 5, 10, 0, -8, 2};
  GreyShares({1.25F, 0, 0.5F}).add(values);
  EXPECT_THAT(values, ElementsAre(2, 5, 12, -2.5F, -8, 1));
}

TEST(GreyShares, ComeOffAgain) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> value(-100, 1000);
  std::uniform_int_distribution<int> steps(0, static_cast<int>(GreyShares::kMostSteps));
  for (const std::size_t channels : {1U, 2U, 3U, 7U}) {
    std::vector<float> shares;
    for (std::size_t c = 0; c < channels; ++c) shares.push_back(static_cast<float>(steps(random)) / GreyShares::kSteps);
    shares[0] = 1;
    const GreyShares grey(shares);
    std::vector<float> values(channels * 50);
    for (float& v : values) v = value(random);
    std::vector<float> added = values;
    grey.add(added);
    EXPECT_NE(added, values);
    std::vector<double> back(added.begin(), added.end());
    take_off_each<double>(grey, back, channels);
    for (std::size_t k = 0; k < values.size(); ++k) {
      // Rounding to float of numbers up to 17 x 1000.
      EXPECT_NEAR(back[k], values[k], 0.01) << channels << " channels";
    }
  }
}

TEST(GreyShares, OfNothingKeepEveryBitOfAChannel) {
  const std::vector<float> values = {-0.0F, 1e-40F, 0.1F, 3.0F, std::numeric_limits<float>::max(), -7e-9F};
  for (const GreyShares& none : {GreyShares(), GreyShares({0, 0, 0})}) {
    EXPECT_FALSE(none.active());
    std::vector<float> same = values;
    none.add(same);
    take_off_each<float>(none, same, 3);
    for (std::size_t k = 0; k < values.size(); ++k) {
      EXPECT_EQ(same[k], values[k]);
      EXPECT_EQ(std::signbit(same[k]), std::signbit(values[k]));
    }
  }
  const GreyShares one({0, 0.5F, 0});
  EXPECT_TRUE(one.active());
  std::vector<float> pair = {0.1F, 0.7F, 1e-40F};
  one.add(pair);
  EXPECT_GT(pair[1], 0.7F);
  take_off_each<float>(one, pair, 3);
  EXPECT_EQ(pair[0], 0.1F);
  EXPECT_EQ(pair[2], 1e-40F);
}

TEST(ChooseGreyShares, LeavesNoChannelNegative) {
  std::vector<float> values = out_of_gamut();
  const GreyShares chosen = choose_grey_shares(values, 3);
  ASSERT_TRUE(chosen.active());
  EXPECT_GT(chosen.shares()[0], 0);
  EXPECT_EQ(chosen.shares()[1], 0);
  EXPECT_EQ(chosen.shares()[2], 0);
  chosen.add(values);
  EXPECT_THAT(values, Each(Ge(0.0F)));
}

TEST(ChooseGreyShares, LeavesAQuarterOfWhatIsNeededToSpareInWhole64ths) {
  // Of the second pair: grey 6, -f / g = 1/2; of the last 0.1 / 0.2333 = 3/7. 80 / 2 + 1 = 41.
  EXPECT_THAT(choose_grey_shares(out_of_gamut(), 3).shares(), ElementsAre(41.0F / 64, 0, 0));
}

TEST(ChooseGreyShares, AreNoneWhereNothingIsNegative) {
  const std::vector<float> values = {0, 0, 0, 1, 2, 3, 0, 5, 0};
  const GreyShares chosen = choose_grey_shares(values, 3);
  EXPECT_FALSE(chosen.active());
  EXPECT_TRUE(chosen.shares().empty());
}

TEST(ChooseGreyShares, PassOverPairsThatAreNoiseBesideTheMeanGrey) {
  // The mean grey is 1. Noise: a grey of 0.001, negative, and 0.
  std::vector<float> values = {4, 4, 4, -0.01F, 0.005F, 0.008F, -1, 0.3F, 0.5F, -0.5F, 0.2F, 0.3F};
  EXPECT_FALSE(choose_grey_shares(values, 3).active());
  // Just above a hundredth of it.
  values[3] = -0.004F;
  values[4] = 0.02F;
  values[5] = 0.02F;
  EXPECT_TRUE(choose_grey_shares(values, 3).active());
}

TEST(ChooseGreyShares, EndAtFour) {
  EXPECT_THAT(choose_grey_shares(std::vector<float>{-50, 51, 2}, 3).shares(), ElementsAre(4, 0, 0));
}

}  // namespace
}  // namespace sbrdf::internal
