// Atlases of small materials against the evaluator of the same slices, and what holds of every atlas.
#include "codec/atlas/atlas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/atlas/atlas_evaluator.h"
#include "codec/atlas/bake.h"
#include "codec/atlas/texel_range.h"
#include "codec/evaluation/evaluator.h"
#include "codec/material/value_map.h"
#include "formats/core/parallel.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/literal_evaluator.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

using Rgb = std::array<float, 3>;

struct Example {
  std::string name;
  SampledBrdf sampled;
};

TestFunction analytic(const Symmetries& symmetries) {
  return [symmetries](const DirectionPair& pair, std::size_t channel) {
    return std::pow(analytic_brdf(pair, symmetries), 1.0 + 0.5 * static_cast<double>(channel));
  };
}

/// As above, but the first channel is below zero where the others are large.
double out_of_gamut(const DirectionPair& pair, std::size_t channel) {
  const double f = analytic_brdf(pair, {});
  return channel == 0 ? 0.4 - 0.2 * f : f * (1 + static_cast<double>(channel));
}

std::vector<FrameSpec> elevation_frames() {
  return {
      elevation_frame(40, 180, {}).value(),
      elevation_frame(28, 90, {}, 70).value(),
      elevation_frame(28, 90, {.isotropic = true}).value(),
      elevation_frame(28, 90, {.isotropic = true, .mirror_x = true}).value(),
      elevation_frame(30, 60, {.isotropic = true, .mirror_y = true}, 90).value(),
      elevation_frame(40, 360, {.isotropic = true, .mirror_x = true, .mirror_y = true}).value(),
      elevation_frame(40, 180, {.mirror_x = true}).value(),
      elevation_frame(40, 180, {.mirror_x = true, .mirror_y = true}).value(),
      elevation_frame_from_nodes({0, 15, 80}, {0, 50, 200}, {0, 30, 330}, {}),
  };
}

std::vector<FrameSpec> half_difference_frames() {
  return {
      half_difference_frame({0, 15, 40}, {0, 20, 40}, {0, 90, 180, 270}, {0, 60, 120}, {}),
      half_difference_frame({0, 10, 40}, {0, 40}, {0, 180}, {0, 90}, {.mirror_x = true}),
      half_difference_frame({0, 20, 90}, {0, 40, 90}, {0, 90, 180, 270}, {0, 90}, {.mirror_x = true, .mirror_y = true},
                            90),
      half_difference_frame({0, 5, 40}, {0, 15, 40}, {0}, {0, 50, 90, 130}, {.isotropic = true, .mirror_x = true}),
      half_difference_frame({0, 30, 50}, {0, 30}, {0}, {0, 70}, {.isotropic = true}),
      half_difference_frame({0, 30, 50}, {0, 30}, {0}, {0}, {.isotropic = true, .mirror_x = true}),
  };
}

std::vector<FrameSpec> all_frames() {
  std::vector<FrameSpec> frames = elevation_frames();
  for (FrameSpec& frame : half_difference_frames()) frames.push_back(std::move(frame));
  return frames;
}

std::string name_of_frame(const FrameSpec& spec) {
  std::string name(geometry(spec.id).name());
  for (const Axis& axis : spec.axes) name += " " + testing::PrintToString(axis.nodes_deg);
  return name + (spec.symmetries.isotropic ? " isotropic" : "") + (spec.symmetries.mirror_x ? " mirror_x" : "") +
         (spec.symmetries.mirror_y ? " mirror_y" : "");
}

Example with_options(const std::string& name, const FrameSpec& spec, SamplingOptions options,
                     const TestFunction& function) {
  Example example = {name + ", " + name_of_frame(spec), {}};
  SampledBrdf& made = example.sampled;
  made.lattice = build_lattice(spec).value();
  options.sample_count = made.lattice.crossings.size() + 400;
  made.sliced = sample_slices(made.lattice, channel_names(3), measure_of(function, 3), options).value();
  return example;
}

