#include "converters/models/analytic.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

using Real = long double;
constexpr Real kPiExact = std::numbers::pi_v<Real>;

struct Vector {
  Real x, y, z;
};

Vector vector_of(const Direction& w) {
  const Real theta = w.theta, phi = w.phi;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

Real dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Real beckmann(const Vector& h, const AnalyticLobe& lobe) {
  const Real theta_h = std::atan2(std::hypot(h.x, h.y), h.z), phi_h = std::atan2(h.y, h.x);
  const Real m_x = lobe.m_x, m_y = lobe.m_y;
  const Real exponent = -std::pow(std::tan(theta_h), 2.0L) *
                        (std::pow(std::cos(phi_h), 2.0L) / (m_x * m_x) + std::pow(std::sin(phi_h), 2.0L) / (m_y * m_y));
  return std::exp(exponent) / (kPiExact * m_x * m_y * std::pow(std::cos(theta_h), 4.0L));
}

// The formula as it is printed, term by term.
Real transcribed(const AnalyticModel& model, std::size_t channel, const DirectionPair& pair) {
  const Vector l = vector_of(pair.i), v = vector_of(pair.v);
  Vector h = {l.x + v.x, l.y + v.y, l.z + v.z};
  const Real length = std::sqrt(dot(h, h));
  h = {h.x / length, h.y / length, h.z / length};
  Real sum = model.k_d[channel] / kPiExact;
  for (const AnalyticLobe& lobe : model.lobes) {
    const Real f_0 = lobe.f_0;
    const Real fresnel = f_0 + (1 - f_0) * std::pow(1 - dot(v, h), 5.0L);
    const Real cosines = std::pow(l.z * v.z, static_cast<Real>(lobe.alpha));
    sum += lobe.k_s[channel] * fresnel * beckmann(h, lobe) / (4 * dot(v, h) * cosines);
  }
  return sum;
}

std::array<float, 3> value_at(const BrdfSource& source, const DirectionPair& pair) {
  std::array<float, 3> value{};
  source.evaluate(std::span(&pair, 1), value);
  return value;
}

AnalyticModel model_of(const std::vector<AnalyticLobe>& lobes) { return {"test", {0.1, 0.2, 0.3}, lobes}; }

void expect_transcribed(const AnalyticModel& model, const DirectionPair& pair) {
  const auto value = value_at(*make_analytic_source(model), pair);
  for (std::size_t c = 0; c < 3; ++c) {
    const double expected = static_cast<double>(transcribed(model, c, pair));
    EXPECT_NEAR(value[c], expected, 1.2e-7 * expected)
        << model.name << " at " << pair.i.theta << " " << pair.i.phi << " " << pair.v.theta << " " << pair.v.phi;
  }
}

TEST(KurtMaterials, AreTheTenOfTable2) {
  const auto names = kurt_material_names();
  ASSERT_EQ(names.size(), 10u);
  for (const std::string& name : names) {
    const auto model = kurt_material(name);
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(model->name, name);
    EXPECT_EQ(model->lobes.size(), name.find("fabric") == 0 || name == "wood01" ? 2u : 1u);
    EXPECT_TRUE(check_analytic(*model).ok());
    EXPECT_FALSE(make_analytic_source(*model)->traits().isotropic);
  }
}

TEST(KurtMaterials, HaveTheirPublishedParameters) {
  const AnalyticModel fabric = kurt_material("fabric112").value();
  EXPECT_EQ(fabric.k_d, (std::array{0.0838, 0.0596, 0.0434}));
  EXPECT_EQ(fabric.lobes[0].k_s, (std::array{0.1419, 0.1078, 0.0521}));
  EXPECT_EQ(fabric.lobes[0].f_0, 1);
  EXPECT_EQ(fabric.lobes[0].m_x, 1.2101);
  EXPECT_EQ(fabric.lobes[0].m_y, 0.2139);
  EXPECT_EQ(fabric.lobes[0].alpha, 0);
  EXPECT_EQ(fabric.lobes[1].m_x, 0.7046);
  EXPECT_EQ(fabric.lobes[1].m_y, 1.2292);
  EXPECT_EQ(fabric.lobes[1].alpha, 0.976);
  const AnalyticModel alum = kurt_material("Brushed alum").value();
  EXPECT_EQ(alum.lobes[0].f_0, 0.999);
  EXPECT_EQ(alum.lobes[0].m_x, 0.035);
  EXPECT_EQ(alum.lobes[0].m_y, 0.129);
}

TEST(KurtMaterials, AreFoundInAnyCaseAndWithDashes) {
  for (const char* name : {"brushed alum", "BRUSHED-ALUM", "Brushed_Alum"}) {
    ASSERT_TRUE(kurt_material(name).ok()) << name;
    EXPECT_EQ(kurt_material(name)->name, "Brushed alum");
  }
  EXPECT_TRUE(kurt_material("WOOD01").ok());
}

TEST(KurtMaterials, UnknownNameListsTheKnownOnes) {
  for (const char* name : {"", "fabric", "fabric1120", "brushed"}) {
    const auto model = kurt_material(name);
    ASSERT_FALSE(model.ok()) << name;
    EXPECT_EQ(model.error().code, ErrorCode::kUsage);
    EXPECT_NE(model.error().message.find("wood01"), std::string::npos);
  }
}

TEST(KurtSource, MatchesTheFormulaAtRandomDirections) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> theta(0, kPi / 2 - kAnalyticGrazing), phi(-1, 7);
  for (const std::string& name : kurt_material_names()) {
    const AnalyticModel model = kurt_material(name).value();
    for (int n = 0; n < 500; ++n)
      expect_transcribed(model, {{theta(random), phi(random)}, {theta(random), phi(random)}});
  }
}

