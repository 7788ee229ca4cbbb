#include "codec/importance/importance_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "codec/search/random_pairs.h"
#include "formats/core/directions.h"
#include "formats/core/parallel.h"
#include "tests/support/hemisphere_bins.h"

namespace sbrdf::internal {
namespace {

using Function = double (*)(const glm::dvec3& i, const glm::dvec3& v);

/// One channel.
VectorBrdf brdf_of(Function function, bool isotropic) {
  const auto evaluate = [function](std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                   std::span<float> values) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      const bool above = w_i[k].z > 0 && w_v[k].z > 0;
      values[k] = above ? static_cast<float>(function(glm::dvec3(w_i[k]), glm::dvec3(w_v[k]))) : 0.0F;
    }
  };
  return {evaluate, 1, isotropic};
}

/// Ward's lobe without the cosines, its long axis turned by `angle` from x.
double lobe(const glm::dvec3& i, const glm::dvec3& v, double a, double b, double angle) {
  const glm::dvec3 h = i + v;
  const double x = (h.x * std::cos(angle) + h.y * std::sin(angle)) / (h.z * a);
  const double y = (h.y * std::cos(angle) - h.x * std::sin(angle)) / (h.z * b);
  return std::exp(-x * x - y * y) / (4 * kPi * a * b);
}

double nothing(const glm::dvec3& /*i*/, const glm::dvec3& /*v*/) { return 0; }
double matt(const glm::dvec3& /*i*/, const glm::dvec3& /*v*/) { return 0.2; }
double mirror_like(const glm::dvec3& i, const glm::dvec3& v) { return lobe(i, v, 0.003, 0.003, 0); }
double needle(const glm::dvec3& i, const glm::dvec3& v) { return lobe(i, v, 0.0003, 0.0003, 0); }
double paint(const glm::dvec3& i, const glm::dvec3& v) { return 0.1 + 0.3 * lobe(i, v, 0.1, 0.1, 0); }
double brushed(const glm::dvec3& i, const glm::dvec3& v) { return 0.01 + lobe(i, v, 0.02, 0.3, 0); }
double brushed_aslant(const glm::dvec3& i, const glm::dvec3& v) { return 0.01 + lobe(i, v, 0.02, 0.3, 0.6); }
double one_sided(const glm::dvec3& i, const glm::dvec3& v) { return (1 + v.x) * lobe(i, v, 0.1, 0.4, 0.3); }
double back_to_the_light(const glm::dvec3& i, const glm::dvec3& v) {
  return 0.05 + 50 * std::exp(300 * (glm::dot(i, v) - 1));
}
double bright_at_the_horizon(const glm::dvec3& i, const glm::dvec3& v) {
  return 0.1 / std::sqrt(std::max(i.z, 1e-3) * std::max(v.z, 1e-3));
}
/// Negative where `paint` is not large.
double partly_negative(const glm::dvec3& i, const glm::dvec3& v) { return paint(i, v) - 0.5; }
double partly_zero(const glm::dvec3& i, const glm::dvec3& v) { return std::max(paint(i, v) - 0.5, 0.0); }

struct Case {
  std::string name;
  VectorBrdf brdf;
  IncidenceSymmetry symmetry;
};

std::vector<Case> cases() {
  using enum IncidenceSymmetry;
  return {{"nothing", brdf_of(nothing, true), kIsotropic},
          {"matt", brdf_of(matt, true), kIsotropic},
          {"mirror-like", brdf_of(mirror_like, true), kIsotropic},
          {"paint", brdf_of(paint, true), kIsotropic},
          {"brushed", brdf_of(brushed, false), kQuarter},
          {"brushed aslant", brdf_of(brushed_aslant, false), kHalfTurn},
          {"one-sided", brdf_of(one_sided, false), kNone},
          {"back to the light", brdf_of(back_to_the_light, true), kIsotropic},
          {"bright at the horizon", brdf_of(bright_at_the_horizon, true), kIsotropic},
          {"partly negative", brdf_of(partly_negative, true), kIsotropic}};
}

glm::vec3 light(double theta_deg, double phi_deg) {
  return glm::vec3(vector_from_direction(direction_from_degrees(theta_deg, phi_deg)));
}