std::vector<Example> with_guides_and_shares() {
  std::vector<Example> examples;
  SamplingOptions options;
  options.domain = DomainKind::kLog;
  options.refinement = Refinement::kBySource;
  for (const double ratio : {1.0, 2.5}) {
    options.guide_ratio = ratio;
    const FrameSpec spec = ratio == 1 ? half_difference_frames()[3] : half_difference_frames()[2];
    examples.push_back(
        with_options("guide of ratio " + std::to_string(ratio), spec, options, analytic(spec.symmetries)));
  }
  options.guide_ratio = {};
  options.grey_shares = GreyShares({41.0F / 64, 0, 0.5F});
  for (const FrameSpec& spec : {elevation_frames()[1], half_difference_frames()[0]}) {
    for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
      options.domain = domain;
      examples.push_back(with_options("grey shares", spec, options, out_of_gamut));
    }
  }
  return examples;
}

/// All frames in both domains with three channels, one with a single channel, guides and grey shares.
const std::vector<Example>& examples() {
  static const std::vector<Example> kMade = [] {
    std::vector<Example> made;
    for (const FrameSpec& spec : all_frames()) {
      for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
        made.push_back({(domain == DomainKind::kLog ? "log, " : "linear, ") + name_of_frame(spec),
                        sample_function(spec, 400, domain, analytic(spec.symmetries), 3)});
      }
    }
    const FrameSpec one = elevation_frame(40, 180, {}).value();
    made.push_back({"one channel", sample_function(one, 200, DomainKind::kLog, analytic(one.symmetries), 1)});
    for (Example& example : with_guides_and_shares()) made.push_back(std::move(example));
    return made;
  }();
  return kMade;
}

Atlas bake(const SampledBrdf& sampled, const BakeOptions& options = {}) {
  Result<Atlas> baked = bake_atlas(sampled.sliced, sampled.lattice, options);
  if (!baked) throw std::runtime_error(baked.error().message);
  return *std::move(baked);
}

Rgb values_of(const AtlasEvaluator& evaluator, const DirectionPair& pair) {
  Rgb values{};
  evaluator.evaluate(pair, values);
  return values;
}

Rgb values_at(const AtlasEvaluator& evaluator, const Coordinates& x) {
  Rgb values{};
  evaluator.evaluate_at(x, values);
  return values;
}

DirectionPair random_pair(std::mt19937_64& random, double theta_max = 90) {
  std::uniform_real_distribution<double> theta(0, theta_max);
  std::uniform_real_distribution<double> phi(0, 360);
  return {direction_from_degrees(theta(random), phi(random)), direction_from_degrees(theta(random), phi(random))};
}

/// What a difference is measured by: the largest channel, grey shares included.
double size_of(const Rgb& values) {
  return std::max({std::abs(double{values[0]}), std::abs(double{values[1]}), std::abs(double{values[2]})});
}

double difference(const Rgb& a, const Rgb& b) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(double{a[c]} - double{b[c]}));
  return most;
}

/// The slow evaluator finds lines by their directions, of which the half/difference frame has none below the horizon.
bool within_reach_of_literal(const FrameSpec& spec) {
  return spec.id == FrameId::kElevation ||
         spec.axes[kHorizontal].nodes_deg.back() + spec.axes[kVertical].nodes_deg.back() <= 80;
}

/// Pairs, and what the slices give there without grey shares taken off; only those where no channel is a bound of the
/// slices of its cell, which an atlas does not know.
struct Expected {
  std::vector<DirectionPair> pairs;
  std::vector<Rgb> values;
};

Expected unbounded_values(const SampledBrdf& sampled) {
  constexpr int kPairs = 120;
  const auto& [lattice, sliced] = sampled;
  const std::size_t channels = sliced.channel_count();
  LiteralEvaluator literal(sliced, lattice);
  std::mt19937_64 random(3);
  Expected expected;
  for (int k = 0; k < kPairs; ++k) {
    const DirectionPair pair = random_pair(random);
    Rgb values{};
    bool bounded = false;
    for (std::size_t c = 0; c < channels; ++c) {
      const auto [value, clamped] = literal(plain_coordinates(pair, lattice.spec.id), c);
      values[c] = static_cast<float>(value);
      bounded = bounded || clamped != 0;
    }
    if (bounded) continue;
    sliced.grey_shares.take_off(std::span(values).first(channels));
    if (channels == 1) values[1] = values[2] = values[0];
    expected.pairs.push_back(pair);
    expected.values.push_back(values);
  }
  return expected;
}

