#include "converters/files/rgl/rgl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "converters/files/rgl/rgl_tables.h"
#include "formats/rgl/rgl_material.h"
#include "tests/support/rgl_small_material.h"
#include "tests/support/test_data.h"

namespace sbrdf::internal::rgl_testing {
namespace {

using testing::HasSubstr;

double cosine_of(const Direction& direction) { return std::cos(direction.theta); }

constexpr std::array kMaterials = {"acrylic_felt_green_rgb.bsdf", "aurora_white_rgb.bsdf",
                                   "cc_green_malachite_rgb.bsdf", "chm_orange_rgb.bsdf", "vch_silk_blue_rgb.bsdf"};

/// Of the tree, made of a formula; specs/reference/make_rgl_material.py worked its values out.
const std::filesystem::path kVectors = SBRDF_SOURCE_DIR "/tests/vectors/rgl";

std::string measured(std::string_view name) { return "rgl/" + std::string(name); }

std::unique_ptr<BrdfSource> load_file(const std::filesystem::path& path) {
  auto source = load_rgl(read_bytes(path));
  EXPECT_TRUE(source.ok()) << source.error().message;
  return source.ok() ? std::move(source).value() : nullptr;
}
std::unique_ptr<BrdfSource> load_measured(std::string_view name) {
  return load_file(test_data(measured(name)).value());
}

struct ReferenceRow {
  std::string file;
  DirectionPair pair;
  std::array<double, 3> f_r_cos;
};

std::vector<ReferenceRow> read_reference(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::vector<ReferenceRow> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#') || line.starts_with("file,")) continue;
    std::ranges::replace(line, ',', ' ');
    std::istringstream words(line);
    ReferenceRow row;
    std::array<double, 4> angles{};
    words >> row.file;
    for (double& angle : angles) words >> angle;
    for (double& value : row.f_r_cos) words >> value;
    EXPECT_TRUE(words) << line;
    row.pair = pair_from_degrees(angles[0], angles[1], angles[2], angles[3]);
    rows.push_back(row);
  }
  return rows;
}

TEST(RglEvaluate, AgreesWithTheLoaderOfTheDatabase) {
  SBRDF_FIND_TEST_DATA(path, "rgl/reference_values.csv");
  std::map<std::string, std::unique_ptr<BrdfSource>> sources;
  for (const char* name : kMaterials) sources[name] = load_measured(name);
  const std::vector<ReferenceRow> rows = read_reference(path);
  ASSERT_EQ(rows.size(), 900u);
  double worst_relative = 0;
  for (const ReferenceRow& row : rows) {
    ASSERT_NE(sources[row.file], nullptr) << row.file;
    const std::array<float, 3> f_r = evaluate(*sources[row.file], row.pair);
    for (std::size_t c = 0; c < 3; ++c) {
      const double error = std::abs(f_r[c] * cosine_of(row.pair.v) - row.f_r_cos[c]);
      const double size = std::abs(row.f_r_cos[c]);
      EXPECT_LE(error, size > 1e-4 ? 1e-4 * size : 1e-7) << row.file << " channel " << c;
      if (size > 1e-4) worst_relative = std::max(worst_relative, error / size);
    }
  }
  RecordProperty("worst_relative_error", std::to_string(worst_relative));
}

TEST(RglEvaluate, AgreesWithAProgramWrittenFromTheSpecification) {
  const auto source = load_file(kVectors / "small.bsdf");
  const std::vector<ReferenceRow> rows = read_reference(kVectors / "small_reference.csv");
  ASSERT_EQ(rows.size(), 60u);
  for (const ReferenceRow& row : rows) {
    const std::array<float, 3> f_r = evaluate(*source, row.pair);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(f_r[c] * cosine_of(row.pair.v), row.f_r_cos[c], 1e-6 * row.f_r_cos[c]) << "channel " << c;
    }
  }
}