TEST(KurtSource, MatchesTheFormulaWhicheverLobeHasAnExponent) {
  const AnalyticLobe with{{0.1, 0.2, 0.3}, 0.5, 0.3, 0.6, 0.7}, without{{0.3, 0.2, 0.1}, 0.2, 0.9, 0.4, 0};
  for (const auto& lobes : {std::vector{with, without}, std::vector{without, with}, std::vector{without}}) {
    expect_transcribed(model_of(lobes), {{0.5, 1}, {0.9, 2.5}});
  }
}

TEST(KurtSource, MatchesTheFormulaAtPoleMirrorAndGrazing) {
  const double edge = kPi / 2 - kAnalyticGrazing;
  for (const std::string& name : kurt_material_names()) {
    const AnalyticModel model = kurt_material(name).value();
    for (const double theta : {1e-12, 1e-6, 0.7, edge}) {
      expect_transcribed(model, {{theta, 1}, {theta, 1}});
      expect_transcribed(model, {{theta, 1}, {theta / 2, 1 + 1e-9}});
      expect_transcribed(model, {{theta, 1}, {theta, 1 + 2}});
    }
  }
}

TEST(KurtSource, IsReciprocalBitForBit) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> theta(0, kPi / 2), phi(0, 2 * kPi);
  for (const std::string& name : kurt_material_names()) {
    const auto source = make_analytic_source(kurt_material(name).value());
    EXPECT_TRUE(source->traits().reciprocal);
    for (int n = 0; n < 200; ++n) {
      const Direction i{theta(random), phi(random)}, v{theta(random), phi(random)};
      EXPECT_EQ(value_at(*source, {i, v}), value_at(*source, {v, i}));
    }
  }
}

TEST(KurtSource, IsIsotropicOnlyIfEveryLobeIs) {
  const AnalyticLobe round{{0.1, 0.1, 0.1}, 0.5, 0.3, 0.3, 0.2}, long_one{{0.1, 0.1, 0.1}, 0.5, 0.3, 0.4, 0.2};
  EXPECT_TRUE(make_analytic_source(model_of({}))->traits().isotropic);
  EXPECT_TRUE(make_analytic_source(model_of({round, round}))->traits().isotropic);
  EXPECT_FALSE(make_analytic_source(model_of({round, long_one}))->traits().isotropic);
  EXPECT_FALSE(make_analytic_source(model_of({long_one, round}))->traits().isotropic);

  const auto source = make_analytic_source(model_of({round}));
  const auto expected = value_at(*source, {{0.5, 1}, {0.9, 2.5}});
  for (const double turn : {0.3, 2.0, 5.0}) {
    EXPECT_NEAR(value_at(*source, {{0.5, 1 + turn}, {0.9, 2.5 + turn}})[0], expected[0], 1e-6 * expected[0]);
  }
}