struct Errors {
  double mean = 0;
  double largest = 0;
};

/// Relative to the largest channel.
Errors errors_of(const Atlas& atlas, const Expected& expected) {
  const AtlasEvaluator evaluator(atlas);
  Errors errors;
  for (std::size_t k = 0; k < expected.pairs.size(); ++k) {
    const Rgb& values = expected.values[k];
    const double error = difference(values_of(evaluator, expected.pairs[k]), values) / size_of(values);
    errors.mean += error / static_cast<double>(expected.pairs.size());
    errors.largest = std::max(errors.largest, error);
  }
  return errors;
}

// The oracle is the evaluator that reads the equations literally.
TEST(Atlas, IsCloseToTheSlicesAndTheCloserTheSmallerTheTolerance) {
  for (const Example& example : examples()) {
    if (!within_reach_of_literal(example.sampled.lattice.spec)) continue;
    const Expected expected = unbounded_values(example.sampled);
    EXPECT_GT(expected.pairs.size(), 30U) << example.name;
    Errors before;
    for (const double tolerance : {0.05, 0.005, 0.0005}) {
      const Errors errors = errors_of(bake(example.sampled, {.tolerance = tolerance}), expected);
      EXPECT_LE(errors.mean, 2 * tolerance) << example.name;
      EXPECT_LE(errors.largest, 8 * tolerance) << example.name;
      if (before.mean > 0.001) {
        EXPECT_LE(errors.mean, 0.7 * before.mean) << example.name << " " << tolerance;
      }
      before = errors;
    }
  }
}

// Between slices it is interpolated like everything else, where the evaluator knows it: its error does not fall with
// the tolerance, but with the number of nodes of phi_h, of which there are four here.
TEST(Atlas, KnowsAGuideThatIsAnEllipseOnSlicesOnly) {
  const FrameSpec spec = half_difference_frame({0, 20, 90}, {0, 40, 90}, {0, 90, 180, 270}, {0, 90},
                                               {.mirror_x = true, .mirror_y = true}, 90);
  SamplingOptions options;
  options.domain = DomainKind::kLog;
  options.refinement = Refinement::kBySource;
  options.guide_ratio = 2.5;
  const Example example = with_options("ellipse", spec, options, analytic(spec.symmetries));
  const Evaluator slices(example.sampled.sliced, example.sampled.lattice);
  std::mt19937_64 random(3);
  Expected anywhere;
  Expected on_slices;
  for (int k = 0; k < 500; ++k) {
    Coordinates x = geometry(spec.id).coordinates(random_pair(random));
    anywhere.pairs.push_back(directions_at(spec, x));
    x = {90 * static_cast<double>(k % 4), 90 * static_cast<double>(k / 4 % 2), 40, 20};
    std::uniform_real_distribution<double> place(0, k % 5 < 2 ? 180 : 40);
    x[static_cast<std::size_t>(k % 5 % 4)] = place(random);
    on_slices.pairs.push_back(directions_at(spec, x));
  }
  for (Expected* expected : {&anywhere, &on_slices}) {
    for (const DirectionPair& pair : expected->pairs) slices.evaluate(pair, expected->values.emplace_back());
  }
  const Atlas atlas = bake(example.sampled, {.tolerance = 0.0005});
  EXPECT_LE(errors_of(atlas, on_slices).mean, 0.001);
  EXPECT_LE(errors_of(atlas, anywhere).mean, 0.03);
}

TEST(Atlas, IsReciprocalToTheLastBit) {
  for (const Example& example : examples()) {
    const Atlas atlas = bake(example.sampled);
    const AtlasEvaluator evaluator(atlas);
    std::mt19937_64 random(4);
    for (int k = 0; k < 1000; ++k) {
      const DirectionPair pair = random_pair(random);
      ASSERT_EQ(values_of(evaluator, pair), values_of(evaluator, {pair.v, pair.i})) << example.name;
    }
  }
}