TEST(RglEvaluate, DescribesTheSmallMaterial) {
  const auto gold = load_file(kVectors / "small.bsdf");
  EXPECT_EQ(gold->traits().format, "rgl");
  EXPECT_EQ(gold->traits().description, "Rough gold, made of a formula");
  EXPECT_EQ(gold->traits().channels, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_TRUE(gold->traits().isotropic);
  EXPECT_FALSE(gold->traits().reciprocal);
  EXPECT_TRUE(gold->traits().findings.empty());
}

TEST(RglEvaluate, DescribesTheMeasuredMaterials) {
  SBRDF_FIND_TEST_DATA(path, measured(kMaterials[0]));
  const auto felt = load_measured(kMaterials[0]);
  EXPECT_EQ(felt->traits().format, "rgl");
  EXPECT_EQ(felt->traits().description, "Green acrylic felt (Edukit A4)");
  EXPECT_EQ(felt->traits().channels, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_TRUE(felt->traits().isotropic);
  EXPECT_FALSE(felt->traits().reciprocal);
  EXPECT_TRUE(felt->traits().findings.empty());
}

TEST(RglEvaluate, CountsTheNegativeCellsOfTheMeasuredMaterials) {
  SBRDF_FIND_TEST_DATA(path, measured(kMaterials[0]));
  const std::array<std::uint64_t, kMaterials.size()> counts = {0, 0, 2110, 230, 1720};
  for (std::size_t i = 0; i < kMaterials.size(); ++i) {
    const auto source = load_measured(kMaterials[i]);
    const auto& findings = source->traits().findings;
    if (counts[i] == 0) {
      EXPECT_TRUE(findings.empty()) << kMaterials[i];
      continue;
    }
    ASSERT_EQ(findings.size(), 1u) << kMaterials[i];
    EXPECT_EQ(findings[0].count, counts[i]) << kMaterials[i];
    EXPECT_EQ(findings[0].total, 1u * 8 * 3 * 32 * 32) << kMaterials[i];
  }
}

void expect_finite_everywhere(const BrdfSource& source, std::string_view name) {
  for (const double theta_i : {0.0, 1e-9, 30.0, 89.9999, 90.0}) {
    for (const double theta_v : {0.0, 1e-9, 30.0, 89.9999, 90.0}) {
      for (const double phi_v : {0.0, 1e-9, 90.0, 180.0, 270.0, 359.999999999}) {
        for (const float value : evaluate(source, pair_from_degrees(theta_i, 0, theta_v, phi_v))) {
          EXPECT_TRUE(std::isfinite(value)) << name << " " << theta_i << " " << theta_v << " " << phi_v;
        }
      }
    }
  }
}

TEST(RglEvaluate, IsFiniteForAllDirectionsOfTheSmallMaterial) {
  expect_finite_everywhere(*load_file(kVectors / "small.bsdf"), "small.bsdf");
}

TEST(RglEvaluate, IsFiniteForAllDirectionsOfTheMeasuredMaterials) {
  SBRDF_FIND_TEST_DATA(path, measured(kMaterials[0]));
  for (const char* name : kMaterials) expect_finite_everywhere(*load_measured(name), name);
}

/// f_r cos(theta_v) that does not depend on the channel is linear over the square of half directions.
SmallMaterial linear_in_half_direction() {
  SmallMaterial material;
  material.rgb = [](std::size_t, std::size_t channel, std::size_t x, std::size_t y) {
    return static_cast<float>(0.25 + double(channel) + 2 * double(x) + 4 * double(y));
  };
  return material;
}

/// Coordinates of the half direction; `theta_h` and `phi_h` in radians.
RglPoint square_of(double theta_h, double phi_h) {
  return {std::sqrt(theta_h * 2 / kPi), wrap(phi_h + kPi, 2 * kPi) / (2 * kPi)};
}

TEST(RglEvaluate, LooksColoursUpAtTheHalfDirectionWhereTheWarpIsUniform) {
  const auto source = load(linear_in_half_direction().fields());
  for (const double phi_i : {0.0, 50.0}) {
    const DirectionPair pair = pair_from_degrees(40, phi_i, 20, phi_i + 110);
    const HalfDifference half = half_difference_from_pair(pair);
    const RglPoint u = square_of(half.theta_h, half.phi_h - pair.i.phi);
    const std::array<float, 3> f_r = evaluate(*source, pair);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(f_r[c] * cosine_of(pair.v), 0.25 + double(c) + 2 * u.x + 4 * u.y, 1e-5);
    }
  }
}

TEST(RglEvaluate, AppliesTheJacobianOnlyWhereTheFileAsksForIt) {
  SmallMaterial material = linear_in_half_direction();
  const DirectionPair pair = pair_from_degrees(45, 0, 60, 90);
  const float plain = evaluate(*load(material.fields()), pair)[0];
  material.jacobian = 1;
  const float scaled = evaluate(*load(material.fields()), pair)[0];
  const RglPoint u_m = square_of(half_difference_from_pair(pair).theta_h, 0);
  const double ndf = 3 - 2 * u_m.x;
  const double sigma = 0.5 - 0.25 * std::sqrt(0.5);
  EXPECT_NEAR(scaled, plain * ndf / (4 * sigma), 1e-5 * scaled);
}

TEST(RglEvaluate, DependsOnTheDifferenceOfAzimuthsOnlyWhereIsotropic) {
  SmallMaterial material = linear_in_half_direction();
  material.jacobian = 1;
  material.phi_i = {-1, 1};
  material.sigma = {0.5f, 0.25f, 0.75f, 0.5f};
  material.rgb = [](std::size_t slice, std::size_t, std::size_t x, std::size_t) { return float(1 + slice + x); };
  const auto source = load(material.fields());
  EXPECT_TRUE(source->traits().isotropic);
  EXPECT_EQ(source->traits().slice_theta_max_deg, 80) << "f_r has a pole at the horizon";
  const std::array<float, 3> expected = evaluate(*source, pair_from_degrees(50, 0, 30, 100));
  for (const double turn : {10.0, 170.0, 200.0, 350.0}) {
    const std::array<float, 3> turned = evaluate(*source, pair_from_degrees(50, turn, 30, 100 + turn));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(turned[c], expected[c], 1e-5f * expected[c]);
  }
}

// As by a reader that works on unit vectors, whatever the tables say of an azimuth there.
TEST(RglEvaluate, GivesOneValueForOnePairAtTheNormal) {
  SmallMaterial material = linear_in_half_direction();
  material.jacobian = 1;
  material.sigma = {0.5f, 0.25f, 0.75f, 0.5f};
  material.vndf = [](std::size_t slice, std::size_t x, std::size_t y) { return float(1 + slice + x + 3 * y); };
  material.rgb = [](std::size_t slice, std::size_t, std::size_t x, std::size_t y) { return float(1 + slice + x + y); };
  const float pi = 3.1415927f;
  const std::vector<std::vector<float>> azimuths = {{0}, {-1, 1}, {-pi, -1, 2, pi}, {-pi, -1, 0}, {-pi, -2, -pi / 2}};
  for (const std::vector<float>& phi_i : azimuths) {
    material.phi_i = phi_i;
    const auto source = load(material.fields());
    const auto at = [&](double theta_i, double written_i, double theta_v, double written_v) {
      return evaluate(*source, pair_from_degrees(theta_i, written_i, theta_v, written_v));
    };
    for (const double written : {45.0, 77.0, 180.0, 300.0}) {
      EXPECT_EQ(at(0, written, 20, 30), at(0, 0, 20, 30)) << phi_i.size() << " azimuths";
      EXPECT_EQ(at(20, 30, 0, written), at(20, 30, 0, 0)) << phi_i.size() << " azimuths";
      EXPECT_EQ(at(0, written, 0, 0), at(0, 0, 0, written)) << phi_i.size() << " azimuths";
    }
  }
}

TEST(RglEvaluate, InterpolatesBetweenElevationsOfIncidence) {
  SmallMaterial material;
  material.rgb = [](std::size_t slice, auto...) { return static_cast<float>(1 + slice * slice); };
  const auto source = load(material.fields());
  const auto at = [&](double theta_i) { return evaluate(*source, {{theta_i, 0}, {0.25, 1}})[1] * std::cos(0.25); };
  EXPECT_NEAR(at(0), 1, 1e-6);
  EXPECT_NEAR(at(0.375), 1.5, 1e-6);
  EXPECT_NEAR(at(0.75), 2, 1e-6);
  EXPECT_NEAR(at((0.75 + kPi / 2) / 2), 3.5, 1e-6);
  EXPECT_NEAR(at(kPi / 2), 5, 1e-6);
}

TEST(RglEvaluate, HoldsTheLastNodeBeyondTheEndsOfAnAxis) {
  SmallMaterial material;
  material.theta_i = {0.5f, 1.0f};
  material.rgb = [](std::size_t slice, auto...) { return static_cast<float>(1 + slice); };
  const auto source = load(material.fields());
  EXPECT_FLOAT_EQ(evaluate(*source, {{0.25, 0}, {0, 0}})[0], 1);
  EXPECT_FLOAT_EQ(evaluate(*source, {{1.25, 0}, {0, 0}})[0], 2);
}

/// Colours that tell the azimuth of incidence by the slice and that of the half direction by y.
SmallMaterial anisotropic(std::vector<float> phi_i) {
  SmallMaterial material;
  material.theta_i = {0};
  material.rgb = [phi_i](std::size_t slice, std::size_t channel, std::size_t, std::size_t y) {
    return static_cast<float>(channel == 0 ? 10 + phi_i[slice] : 10 + double(channel) + 2 * double(y));
  };
  material.phi_i = std::move(phi_i);
  return material;
}

struct Azimuths {
  double phi_i;
  double phi_h;
};

/// What an anisotropic material shows for a pair: both azimuths [degrees] of the measured part of the turn.
Azimuths shown_azimuths(const BrdfSource& source, const DirectionPair& pair) {
  const std::array<float, 3> f_r = evaluate(source, pair);
  const double phi_i = f_r[0] * cosine_of(pair.v) - 10;
  const double u = (f_r[1] * cosine_of(pair.v) - 11) / 2;
  return {degrees_from_radians(phi_i), 360 * u - 180};
}

double half_azimuth_deg(const DirectionPair& pair) {
  return degrees_from_radians(half_difference_from_pair(pair).phi_h);
}

void expect_same_azimuth(double found, double expected) { EXPECT_NEAR(std::remainder(found - expected, 360), 0, 1e-3); }

TEST(RglEvaluate, UsesBothAzimuthsWhereAnisotropic) {
  const auto source = load(anisotropic({-3.1415927f, -1.5f, 0, 1.5f, 3.1415925f}).fields());
  EXPECT_FALSE(source->traits().isotropic);
  for (const double phi_i : {0.0, 20.0, 100.0, 179.0, 181.0, 300.0}) {
    const DirectionPair pair = pair_from_degrees(40, phi_i, 50, phi_i + 75);
    const Azimuths shown = shown_azimuths(*source, pair);
    EXPECT_NEAR(shown.phi_i, std::remainder(phi_i, 360), 1e-3);
    expect_same_azimuth(shown.phi_h, half_azimuth_deg(pair));
  }
}

TEST(RglEvaluate, TurnsThePairByAHalfTurnWhereHalfATurnWasMeasured) {
  const auto source = load(anisotropic({-3.1415927f, -1.5f, 0}).fields());
  for (const double phi_i : {10.0, 100.0, 170.0, 190.0, 280.0}) {
    const DirectionPair pair = pair_from_degrees(40, phi_i, 50, phi_i + 75);
    const Azimuths shown = shown_azimuths(*source, pair);
    const double turn = phi_i < 180 ? -180 : -360;
    EXPECT_NEAR(shown.phi_i, phi_i + turn, 1e-3);
    expect_same_azimuth(shown.phi_h, half_azimuth_deg(pair) + turn);
  }
}

TEST(RglEvaluate, MirrorsThePairWhereAQuarterTurnWasMeasured) {
  const auto source = load(anisotropic({-3.1415927f, -2.5f, -1.5707964f}).fields());
  const std::array<std::array<double, 2>, 4> mirrors = {{{1, 180}, {-1, 0}, {1, 0}, {-1, 180}}};
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    const auto [sign, turn] = mirrors[quarter];
    const double phi_i = 90.0 * double(quarter) + 20;
    const DirectionPair pair = pair_from_degrees(40, phi_i, 50, phi_i + 75);
    const Azimuths shown = shown_azimuths(*source, pair);
    EXPECT_LE(shown.phi_i, -90);
    expect_same_azimuth(shown.phi_i, sign * phi_i + turn);
    expect_same_azimuth(shown.phi_h, sign * half_azimuth_deg(pair) + turn);
  }
}