glm::dvec2 draw_square(std::mt19937_64& random) {
  const double x = draw_uniform(random, 1);
  return {x, draw_uniform(random, 1)};
}

HemisphereBins bins_of(const ImportanceTable& table, const glm::vec3& w_i, double most = 1.0 / 128) {
  const auto density = [&, w_i](const glm::dvec3& w) { return static_cast<double>(table.pdf(w_i, glm::vec3(w))); };
  return {density, {-w_i.x, -w_i.y, w_i.z}, most, 5e-6};
}

TEST(ImportanceTable, KnowsSymmetriesAndKeepsToItsBytes) {
  for (const Case& one : cases()) {
    const ImportanceTable table = make_importance_table(one.brdf);
    EXPECT_EQ(table.grid().symmetry, one.symmetry) << one.name;
    const bool isotropic = one.symmetry == IncidenceSymmetry::kIsotropic;
    EXPECT_LE(table.bytes(), isotropic ? kMostIsotropicTableBytes : kMostTableBytes) << one.name;
  }
}

TEST(ImportanceDistribution, HasADensityThatIntegratesToOne) {
  for (const Case& one : cases()) {
    const ImportanceTable table = make_importance_table(one.brdf);
    for (const double theta : {0.0, 85.0, 89.97}) {
      EXPECT_NEAR(bins_of(table, light(theta, 200), 1.0 / 32).total(), 1, 0.002) << one.name << ' ' << theta;
    }
  }
}

TEST(ImportanceDistribution, DrawsAsItsDensitySays) {
  constexpr std::size_t kCount = 1'000'000;
  std::mt19937_64 random(3);
  for (const auto& [index, theta] : std::map<std::size_t, double>{{3, 60}, {4, 30}, {5, 75}, {6, 85}, {8, 80}}) {
    const Case one = cases()[index];
    const ImportanceTable table = make_importance_table(one.brdf);
    const glm::vec3 w_i = light(theta, 110);
    const HemisphereBins bins = bins_of(table, w_i);
    std::vector<double> counts(bins.masses().size());
    for (std::size_t k = 0; k < kCount; ++k) {
      ++counts[bins.find(glm::dvec3(table.sample(w_i, draw_square(random)).w_v))];
    }
    EXPECT_GT(chi_square_chance(bins.masses(), counts), 1e-3) << one.name;
  }
}

// The oracle notices a density that is a little off, and bins that are.
TEST(ImportanceDistribution, IsJudgedByATestThatCanFail) {
  const ImportanceTable table = make_importance_table(brdf_of(paint, true));
  const glm::vec3 w_i = light(60, 0);
  const HemisphereBins bins = bins_of(table, w_i);
  std::vector<double> counts(bins.masses().size());
  std::mt19937_64 random(4);
  for (std::size_t k = 0; k < 1'000'000; ++k) {
    glm::dvec2 u = draw_square(random);
    u.y = std::pow(u.y, 1.03);
    ++counts[bins.find(glm::dvec3(table.sample(w_i, u).w_v))];
  }
  EXPECT_LT(chi_square_chance(bins.masses(), counts), 1e-6);
}

TEST(ImportanceTable, TellsTheSameDensityTwice) {
  std::mt19937_64 random(5);
  for (const Case& one : cases()) {
    const ImportanceTable table = make_importance_table(one.brdf);
    for (int k = 0; k < 3000; ++k) {
      const glm::vec3 w_i = 3.0F * light(draw_uniform(random, 90), draw_uniform(random, 360));
      const DrawnDirection drawn = table.sample(w_i, draw_square(random));
      EXPECT_EQ(drawn.pdf, table.pdf(w_i, drawn.w_v)) << one.name;
      EXPECT_GT(drawn.pdf, 0) << one.name;
      EXPECT_GT(drawn.w_v.z, 0) << one.name;
      EXPECT_NEAR(glm::length(drawn.w_v), 1, 1e-6) << one.name;
    }
  }
}