TEST(KurtSource, LobeIsLongAcrossTheSmallerRoughness) {
  const auto source = make_analytic_source(model_of({{{1, 1, 1}, 1, 0.05, 0.5, 0}}));
  const auto along_x = value_at(*source, {{0.2, 0}, {0.2, 0}}),
             along_y = value_at(*source, {{0.2, kPi / 2}, {0.2, kPi / 2}});
  EXPECT_LT(along_x[0], along_y[0]);
}

// With v = i, k_s = f_0 = 1, alpha = 0 and no diffuse part the value is D / 4.
TEST(KurtSource, DistributionOfNormalsIntegratesToOne) {
  for (const auto& [m_x, m_y] : {std::pair{0.3, 0.3}, std::pair{0.1, 0.6}, std::pair{1.2, 0.2}, std::pair{2.0, 2.6}}) {
    const auto source = make_analytic_source({"test", {0, 0, 0}, {{{1, 1, 1}, 1, m_x, m_y, 0}}});
    constexpr int kThetaCount = 2000, kPhiCount = 360;
    double sum = 0;
    for (int t = 0; t < kThetaCount; ++t) {
      const double theta = (t + 0.5) * (kPi / 2) / kThetaCount;
      for (int p = 0; p < kPhiCount; ++p) {
        const Direction w{theta, p * 2 * kPi / kPhiCount};
        sum += 4.0 * value_at(*source, {w, w})[0] * std::cos(theta) * std::sin(theta);
      }
    }
    EXPECT_NEAR(sum * (kPi / 2 / kThetaCount) * (2 * kPi / kPhiCount), 1, 1e-5) << m_x << " " << m_y;
  }
}

TEST(KurtSource, WithoutLobesIsDiffuse) {
  const auto source = make_analytic_source(model_of({}));
  for (const double theta : {0.0, 1.0, kPi / 2}) {
    EXPECT_FLOAT_EQ(value_at(*source, {{theta, 0}, {0.3, 2}})[2], static_cast<float>(0.3 / kPi));
  }
}

TEST(KurtSource, HoldsItsValueCloserToTheHorizonThanTheStatedAngle) {
  for (const std::string& name : kurt_material_names()) {
    const auto source = make_analytic_source(kurt_material(name).value());
    const double edge = kPi / 2 - kAnalyticGrazing;
    const auto expected = value_at(*source, {{edge, 0.4}, {edge, 2}});
    EXPECT_EQ(value_at(*source, {{kPi / 2, 0.4}, {kPi / 2, 2}}), expected);
    EXPECT_EQ(value_at(*source, {{kPi / 2 - kAnalyticGrazing / 2, 0.4}, {kPi / 2, 2}}), expected);
  }
}

TEST(KurtSource, IsZeroBelowTheHorizon) {
  const auto source = make_analytic_source(kurt_material("wood01").value());
  const double below = std::nextafter(kPi / 2, 2);
  EXPECT_EQ(value_at(*source, {{below, 0}, {0.2, 1}}), (std::array<float, 3>{}));
  EXPECT_EQ(value_at(*source, {{0.2, 0}, {3, 1}}), (std::array<float, 3>{}));
}