TEST(RglEvaluate, KeepsNegativeColours) {
  SmallMaterial material;
  material.rgb = [](std::size_t, std::size_t channel, auto...) { return channel == 2 ? -0.5f : 1.0f; };
  const auto source = load(material.fields());
  EXPECT_EQ(evaluate(*source, pair_from_degrees(30, 0, 0, 0))[2], -0.5f);
  ASSERT_EQ(source->traits().findings.size(), 1u);
  EXPECT_EQ(source->traits().findings[0].count, 12u);
  EXPECT_EQ(source->traits().findings[0].total, 36u);
}

// Green is negative where the half direction leans far.
TEST(RglNegatives, StayBecomeZeroOrMakeThePairUnmeasured) {
  SmallMaterial material;
  material.rgb = [](std::size_t, std::size_t channel, std::size_t x, std::size_t) {
    return channel == 1 && x == 1 ? -2.0f : 1.0f;
  };
  const Bytes file = emit(material.fields());
  const auto open = [&](const char* policy) {
    return open_rgl(std::make_shared<OwnedMemorySource>(file), Options().set("negatives", policy)).value();
  };
  const auto keep = open("keep");
  const auto clamp = open("clamp");
  const auto unmeasured = open("unmeasured");
  EXPECT_EQ(keep->mask_grid(), std::nullopt);
  EXPECT_EQ(clamp->mask_grid(), std::nullopt);
  ASSERT_TRUE(unmeasured->mask_grid().has_value());
  EXPECT_TRUE(unmeasured->mask_grid()->is_valid());
  std::size_t negative = 0;
  for (double theta = 0; theta < 90; theta += 5) {
    const DirectionPair pair = pair_from_degrees(theta, 0, theta, 10);
    const std::array<float, 3> kept = evaluate(*keep, pair);
    EXPECT_EQ(evaluate(*clamp, pair), (std::array<float, 3>{kept[0], std::max(kept[1], 0.0f), kept[2]}));
    std::uint8_t flag = 2;
    unmeasured->measured(std::span(&pair, 1), std::span(&flag, 1));
    EXPECT_EQ(flag, kept[1] < 0 ? 0 : 1) << theta;
    clamp->measured(std::span(&pair, 1), std::span(&flag, 1));
    EXPECT_EQ(flag, 1);
    negative += kept[1] < 0 ? 1 : 0;
  }
  EXPECT_GT(negative, 3U);
  EXPECT_LT(negative, 17U);
}