TEST(Atlas, IsZeroBelowTheHorizonAndFiniteEverywhereElse) {
  const double below = 90.001;
  for (const Example& example : examples()) {
    const Atlas atlas = bake(example.sampled, {.tolerance = 0.02});
    const AtlasEvaluator evaluator(atlas);
    std::mt19937_64 random(5);
    for (int k = 0; k < 100; ++k) {
      const DirectionPair pair = random_pair(random);
      const Direction low = direction_from_degrees(below + k % 90, pair.i.phi);
      EXPECT_EQ(values_of(evaluator, {low, pair.v}), Rgb{}) << example.name;
      EXPECT_EQ(values_of(evaluator, {pair.i, low}), Rgb{}) << example.name;
      EXPECT_EQ(values_of(evaluator, {low, low}), Rgb{}) << example.name;
    }
    EXPECT_EQ(values_of(evaluator, {{std::nan(""), 0}, {0.1, 0}}), Rgb{});
    for (const double theta_i : {0.0, 1e-300, 1e-9, 0.5, kPi / 2}) {
      for (const double theta_v : {0.0, 1e-300, 1e-9, 0.5, kPi / 2}) {
        for (const double phi : {-1e-300, 0.0, kPi, 2 * kPi, 100.0}) {
          for (const float f : values_of(evaluator, {{theta_i, 0.2}, {theta_v, phi}})) {
            EXPECT_TRUE(std::isfinite(f)) << example.name << " " << theta_i << " " << theta_v << " " << phi;
          }
        }
      }
    }
  }
}

TEST(Atlas, GivesBackTheValuesOfCrossings) {
  for (const Example& example : examples()) {
    const auto& [lattice, sliced] = example.sampled;
    const Atlas atlas = bake(example.sampled, {.tolerance = 0.05});
    const AtlasEvaluator evaluator(atlas);
    const std::size_t channels = sliced.channel_count();
    std::size_t met = 0;
    for (std::size_t k = 0; k < lattice.crossings.size(); ++k) {
      const Coordinates& x = lattice.crossings[k];
      // Seen from the pole, crossings of uneven lists lie between the nodes of s.
      bool at_nodes = true;
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const auto& nodes = lattice.nodes[axis];
        at_nodes = at_nodes && std::find(nodes.begin(), nodes.end(), x[axis]) != nodes.end();
      }
      if (!at_nodes) continue;
      ++met;
      // Rings have texels of their own, at equal distances.
      bool on_ring = false;
      for (const AtlasPole& pole : poles(atlas.layout)) on_ring = on_ring || x[pole.polar_axis] == 0;
      const Rgb values = values_at(evaluator, x);
      Rgb expected{};
      std::copy_n(sliced.crossing_values.begin() + static_cast<std::ptrdiff_t>(k * channels), channels,
                  expected.begin());
      sliced.grey_shares.take_off(std::span(expected).first(channels));
      if (channels == 1) expected[1] = expected[2] = expected[0];
      ASSERT_LE(difference(values, expected), (on_ring ? 0.15 : 1e-5) * size_of(expected))
          << example.name << " at " << testing::PrintToString(x);
    }
    EXPECT_GT(2 * met, lattice.crossings.size()) << example.name;
  }
}

/// Two pairs whose coordinates lie on both sides of a node of an axis, or of where theta_i = theta_v.
std::vector<std::pair<DirectionPair, DirectionPair>> pairs_across(const Lattice& lattice, double step_deg) {
  const FrameSpec& spec = lattice.spec;
  std::mt19937_64 random(6);
  std::vector<std::pair<DirectionPair, DirectionPair>> pairs;
  const auto drawn = [&](std::size_t axis) {
    return std::uniform_real_distribution<double>(0, lattice.nodes[axis].back())(random);
  };
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    for (const double node : lattice.nodes[axis]) {
      for (int k = 0; k < 60; ++k) {
        Coordinates x;
        for (std::size_t other = 0; other < kAxisCount; ++other) x[other] = drawn(other);
        if (spec.id == FrameId::kElevation && x[kVertical] > x[kHorizontal]) std::swap(x[kVertical], x[kHorizontal]);
        Coordinates y = x;
        x[axis] = std::max(node - step_deg, axis >= kHorizontal ? 0 : -step_deg);
        y[axis] = node + step_deg;
        pairs.emplace_back(directions_at(spec, x), directions_at(spec, y));
      }
    }
  }
  for (int k = 0; k < 300; ++k) {
    DirectionPair pair = random_pair(random);
    pair.v.theta = pair.i.theta;
    DirectionPair other = pair;
    pair.v.theta -= radians_from_degrees(step_deg);
    other.i.theta -= radians_from_degrees(step_deg);
    pairs.emplace_back(pair, other);
  }
  return pairs;
}

