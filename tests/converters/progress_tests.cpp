#include "converters/source/progress.h"

#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
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

/// Rising fractions, all of which `progress` would pass on.
struct Recorder {
  std::vector<double> fractions;
  Progress progress = {[this](double fraction) {
    fractions.push_back(fraction);
    return true;
  }};
};

TEST(StepwiseProgress, GivesEachStepItsShareOfWhatIsLeftAndEndsAtOne) {
  Recorder recorder;
  StepwiseProgress steps(recorder.progress);
  const Progress first = steps.step(0.5);
  first.report(0.5);
  first.report(1);
  steps.step(0.5).report(1);
  EXPECT_TRUE(steps.finish());
  EXPECT_EQ(recorder.fractions, (std::vector<double>{0.25, 0.5, 0.75, 1}));
}

TEST(StepwiseProgress, NeverGoesBackNorRepeatsItself) {
  Recorder recorder;
  StepwiseProgress steps(recorder.progress);
  const Progress step = steps.step(0.5);
  for (const double fraction : {0.5, 0.5, 0.25, 1.0}) EXPECT_TRUE(step.report(fraction));
  steps.step(0).report(1);
  steps.finish();
  steps.finish();
  EXPECT_EQ(recorder.fractions, (std::vector<double>{0.25, 0.5, 1}));
}

TEST(StepwiseProgress, StaysStoppedAfterTheFirstRefusal) {
  int asked = 0;
  StepwiseProgress steps({[&](double) { return ++asked > 1; }});
  EXPECT_FALSE(steps.step(0.5).report(0.5));
  EXPECT_FALSE(steps.step(0.5).report(0.5));
  EXPECT_FALSE(steps.finish());
  EXPECT_EQ(asked, 1);
}

TEST(StepwiseProgress, ReportsNothingToNobody) {
  StepwiseProgress steps({});
  EXPECT_FALSE(steps.step(0.5).report);
  EXPECT_TRUE(steps.finish());
}

}  // namespace
}  // namespace sbrdf::internal
