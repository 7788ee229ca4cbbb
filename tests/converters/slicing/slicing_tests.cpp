#include "converters/slicing/slicing.h"
#include "converters/files/sliced/sliced.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "converters/judge/compare.h"
#include "converters/models/analytic.h"
#include "formats/core/parallel.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

SliceOptions coarse(std::uint64_t samples, DomainKind domain = DomainKind::kLinear) {
  SliceOptions options;
  options.structure = Placement{40, 90};
  options.stop = SampleCount{samples};
  options.domain = domain;
  return options;
}

/// With nothing to choose and nothing fitted, which takes most of the time.
SliceOptions plain(std::uint64_t samples, DomainKind domain = DomainKind::kLinear) {
  SliceOptions options = coarse(samples, domain);
  options.fit_values = false;
  options.precision = 0;
  return options;
}

/// `reciprocal` is what the source says of itself; the function is reciprocal in any case.
FunctionSource analytic(bool reciprocal = true, const Symmetries& symmetries = {}) {
  return FunctionSource(
      [symmetries](const DirectionPair& pair, std::size_t c) {
        return analytic_brdf(pair, symmetries) + static_cast<double>(c);
      },
      {.isotropic = symmetries.isotropic, .reciprocal = reciprocal});
}

Error refusal(const BrdfSource& source, const SliceOptions& options) {
  const auto result = slice_source(source, options);
  EXPECT_FALSE(result);
  return result ? Error{} : result.error();
}

TEST(SliceSource, TakesTheNumberOfSamplesAskedForAndTheNamesOfTheChannels) {
  const Slicing slicing = slice_source(analytic(), plain(400)).value();
  EXPECT_EQ(slicing.sliced.crossing_count() + slicing.sliced.adaptive_count(), 400U);
  EXPECT_EQ(slicing.sliced.channels, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_EQ(slicing.report.values, 1200U);
  EXPECT_EQ(slicing.report.zero_values, 0U);
  EXPECT_EQ(slicing.report.negative_values, 0U);
  EXPECT_EQ(slicing.report.reciprocity_difference_percent, 0);
  EXPECT_TRUE(check_sliced(slicing.sliced, slicing.lattice));
}

TEST(SliceSource, StoresAnIsotropicSourceAsSuch) {
  const Symmetries symmetries = {.isotropic = true};
  const Slicing slicing = slice_source(analytic(true, symmetries), plain(100)).value();
  EXPECT_EQ(slicing.sliced.frame.symmetries, symmetries);
  EXPECT_EQ(slicing.sliced.frame.axes[kAxial].nodes_deg.size(), 1U);
}

TEST(SliceSource, MeasuresTheMeanOfBothOrdersOfASourceThatIsNotReciprocal) {
  const auto one_sided = [](const DirectionPair& pair, std::size_t) { return 1 + pair.i.theta; };
  const auto mean = [](const DirectionPair& pair, std::size_t) { return 1 + (pair.i.theta + pair.v.theta) / 2; };
  const Slicing found = slice_source(FunctionSource(one_sided), plain(300)).value();
  const Slicing expected = slice_source(FunctionSource(mean, {.reciprocal = true}), plain(300)).value();
  ASSERT_EQ(found.sliced.crossing_values.size(), expected.sliced.crossing_values.size());
  for (std::size_t k = 0; k < found.sliced.crossing_values.size(); ++k) {
    EXPECT_NEAR(found.sliced.crossing_values[k], expected.sliced.crossing_values[k], 1e-6);
  }
  EXPECT_GT(found.report.reciprocity_difference_percent, 1);
}

TEST(SliceSource, CountsZerosAndNegativesAmongTheSamples) {
  const FunctionSource source(
      [](const DirectionPair& pair, std::size_t c) {
        if (pair.i.theta > 0 && pair.v.theta > 0) return 1.0;
        return c == 0 ? 0.0 : c == 1 ? -1.0 : 1.0;
      },
      {.reciprocal = true});
  for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
    const SliceOptions options = plain(300, domain);
    const Slicing slicing = slice_source(source, options).value();
    std::uint64_t zeros = 0;
    std::uint64_t negatives = 0;
    for (const auto* values : {&slicing.sliced.crossing_values, &slicing.sliced.sample_values}) {
      zeros += static_cast<std::uint64_t>(std::count(values->begin(), values->end(), 0.0F));
      negatives += static_cast<std::uint64_t>(std::count(values->begin(), values->end(), -1.0F));
    }
    EXPECT_GT(zeros, 0U);
    EXPECT_EQ(slicing.report.zero_values, zeros);
    EXPECT_EQ(slicing.report.negative_values, negatives);
  }
}