TEST(Atlas, IsContinuousAcrossCellsAndWhereBothElevationsAreTheSame) {
  // So small that the root of theta_h beside its first node, the steepest place, makes no step.
  constexpr double kStep = 1e-10;
  for (const Example& example : examples()) {
    for (const bool blocks : {false, true}) {
      const Atlas atlas = bake(example.sampled, {.tolerance = 0.02, .blocks = blocks});
      const AtlasEvaluator evaluator(atlas);
      for (const auto& [before, after] : pairs_across(example.sampled.lattice, kStep)) {
        if (!above_horizon(before) || !above_horizon(after)) continue;
        const Rgb a = values_of(evaluator, before);
        const Rgb b = values_of(evaluator, after);
        ASSERT_LE(difference(a, b), 1e-4 * size_of(a))
            << example.name << " at " << testing::PrintToString(geometry(atlas.layout.frame).coordinates(before))
            << " and " << testing::PrintToString(geometry(atlas.layout.frame).coordinates(after));
      }
    }
  }
}

TEST(Atlas, HasOneValueForEachDirectionAtThePoles) {
  for (const Example& example : examples()) {
    const Atlas atlas = bake(example.sampled);
    const AtlasEvaluator evaluator(atlas);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> phi(0, 2 * kPi);
    for (int k = 0; k < 200; ++k) {
      const Direction v = random_pair(random).v;
      // Whatever azimuth the normal is said to have.
      const Rgb a = values_of(evaluator, {{0, phi(random)}, v});
      const Rgb b = values_of(evaluator, {{1e-13, phi(random)}, v});
      ASSERT_LE(difference(a, b), 1e-4 * size_of(a)) << example.name << " theta_v " << v.theta << " phi " << v.phi;
      // Near the mirror direction half vectors have any azimuth.
      const Direction mirror = {v.theta, v.phi + kPi};
      const Rgb c = values_of(evaluator, {v, {mirror.theta + 1e-12, mirror.phi}});
      const Rgb d = values_of(evaluator, {v, {mirror.theta, mirror.phi + 1e-12}});
      ASSERT_LE(difference(c, d), 1e-4 * size_of(c)) << example.name << " theta " << v.theta << " phi " << v.phi;
    }
  }
}

TEST(Atlas, HasTheSymmetriesOfItsMaterial) {
  for (const Example& example : examples()) {
    const Symmetries& symmetries = example.sampled.lattice.spec.symmetries;
    const Atlas atlas = bake(example.sampled);
    const AtlasEvaluator evaluator(atlas);
    std::mt19937_64 random(8);
    const auto expect_same = [&](const Rgb& values, const DirectionPair& image) {
      ASSERT_LE(difference(values, values_of(evaluator, image)), 1e-4 * size_of(values)) << example.name;
    };
    for (int k = 0; k < 200; ++k) {
      const DirectionPair p = random_pair(random);
      const Rgb values = values_of(evaluator, p);
      if (symmetries.isotropic) expect_same(values, {{p.i.theta, p.i.phi + 1}, {p.v.theta, p.v.phi + 1}});
      if (symmetries.mirror_x) expect_same(values, {{p.i.theta, -p.i.phi}, {p.v.theta, -p.v.phi}});
      if (symmetries.mirror_y) expect_same(values, {{p.i.theta, kPi - p.i.phi}, {p.v.theta, kPi - p.v.phi}});
    }
  }
}

