#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "converters/files/sliced/sliced.h"
#include "converters/judge/compare.h"
#include "converters/models/analytic.h"
#include "converters/paper/reproduce.h"
#include "converters/slicing/slicing.h"
#include "converters/source/symmetry_detection.h"
#include "formats/core/parallel.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

std::unique_ptr<BrdfSource> shiny_isotropic() {
  return make_analytic_source({"shiny", {0.1, 0.05, 0.02}, {{{0.05, 0.05, 0.05}, 0.9, 0.08, 0.08, 0}}});
}

SliceOptions quick(std::uint64_t samples) {
  SliceOptions options;
  options.stop = SampleCount{samples};
  options.structure = SearchedStructure{.evaluations = 20};
  return options;
}

double rel_l1(const BrdfSource& reference, const Slicing& slicing) {
  CompareOptions directions;
  directions.random_count = 5000;
  const SlicedSource sliced(DecodedSliced{slicing.sliced, slicing.lattice, {}});
  return compare_sources(reference, sliced, directions).value().rel_l1_percent;
}

TEST(DetectSymmetries, FindsThoseThatASourceHas) {
  const Symmetries fabric = detect_symmetries(*make_analytic_source(kurt_material("fabric112").value()));
  EXPECT_EQ(fabric, (Symmetries{.isotropic = false, .mirror_x = true, .mirror_y = true}));
  const Symmetries shiny = detect_symmetries(*shiny_isotropic());
  EXPECT_TRUE(shiny.isotropic && shiny.mirror_x);
  const FunctionSource skewed(
      [](const DirectionPair& pair, std::size_t) {
        return 2 + std::sin(pair.i.theta) * std::sin(pair.v.theta) * std::sin(pair.i.phi + pair.v.phi);
      },
      {.reciprocal = true});
  EXPECT_EQ(detect_symmetries(skewed), Symmetries{});
}

/// A mirror that is blurred by so little, and by another angle across.
std::unique_ptr<BrdfSource> narrow_lobe(double along_deg, double across_deg) {
  const AnalyticLobe lobe = {{0.3, 0.25, 0.2},
                             0.3,
                             std::tan(radians_from_degrees(along_deg)),
                             std::tan(radians_from_degrees(across_deg)),
                             0.2};
  return make_analytic_source({"narrow", {0.1, 0.2, 0.05}, {lobe}});
}

TEST(DetectSymmetries, LooksIntoNarrowHighlights) {
  const Symmetries round = detect_symmetries(*narrow_lobe(0.05, 0.05));
  EXPECT_TRUE(round.isotropic && round.mirror_x);
  EXPECT_EQ(detect_symmetries(*narrow_lobe(0.05, 0.1)), (Symmetries{.mirror_x = true, .mirror_y = true}));
}

TEST(SliceSource, FindsAHighlightAFiftiethOfADegreeWide) {
  const auto source = narrow_lobe(0.02, 0.02);
  SliceOptions options = quick(800);
  options.structure = SearchedStructure{.evaluations = 60};
  const Slicing slicing = slice_source(*source, options).value();
  const SlicedSource sliced(DecodedSliced{slicing.sliced, slicing.lattice, {}});
  CompareOptions directions;
  directions.directions = CompareDirections::kHighlight;
  directions.random_count = 20'000;
  const Comparison report = compare_sources(*source, sliced, directions).value();
  EXPECT_LT(report.rel_l1_percent, 3);  // where it is missed, all of its light: half
  EXPECT_LT(report.mre_percent, 1);
}

TEST(TrueRefinement, IsBetterThanTheMeasuredOneAndTakesAsManySamples) {
  const auto fabric = make_analytic_source(kurt_material("fabric112").value());
  SliceOptions options;
  options.structure = Placement{28, 60};
  options.stop = SampleCount{1500};
  options.refinement = Refinement::kByMeasured;
  const Slicing measured = slice_source(*fabric, options).value();
  options.refinement = Refinement::kBySource;
  const Slicing true_error = slice_source(*fabric, options).value();
  EXPECT_EQ(measured.sliced.sample_count(), 1500U);
  EXPECT_EQ(true_error.sliced.sample_count(), 1500U);
  EXPECT_LT(rel_l1(*fabric, true_error), rel_l1(*fabric, measured));
}

TEST(SliceSource, EndsBelowTheNumberOfSamplesWhereEveryGapIsAtTheMinimum) {
  for (const Refinement refinement : {Refinement::kByMeasured, Refinement::kBySource}) {
    SliceOptions options;
    options.structure = Placement{40, 90};
    options.stop = SampleCount{5000};
    options.refinement = refinement;
    options.minimum_gap_deg = 90;
    const Slicing slicing = slice_source(*shiny_isotropic(), options).value();
    EXPECT_LT(slicing.sliced.sample_count(), 5000U);
    EXPECT_EQ(slicing.report.wanted_samples, 5000U);
  }
}

