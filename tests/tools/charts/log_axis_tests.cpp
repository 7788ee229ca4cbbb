#include "tools/charts/log_axis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;

std::vector<std::string> labels_of(const LogAxis& axis) {
  std::vector<std::string> labels;
  for (const Tick& tick : axis.ticks()) {
    if (!tick.label.empty()) labels.push_back(tick.label);
  }
  return labels;
}

TEST(LogAxis, EndsAtOneTwoOrFiveTimesAPowerOfTenWithRoomToSpare) {
  for (const double least : {1e-9, 0.0019, 0.002, 0.0021, 0.77, 1.0, 3.0, 99.0, 350'000.0, 6.02e23}) {
    for (const double factor : {1.0, 1.5, 7.0, 1e4, 1e12}) {
      const LogAxis axis = LogAxis::around(least, least * factor, Numerals::kPlain);
      EXPECT_LE(axis.low() * 1.07, least);
      EXPECT_GE(axis.high(), least * factor * 1.07);
      EXPECT_GE(axis.high() / axis.low(), 3.999);
      for (const double end : {axis.low(), axis.high()}) {
        const double digit = end / std::pow(10, std::floor(std::log10(end) + 1e-9));
        EXPECT_LT(std::min({std::abs(digit - 1), std::abs(digit - 2), std::abs(digit - 5)}), 1e-9) << end;
      }
      EXPECT_GE(axis.ticks().size(), 3U);
    }
  }
}

TEST(LogAxis, LabelsFewerNumbersTheFartherItGoes) {
  EXPECT_THAT(labels_of(LogAxis::around(22, 90, Numerals::kPlain)),
              ElementsAre("20", "30", "40", "50", "60", "70", "80", "90", "100"));
  EXPECT_THAT(labels_of(LogAxis::around(0.06, 4, Numerals::kPlain)),
              ElementsAre("0.05", "0.1", "0.2", "0.5", "1", "2", "5"));
  EXPECT_THAT(labels_of(LogAxis::around(1.1, 400'000, Numerals::kPlain)),
              ElementsAre("1", "10", "100", "1,000", "10,000", "100,000"));
  EXPECT_THAT(labels_of(LogAxis::around(800, 30e6, Numerals::kBytes)),
              ElementsAre("1 kB", "10 kB", "100 kB", "1 MB", "10 MB"));
}

TEST(LogAxis, PlacesByTheLogarithmAndHoldsWhatIsBeyond) {
  const LogAxis axis = LogAxis::around(1.1, 90, Numerals::kPlain);
  EXPECT_DOUBLE_EQ(axis.low(), 1);
  EXPECT_DOUBLE_EQ(axis.high(), 100);
  EXPECT_DOUBLE_EQ(axis.place(10), 0.5);
  EXPECT_EQ(axis.place(0), 0);
  EXPECT_EQ(axis.place(-3), 0);
  EXPECT_EQ(axis.place(1e9), 1);
  EXPECT_EQ(axis.place(std::numeric_limits<double>::quiet_NaN()), 0);
}

TEST(Numeral, IsShort) {
  EXPECT_EQ(numeral(0.001, Numerals::kPlain), "0.001");
  EXPECT_EQ(numeral(18'721, Numerals::kPlain), "18,721");
  EXPECT_EQ(numeral(999, Numerals::kBytes), "999 B");
  EXPECT_EQ(numeral(999.9, Numerals::kBytes), "1 kB");
  EXPECT_EQ(numeral(34'992'012, Numerals::kBytes), "35 MB");
}

}  // namespace
}  // namespace sbrdf::internal