TEST(SliceSource, RecordsWhatItDidAsJson) {
  FunctionSource source([](const DirectionPair& pair, std::size_t) { return 1 + pair.i.theta; });
  SliceOptions options = plain(300);
  options.metadata = MetadataDetail::kFull;
  const Slicing slicing = slice_source(source, options).value();
  const auto json = nlohmann::json::parse(slicing.sliced.metadata);
  EXPECT_EQ(json["source"]["format"], "test");
  EXPECT_EQ(json["source"]["description"], "a function");
  EXPECT_EQ(json["symmetrised"], true);
  EXPECT_NEAR(json["reciprocity_residual_percent"].get<double>(), slicing.report.reciprocity_difference_percent, 0.01);
  EXPECT_EQ(json["zero_values"], 0);
  EXPECT_EQ(json["negative_values"], 0);
}

TEST(SliceSource, RefusesPlacementsAndCountsThatCannotBe) {
  EXPECT_EQ(refusal(analytic(), plain(10)).code, ErrorCode::kUsage);
  SliceOptions options = plain(10000);
  options.structure = Placement{40, 7};
  EXPECT_EQ(refusal(analytic(), options).code, ErrorCode::kUsage);
  options.structure = Placement{0, 36};
  EXPECT_EQ(refusal(analytic(), options).code, ErrorCode::kUsage);
}

TEST(SliceSource, RefusesASourceThatIsNotFiniteAndSaysWhere) {
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const FunctionSource source([value](const DirectionPair& pair, std::size_t) {
      return std::abs(pair.v.theta - 80 * kPi / 180) < 1e-9 && pair.i.theta == 0 ? value : 1.0;
    });
    const Error error = refusal(source, coarse(300));
    EXPECT_EQ(error.code, ErrorCode::kInvalidFile);
    EXPECT_THAT(error.message, HasSubstr("80.0"));
  }
}

TEST(SliceSource, RefusesASourceWithoutAPositiveValue) {
  for (const double value : {0.0, -1.0}) {
    const FunctionSource source([value](const auto&, std::size_t) { return value; });
    EXPECT_EQ(refusal(source, coarse(300)).code, ErrorCode::kInvalidFile);
  }
}

TEST(SliceSource, EndsSoonWhenAskedToStop) {
  int calls = 0;
  const auto result = slice_source(analytic(), coarse(400), {[&](double) { return ++calls < 2; }});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, interrupted_error().message);
}

TEST(AnyNumberOfThreads, GivesTheSameBytesOfASlicing) {
  std::vector<std::vector<std::byte>> files;
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const ThreadLimit control(threads);
    const Slicing slicing = slice_source(analytic(false), coarse(300, DomainKind::kLog)).value();
    files.push_back(encode_sliced(slicing.sliced, slicing.lattice));
  }
  EXPECT_EQ(files[1], files[0]);
  EXPECT_EQ(files[2], files[0]);
}

std::unique_ptr<BrdfSource> through_a_file(const Slicing& slicing) {
  return open_sliced(std::make_shared<OwnedMemorySource>(encode_sliced(slicing.sliced, slicing.lattice)), {}).value();
}

TEST(SlicedSource, ComesBackFromAFileAsItWasAndEvaluatesAlike) {
  const Slicing slicing = slice_source(analytic(), plain(600, DomainKind::kLog)).value();
  const SlicedSource direct(DecodedSliced{slicing.sliced, slicing.lattice});
  const auto loaded = through_a_file(slicing);
  EXPECT_EQ(loaded->traits().format, "sbrdf");
  EXPECT_EQ(loaded->traits().channels, slicing.sliced.channels);
  EXPECT_TRUE(loaded->traits().reciprocal);
  EXPECT_FALSE(loaded->traits().isotropic);
  std::vector<DirectionPair> pairs;
  for (int k = 0; k < 1000; ++k) pairs.push_back({{0.0014 * k, 0.1 * k}, {1.4 - 0.0013 * k, 0.37 * k}});
  std::vector<float> a(3000);
  std::vector<float> b(3000);
  direct.evaluate(pairs, a);
  loaded->evaluate(pairs, b);
  EXPECT_EQ(a, b);
}