TEST(RglEvaluate, ReportsNegativeMicrofacetDensities) {
  SmallMaterial material;
  material.ndf[1] = -1;
  const auto source = load(material.fields());
  ASSERT_EQ(source->traits().findings.size(), 1u);
  EXPECT_THAT(source->traits().findings[0].what, HasSubstr("ndf"));
}

TEST(RglEvaluate, HoldsTheCosineAtItsFloorTowardsGrazing) {
  const auto source = load(SmallMaterial().fields());
  EXPECT_FLOAT_EQ(evaluate(*source, {{0.5, 0}, {std::acos(1e-3), 1}})[0], 1e3f);
  EXPECT_FLOAT_EQ(evaluate(*source, {{0.5, 0}, {kPi / 2, 1}})[0], static_cast<float>(1 / kRglMinCosine));
}

TEST(RglEvaluate, GivesZeroBelowTheHorizon) {
  const auto source = load(SmallMaterial().fields());
  const double below = std::nextafter(kPi / 2, 2);
  EXPECT_EQ(evaluate(*source, {{below, 0}, {0.5, 1}})[0], 0);
  EXPECT_EQ(evaluate(*source, {{0.5, 0}, {below, 1}})[0], 0);
  EXPECT_NE(evaluate(*source, {{kPi / 2, 0}, {0.5, 1}})[0], 0);
}

