#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include "converters/models/analytic.h"
#include "converters/slicing/slicing.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

std::unique_ptr<BrdfSource> shiny_isotropic() {
  return make_analytic_source({"shiny", {0.1, 0.05, 0.02}, {{{0.05, 0.05, 0.05}, 0.9, 0.08, 0.08, 0}}});
}

std::unique_ptr<BrdfSource> fabric() { return make_analytic_source(kurt_material("fabric112").value()); }

SliceOptions until(const StopRule& stop, const StructureRule& structure = SearchedStructure{.evaluations = 20}) {
  SliceOptions options;
  options.stop = stop;
  options.structure = structure;
  return options;
}

std::size_t file_size(const Slicing& slicing, const SliceOptions& options) {
  return encode_sliced(slicing.sliced, slicing.lattice, encoding_of(slicing, options)).size();
}

/// A slicing and all that it said of its progress.
struct Watched {
  Result<Slicing> result;
  std::vector<double> fractions;
};

Watched watch(const BrdfSource& source, const SliceOptions& options) {
  std::vector<double> fractions;
  Result<Slicing> result = slice_source(source, options, {[&](double fraction) {
                                          fractions.push_back(fraction);
                                          return true;
                                        }});
  return {std::move(result), std::move(fractions)};
}

void expect_rising_to_one(const std::vector<double>& fractions, double largest_step) {
  ASSERT_FALSE(fractions.empty());
  double before = 0;
  for (const double fraction : fractions) {
    EXPECT_GT(fraction, before);
    EXPECT_LE(fraction - before, largest_step);
    before = fraction;
  }
  EXPECT_EQ(before, 1);
}

/// The numbers in a text, in their order; those with separators are none.
std::vector<double> numbers_in(const std::string& text) {
  std::vector<double> numbers;
  const std::regex number("(^| )([0-9]+(\\.[0-9]+)?)(?=, |[ :]|$)");
  for (std::sregex_iterator found(text.begin(), text.end(), number), end; found != end; ++found) {
    numbers.push_back(std::stod((*found)[2]));
  }
  return numbers;
}

TEST(StopRule, ReachesATargetOnDirectionsThatTookNoPart) {
  const Slicing slicing = slice_source(*shiny_isotropic(), until(TargetRelL1{5})).value();
  EXPECT_LE(slicing.report.error.rel_l1_percent, 5);
  EXPECT_LT(slicing.sliced.sample_count(), 2000U);
}

// Six precisions to a tenfold: some of them would do with more bytes.
TEST(StopRule, ReachesATargetInFewerBytesWithAnOpenPrecision) {
  const SliceOptions open = until(TargetRelL1{5});
  SliceOptions fixed = open;
  fixed.precision = 0.001;
  const Slicing traded = slice_source(*shiny_isotropic(), open).value();
  EXPECT_LE(traded.report.error.rel_l1_percent, 5);
  EXPECT_GT(*traded.precision, 0.002);
  const Slicing finer = slice_source(*shiny_isotropic(), fixed).value();
  EXPECT_LT(static_cast<double>(file_size(traded, open)), 0.8 * static_cast<double>(file_size(finer, fixed)));
}

// Regular structures need 1,856 samples here.
TEST(StopRule, ReachesATargetWithAsFewSamplesAsSearchedStructuresNeed) {
  const auto source = make_analytic_source({"narrow", {0.02, 0.01, 0.01}, {{{0.3, 0.2, 0.1}, 0.9, 0.012, 0.03, 0.5}}});
  const Slicing slicing = slice_source(*source, until(TargetRelL1{3}, SearchedStructure{.evaluations = 60})).value();
  EXPECT_LE(slicing.report.error.rel_l1_percent, 3);
  EXPECT_LT(slicing.sliced.sample_count(), 600U);
}

TEST(StopRule, HasLessErrorInSoManyBytesWithAnOpenPrecision) {
  const SliceOptions open = until(MaxBytes{1500});
  SliceOptions fixed = open;
  fixed.precision = 0.001;
  const HeldBackError traded = slice_source(*shiny_isotropic(), open).value().report.error;
  const HeldBackError finer = slice_source(*shiny_isotropic(), fixed).value().report.error;
  EXPECT_LT(traded.mre_percent * traded.rel_l1_percent, 0.9 * finer.mre_percent * finer.rel_l1_percent);
}

TEST(StopRule, FillsButDoesNotPassALargestSize) {
  const SliceOptions options = until(MaxBytes{3000});
  const Slicing slicing = slice_source(*shiny_isotropic(), options).value();
  EXPECT_LE(file_size(slicing, options), 3000U);
  EXPECT_GT(file_size(slicing, options), 2500U);
}

TEST(StopRule, FillsALargestSizeWithAPlacementAndInAFrameThatNeedsMoreThanTheFewestSamples) {
  for (const StructureRule& structure :
       {StructureRule{Placement{28, 60}},
        StructureRule{SearchedStructure{.frame = FrameId::kHalfDifference, .evaluations = 10}}}) {
    SliceOptions options = until(MaxBytes{3000}, structure);
    options.fit_values = false;  // thousands of samples, some forty times
    options.precision = 0.001;
    const Slicing slicing = slice_source(*fabric(), options).value();
    EXPECT_LE(file_size(slicing, options), 3000U);
    EXPECT_GT(file_size(slicing, options), 2500U);
  }
}

