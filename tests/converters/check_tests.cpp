#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/judge/plausibility.h"
#include "converters/tables/dense_source.h"
#include "formats/core/parallel.h"
#include "tests/support/function_source.h"
#include "tests/support/test_data.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

/// GGX with Smith's height-correlated shadowing and Schlick's Fresnel term, over a diffuse base.
double ggx(const DirectionPair& pair, double alpha, double f0, double diffuse) {
  const double ci = std::cos(pair.i.theta);
  const double cv = std::cos(pair.v.theta);
  if (ci <= 0 || cv <= 0) return 0;
  const auto sum = vector_from_direction(pair.i) + vector_from_direction(pair.v);
  const double cos_h = sum.z / glm::length(sum);
  const double cos_d = 0.5 * glm::length(sum);
  const double a2 = alpha * alpha;
  const double base = cos_h * cos_h * (a2 - 1) + 1;
  const auto lambda = [&](double c) { return 0.5 * (std::sqrt(1 + a2 * (1 - c * c) / (c * c)) - 1); };
  const double f = f0 + (1 - f0) * std::pow(1 - cos_d, 5);
  return diffuse / kPi + a2 / (kPi * base * base) / (1 + lambda(ci) + lambda(cv)) * f / (4 * ci * cv);
}

/// Plausible: three colours of the same gloss.
double plausible(const DirectionPair& pair, std::size_t channel) {
  return ggx(pair, 0.25, 0.05, 0.5 - 0.15 * static_cast<double>(channel));
}

/// Not quite reciprocal, alike in all channels, as measured data are.
double measured_like(const DirectionPair& pair, std::size_t channel) {
  return plausible(pair, channel) *
         (1 + 0.1 * (std::sin(pair.i.theta) - std::sin(pair.v.theta)) * std::cos(pair.v.phi - pair.i.phi));
}

DirectionPair exchanged(const DirectionPair& pair) { return {pair.v, pair.i}; }

std::unique_ptr<BrdfSource> table_of(const BrdfSource& source, Grid grid,
                                     const std::function<void(std::vector<double>&, const Grid&)>& damage = {}) {
  const DenseTable sampled = table_of_source(source, grid);
  std::vector<GridNode> nodes;
  for (std::uint64_t k = 0; k < grid.node_count(); ++k) nodes.push_back(grid.node(k));
  std::vector<double> values(nodes.size() * source.channel_count());
  sampled.values->gather(nodes, values);
  if (damage) damage(values, grid);
  DenseDescription description;
  description.format = "test";
  description.description = "a table";
  description.channels = source.traits().channels;
  return DenseSource::make(table_in_memory(std::move(grid), source.channel_count(), std::move(values)), description)
      .value();
}

Grid isotropic_grid(double theta_step, double phi_step, double last = 90) {
  Grid grid;
  grid.frame = GridFrame::kDifference;
  const auto thetas = even_nodes(0, theta_step, static_cast<std::size_t>(last / theta_step + 0.5) + 1);
  grid.axes = {GridAxis({0}), GridAxis(thetas), GridAxis(thetas),
               GridAxis(even_nodes(0, phi_step, static_cast<std::size_t>(360 / phi_step + 0.5)), Ends::kFullTurn)};
  return grid;
}

const CheckRemark* find(const CheckReport& report, const std::string& topic) {
  const auto found = std::find_if(report.remarks.begin(), report.remarks.end(),
                                  [&](const CheckRemark& remark) { return remark.topic == topic; });
  return found == report.remarks.end() ? nullptr : &*found;
}

std::vector<std::string> suspicions(const CheckReport& report) {
  std::vector<std::string> topics;
  for (const CheckRemark& remark : report.remarks) {
    if (remark.suspicious) topics.push_back(remark.topic);
  }
  return topics;
}

CheckReport checked(const BrdfSource& source) { return check_source(source).value(); }