// What the density of the cosine alone leaves: the square of f cos / pdf.
double variance(const VectorBrdf& brdf, const ImportanceTable& table, const glm::vec3& w_i, bool by_cosine) {
  constexpr int kCount = 30'000;
  std::mt19937_64 random(6);
  double sum = 0;
  double squares = 0;
  for (int k = 0; k < kCount; ++k) {
    const DrawnDirection drawn = table.sample(w_i, draw_square(random));
    float f = 0;
    brdf.evaluate(std::span(&w_i, 1), std::span(&drawn.w_v, 1), std::span(&f, 1));
    const double weight = static_cast<double>(f) * static_cast<double>(drawn.w_v.z) / static_cast<double>(drawn.pdf);
    sum += weight;
    squares += weight * (by_cosine ? static_cast<double>(f) * kPi : weight);
  }
  return squares / kCount - sum / kCount * sum / kCount;
}

TEST(ImportanceTable, VariesFarLessThanTheCosine) {
  const std::map<std::string, double> most = {
      {"paint", 0.02},        {"brushed", 0.01},          {"brushed aslant", 0.02},      {"one-sided", 0.05},
      {"mirror-like", 0.001}, {"back to the light", 0.1}, {"bright at the horizon", 0.1}};
  for (const Case& one : cases()) {
    const auto limit = most.find(one.name);
    if (limit == most.end()) continue;
    const ImportanceTable table = make_importance_table(one.brdf);
    for (const double theta : {0.0, 30.0, 60.0, 85.0}) {
      const glm::vec3 w_i = light(theta, 70);
      const double ratio =
          variance(one.brdf, table, w_i, false) / std::max(variance(one.brdf, table, w_i, true), 1e-12);
      EXPECT_LT(ratio, limit->second) << one.name << ' ' << theta;
    }
  }
}

TEST(ImportanceTable, FindsAHighlightAFiftiethOfADegreeWide) {
  const VectorBrdf brdf = brdf_of(needle, true);
  const ImportanceTable table = make_importance_table(brdf);
  for (const double theta : {0.0, 60.0, 85.0}) {
    const glm::vec3 w_i = light(theta, 70);
    EXPECT_LT(variance(brdf, table, w_i, false), 1e-5 * variance(brdf, table, w_i, true)) << theta;
  }
}

TEST(ImportanceTable, IsTheCosineForWhatIsMatt) {
  for (const Function function : {matt, nothing}) {
    const ImportanceTable table = make_importance_table(brdf_of(function, true));
    for (const double theta : {0.0, 20.0, 70.0, 88.0}) {
      for (const double theta_v : {0.0, 40.0, 89.0}) {
        const double cosine = std::cos(radians_from_degrees(theta_v));
        EXPECT_NEAR(table.pdf(light(theta, 0), light(theta_v, 50)), cosine / kPi, 1e-3 * cosine) << theta;
      }
    }
  }
}

TEST(ImportanceTable, TakesNegativeAndOtherUselessValuesAsZero) {
  const VectorBrdf zero = brdf_of(partly_zero, true);
  VectorBrdf useless = zero;
  useless.evaluate = [&](std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v, std::span<float> values) {
    constexpr std::array kUseless = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                                     -1e30F};
    zero.evaluate(w_i, w_v, values);
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (values[k] == 0) values[k] = kUseless[k % kUseless.size()];
    }
  };
  const ImportanceTable expected = make_importance_table(zero);
  const ImportanceTable negative = make_importance_table(brdf_of(partly_negative, true));
  const ImportanceTable table = make_importance_table(useless);
  std::mt19937_64 random(7);
  int drawn_in_vain = 0;
  for (int k = 0; k < 2000; ++k) {
    const glm::vec3 w_i = light(draw_uniform(random, 80), 0);
    const glm::dvec2 u = draw_square(random);
    const DrawnDirection drawn = expected.sample(w_i, u);
    EXPECT_EQ(table.sample(w_i, u).w_v, drawn.w_v);
    EXPECT_EQ(negative.sample(w_i, u).w_v, drawn.w_v);
    EXPECT_EQ(negative.sample(w_i, u).pdf, drawn.pdf);
    drawn_in_vain += partly_zero(glm::dvec3(w_i), glm::dvec3(drawn.w_v)) > 0 ? 0 : 1;
  }
  EXPECT_LT(drawn_in_vain, 300);
}