TEST(RglEvaluate, StaysFiniteForTheLargestAndSmallestNumbers) {
  static constexpr float kLargest = std::numeric_limits<float>::max();
  static constexpr float kSmallest = std::numeric_limits<float>::denorm_min();
  SmallMaterial material;
  material.jacobian = 1;
  material.vndf = [](std::size_t slice, auto...) { return slice == 0 ? kLargest : kSmallest; };
  material.rgb = [](auto...) { return kLargest; };
  material.sigma.assign(4, kSmallest);
  material.ndf.assign(4, kLargest);
  const auto source = load(material.fields());
  for (const double theta_i : {0.0, 20.0, 50.0, 90.0}) {
    EXPECT_EQ(evaluate(*source, pair_from_degrees(theta_i, 0, 90, 10))[0], kLargest);
  }
}

TEST(RglEvaluate, StaysFiniteWhereTheAreaFallsByManyPowers) {
  SmallMaterial material;
  material.jacobian = 1;
  material.rgb = [](std::size_t, std::size_t channel, auto...) { return channel == 1 ? 0.0f : 1.0f; };
  material.sigma = {1e30f, 1e-30f, 1e30f, 1e-30f};
  const auto source = load(material.fields());
  EXPECT_GT(evaluate(*source, pair_from_degrees(90, 0, 30, 10))[0], 1e29f);
  EXPECT_EQ(evaluate(*source, pair_from_degrees(90, 0, 30, 10))[1], 0.0f);
}