TEST(KurtSource, IsFiniteForEveryModelInRange) {
  const double most = kParameterLargest, least = 1 / kParameterLargest;
  const std::vector<double> thetas = {0, 1e-9, 0.5, kPi / 2 - 1e-5, kPi / 2}, phis = {0, 1, kPi / 2, kPi, 5};
  for (const double m_x : {least, 0.3, most}) {
    for (const double m_y : {least, 0.3, most}) {
      for (const double alpha : {0.0, 1.0, kLargestAlpha}) {
        const AnalyticModel model{"test", {most, 0, 0}, {{{most, 0, 1}, most, m_x, m_y, alpha}}};
        ASSERT_TRUE(check_analytic(model).ok());
        const auto source = make_analytic_source(model);
        for (const double theta_i : thetas) {
          for (const double theta_v : thetas) {
            for (const double phi : phis) {
              for (const float value : value_at(*source, {{theta_i, 0}, {theta_v, phi}})) {
                EXPECT_TRUE(std::isfinite(value) && value >= 0) << m_x << " " << m_y << " " << alpha;
              }
            }
          }
        }
      }
    }
  }
}

constexpr std::string_view kGoodJson =
    R"({"name": "n", "k_d": [0.1, 0, 1], "lobes": [{"k_s": [1, 2, 3], "f_0": 0.5, "m_x": 0.2, "m_y": 0.3, "alpha": 0}]})";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto position = text.find(from);
  EXPECT_NE(position, std::string::npos) << from;
  return text.replace(position, from.size(), to);
}

void expect_refused(const std::string& text, const std::string& words) {
  const auto model = parse_analytic_json(text);
  ASSERT_FALSE(model.ok()) << text;
  EXPECT_EQ(model.error().code, ErrorCode::kInvalidFile);
  EXPECT_NE(model.error().message.find(words), std::string::npos) << model.error().message;
  EXPECT_EQ(model.error().message.find('\n'), std::string::npos);
}

void expect_refused(const std::string& from, const std::string& to, const std::string& words) {
  expect_refused(replaced(std::string(kGoodJson), from, to), words);
}

TEST(KurtJson, ReadsEveryNumber) {
  const auto model = parse_analytic_json(kGoodJson);
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_EQ(model->name, "n");
  EXPECT_EQ(model->k_d, (std::array{0.1, 0.0, 1.0}));
  ASSERT_EQ(model->lobes.size(), 1u);
  EXPECT_EQ(model->lobes[0].k_s, (std::array{1.0, 2.0, 3.0}));
  EXPECT_EQ(model->lobes[0].f_0, 0.5);
  EXPECT_EQ(model->lobes[0].m_x, 0.2);
  EXPECT_EQ(model->lobes[0].m_y, 0.3);
  EXPECT_EQ(model->lobes[0].alpha, 0);
}

TEST(KurtJson, TakesAnyNumberOfLobes) {
  const std::string lobe = R"({"k_s": [1, 2, 3], "f_0": 0.5, "m_x": 0.2, "m_y": 0.3, "alpha": 0})";
  EXPECT_EQ(parse_analytic_json(replaced(std::string(kGoodJson), lobe, ""))->lobes.size(), 0u);
  EXPECT_EQ(parse_analytic_json(replaced(std::string(kGoodJson), lobe, lobe + "," + lobe + "," + lobe))->lobes.size(),
            3u);
}

TEST(KurtJson, NamesTheKeyOfAWrongType) {
  expect_refused(R"("n")", "3", "name must be a string");
  expect_refused("[0.1, 0, 1]", "0.1", "k_d must be an array of 3 numbers");
  expect_refused("[0.1, 0, 1]", "[0.1, 0]", "k_d must be an array of 3 numbers");
  expect_refused("[0.1, 0, 1]", "[0.1, 0, 1, 1]", "k_d must be an array of 3 numbers");
  expect_refused("[0.1, 0, 1]", "[0.1, null, 1]", "k_d[1] must be a number");
  expect_refused("[1, 2, 3]", R"(["1", 2, 3])", "lobes[0].k_s[0] must be a number");
  expect_refused("0.2", "true", "lobes[0].m_x must be a number");
  expect_refused("0.5", "[0.5]", "lobes[0].f_0 must be a number");
  expect_refused(R"("lobes": [)", R"("lobes": [3, )", "lobes[0] must be an object");
  expect_refused(R"({"name": "n", "k_d": [0, 0, 0], "lobes": {}})", "lobes must be an array");
  for (const char* text : {"[]", "3", "null", "\"text\""}) expect_refused(text, "must be an object");
}