TEST(DirectionalAlbedo, OfAWhiteDiffuseMaterialIsOne) {
  const FunctionSource white([](const auto&, std::size_t) { return 1 / kPi; }, {.isotropic = true, .reciprocal = true});
  for (const double theta : {0, 15, 45, 75, 85, 90}) {
    const Albedo albedo = directional_albedo(white, direction_from_degrees(theta, 30));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(albedo.total(c), 1, 1e-6) << theta;
    EXPECT_TRUE(albedo.reached);
    EXPECT_EQ(albedo.beyond, (std::vector<double>{0, 0, 0}));
  }
}

// Gauss-Legendre of 1000 nodes in theta_v, 2000 azimuths, in numpy; unchanged with 500 and 1000.
TEST(DirectionalAlbedo, OfGgxIsWhatNumpySaysAndItsErrorIsTold) {
  struct Known {
    double alpha, theta_deg, albedo;
  };
  for (const Known& known : {Known{0.3, 0, 0.33512657},
                             {0.3, 30, 0.33517868},
                             {0.3, 60, 0.35112357},
                             {0.3, 85, 0.45092931},
                             {0.1, 0, 0.33953870},
                             {0.1, 30, 0.33968858},
                             {0.1, 60, 0.36962169},
                             {0.1, 85, 0.6351358}}) {
    const FunctionSource source(
        [&](const DirectionPair& pair, std::size_t) { return ggx(pair, known.alpha, 0.04, 0.3); },
        {.isotropic = true, .reciprocal = true, .channels = {"Y"}});
    const Albedo albedo = directional_albedo(source, direction_from_degrees(known.theta_deg, 77));
    EXPECT_NEAR(albedo.total(0), known.albedo, 1e-4) << known.alpha << " " << known.theta_deg;
    EXPECT_LE(albedo.error[0], 1e-4);
    EXPECT_TRUE(albedo.reached);
  }
}

// f cos theta_v is von Mises' and Fisher's density around the mirror direction, or back to the light: its integral
// is 1.
TEST(DirectionalAlbedo, FindsHighlightsAFiftiethOfADegreeWide) {
  const double width = radians_from_degrees(0.02);
  const double kappa = 1 / (width * width);
  for (const double azimuth : {0.0, 180.0}) {
    const FunctionSource source(
        [&](const DirectionPair& pair, std::size_t) {
          const auto v = vector_from_direction(pair.v);
          const auto away = v - vector_from_direction({pair.i.theta, pair.i.phi + radians_from_degrees(azimuth)});
          return kappa / (2 * kPi) * std::exp(-0.5 * kappa * glm::dot(away, away)) / std::cos(pair.v.theta);
        },
        {.isotropic = true, .channels = {"Y"}});
    for (const double theta : {0, 15, 60, 85}) {
      const Albedo albedo = directional_albedo(source, direction_from_degrees(theta, 10));
      EXPECT_NEAR(albedo.total(0), 1, 2e-4) << theta << " " << azimuth;
      EXPECT_TRUE(albedo.reached);
    }
  }
}