// The warp by itself.

/// Bilinear interpolation of one slice at u, not normalised.
double density_at(const std::vector<float>& density, const RglGrid& grid, const RglPoint& u) {
  return RglTable(grid, density).at(u);
}

/// Integral of the normalised density over [0, u.x] x [0, u.y] by the midpoint rule on a fine grid.
double integral_below(const std::vector<float>& density, const RglGrid& grid, const RglPoint& u) {
  constexpr int steps = 400;
  double sum = 0;
  double total = 0;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < steps; ++j) {
      const double x = (i + 0.5) / steps;
      const double y = (j + 0.5) / steps;
      sum += density_at(density, grid, {x * u.x, y * u.y});
      total += density_at(density, grid, {x, y});
    }
  }
  return sum * u.x * u.y / total;
}

std::vector<float> random_density(const RglGrid& grid, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> density(grid.cell_count());
  for (float& value : density) value = static_cast<float>(random() % 1000) / 100;
  return density;
}

TEST(RglEvaluate, WarpsByTheDistributionOfTheDensity) {
  const RglGrid grid = {5, 4};
  const std::vector<float> density = random_density(grid, 1);
  const RglWarp warp(grid, density);
  const RglSlices slices = {{0}, {1}, 1};
  for (const RglPoint u : {RglPoint{0.3, 0.7}, {0.75, 0.2}, {0.5, 0.999}, {0.01, 0.5}}) {
    const RglPoint found = warp.invert(u, slices);
    EXPECT_NEAR(found.y, integral_below(density, grid, {1, u.y}), 2e-5);
    const double step = 1e-3;
    const double along_row =
        integral_below(density, grid, {u.x, u.y + step / 2}) - integral_below(density, grid, {u.x, u.y - step / 2});
    const double whole_row =
        integral_below(density, grid, {1, u.y + step / 2}) - integral_below(density, grid, {1, u.y - step / 2});
    EXPECT_NEAR(found.x, along_row / whole_row, 2e-3);
  }
}

TEST(RglEvaluate, WarpsByTheMeanOfNormalisedSlices) {
  const RglGrid grid = {4, 6};
  const std::vector<float> first = random_density(grid, 2);
  std::vector<float> second = random_density(grid, 3);
  std::vector<float> both = first;
  both.insert(both.end(), second.begin(), second.end());
  const RglWarp warp(grid, both);
  const RglPoint u = {0.4, 0.6};
  const double y = 0.25 * warp.invert(u, {{0}, {1}, 1}).y + 0.75 * warp.invert(u, {{1}, {1}, 1}).y;
  EXPECT_NEAR(warp.invert(u, {{0, 1}, {0.25, 0.75}, 2}).y, y, 1e-6);
  for (float& value : second) value *= 1e-20f;
  std::ranges::copy(second, both.begin() + std::ptrdiff_t(first.size()));
  EXPECT_NEAR(RglWarp(grid, both).invert(u, {{0, 1}, {0.25, 0.75}, 2}).y, y, 1e-6);
}

TEST(RglEvaluate, WarpsTheSquareOntoItself) {
  const RglGrid grid = {7, 3};
  const RglWarp warp(grid, random_density(grid, 4));
  const RglSlices slices = {{0}, {1}, 1};
  EXPECT_EQ(warp.invert({0, 0}, slices).x, 0);
  EXPECT_EQ(warp.invert({0, 0}, slices).y, 0);
  EXPECT_NEAR(warp.invert({1, 1}, slices).x, 1, 1e-6);
  EXPECT_NEAR(warp.invert({1, 1}, slices).y, 1, 1e-6);
}

TEST(RglEvaluate, GivesTheFirstColumnForARowWithoutDensity) {
  const RglGrid grid = {2, 3};
  const RglWarp warp(grid, std::vector<float>{0, 0, 0, 0, 1, 1});
  EXPECT_EQ(warp.invert({0.5, 0.25}, {{0}, {1}, 1}).x, 0);
}

}  // namespace
}  // namespace sbrdf::internal::rgl_testing
