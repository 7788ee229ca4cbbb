#include "codec/atlas/paper/paper_textures.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "codec/atlas/paper/paper_evaluator.h"
#include "codec/evaluation/evaluator.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

using Rgb = std::array<float, 3>;

struct Baked {
  SampledBrdf brdf;
  PaperTextures textures;
};

Baked bake(const FrameSpec& spec, DomainKind domain, std::uint64_t extra = 400) {
  const auto function = [symmetries = spec.symmetries](const DirectionPair& pair, std::size_t channel) {
    const double f = analytic_brdf(pair, symmetries);
    return channel == 0 ? f : channel == 1 ? 0.3 + 0.5 * f : f * f;
  };
  Baked baked;
  baked.brdf = sample_function(spec, extra, domain, function, 3);
  baked.textures = bake_paper_textures(baked.brdf.sliced, baked.brdf.lattice).value();
  return baked;
}

void expect_near(const Rgb& r, const Rgb& expected, double relative, const Coordinates& x) {
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(r[c], expected[c], relative * std::abs(expected[c]))
        << x[0] << ", " << x[1] << ", " << x[2] << ", " << x[3] << " channel " << c;
  }
}

/// e_n from its definition: steps below 80, and 80.
std::uint64_t elevation_count(int step) {
  std::uint64_t count = 1;
  for (int theta = step; theta < 80; theta += step) ++count;
  return count;
}

std::uint64_t texels_by_formula(std::uint64_t e, std::uint64_t a) {
  const std::uint64_t areas = e * (e + 1) / 2;
  return areas * (a + 1) * (2 * a + 1) + 2 * areas * (a + 1) * 360 + a * (2 * a + 1) * 90 * e;
}

TEST(PaperTextures, HaveTheTexelsOfSection8ForAllPlacements) {
  constexpr std::array<std::array<int, 2>, 17> kPlacements = {{{28, 180},
                                                               {20, 180},
                                                               {16, 180},
                                                               {28, 60},
                                                               {20, 60},
                                                               {16, 60},
                                                               {14, 60},
                                                               {16, 36},
                                                               {14, 36},
                                                               {12, 36},
                                                               {10, 36},
                                                               {8, 36},
                                                               {12, 20},
                                                               {10, 20},
                                                               {8, 20},
                                                               {6, 20},
                                                               {6, 12}}};
  for (const auto& [e_s, a_s] : kPlacements) {
    PaperTextures textures;
    const FrameSpec spec = elevation_frame(e_s, a_s, {}).value();
    const std::vector<double>& elevations = spec.axes[kVertical].nodes_deg;
    textures.elevations_deg.assign(elevations.begin() + 1, elevations.end());
    textures.azimuth_count = static_cast<std::uint32_t>(spec.axes[kDiagonal].nodes_deg.size());
    ASSERT_TRUE(lay_out_paper(textures));
    EXPECT_EQ(textures.texel_count(), texels_by_formula(elevation_count(e_s), static_cast<std::uint64_t>(360 / a_s)))
        << e_s << "/" << a_s;
  }
}

std::string megabytes(std::uint64_t texels) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%.1f", static_cast<double>(texels * 12) / (1 << 20));
  return text.data();
}