TEST(KurtJson, NamesAMissingKey) {
  expect_refused(R"("name": "n", )", "", "name is missing");
  expect_refused(R"("k_d": [0.1, 0, 1], )", "", "k_d is missing");
  expect_refused(R"({"name": "n", "k_d": [0, 0, 0]})", "lobes is missing");
  expect_refused(R"("k_s": [1, 2, 3], )", "", "lobes[0].k_s is missing");
  expect_refused(R"("f_0": 0.5, )", "", "lobes[0].f_0 is missing");
  expect_refused(R"("m_x": 0.2, )", "", "lobes[0].m_x is missing");
  expect_refused(R"("m_y": 0.3, )", "", "lobes[0].m_y is missing");
  expect_refused(R"(, "alpha": 0)", "", "lobes[0].alpha is missing");
}

TEST(KurtJson, NamesAnUnknownOrRepeatedKey) {
  expect_refused(R"("name": "n")", R"("name": "n", "gamma": 2)", R"("gamma" is not a known key)");
  expect_refused(R"("f_0")", R"("F_0": 1, "f_0")", R"(lobes[0]."F_0" is not a known key)");
  expect_refused(R"("name": "n")", R"("name": "n", "line\nbreak": 2)", R"("line\nbreak" is not a known key)");
  expect_refused(R"("m_x": 0.2)", R"("m_x": 0.2, "m_x": 0.4)", R"("m_x" is repeated)");
}

TEST(KurtJson, NamesANumberOutOfRange) {
  expect_refused("[0.1, 0, 1]", "[0.1, -1e-9, 1]", "k_d[1] is -1e-09");
  expect_refused("[1, 2, 3]", "[1, 2, -3]", "lobes[0].k_s[2] is -3");
  expect_refused("[1, 2, 3]", "[1, 2, 1e7]", "lobes[0].k_s[2] is 10000000");
  expect_refused("0.5", "-0.5", "lobes[0].f_0 is -0.5");
  expect_refused("0.2", "0", "lobes[0].m_x is 0");
  expect_refused("0.3", "-0.3", "lobes[0].m_y is -0.3");
  expect_refused("0.3", "1e-300", "lobes[0].m_y is 1e-300");
  expect_refused(R"("alpha": 0)", R"("alpha": -1)", "lobes[0].alpha is -1");
  expect_refused(R"("alpha": 0)", R"("alpha": 11)", "lobes[0].alpha is 11");
  expect_refused("0.5", "1e999", "beyond the range of double");
}

TEST(KurtJson, RefusesControlCharactersInTheName) { expect_refused(R"("n")", R"("n\nm")", "control character"); }

TEST(KurtJson, RefusesEveryTruncatedPrefix) {
  for (std::size_t size = 0; size < kGoodJson.size(); ++size) {
    expect_refused(std::string(kGoodJson.substr(0, size)), "no valid JSON");
  }
}

TEST(KurtJson, RefusesWhatIsNoJson) {
  for (const char* text : {"# a text file", "{,}", "{\"name\": NaN}", "[Infinity]", "\xff\xfe", "\"\xff\""}) {
    expect_refused(text, "no valid JSON");
  }
  expect_refused(std::string(kGoodJson) + "x", "no valid JSON");
  EXPECT_EQ(parse_analytic_json("{,}").error().offset, 1u);
}

TEST(KurtJson, TakesDeepNestingWithoutExhaustingTheStack) {
  expect_refused(std::string(200000, '['), "no valid JSON");
  expect_refused(std::string(200000, '[') + std::string(200000, ']'), "must be an object");
}

TEST(KurtModelCheck, RefusesNanAndInfinity) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    AnalyticModel model = model_of({{{1, 1, 1}, 1, 1, 1, 0}});
    model.lobes[0].m_y = bad;
    const Status status = check_analytic(model);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, ErrorCode::kUsage);
    EXPECT_NE(status.error().message.find("lobes[0].m_y"), std::string::npos);
  }
}

}  // namespace
}  // namespace sbrdf::internal