TEST(SlicedSource, IsZeroBelowTheHorizonButNotOnItInBothFrames) {
  const double just_below = std::nextafter(kPi / 2, 2.0);
  for (const FrameId frame : {FrameId::kElevation, FrameId::kHalfDifference}) {
    SliceOptions options = plain(500, DomainKind::kLog);
    options.structure = SearchedStructure{.frame = frame, .evaluations = 5};
    const auto source = through_a_file(slice_source(analytic(), options).value());
    ASSERT_EQ(dynamic_cast<const SlicedSource&>(*source).sliced()->sliced.frame.id, frame);
    const std::array pairs = {DirectionPair{{just_below, 0}, {0.5, 1}}, DirectionPair{{0.5, 0}, {kPi / 2, 1}},
                              DirectionPair{{0.5, 0}, {just_below, 1}}, DirectionPair{{kPi / 2, 0}, {kPi / 2, 3}},
                              DirectionPair{{2, 0}, {1.6, 1}}};
    std::vector<float> values(15, -1);
    source->evaluate(pairs, values);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const bool on_horizon = k / 3 == 1 || k / 3 == 3;
      EXPECT_TRUE(on_horizon ? values[k] > 0 : values[k] == 0) << k << ": " << values[k];
    }
  }
}

TEST(OpenSliced, RefusesWhatIsNoSlicedFile) {
  EXPECT_FALSE(open_sliced(std::make_shared<OwnedMemorySource>(std::vector<std::byte>(100)), {}));
}

TEST(SliceSource, ReportsHowLargeErrorsGetOffTheGrid) {
  const auto source = make_analytic_source(kurt_material("fabric112").value());
  SliceOptions options;
  options.structure = Placement{28, 60};
  options.stop = SampleCount{1500};
  const Slicing slicing = slice_source(*source, options).value();
  const ErrorFigures& figures = slicing.report.figures;
  EXPECT_NEAR(figures.mre_percent / slicing.report.error.mre_percent, 1, 1e-6);
  EXPECT_NEAR(figures.rel_l1_percent / slicing.report.error.rel_l1_percent, 1, 1e-6);
  EXPECT_LT(figures.mre_percent, figures.relative_p999_percent);
  EXPECT_LE(figures.relative_p999_percent, figures.max_relative_percent);
  std::vector<float> f(3);
  std::vector<float> r(3);
  const ValuePlace& at = figures.max_relative_at;
  source->evaluate(std::span(&at.pair, 1), f);
  Evaluator(slicing.sliced, slicing.lattice).evaluate(at.pair, r);
  EXPECT_EQ(f[at.channel], static_cast<float>(at.reference));
  EXPECT_EQ(r[at.channel], static_cast<float>(at.test));
  EXPECT_EQ(slicing.report.false_values.count, 0U);
}

// A spike two degrees wide on a node of a coarse lattice spreads over whole cells.
TEST(SliceSource, ReportsFalseValues) {
  const FunctionSource source(
      [](const DirectionPair& pair, std::size_t) {
        const double away = std::hypot(pair.i.theta - 28 * kPi / 180, pair.v.theta - 28 * kPi / 180) * 180 / kPi;
        return 0.01 + 10 * std::exp(-0.5 * away * away);
      },
      {.reciprocal = true});
  SliceOptions options;
  options.structure = Placement{28, 180};
  options.stop = SampleCount{60};
  options.domain = DomainKind::kLinear;
  options.refinement = Refinement::kByMeasured;
  const SliceReport report = slice_source(source, options).value().report;
  EXPECT_GT(report.false_values.count, 1000U);
  EXPECT_GT(report.false_values.worst_factor, 100);
}

double mean_relative_error(const BrdfSource& reference, std::uint64_t samples, DomainKind domain) {
  SliceOptions options;
  options.structure = Placement{14, 36};
  options.refinement = Refinement::kByMeasured;
  options.stop = SampleCount{samples};
  options.domain = domain;
  const auto sliced = through_a_file(slice_source(reference, options).value());
  CompareOptions directions;
  directions.random_count = 20000;
  return compare_sources(reference, *sliced, directions).value().mre_percent;
}

// The published figure for 8,911 samples is 1.3; that of log values was found with an independent implementation.
TEST(SlicedFabric112, HasTheErrorOfThePaperAt8911Samples) {
  const auto fabric112 = make_analytic_source(kurt_material("fabric112").value());
  EXPECT_NEAR(mean_relative_error(*fabric112, 8911, DomainKind::kLinear), 1.25, 0.125);
  EXPECT_NEAR(mean_relative_error(*fabric112, 8911, DomainKind::kLog), 0.93, 0.093);
}

TEST(SlicedFabric112, GetsBetterWithMoreSamples) {
  const auto fabric112 = make_analytic_source(kurt_material("fabric112").value());
  for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
    EXPECT_LT(mean_relative_error(*fabric112, 16000, domain), mean_relative_error(*fabric112, 5000, domain));
  }
}

}  // namespace
}  // namespace sbrdf::internal