TEST(StopRule, ReportsProgressAllTheWay) {
  for (const StopRule& stop :
       {StopRule{SampleCount{600}}, StopRule{TargetMre{40}}, StopRule{TargetRelL1{40}}, StopRule{MaxBytes{2000}}}) {
    for (const StructureRule& structure :
         {StructureRule{Placement{28, 180}}, StructureRule{SearchedStructure{.evaluations = 4}}}) {
      SliceOptions options = until(stop, structure);
      options.fit_values = false;
      const Watched watched = watch(*shiny_isotropic(), options);
      EXPECT_TRUE(watched.result) << watched.result.error().message;
      expect_rising_to_one(watched.fractions, 0.9);
    }
  }
}

TEST(StopRule, SaysWhichErrorWasReachedWhereATargetIsOutOfReach) {
  for (const StopRule& stop : {StopRule{TargetMre{0.001}}, StopRule{TargetRelL1{0.001}}}) {
    SliceOptions options = until(stop, Placement{28, 180});
    options.fit_values = false;
    options.minimum_gap_deg = 1;  // a million samples are not taken
    const auto source = fabric();
    const Watched watched = watch(*source, options);
    ASSERT_FALSE(watched.result);
    const Error& error = watched.result.error();
    EXPECT_EQ(error.code, ErrorCode::kDifference);
    const std::vector<double> numbers = numbers_in(error.message);  // target, error, samples, bytes
    ASSERT_EQ(numbers.size(), 4U) << error.message;
    EXPECT_EQ(numbers[0], 0.001);
    const auto samples = static_cast<std::uint64_t>(numbers[2]);
    SliceOptions again = until(SampleCount{samples}, Placement{28, 180});
    again.fit_values = false;
    again.minimum_gap_deg = options.minimum_gap_deg;
    again.precision = 0;  // the error is that of samples that are not rounded
    const Slicing slicing = slice_source(*source, again).value();
    EXPECT_EQ(slicing.sliced.sample_count(), samples);
    EXPECT_EQ(static_cast<double>(file_size(slicing, again)), numbers[3]);
    const HeldBackError& reached = slicing.report.error;  // on other directions
    const double other = std::holds_alternative<TargetMre>(stop) ? reached.mre_percent : reached.rel_l1_percent;
    EXPECT_NEAR(numbers[1], other, 0.2 * other);
    expect_rising_to_one(watched.fractions, 0.3);
  }
}

TEST(StopRule, SaysWhichErrorASearchReachedWhereATargetIsOutOfReach) {
  SliceOptions options = until(TargetMre{0.001}, SearchedStructure{.frame = FrameId::kElevation, .evaluations = 1});
  options.minimum_gap_deg = 45;
  const Watched watched = watch(*shiny_isotropic(), options);
  ASSERT_FALSE(watched.result);
  EXPECT_EQ(watched.result.error().code, ErrorCode::kDifference);
  EXPECT_EQ(numbers_in(watched.result.error().message).size(), 4U) << watched.result.error().message;
  expect_rising_to_one(watched.fractions, 0.3);
}

TEST(StopRule, SaysHowLargeTheSmallestFileIsWhereNoneIsSmallEnough) {
  for (const StructureRule& structure : {StructureRule{Placement{28, 180}}, StructureRule{Placement{14, 36}},
                                         StructureRule{SearchedStructure{.evaluations = 20}}}) {
    const auto source = fabric();
    const auto measured_until = [&](std::uint64_t bytes) {
      SliceOptions options = until(MaxBytes{bytes}, structure);
      options.fit_values = false;
      options.precision = 0.001;
      return options;
    };
    const Watched watched = watch(*source, measured_until(60));
    ASSERT_FALSE(watched.result);
    const Error& error = watched.result.error();
    EXPECT_EQ(error.code, ErrorCode::kDifference);
    const std::vector<double> numbers = numbers_in(error.message);  // limit, smallest, samples
    ASSERT_EQ(numbers.size(), 3U) << error.message;
    EXPECT_EQ(numbers[0], 60);
    expect_rising_to_one(watched.fractions, 1);
    // So large a file is possible, and no smaller one.
    const auto smallest = static_cast<std::uint64_t>(numbers[1]);
    const SliceOptions options = measured_until(smallest);
    const Result<Slicing> fitting = slice_source(*source, options);
    ASSERT_TRUE(fitting) << fitting.error().message;
    EXPECT_LE(file_size(*fitting, options), smallest);
    EXPECT_EQ(slice_source(*source, measured_until(smallest - 1)).error().code, ErrorCode::kDifference);
  }
}

TEST(StopRule, RefusesATargetWhereNoStructureCanBe) {
  for (const StopRule& stop : {StopRule{TargetMre{1}}, StopRule{MaxBytes{1000}}}) {
    const Result<Slicing> result = slice_source(*fabric(), until(stop, Placement{0, 36}));
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::kUsage);
    EXPECT_THAT(result.error().message, HasSubstr("elevation"));
  }
}

}  // namespace
}  // namespace sbrdf::internal
