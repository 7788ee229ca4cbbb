#include "converters/source/progress.h"

#include <vector>

#include <gtest/gtest.h>

namespace sbrdf {
namespace {

TEST(ProgressCounter, ReportsRarelyAndEndsAtOne) {
  std::vector<double> fractions;
  ProgressCounter counter({[&](double fraction) {
                            fractions.push_back(fraction);
                            return true;
                          }},
                          100000);
  for (int n = 0; n < 100000; ++n) EXPECT_TRUE(counter.advance());
  EXPECT_GE(fractions.size(), 100u);
  EXPECT_LE(fractions.size(), 257u);
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST(ProgressCounter, ReportsTheEndOnceWhereThereWasMoreToDo) {
  std::vector<double> fractions;
  ProgressCounter counter({[&](double fraction) {
                            fractions.push_back(fraction);
                            return true;
                          }},
                          2);
  for (int n = 0; n < 5; ++n) counter.advance();
  EXPECT_EQ(fractions, (std::vector<double>{0.5, 1.0}));
}

TEST(ProgressCounter, StaysStoppedAfterTheFirstRefusal) {
  int reports = 0;
  ProgressCounter counter({[&](double) { return ++reports > 1; }}, 4);
  EXPECT_FALSE(counter.advance());
  EXPECT_FALSE(counter.advance());
  EXPECT_TRUE(counter.stopped());
  EXPECT_EQ(reports, 1);
}

TEST(ProgressCounter, NeverStopsWithoutAReport) {
  ProgressCounter counter({}, 1);
  EXPECT_TRUE(counter.advance(3));
  EXPECT_FALSE(counter.stopped());
}

}  // namespace
}  // namespace sbrdf