TEST(Atlas, HoldsAMaterialThatIsTheSameEverywhere) {
  const TestFunction constant = [](const auto&, std::size_t channel) {
    return 0.25 * static_cast<double>(1 + channel);
  };
  for (const FrameSpec& spec : all_frames()) {
    for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
      const Atlas atlas = bake(sample_function(spec, 0, domain, constant, 3));
      const AtlasEvaluator evaluator(atlas);
      std::mt19937_64 random(9);
      for (int k = 0; k < 50; ++k) {
        EXPECT_THAT(values_of(evaluator, random_pair(random)),
                    testing::ElementsAre(testing::FloatEq(0.25F), testing::FloatEq(0.5F), testing::FloatEq(0.75F)));
      }
      for (const AtlasAxis& axis : atlas.layout.axes) {
        if (axis.moves()) {
          EXPECT_EQ(axis.texels.back() + 1, axis.nodes_deg.size()) << "a texel for each node will do";
        }
      }
    }
  }
}

TEST(Atlas, KeepsValuesBetweenTheBoundsOfItsSlices) {
  std::mt19937_64 random(10);
  std::uniform_real_distribution<double> share(0, 1);
  // Deep valleys in a level plain and a few hills: sums of slices leave the range of the slices.
  const auto rough = [&](const auto&, std::size_t) {
    const double drawn = share(random);
    return drawn < 0.4 ? 1.0 + drawn : drawn < 0.8 ? 0.001 * drawn : 20 * drawn;
  };
  for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
    const SampledBrdf sampled = sample_function(elevation_frame(40, 180, {}).value(), 60, domain, rough, 3);
    const std::vector<ValueRange> ranges = value_ranges(sampled.sliced);
    const Atlas atlas = bake(sampled);
    const AtlasEvaluator evaluator(atlas);
    int at_bounds = 0;
    for (int k = 0; k < 2000; ++k) {
      const Rgb values = values_of(evaluator, random_pair(random));
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_GE(values[c], std::min(ranges[c].least, 0.0F));
        ASSERT_LE(values[c], atlas.domain.most[c]);
        at_bounds += values[c] == atlas.domain.least[c] || values[c] == atlas.domain.most[c] ? 1 : 0;
      }
    }
    EXPECT_GT(at_bounds, 20);
  }
}