TEST(PaperTextures, TakeWhatTable5Prints) {
  const Baked coarse = bake(elevation_frame(14, 36, {}).value(), DomainKind::kLog);
  EXPECT_EQ(coarse.textures.texel_count(), 284'571U);
  EXPECT_EQ(megabytes(coarse.textures.texel_count()), "3.3");
  const Baked fine = bake(elevation_frame(10, 36, {}).value(), DomainKind::kLog);
  EXPECT_EQ(fine.textures.texel_count(), 444'636U);
  EXPECT_EQ(megabytes(fine.textures.texel_count()), "5.1");
  for (const PaperTexture& texture : fine.textures.textures) {
    EXPECT_EQ(texture.texels.size(), std::size_t{texture.width} * texture.height * 3);
  }
}

class PaperDomain : public testing::TestWithParam<DomainKind> {};
INSTANTIATE_TEST_SUITE_P(Domains, PaperDomain, testing::Values(DomainKind::kLinear, DomainKind::kLog));

/// A texel is on every slice at each degree of its parameter: there only rounding may differ.
TEST_P(PaperDomain, GivesSlicesAtEachDegree) {
  const Baked baked = bake(elevation_frame(20, 60, {}).value(), GetParam());
  const Evaluator evaluator(baked.brdf.sliced, baked.brdf.lattice);
  const PaperEvaluator paper(baked.textures);
  std::mt19937 random(7);
  const auto below = [&](std::uint32_t count) { return static_cast<double>(random() % count); };
  for (int k = 0; k < 4000; ++k) {
    const double view = 1 + below(4);
    Coordinates x = {60 * below(12), 60 * below(6), 20 * view, 20 * (1 + below(static_cast<std::uint32_t>(view)))};
    const std::size_t along = random() % 5;  // 4: a crossing
    if (along == kAxial) x[kAxial] = 2 * below(360);
    if (along == kDiagonal) x[kDiagonal] = 2 * below(180);
    if (along == kHorizontal) x[kHorizontal] = x[kVertical] + below(81 - static_cast<std::uint32_t>(x[kVertical]));
    if (along == kVertical) x[kVertical] = below(static_cast<std::uint32_t>(x[kHorizontal]) + 1);
    Rgb expected{}, r{};
    evaluator.evaluate_at(x, expected);
    paper.evaluate_at(x, r);
    expect_near(r, expected, 3e-5, x);
  }
}

TEST_P(PaperDomain, GivesNodesOfTheRingsAndNothingElseOfAzimuthsAtThePole) {
  const Baked baked = bake(elevation_frame(20, 60, {}).value(), GetParam());
  const Evaluator evaluator(baked.brdf.sliced, baked.brdf.lattice);
  const PaperEvaluator paper(baked.textures);
  for (const double theta : {20.0, 40.0, 80.0}) {
    for (double s = 0; s < 720; s += 60) {
      Rgb expected{}, r{};
      evaluator.evaluate_at({s, 0, theta, 0}, expected);
      paper.evaluate_at({s, 0, theta, 0}, r);
      expect_near(r, expected, 3e-5, {s, 0, theta, 0});
    }
    for (const double phi : {0.0, 17.0, 200.0}) {  // the same phi_v
      Rgb first{}, r{};
      paper.evaluate_at({214, 0, theta, 0}, first);
      paper.evaluate_at({214 + phi, phi, theta, 0}, r);
      expect_near(r, first, 3e-5, {214 + phi, phi, theta, 0});
    }
  }
  Rgb expected{}, r{};
  evaluator.evaluate_at({}, expected);
  paper.evaluate_at({}, r);
  expect_near(r, expected, 3e-5, {});
}

DirectionPair random_pair(std::mt19937& random) {
  std::uniform_real_distribution<double> theta(0, 80);
  std::uniform_real_distribution<double> phi(0, 360);
  const auto direction = [&] {
    return Direction{radians_from_degrees(theta(random)), radians_from_degrees(phi(random))};
  };
  const Direction i = direction();
  return {i, direction()};
}

TEST_P(PaperDomain, IsNearTheSlicesEverywhereAndReciprocalToTheLastBit) {
  const Baked baked = bake(elevation_frame(14, 36, {}).value(), GetParam(), 3000);
  const Evaluator evaluator(baked.brdf.sliced, baked.brdf.lattice);
  const PaperEvaluator paper(baked.textures);
  std::mt19937 random(3);
  double sum = 0;
  double error = 0;
  std::array<int, 2> values{};  // by whether both directions are beyond the first elevation
  std::array<int, 2> far_off{};
  double least_off = 0;
  for (int k = 0; k < 20'000; ++k) {
    const DirectionPair pair = random_pair(random);
    Rgb expected{}, r{}, exchanged{};
    evaluator.evaluate(pair, expected);
    paper.evaluate(pair, r);
    paper.evaluate({pair.v, pair.i}, exchanged);
    EXPECT_EQ(r, exchanged);
    const bool away = degrees_from_radians(std::min(pair.i.theta, pair.v.theta)) > 14;
    for (std::size_t c = 0; c < 3; ++c) {
      sum += expected[c];
      error += std::abs(double{r[c]} - double{expected[c]});
      ++values[away ? 1 : 0];
      const double off = double{r[c]} / double{expected[c]} - 1;
      if (std::abs(off) > 1e-3) ++far_off[away ? 1 : 0];
      if (away) least_off = std::min(least_off, off);
    }
  }
  // Beyond the first elevation sums differ by what lies between rows of a degree alone. Where the least slice stands
  // for the sum it is the least of what the filter gives, which is higher than that of all 32, and the evaluator alone
  // has a bound from above: so what is far off is too large.
  EXPECT_LE(error / sum, 2e-3);
  EXPECT_LE(far_off[1], values[1] / 100);
  EXPECT_GE(least_off, -1e-3);
}

TEST(PaperTextures, AreZeroBelowTheHorizonAndOfAnglesThatAreNoNumbers) {
  const Baked baked = bake(elevation_frame(28, 180, {}).value(), DomainKind::kLog);
  const PaperEvaluator paper(baked.textures);
  for (const DirectionPair& pair :
       {DirectionPair{{2, 0}, {0.5, 0}}, DirectionPair{{0.5, 0}, {1.6, 0}}, DirectionPair{{NAN, 0}, {0.5, 0}},
        DirectionPair{{0.5, NAN}, {0.5, 0}}, DirectionPair{{0.5, 0}, {0.5, INFINITY}}}) {
    Rgb r = {1, 1, 1};
    paper.evaluate(pair, r);
    EXPECT_EQ(r, (Rgb{}));
  }
}

TEST(PaperTextures, OfIsotropicMaterialsHoldTheirSlices) {
  const Symmetries isotropic = {.isotropic = true};
  const Baked baked = bake(elevation_frame(20, 30, isotropic).value(), DomainKind::kLog);
  EXPECT_EQ(baked.textures.texel_count(), texels_by_formula(4, 12));
  const Evaluator evaluator(baked.brdf.sliced, baked.brdf.lattice);
  const PaperEvaluator paper(baked.textures);
  for (double s = 0; s < 720; s += 31) {
    const Coordinates x = {s, 74, 60, 20};
    Rgb expected{}, r{};
    evaluator.evaluate_at(x, expected);
    paper.evaluate_at(x, r);
    expect_near(r, expected, 3e-5, x);
  }
}

void expect_unsupported(const FrameSpec& spec, const std::string& what, std::size_t channels = 3) {
  const SampledBrdf brdf = sample_function(
      spec, 0, DomainKind::kLog, [](const DirectionPair&, std::size_t) { return 1.0; }, channels);
  const Result<PaperTextures> textures = bake_paper_textures(brdf.sliced, brdf.lattice);
  ASSERT_FALSE(textures) << what;
  EXPECT_EQ(textures.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(textures.error().message.find(what), std::string::npos) << textures.error().message;
}

TEST(PaperTextures, RefuseWhatDoesNotFitAndSayWhy) {
  expect_unsupported(half_difference_frame({0, 40, 80}, {0, 40, 80}, {0, 180}, {0, 90}, {}), "half-difference");
  expect_unsupported(elevation_frame_from_nodes({0, 40, 80}, {0, 180}, {0, 90, 270}, {}), "axial slices");
  expect_unsupported(elevation_frame_from_nodes({0, 40, 80}, {0, 100, 180, 270}, {0, 90, 180, 270}, {}),
                     "diagonal slices");
  expect_unsupported(elevation_frame_from_nodes({0, 40, 80}, {0, 180}, {0, 90, 180, 270}, {}), "diagonal slices");
  expect_unsupported(elevation_frame(30, 90, {}, 90).value(), "theta_v = 89");
  expect_unsupported(elevation_frame(40, 180, {}).value(), "three channels", 2);
}

}  // namespace
}  // namespace sbrdf::internal