TEST(ImportanceTable, RefusesWhatIsNoDirectionAboveTheHorizon) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const glm::vec3 up(0.1F, 0.2F, 0.9F);
  const std::vector<glm::vec3> none = {{1, 0, 0},    {0, 1, -0.0F}, {0.1F, 0, -1},     {0, 0, 0},
                                       {kNan, 0, 1}, {0, 0, kNan},  {0, 0, kInfinity}, {kInfinity, 0, 1}};
  for (const Case& one : cases()) {
    const ImportanceTable table = make_importance_table(one.brdf);
    for (const glm::vec3& w : none) {
      EXPECT_EQ(table.pdf(w, up), 0) << one.name;
      EXPECT_EQ(table.pdf(up, w), 0) << one.name;
      EXPECT_EQ(table.sample(w, {0.3, 0.7}).pdf, 0) << one.name;
      EXPECT_EQ(table.sample(w, {0.3, 0.7}).w_v, glm::vec3(0, 0, 1)) << one.name;
    }
  }
}

TEST(ImportanceTable, TakesAnyNumbersForWhatIsDrawn) {
  for (const Case& one : cases()) {
    const ImportanceTable table = make_importance_table(one.brdf);
    const double below_one = std::nextafter(1.0, 0.0);
    for (const glm::vec3& w_i : {light(0, 0), light(89.9999, 12), light(45, 90), glm::vec3(1, 0, 1e-30F)}) {
      for (const double x : {-1.0, 0.0, 0.5, below_one, 1.0, 1e300, std::nan("")}) {
        for (const double y : {0.0, below_one, 7.0, std::nan("")}) {
          const DrawnDirection drawn = table.sample(w_i, {x, y});
          EXPECT_TRUE(drawn.pdf > 0 && std::isfinite(drawn.pdf)) << one.name << ' ' << x << ' ' << y;
          EXPECT_GT(drawn.w_v.z, 0) << one.name;
          EXPECT_NEAR(glm::length(drawn.w_v), 1, 1e-5) << one.name << ' ' << x << ' ' << y;
        }
      }
      EXPECT_EQ(table.sample(w_i, {1.0, 2.0}).w_v, table.sample(w_i, {below_one, below_one}).w_v) << one.name;
      EXPECT_EQ(table.sample(w_i, {std::nan(""), -3.0}).w_v, table.sample(w_i, {0.0, 0.0}).w_v) << one.name;
    }
  }
}

TEST(ImportanceTable, IsTheSameOnAnyNumberOfThreads) {
  for (const Case& one : cases()) {
    const ImportanceTable table = make_importance_table(one.brdf);
    const ThreadLimit limit(1);
    const ImportanceTable alone = make_importance_table(one.brdf);
    std::mt19937_64 random(8);
    for (int k = 0; k < 300; ++k) {
      const glm::vec3 w_i = light(draw_uniform(random, 90), draw_uniform(random, 360));
      const glm::dvec2 u = draw_square(random);
      EXPECT_EQ(table.sample(w_i, u).w_v, alone.sample(w_i, u).w_v) << one.name;
      EXPECT_EQ(table.sample(w_i, u).pdf, alone.sample(w_i, u).pdf) << one.name;
    }
  }
}

TEST(ImportanceTable, TurnsAndMirrorsWithTheLight) {
  const ImportanceTable table = make_importance_table(brdf_of(brushed, false));
  const ImportanceTable turned = make_importance_table(brdf_of(brushed_aslant, false));
  std::mt19937_64 random(9);
  for (int k = 0; k < 1000; ++k) {
    const glm::vec3 w_i = light(draw_uniform(random, 85), draw_uniform(random, 360));
    const glm::vec3 w_v = light(draw_uniform(random, 85), draw_uniform(random, 360));
    for (const glm::vec3& mirror : {glm::vec3(-1, 1, 1), glm::vec3(1, -1, 1), glm::vec3(-1, -1, 1)}) {
      EXPECT_EQ(table.pdf(w_i * mirror, w_v * mirror), table.pdf(w_i, w_v));
    }
    const glm::vec3 half_turn(-1, -1, 1);
    EXPECT_EQ(turned.pdf(w_i * half_turn, w_v * half_turn), turned.pdf(w_i, w_v));
  }
}

}  // namespace
}  // namespace sbrdf::internal