TEST(DirectionalAlbedo, TellsApartWhatComesFromBeyondThetaMaxAndWhereTheAccuracyIsNotReached) {
  const FunctionSource grey([](const auto&, std::size_t) { return 0.5 / kPi; });
  const auto table = table_of(grey, isotropic_grid(15, 15, 75));
  const Albedo albedo = directional_albedo(*table, direction_from_degrees(30, 0));
  const double measured = std::pow(std::sin(radians_from_degrees(75)), 2);
  EXPECT_NEAR(albedo.measured[1], 0.5 * measured, 1e-6);
  EXPECT_NEAR(albedo.beyond[1], 0.5 * (1 - measured), 1e-6);
  const FunctionSource rough([](const DirectionPair& pair, std::size_t) { return 1 + std::sin(1e5 * pair.v.theta); });
  const Albedo poor = directional_albedo(rough, direction_from_degrees(30, 0), {.most_evaluations = 50'000});
  EXPECT_FALSE(poor.reached);
  EXPECT_GT(poor.error[0], 1e-4);
  EXPECT_LE(poor.evaluations, 50'000);
}

TEST(Check, FindsNothingInPlausibleData) {
  for (const bool as_table : {false, true}) {
    const FunctionSource source(measured_like, {.isotropic = true});
    const auto table = table_of(source, isotropic_grid(5, 10));
    const CheckReport report = checked(as_table ? *table : static_cast<const BrdfSource&>(source));
    EXPECT_EQ(report.verdict(), "plausible") << testing::PrintToString(suspicions(report));
    EXPECT_GT(report.reciprocity.percent, 1);
    EXPECT_LT(report.reciprocity.percent, 8);
    EXPECT_LT(report.pairs.isotropy.percent, 1e-3);
    EXPECT_LT(report.pairs.mirror_x.percent, 1e-3);
    EXPECT_LT(report.highest_albedo, 1);
    EXPECT_EQ(report.spikes->count, 0U);
  }
}

TEST(Check, FindsAMissingScaleAndAFactorOfPi) {
  const auto scaled = [](double factor) {
    const FunctionSource source([=](const auto& pair, std::size_t c) { return factor * measured_like(pair, c); },
                                {.isotropic = true});
    return checked(source);
  };
  const CheckReport large = scaled(1500);
  EXPECT_EQ(suspicions(large), (std::vector<std::string>{"albedo", "scale"}));
  EXPECT_THAT(find(large, "scale")->text, HasSubstr("far too large"));
  EXPECT_THAT(find(large, "albedo")->text, HasSubstr("for 7 of 7 directions of the light"));
  EXPECT_THAT(find(scaled(1.0 / 1500), "scale")->text, HasSubstr("far too small"));
  EXPECT_THAT(find(scaled(kPi), "scale")->text, HasSubstr("divided by pi"));
}

TEST(Check, FindsACosineThatWasMultipliedIn) {
  const FunctionSource with_v(
      [](const auto& pair, std::size_t c) { return measured_like(pair, c) * std::cos(pair.v.theta); },
      {.isotropic = true});
  const auto table = table_of(with_v, isotropic_grid(5, 10));
  for (const BrdfSource* source :
       {static_cast<const BrdfSource*>(&with_v), static_cast<const BrdfSource*>(table.get())}) {
    const CheckReport report = checked(*source);
    EXPECT_EQ(suspicions(report), (std::vector<std::string>{"cosine"}));
    EXPECT_THAT(find(report, "cosine")->text, HasSubstr("cos theta_v seems to be multiplied in"));
    EXPECT_NEAR(report.pairs.exchange_slope, 1, 0.1);
  }
  const FunctionSource with_i(
      [](const auto& pair, std::size_t c) { return measured_like(pair, c) * std::cos(pair.i.theta); },
      {.isotropic = true});
  EXPECT_THAT(find(checked(with_i), "cosine")->text, HasSubstr("cos theta_i seems to be multiplied in"));
}

TEST(Check, FindsLightAndViewerExchangedInOneChannel) {
  const FunctionSource source(
      [](const auto& pair, std::size_t c) { return measured_like(c == 1 ? exchanged(pair) : pair, c); },
      {.isotropic = true});
  const CheckReport report = checked(*table_of(source, angles_grid(15, 75, 30)));
  EXPECT_EQ(suspicions(report), (std::vector<std::string>{"exchange"}));
  EXPECT_THAT(find(report, "exchange")->text, HasSubstr("exchanged in G: "));
}

TEST(Check, FindsASingleNodeThatIsTooLargeOrLost) {
  const FunctionSource source(measured_like, {.isotropic = true});
  for (const double factor : {4.0, 0.0}) {
    for (const bool anisotropic : {false, true}) {
      const Grid grid = anisotropic ? angles_grid(15, 75, 15) : isotropic_grid(5, 10);
      const GridNode node = anisotropic ? GridNode{2, 3, 3, 7} : GridNode{0, 5, 9, 4};
      const auto table = table_of(
          source, grid, [&](std::vector<double>& values, const Grid& of) { values[of.index(node) * 3 + 2] *= factor; });
      const CheckReport report = checked(*table);
      ASSERT_EQ(report.spikes->count, 1U) << factor << anisotropic;
      EXPECT_EQ(report.spikes->worst[0].node, node);
      EXPECT_EQ(report.spikes->worst[0].channel, 2U);
      EXPECT_EQ(report.spikes->worst[0].place, grid.node_text(node));
      EXPECT_EQ(suspicions(report), (std::vector<std::string>{"spikes"}));
    }
  }
}

TEST(Check, TakesNoNarrowHighlightForASpike) {
  const FunctionSource narrow([](const DirectionPair& pair, std::size_t) { return ggx(pair, 0.02, 0.9, 0.01); },
                              {.isotropic = true});
  for (const Grid& grid : {isotropic_grid(5, 10), angles_grid(15, 75, 15), isotropic_grid(15, 7.5, 75)}) {
    EXPECT_EQ(find_spikes(*table_of(narrow, grid)->table(), {})->count, 0U) << grid.size_text();
  }
}

TEST(Check, CountsNodesThatAreNegativeUnmeasuredOrOutOfGamut) {
  const FunctionSource source(measured_like, {.isotropic = true});
  const Grid grid = isotropic_grid(10, 20);
  const auto table = table_of(source, grid, [](std::vector<double>& values, const Grid& of) {
    const std::size_t rings = of.axes[1].size();  // theta_i
    const std::size_t per_ring = values.size() / 3 / rings;
    for (std::size_t n = 0; n < per_ring; ++n) {
      values[(3 * per_ring + n) * 3] = -0.01;                                                 // red, at 30 degrees
      for (std::size_t c = 0; c < 3; ++c) values[(6 * per_ring + n) * 3 + c] = std::nan("");  // at 60 degrees
    }
  });
  const Shares shares = checked(*table).shares;
  EXPECT_EQ(shares.count, grid.node_count());
  EXPECT_NEAR(shares.negative_percent, 10, 1e-9);
  EXPECT_NEAR(shares.gamut_percent, 10, 1e-9);
  EXPECT_NEAR(shares.unmeasured_percent, 10, 1e-9);
  // sin theta_i over the trapezoids of the axis; the other angles cancel.
  double all = 0.5 * std::sin(kPi / 2);
  for (int k = 1; k < 9; ++k) all += std::sin(radians_from_degrees(10 * k));
  EXPECT_NEAR(shares.negative_solid_percent, 100 * 0.5 / all, 1e-6);
  EXPECT_NEAR(shares.unmeasured_solid_percent, 100 * std::sin(kPi / 3) / all, 1e-6);
  ASSERT_TRUE(shares.worst_gamut.has_value());
  EXPECT_EQ(shares.worst_gamut->channel, 0U);
  EXPECT_DOUBLE_EQ(shares.worst_gamut->reference, -0.01);
  EXPECT_NEAR(degrees_from_radians(shares.worst_gamut->pair.i.theta), 30, 1e-9);
}

TEST(Check, FindsAPoleAtTheHorizonAndThetaInRadians) {
  const FunctionSource pole(
      [](const auto& pair, std::size_t c) { return 0.1 * measured_like(pair, c) / std::cos(pair.v.theta); },
      {.isotropic = true});
  const CheckReport report = checked(pole);
  ASSERT_NE(find(report, "grazing"), nullptr);
  EXPECT_TRUE(find(report, "grazing")->suspicious);
  EXPECT_NEAR(report.grazing.back().power, 1, 0.05);
  const FunctionSource source(measured_like, {.isotropic = true});
  Grid grid = isotropic_grid(0.3, 30, 1.5);
  EXPECT_NE(find(checked(*table_of(source, grid)), "unit"), nullptr);
}

TEST(Check, SaysTheSameOnAnyNumberOfThreads) {
  const FunctionSource source(measured_like, {.isotropic = true});
  const auto table = table_of(source, isotropic_grid(10, 20));
  const CheckReport many = checked(*table);
  const ThreadLimit one(1);
  const CheckReport alone = checked(*table);
  for (std::size_t k = 0; k < many.albedos.size(); ++k) {
    EXPECT_EQ(many.albedos[k].measured, alone.albedos[k].measured);
    EXPECT_EQ(many.albedos[k].error, alone.albedos[k].error);
  }
  EXPECT_EQ(many.reciprocity.percent, alone.reciprocity.percent);
  EXPECT_EQ(many.pairs.isotropy.percent, alone.pairs.isotropy.percent);
  EXPECT_EQ(many.shares.negative_solid_percent, alone.shares.negative_solid_percent);
}

TEST(Check, CanBeStopped) {
  const FunctionSource source(measured_like, {.isotropic = true});
  const auto report = check_source(source, {}, {[](double) { return false; }});
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().message, interrupted_error().message);
}

// Highlights that are narrower than a coarse grid, noise in the dark of a mirror: none of it is a spike.
TEST(CheckOfMeasuredData, FindsNoSpikesInResampledMaterials) {
  SBRDF_FIND_TEST_DATA(rgl, "rgl");
  std::vector<std::string> names = {"kurt:fabric112", "kurt:Brushed alum", "kurt:fabric139"};
  for (const char* name : {"acrylic_felt_green", "aurora_white", "cc_green_malachite", "chm_mint", "chm_orange",
                           "vch_golden_yellow", "vch_silk_blue"}) {
    names.push_back((rgl / (std::string(name) + "_rgb.bsdf")).string());
  }
  for (const std::string& name : names) {
    const OpenedSource opened = open_source(name).value();
    const bool isotropic = opened.source->traits().isotropic;
    for (const Grid& grid : {angles_grid(15, 75, 15), isotropic_grid(5, 10, 80), isotropic_grid(15, 7.5, 75)}) {
      if (!isotropic && grid.frame == GridFrame::kDifference) continue;
      const SpikeSearch found = find_spikes(*table_of(*opened.source, grid)->table(), {}).value();
      EXPECT_EQ(found.count, 0U) << name << ", " << grid.size_text() << ": "
                                 << (found.worst.empty() ? "" : found.worst[0].place);
    }
  }
}

/// A defect in measured data, resampled: what is added to what the file itself is said.
TEST(CheckOfMeasuredData, FindsInjectedDefectsAndNothingElse) {
  SBRDF_FIND_TEST_DATA(file, "rgl/vch_golden_yellow_rgb.bsdf");
  const OpenedSource opened = open_source(file.string()).value();
  const BrdfSource& source = *opened.source;
  const Grid grid = isotropic_grid(5, 10, 80);
  const GridNode node = {0, 6, 3, 11};
  EXPECT_EQ(suspicions(checked(*table_of(source, grid))), (std::vector<std::string>{}))
      << checked(*table_of(source, grid)).remarks.front().text;
  const auto spiked =
      table_of(source, grid, [&](std::vector<double>& values, const Grid& of) { values[of.index(node) * 3 + 1] *= 5; });
  const CheckReport report = checked(*spiked);
  EXPECT_EQ(suspicions(report), (std::vector<std::string>{"spikes"}));
  EXPECT_EQ(report.spikes->count, 1U);
  EXPECT_EQ(report.spikes->worst[0].node, node);
  const auto each = [&](const auto& change) {
    const FunctionSource changed(
        [&](const DirectionPair& pair, std::size_t c) {
          std::vector<float> colour(3);
          source.evaluate(std::span(&pair, 1), colour);
          return change(pair, c, static_cast<double>(colour[c]));
        },
        {.isotropic = true});
    return suspicions(checked(*table_of(changed, grid)));
  };
  EXPECT_THAT(each([](const auto& pair, std::size_t, double f) { return f * std::cos(pair.v.theta); }),
              testing::Contains("cosine"));
  EXPECT_THAT(each([](const auto&, std::size_t, double f) { return f * 1500; }), testing::Contains("scale"));
  EXPECT_THAT(each([&](const auto& pair, std::size_t c, double f) {
                if (c != 2) return f;
                std::vector<float> colour(3);
                const DirectionPair turned = exchanged(pair);
                source.evaluate(std::span(&turned, 1), colour);
                return static_cast<double>(colour[2]);
              }),
              testing::Contains("exchange"));
}

}  // namespace
}  // namespace sbrdf::internal