TEST(StructureSearch, BeatsTheTableOfThePaper) {
  const auto fabric = make_analytic_source(kurt_material("fabric112").value());
  SliceOptions paper;
  paper.structure = table_3_placement(400);
  paper.stop = SampleCount{400};
  EXPECT_LT(rel_l1(*fabric, slice_source(*fabric, quick(400)).value()),
            0.7 * rel_l1(*fabric, slice_source(*fabric, paper).value()));
}

TEST(StructureSearch, TriesNoMoreStartsThanAskedFor) {
  const auto source = shiny_isotropic();
  for (const auto& [evaluations, tried] : {std::pair{1, "after 1 structure tried"}, {5, "after 5 structures tried"}}) {
    SliceOptions options = quick(300);
    options.structure = SearchedStructure{.evaluations = static_cast<std::size_t>(evaluations)};
    EXPECT_THAT(slice_source(*source, options).value().report.reasons.back(), HasSubstr(tried));
  }
  SliceOptions none = quick(300);
  none.structure = SearchedStructure{.evaluations = 0};
  EXPECT_EQ(slice_source(*source, none).error().code, ErrorCode::kUsage);
}

TEST(StructureSearch, GoesByWayOfFewerSamples) {
  const auto source = make_analytic_source(
      {"lobes", {0.02, 0.1, 0.2}, {{{0.05, 0.01, 0.2}, 0.5, 0.06, 0.3, 0.4}, {{0.1, 0.1, 0.01}, 0.2, 0.4, 0.1, 0.8}}});
  const Measure measure = [&](auto pairs, auto values) {
    source->evaluate(pairs, values);
    return ok_status();
  };
  const HeldBack held_back = draw_held_back({.count = 2000}, 3, measure).value();
  SearchOptions options;
  options.symmetries = detect_symmetries(*source);
  const auto found = [&](std::uint64_t samples, std::size_t evaluations) {
    options.sampling.sample_count = samples;
    options.evaluations = evaluations;
    return search_structure(source->traits().channels, measure, held_back, options).value();
  };
  // With a single try there is none but what was found before.
  EXPECT_EQ(found(600, 1).structure.outline.lists, found(1200, 1).structure.outline.lists);
  const HeldBackError few = found(600, 20).error;
  const HeldBackError many = found(1200, 20).error;
  EXPECT_LT(many.mre_percent, few.mre_percent);
  EXPECT_LT(many.rel_l1_percent, few.rel_l1_percent);
}

TEST(StructureSearch, TakesNothingThatIsWorseByEitherErrorThanWhatFewerSamplesFound) {
  for (const char* name : {"Brushed alum", "fabric112", "Yellow satin"}) {
    const auto source = make_analytic_source(kurt_material(name).value());
    const Measure measure = [&](auto pairs, auto values) {
      source->evaluate(pairs, values);
      return ok_status();
    };
    const HeldBack held_back = draw_held_back({.count = 1000}, 3, measure).value();
    SearchOptions options;
    options.symmetries = detect_symmetries(*source);
    options.evaluations = 20;
    options.sampling.sample_count = 500;
    const SearchResult few = search_structure(source->traits().channels, measure, held_back, options).value();
    options.sampling.sample_count = 1000;
    const SearchResult many = search_structure(source->traits().channels, measure, held_back, options).value();
    const Lattice lattice = build_lattice(expand_outline(few.structure.outline)).value();
    const SlicedBrdf sampled =
        sample_slices(lattice, source->traits().channels, measure, sampling_for(few.structure, options.sampling))
            .value();
    const HeldBackError kept = judge(Evaluator(sampled, lattice), held_back);
    EXPECT_LE(many.error.mre_percent, std::max(few.error.mre_percent, kept.mre_percent)) << name;
    EXPECT_LE(many.error.rel_l1_percent, std::max(few.error.rel_l1_percent, kept.rel_l1_percent)) << name;
  }
}

TEST(StructureSearch, StopsWhenAskedToOnce) {
  const auto source = shiny_isotropic();
  int asked = 0;
  const Result<Slicing> result = slice_source(*source, quick(1200), {[&](double) { return ++asked != 1; }});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kIo);
  EXPECT_EQ(asked, 1);
}

TEST(StructureSearch, GivesTheSameBytesOnAnyNumberOfThreads) {
  const auto source = shiny_isotropic();
  std::vector<std::vector<std::byte>> files;
  for (const std::size_t threads : {1, 2}) {
    const ThreadLimit limit(threads);
    const Slicing slicing = slice_source(*source, quick(300)).value();
    files.push_back(encode_sliced(slicing.sliced, slicing.lattice));
  }
  EXPECT_EQ(files[0], files[1]);
}

TEST(StructureSearch, StaysInTheFrameAskedForAndSaysWhy) {
  const auto source = shiny_isotropic();
  for (const FrameId id : {FrameId::kElevation, FrameId::kHalfDifference}) {
    SliceOptions options = quick(300);
    options.structure = SearchedStructure{.frame = id, .evaluations = 20};
    const Slicing slicing = slice_source(*source, options).value();
    EXPECT_EQ(slicing.sliced.frame.id, id);
    ASSERT_FALSE(slicing.report.reasons.empty());
    EXPECT_THAT(slicing.report.reasons.front(), HasSubstr(std::string(geometry(id).name())));
  }
}