TEST(Atlas, IsRefusedForOtherNumbersOfChannelsAndForTexturesThatAreTooSmall) {
  const FrameSpec spec = elevation_frame(40, 180, {}).value();
  for (const std::size_t channels : {2U, 4U}) {
    const SampledBrdf sampled = sample_function(spec, 0, DomainKind::kLog, analytic({}), channels);
    const Result<Atlas> baked = bake_atlas(sampled.sliced, sampled.lattice);
    ASSERT_FALSE(baked);
    EXPECT_EQ(baked.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(baked.error().message, testing::HasSubstr("has " + std::to_string(channels)));
  }
  const SampledBrdf sampled = sample_function(spec, 200, DomainKind::kLog, analytic({}), 3);
  const Result<Atlas> baked = bake_atlas(sampled.sliced, sampled.lattice, {.most_side = 16});
  ASSERT_FALSE(baked);
  EXPECT_EQ(baked.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(baked.error().message, testing::HasSubstr("16 x 16"));
}

TEST(Atlas, HasTheSameTexelsForAnyNumberOfThreads) {
  for (const std::size_t k : {2U, 3U, 18U}) {
    const Example& example = examples()[k];
    std::vector<Atlas> atlases;
    for (const std::size_t threads : {1U, 4U}) {
      const ThreadLimit limit(threads);
      atlases.push_back(bake(example.sampled));
    }
    EXPECT_EQ(atlases[0].texels, atlases[1].texels) << example.name;
    EXPECT_EQ(atlases[0].layout.width, atlases[1].layout.width);
  }
}

TEST(TexelRanges, KeepValuesAndHoldAllTexels) {
  for (const Example& example : examples()) {
    const Atlas plain = bake(example.sampled, {.tolerance = 0.02});
    const AtlasEvaluator evaluator(plain);
    for (const TexelRange range : {TexelRange::kAsIs, TexelRange::kSigned, TexelRange::kUnsigned}) {
      Atlas atlas = plain;
      use_range(atlas, range);
      if (range != TexelRange::kAsIs) {
        const auto [least, most] = std::minmax_element(atlas.texels.begin(), atlas.texels.end());
        EXPECT_GE(*least, range == TexelRange::kSigned ? -1 : 0) << example.name;
        EXPECT_LE(*most, 1) << example.name;
        EXPECT_EQ(*most, 1) << "all of the range is used: " << example.name;
        ASSERT_EQ(atlas.scales[0].size(), range == TexelRange::kSigned ? 1 : atlas.layout.tables[0].tile_count);
      }
      const AtlasEvaluator ranged(atlas);
      std::mt19937_64 random(11);
      for (int k = 0; k < 500; ++k) {
        const DirectionPair pair = random_pair(random);
        const Rgb values = values_of(evaluator, pair);
        ASSERT_LE(difference(values, values_of(ranged, pair)), 2e-5 * size_of(values)) << example.name;
      }
    }
  }
}

/// A tile: where it begins, its sides, and how much of it is more than padding.
struct Tile {
  std::uint32_t x = 0, y = 0, width = 0, height = 0, used_width = 0, used_height = 0;
};

std::vector<Tile> tiles_of(const AtlasLayout& layout) {
  std::vector<Tile> tiles;
  for (const AtlasTable& table : layout.tables) {
    const std::uint32_t rows =
        table.across ? static_cast<std::uint32_t>(layout.axes[*table.across].nodes_deg.size()) : 1;
    for (std::uint32_t k = 0; k < table.tile_count; ++k) {
      tiles.push_back({table.x + k % table.tiles_per_row * table.tile_width,
                       table.y + k / table.tiles_per_row * table.tile_height, table.tile_width, table.tile_height,
                       layout.axes[table.along].texels.back() + 1, rows});
    }
  }
  if (layout.ring) {
    const AtlasRing& ring = *layout.ring;
    tiles.push_back({ring.x, ring.y, ring.tile_width, ring.tile_height, ring.ring_texels + 1,
                     layout.axes[kHorizontal].texels.back() + 1});
  }
  return tiles;
}

TEST(AtlasTiles, ArePaddedWithCopiesWhereTheyAreBlocks) {
  int padded = 0;
  for (const Example& example : examples()) {
    const Atlas atlas = bake(example.sampled, {.tolerance = 0.02, .blocks = true});
    const auto texel = [&](std::uint32_t x, std::uint32_t y) {
      const float* rgb = atlas.texels.data() + (std::size_t{y} * atlas.layout.width + x) * 3;
      return Rgb{rgb[0], rgb[1], rgb[2]};
    };
    for (const Tile& tile : tiles_of(atlas.layout)) {
      ASSERT_EQ(tile.x % 4 + tile.y % 4 + tile.width % 4 + tile.height % 4, 0U) << example.name;
      ASSERT_LT(tile.width - tile.used_width, 4U);
      ASSERT_LT(tile.height - tile.used_height, 4U);
      for (std::uint32_t y = 0; y < tile.height; ++y) {
        for (std::uint32_t x = 0; x < tile.width; ++x) {
          if (x < tile.used_width && y < tile.used_height) continue;
          ++padded;
          const Rgb copied =
              texel(tile.x + std::min(x, tile.used_width - 1), tile.y + std::min(y, tile.used_height - 1));
          ASSERT_EQ(texel(tile.x + x, tile.y + y), copied) << example.name << " " << x << " " << y;
        }
      }
    }
  }
  EXPECT_GT(padded, 1000);
}

AtlasLayout random_layout(std::mt19937_64& random) {
  const auto drawn = [&](std::uint64_t least, std::uint64_t most) { return least + random() % (most - least + 1); };
  AtlasLayout layout;
  layout.frame = random() % 2 == 0 ? FrameId::kElevation : FrameId::kHalfDifference;
  layout.blocks = random() % 2 == 0;
  bool all_move = true;
  for (AtlasAxis& axis : layout.axes) {
    const std::uint64_t nodes = drawn(1, 7);
    for (std::uint64_t k = 0; k < nodes; ++k) {
      axis.nodes_deg.push_back(10.0 * static_cast<double>(k));
      axis.texels.push_back(k == 0 ? 0 : axis.texels.back() + static_cast<std::uint32_t>(drawn(1, 9)));
    }
    all_move = all_move && axis.moves();
  }
  if (layout.frame == FrameId::kElevation) {
    all_move = all_move && layout.axes[kVertical].moves() == layout.axes[kHorizontal].moves();
    layout.axes[kVertical] = layout.axes[kHorizontal];
    all_move = all_move && layout.axes[kVertical].moves();
  }
  if (all_move) layout.ring.emplace().ring_texels = static_cast<std::uint32_t>(drawn(1, 40));
  return layout;
}

TEST(AtlasTiles, NeverOverlapAndLieInATextureWithSidesThatAreMultiplesOfFour) {
  std::mt19937_64 random(12);
  for (int k = 0; k < 400; ++k) {
    AtlasLayout layout = random_layout(random);
    if (std::none_of(layout.axes.begin(), layout.axes.end(), [](const AtlasAxis& axis) { return axis.moves(); })) {
      continue;
    }
    ASSERT_TRUE(lay_out(layout, 4096));
    ASSERT_GT(layout.width, 0U);
    ASSERT_GT(layout.height, 0U);
    ASSERT_EQ(layout.width % 4 + layout.height % 4, 0U);
    std::vector<bool> taken(std::size_t{layout.width} * layout.height, false);
    for (const Tile& tile : tiles_of(layout)) {
      ASSERT_LE(tile.used_width, tile.width);
      ASSERT_LE(tile.used_height, tile.height);
      ASSERT_LE(tile.x + tile.width, layout.width);
      ASSERT_LE(tile.y + tile.height, layout.height);
      for (std::uint32_t y = tile.y; y < tile.y + tile.height; ++y) {
        for (std::uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
          ASSERT_FALSE(taken[std::size_t{y} * layout.width + x]);
          taken[std::size_t{y} * layout.width + x] = true;
        }
      }
    }
  }
}

TEST(AtlasTiles, HaveNumbersOfTheirOwnWithinTheirTable) {
  std::mt19937_64 random(13);
  for (int k = 0; k < 200; ++k) {
    AtlasLayout layout = random_layout(random);
    ASSERT_TRUE(lay_out(layout, 4096));
    for (const AtlasTable& table : layout.tables) {
      if (table.between.empty()) continue;
      const std::size_t rows = layout.axes[table.between[0]].nodes_deg.size();
      const std::size_t columns = table.between.size() > 1 ? layout.axes[table.between[1]].nodes_deg.size() : 1;
      std::vector<bool> met(table.tile_count, false);
      for (std::size_t first = 0; first < rows; ++first) {
        for (std::size_t second = 0; second < columns; ++second) {
          if (table.triangular && second > first + 1) continue;
          const std::uint32_t number = tile_number(layout, table, first, second);
          ASSERT_LT(number, table.tile_count);
          ASSERT_FALSE(met[number]);
          met[number] = true;
        }
      }
      EXPECT_EQ(std::count(met.begin(), met.end(), false), 0);
    }
  }
}

TEST(AtlasPlaces, AreKeptAmongTheNodes) {
  AtlasAxis axis = {{0, 10, 40}, {0, 4, 6}, false};
  const auto expect = [&](double x, std::size_t cell, double fraction, double texel) {
    const AtlasPlace place = place_on(axis, x);
    EXPECT_EQ(place.cell, cell) << x;
    EXPECT_DOUBLE_EQ(place.fraction, fraction) << x;
    EXPECT_DOUBLE_EQ(place.texel, texel) << x;
  };
  expect(-5, 0, 0, 0);
  expect(2.5, 0, 0.25, 1);
  expect(10, 1, 0, 4);
  expect(25, 1, 0.5, 5);
  expect(40, 1, 1, 6);
  expect(1000, 1, 1, 6);
  axis.root_spacing = true;
  expect(2.5, 0, 0.25, 2);
  expect(25, 1, 0.5, 5);
  axis = {{0}, {}, false};
  expect(77, 0, 0, 0);
}

}  // namespace
}  // namespace sbrdf::internal