TEST(Guide, ComesBackFromItsFileAndIsTakenOffAndAddedAlike) {
  const auto source = shiny_isotropic();
  const FrameSpec frame =
      half_difference_frame({0, 30, 80}, {0, 40, 80}, {0}, {0, 45, 90, 135}, {.isotropic = true, .mirror_x = true});
  const Lattice lattice = build_lattice(frame).value();
  const Measure measure = [&](std::span<const DirectionPair> pairs, std::span<float> values) {
    source->evaluate(pairs, values);
    return ok_status();
  };
  for (const int guided : {0, 1}) {
    SamplingOptions options;
    options.sample_count = 160;
    options.refinement = Refinement::kBySource;
    options.domain = DomainKind::kLog;
    options.minimum_gap_deg = 0.1;
    if (guided == 1) options.guide_ratio = 1;
    const SlicedBrdf sliced = sample_slices(lattice, {"R", "G", "B"}, measure, options).value();
    EXPECT_EQ(sliced.guide.has_value(), guided == 1);
    EXPECT_EQ(sliced.sample_count(), 160U);
    const DecodedSliced decoded = decode_sliced(encode_sliced(sliced, lattice)).value();
    EXPECT_EQ(decoded.sliced.guide, sliced.guide);
    EXPECT_LT(rel_l1(*source, Slicing{decoded.sliced, decoded.lattice, {}}), 4);
    const Evaluator rounded(decoded.sliced, decoded.lattice);
    const BasicEvaluator<long double> exact(decoded.sliced, decoded.lattice);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> theta(0, 1.39);
    std::uniform_real_distribution<double> phi(0, 6.28);
    for (int k = 0; k < 200; ++k) {
      const DirectionPair pair = {{theta(random), phi(random)}, {theta(random), phi(random)}};
      std::array<float, 3> a{};
      std::array<long double, 3> b{};
      rounded.evaluate(pair, a);
      exact.evaluate(pair, b);
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(a[c], static_cast<double>(b[c]), 2e-5 * std::abs(static_cast<double>(b[c])));
    }
  }
}

TEST(Table3, GivesThePlacementOfEachNumberOfSamples) {
  EXPECT_EQ(table_3_placement(55), (Placement{28, 180}));
  EXPECT_EQ(table_3_placement(667), (Placement{28, 180}));
  EXPECT_EQ(table_3_placement(668), (Placement{20, 180}));
  EXPECT_EQ(table_3_placement(8911), (Placement{14, 36}));
  EXPECT_EQ(table_3_placement(18721), (Placement{10, 36}));
  EXPECT_EQ(table_3_placement(184'655), (Placement{6, 20}));
  EXPECT_EQ(table_3_placement(184'656), (Placement{6, 12}));
}

TEST(ReproduceAccuracy, JudgesSamplesThatAreNotRounded) {
  AccuracyOptions options;
  options.materials = {"red-velvet"};
  options.methods = {PaperMethod::kProposed};
  options.random_count = 2000;
  options.slices.domain = DomainKind::kLinear;
  options.slices.refinement = Refinement::kByMeasured;
  const std::vector<AccuracyRow> rows = reproduce_accuracy(options).value();
  ASSERT_EQ(rows.size(), 2);
  EXPECT_EQ(rows[0].structure, "14/36");
  const auto source = make_analytic_source(kurt_material("Red velvet").value());
  const auto mre = [&](double precision) {
    SliceOptions slices = options.slices;
    slices.structure = table_3_placement(8911);
    slices.stop = SampleCount{8911};
    slices.precision = precision;
    Slicing slicing = slice_source(*source, slices).value();
    CompareOptions directions;
    directions.random_count = options.random_count;
    const SlicedSource sliced(DecodedSliced{std::move(slicing.sliced), std::move(slicing.lattice), {}});
    return compare_sources(*source, sliced, directions).value().mre_percent;
  };
  EXPECT_EQ(rows[0].mre_percent, mre(0));
  EXPECT_NE(rows[0].mre_percent, mre(0.001));
}

TEST(ReproduceAccuracy, RefusesAMaterialThatIsNoneOfTheTen) {
  AccuracyOptions options;
  options.materials = {"wood01", "wood02"};
  EXPECT_EQ(reproduce_accuracy(options).error().code, ErrorCode::kUsage);
}

TEST(ReproducePlacement, FindsThePlacementOfTheTableForFewSamples) {
  PlacementOptions options;
  options.counts = {600};
  options.random_count = 300;
  options.slices.refinement = Refinement::kByMeasured;
  const PlacementStudy study = reproduce_placement(options).value();
  EXPECT_EQ(placement_text(table_3_placements()[study.rows[0].best]), "28/180");
  for (const double increase : study.increase) EXPECT_GE(increase, 1);
}

}  // namespace
}  // namespace sbrdf::internal
