#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "converters/files/merl/merl_source.h"
#include "converters/files/merl/merl_writer.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

MerlTable random_table(const MerlShape& shape, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(1, 1000);
  MerlTable table{shape, std::vector<double>(3 * merl_cell_count(shape))};
  for (double& v : table.values) v = value(random);
  return table;
}

double& value_of(MerlTable& table, std::size_t c, std::uint64_t h, std::uint64_t d, std::uint64_t p) {
  const MerlShape& n = table.shape;
  return table.values[((c * n[0] + h) * n[1] + d) * n[2] + p];
}

void mark(MerlTable& table, std::uint64_t h, std::uint64_t d, std::uint64_t p) {
  for (std::size_t c = 0; c < 3; ++c) value_of(table, c, h, d, p) = -1;
}

/// The pair whose positions along the three axes, in cells, are these; phi_h as given.
DirectionPair pair_at(const MerlShape& shape, double h, double d, double p, double phi_h = 0) {
  return pair_from_half_difference(
      {h * h / (shape[0] * shape[0]) * kPi / 2, phi_h, d / shape[1] * kPi / 2, p / shape[2] * kPi});
}

bool is_above(const DirectionPair& pair) { return pair.i.theta <= kPi / 2 && pair.v.theta <= kPi / 2; }

std::array<float, 3> value_at(const BrdfSource& source, const DirectionPair& pair) {
  std::array<float, 3> value{};
  source.evaluate(std::span(&pair, 1), value);
  return value;
}

Result<std::unique_ptr<MerlSource>> make_source(const MerlTable& table) {
  return MerlSource::make(std::make_shared<OwnedMemorySource>(emit_merl(table)));
}

std::unique_ptr<MerlSource> source_of(const MerlTable& table) {
  auto source = make_source(table);
  EXPECT_TRUE(source.ok());
  return std::move(source).value();
}

class RgbFunctionSource final : public BrdfSource {
 public:
  using Function = std::function<std::vector<float>(const DirectionPair&)>;
  RgbFunctionSource(std::size_t channels, Function function) : function_(std::move(function)) {
    traits_.channels.assign(channels, "x");
    traits_.isotropic = traits_.reciprocal = true;
  }
  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  [[nodiscard]] SourceTraits& traits() { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      std::ranges::copy(function_(pairs[n]), values.begin() + static_cast<std::ptrdiff_t>(n * channel_count()));
    }
  }

 private:
  Function function_;
  SourceTraits traits_;
};

RgbFunctionSource constant_source(std::vector<float> value) {
  const std::size_t channels = value.size();
  return {channels, [value = std::move(value)](const DirectionPair&) { return value; }};
}

struct Resampling {
  MerlTable table;
  MerlReport report;
};

/// The table that resample_merl writes, as a reader gets it.
Result<Resampling> resample(const BrdfSource& source, const MerlShape& shape, const Progress& progress = {}) {
  MemorySink sink;
  const Result<MerlReport> report = resample_merl(source, shape, sink, progress);
  if (!report) return report.error();
  return Resampling{parse_merl(std::move(sink).take()).value(), *report};
}

TEST(MerlSource, GivesScaledValuesAtCellCentres) {
  MerlTable table = random_table({5, 4, 6});
  const auto source = source_of(table);
  int tested = 0;
  for (std::uint32_t h = 0; h < 5; ++h) {
    for (std::uint32_t d = 0; d < 4; ++d) {
      for (std::uint32_t p = 0; p < 6; ++p) {
        const DirectionPair pair = pair_at(table.shape, h + 0.5, d + 0.5, p + 0.5, 0.7);
        if (!is_above(pair)) continue;
        const auto value = value_at(*source, pair);
        EXPECT_NEAR(value[0] / (value_of(table, 0, h, d, p) * 1.00 / 1500), 1, 1e-6);
        EXPECT_NEAR(value[1] / (value_of(table, 1, h, d, p) * 1.15 / 1500), 1, 1e-6);
        EXPECT_NEAR(value[2] / (value_of(table, 2, h, d, p) * 1.66 / 1500), 1, 1e-6);
        ++tested;
      }
    }
  }
  EXPECT_GT(tested, 60);
}

TEST(MerlSource, InterpolatesBetweenCentresAlongEachAxis) {
  MerlTable table = random_table({5, 4, 6});
  const auto source = source_of(table);
  const auto red = [&](double h, double d, double p) { return value_at(*source, pair_at(table.shape, h, d, p))[0]; };
  const auto cell = [&](std::uint64_t h, std::uint64_t d, std::uint64_t p) {
    return value_of(table, 0, h, d, p) / 1500;
  };
  EXPECT_NEAR(red(1.75, 1.5, 2.5), 0.75 * cell(1, 1, 2) + 0.25 * cell(2, 1, 2), 1e-6);
  EXPECT_NEAR(red(1.5, 1.75, 2.5), 0.75 * cell(1, 1, 2) + 0.25 * cell(1, 2, 2), 1e-6);
  EXPECT_NEAR(red(1.5, 1.5, 2.75), 0.75 * cell(1, 1, 2) + 0.25 * cell(1, 1, 3), 1e-6);
  EXPECT_NEAR(
      red(1.75, 1.75, 2.5),
      0.75 * (0.75 * cell(1, 1, 2) + 0.25 * cell(1, 2, 2)) + 0.25 * (0.75 * cell(2, 1, 2) + 0.25 * cell(2, 2, 2)),
      1e-6);
}

TEST(MerlSource, PhiDClosesAfterPi) {
  MerlTable table = random_table({5, 4, 6});
  const auto source = source_of(table);
  const double first = value_of(table, 0, 1, 1, 0) / 1500, last = value_of(table, 0, 1, 1, 5) / 1500;
  for (const double turn : {0.0, 6.0}) {
    EXPECT_NEAR(value_at(*source, pair_at(table.shape, 1.5, 1.5, 0.25 + turn))[0], 0.75 * first + 0.25 * last, 1e-6);
    EXPECT_NEAR(value_at(*source, pair_at(table.shape, 1.5, 1.5, 5.75 + turn))[0], 0.25 * first + 0.75 * last, 1e-6);
    EXPECT_NEAR(value_at(*source, pair_at(table.shape, 1.5, 1.5, 0 + turn))[0], 0.5 * first + 0.5 * last, 1e-6);
  }
}

TEST(MerlSource, HoldsTheOuterCellsToTheEndsOfTheirAxes) {
  MerlTable table = random_table({5, 4, 6});
  const auto source = source_of(table);
  EXPECT_NEAR(value_at(*source, pair_at(table.shape, 0.1, 1.5, 2.5))[0], value_of(table, 0, 0, 1, 2) / 1500, 1e-6);
  EXPECT_NEAR(value_at(*source, pair_at(table.shape, 1.5, 0.1, 2.5))[0], value_of(table, 0, 1, 0, 2) / 1500, 1e-6);
  EXPECT_NEAR(value_at(*source, pair_at(table.shape, 4.9, 0.1, 2.5))[0], value_of(table, 0, 4, 0, 2) / 1500, 1e-6);
  EXPECT_NEAR(value_at(*source, pair_at(table.shape, 0.1, 3.9, 2.5))[0], value_of(table, 0, 0, 3, 2) / 1500, 1e-6);
}

TEST(MerlSource, WorksWithOneCellAlongEachAxis) {
  const auto source = source_of({{1, 1, 1}, {1500, 3000, 4500}});
  for (const double theta : {0.0, 0.5, kPi / 2}) {
    for (const double phi : {0.0, 1.0, 3.2}) {
      EXPECT_NEAR(value_at(*source, {{theta, phi}, {0.3, 0}})[1], 2 * 1.15, 1e-6);
    }
  }
}

TEST(MerlSource, IsIsotropicAndReciprocal) {
  const auto source = source_of(random_table({9, 8, 10}));
  EXPECT_TRUE(source->traits().isotropic);
  EXPECT_TRUE(source->traits().reciprocal);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> theta(0, kPi / 2), phi(0, 2 * kPi);
  for (int n = 0; n < 5000; ++n) {
    const Direction i{theta(random), phi(random)}, v{theta(random), phi(random)};
    const double turn = phi(random);
    const auto value = value_at(*source, {i, v});
    const auto swapped = value_at(*source, {v, i});
    const auto turned = value_at(*source, {{i.theta, i.phi + turn}, {v.theta, v.phi + turn}});
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(swapped[c], value[c], 1e-5f * value[c]);
      EXPECT_NEAR(turned[c], value[c], 1e-5f * value[c]);
    }
  }
}

TEST(MerlSource, TurnsFreelyWhereTheHalfVectorIsTheNormal) {
  const auto source = source_of(random_table({9, 8, 10}));
  for (int theta_deg = 0; theta_deg <= 90; theta_deg += 10) {
    const auto expected =
        value_at(*source, {direction_from_degrees(theta_deg, 0), direction_from_degrees(theta_deg, 180)});
    for (int phi_deg = 0; phi_deg < 360; phi_deg += 2) {
      const DirectionPair pair{direction_from_degrees(theta_deg, phi_deg),
                               direction_from_degrees(theta_deg, phi_deg + 180)};
      EXPECT_NEAR(value_at(*source, pair)[0], expected[0], 1e-6f * expected[0]) << theta_deg << " " << phi_deg;
    }
  }
}

TEST(MerlSource, LeavesMarksOutOfTheInterpolation) {
  MerlTable table = random_table({5, 4, 6});
  mark(table, 2, 1, 2);
  const auto source = source_of(table);
  const double neighbour = value_of(table, 0, 1, 1, 2) / 1500;
  EXPECT_NEAR(value_at(*source, pair_at(table.shape, 1.5, 1.5, 2.5))[0], neighbour, 1e-6);
  EXPECT_NEAR(value_at(*source, pair_at(table.shape, 2.0, 1.5, 2.5))[0], neighbour, 1e-6);
  EXPECT_NEAR(value_at(*source, pair_at(table.shape, 2.4, 1.5, 2.5))[0], neighbour, 1e-6);
}

TEST(MerlSource, IsZeroWhereOnlyMarksAreNear) {
  MerlTable table = random_table({5, 4, 6});
  for (std::uint64_t h = 1; h <= 2; ++h) {
    for (std::uint64_t p = 0; p < 6; ++p) mark(table, h, 1, p);
  }
  const auto source = source_of(table);
  for (const float value : value_at(*source, pair_at(table.shape, 2.0, 1.5, 2.9))) EXPECT_EQ(value, 0);
}

TEST(MerlSource, IsNotBlackAtTheHorizonWhereCellsBelowItAreMarks) {
  const MerlShape shape = {30, 30, 60};
  MerlTable table = random_table(shape);
  for (std::uint64_t cell = 0; cell < merl_cell_count(shape); ++cell) {
    if (is_above(merl_cell_centre(shape, cell))) continue;
    for (std::size_t c = 0; c < 3; ++c) table.values[c * merl_cell_count(shape) + cell] = -1;
  }
  const auto source = source_of(table);
  for (const double theta_i : {0.0, 40.0, 80.0, 88.0, 89.5, 90.0}) {
    for (double phi = 0; phi < 180; phi += 2.5) {
      const DirectionPair pair = {direction_from_degrees(theta_i, 0), direction_from_degrees(90, phi)};
      if (!is_above(pair)) continue;
      EXPECT_GT(value_at(*source, pair)[0], 0) << theta_i << ", " << phi;
    }
  }
}

TEST(MerlSource, UsesCellsWithSomeNegativeChannelAsTheyAre) {
  MerlTable table = random_table({5, 4, 6});
  value_of(table, 0, 1, 1, 2) = -30;
  value_of(table, 1, 1, 1, 2) = 15;
  value_of(table, 2, 1, 1, 2) = -0.5;
  const auto source = source_of(table);
  const auto value = value_at(*source, pair_at(table.shape, 1.5, 1.5, 2.5));
  EXPECT_NEAR(value[0], -30 / 1500.0, 1e-7);
  EXPECT_NEAR(value[1], 15 * 1.15 / 1500, 1e-7);
  EXPECT_NEAR(value[2], -0.5 * 1.66 / 1500, 1e-8);
}

TEST(MerlSource, ReportsMarksAndMixedCells) {
  MerlTable table = random_table({5, 4, 6});
  EXPECT_TRUE(source_of(table)->findings().empty());
  mark(table, 0, 0, 0);
  mark(table, 4, 3, 5);
  value_of(table, 1, 2, 2, 2) = -1e-9;
  const auto source = source_of(table);
  const auto& findings = source->findings();
  ASSERT_EQ(findings.size(), 3u);
  EXPECT_EQ(findings[0].count, 2u);
  EXPECT_EQ(findings[0].total, 120u);
  EXPECT_EQ(findings[1].count, 1u) << "above the horizon";
  EXPECT_EQ(findings[2].count, 1u);
}

TEST(MerlSource, IsZeroBelowTheHorizon) {
  const auto source = source_of(random_table({5, 4, 6}));
  const double below = std::nextafter(kPi / 2, 2);
  for (const float value : value_at(*source, {{below, 0}, {0.1, 0}})) EXPECT_EQ(value, 0);
  for (const float value : value_at(*source, {{0.1, 0}, {below, 0}})) EXPECT_EQ(value, 0);
  EXPECT_GT(value_at(*source, {{kPi / 2, 0}, {kPi / 2, 1}})[0], 0);
}

TEST(MerlSource, KeepsTheTableBitForBit) {
  MerlTable table = random_table({5, 4, 6});
  mark(table, 1, 2, 3);
  value_of(table, 0, 0, 0, 0) = -0.0;
  const auto source = source_of(table);
  const std::shared_ptr<const ByteSource> stored = source->stored("merl");
  ASSERT_NE(stored, nullptr);
  EXPECT_EQ(read_range(*stored, 0, stored->size()).value(), emit_merl(table));
  EXPECT_EQ(source->stored("sbrdf"), nullptr);
}

TEST(MerlSource, RefusesNanAndInfinityAndNamesTheFirst) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity(), 1e300, -1e45}) {
    MerlTable table = random_table({5, 4, 6});
    value_of(table, 1, 2, 3, 4) = bad;
    value_of(table, 2, 0, 0, 1) = bad;
    const auto source = make_source(table);
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error().code, ErrorCode::kInvalidFile);
    EXPECT_EQ(source.error().offset, 12u + 8u * (120 + 48 + 18 + 4));
    EXPECT_EQ(source.error().message.substr(0, 9), "2 of 360 ");
    EXPECT_NE(source.error().message.find("theta_h 2, theta_d 3, phi_d 4, channel G"), std::string::npos)
        << source.error().message;
  }
}

TEST(MerlSource, RefusesTablesWithNothingPositive) {
  for (const double value : {0.0, -0.0, -1.0}) {
    const auto source = make_source({{2, 2, 2}, std::vector<double>(24, value)});
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error().code, ErrorCode::kInvalidFile);
    EXPECT_NE(source.error().message.find("positive"), std::string::npos);
  }
}

TEST(MerlResample, EvaluatesCellCentresAndMarksThoseBelowTheHorizon) {
  const RgbFunctionSource source(3, [](const DirectionPair& pair) -> std::vector<float> {
    const HalfDifference angles = half_difference_from_pair(pair);
    return {static_cast<float>(angles.theta_h), static_cast<float>(angles.theta_d), static_cast<float>(angles.phi_d)};
  });
  auto result = resample(source, {12, 10, 14});
  ASSERT_TRUE(result.ok());
  MerlTable& table = result->table;
  std::uint64_t below = 0;
  for (std::uint32_t h = 0; h < 12; ++h) {
    for (std::uint32_t d = 0; d < 10; ++d) {
      for (std::uint32_t p = 0; p < 14; ++p) {
        const double theta_h = (h + 0.5) * (h + 0.5) / 144 * kPi / 2, theta_d = (d + 0.5) / 10 * kPi / 2;
        const double phi_d = (p + 0.5) / 14 * kPi;
        // The lower of the two directions has the elevation cosine cos cos - |sin sin cos phi_d|.
        const bool is_below =
            std::cos(theta_h) * std::cos(theta_d) < std::fabs(std::sin(theta_h) * std::sin(theta_d) * std::cos(phi_d));
        below += is_below ? 1 : 0;
        EXPECT_NEAR(value_of(table, 0, h, d, p), is_below ? -1 : theta_h * 1500, 1e-3);
        EXPECT_NEAR(value_of(table, 1, h, d, p), is_below ? -1 : theta_d * 1500 / 1.15, 1e-3);
        EXPECT_NEAR(value_of(table, 2, h, d, p), is_below ? -1 : phi_d * 1500 / 1.66, 1e-3);
      }
    }
  }
  EXPECT_EQ(result->report.cells, 12u * 10 * 14);
  EXPECT_EQ(result->report.below_horizon, below);
  EXPECT_GT(below, 0u);
}

TEST(MerlResample, OfATableAtItsOwnShapeReturnsItsValues) {
  MerlTable table = random_table({9, 8, 10});
  value_of(table, 2, 3, 3, 3) = -7;
  const auto result = resample(*source_of(table), table.shape);
  ASSERT_TRUE(result.ok());
  int compared = 0;
  for (std::size_t n = 0; n < table.values.size(); ++n) {
    const std::size_t cell = n % 720;
    const bool is_below = result->table.values[cell] == -1 && result->table.values[720 + cell] == -1;
    if (is_below) continue;
    EXPECT_NEAR(result->table.values[n] / table.values[n], 1, 1e-6) << n;
    ++compared;
  }
  EXPECT_GT(compared, 1000);
  EXPECT_EQ(result->report.some_negative, 1u);
}

TEST(MerlResample, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto source = source_of(random_table({9, 8, 10}));
  std::vector<std::vector<std::byte>> files;
  for (const std::size_t threads : {1u, 2u, 5u}) {
    const ThreadLimit limit(threads);
    files.push_back(emit_merl(resample(*source, {20, 20, 20})->table));
  }
  EXPECT_EQ(files[0], files[1]);
  EXPECT_EQ(files[0], files[2]);
}

TEST(MerlResample, CountsNegativeCells) {
  const auto some = resample(constant_source({1, -1, 1}), {4, 4, 4});
  ASSERT_TRUE(some.ok());
  EXPECT_EQ(some->report.some_negative, 64 - some->report.below_horizon);
  EXPECT_EQ(some->report.all_negative, 0u);
  // Positive in the four cells of the first row.
  const RgbFunctionSource source(3, [](const DirectionPair& pair) -> std::vector<float> {
    const HalfDifference angles = half_difference_from_pair(pair);
    return angles.theta_h < 0.05 && angles.theta_d < 0.3 ? std::vector<float>{1, 1, 1} : std::vector<float>{-1, -2, -1};
  });
  const auto all = resample(source, {4, 4, 4});
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->report.some_negative, 0u);
  EXPECT_EQ(all->report.all_negative, 60 - all->report.below_horizon);
}

TEST(MerlResample, WritesNothingThatNoReaderTakes) {
  for (const float value : {0.0F, -0.0F, -1.0F}) {
    const auto nothing_positive = resample(constant_source({value, value, value}), {4, 4, 4});
    ASSERT_FALSE(nothing_positive.ok());
    EXPECT_EQ(nothing_positive.error().code, ErrorCode::kInvalidFile);
    EXPECT_NE(nothing_positive.error().message.find("positive"), std::string::npos);
  }
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), infinity, -infinity, 2e38F, -2e38F}) {
    const auto too_large = resample(constant_source({1, value, 1}), {4, 4, 4});
    ASSERT_FALSE(too_large.ok());
    EXPECT_EQ(too_large.error().code, ErrorCode::kInvalidFile);
    EXPECT_NE(too_large.error().message.find("channel G"), std::string::npos) << too_large.error().message;
  }
}

TEST(MerlResample, WritesWhatMerlSourceReadsUpToTheLargestValue) {
  for (const float value : {1e-45F, 1.0F, 9.9e37F}) {
    MemorySink sink;
    ASSERT_TRUE(resample_merl(constant_source({value, value, -value}), {4, 4, 4}, sink).ok());
    EXPECT_TRUE(MerlSource::make(std::make_shared<OwnedMemorySource>(std::move(sink).take())).ok()) << value;
  }
}

TEST(MerlResample, GivesTheSameFileInManyBlocksAsInOne) {
  const RgbFunctionSource source(3, [](const DirectionPair& pair) -> std::vector<float> {
    return {static_cast<float>(pair.i.theta), static_cast<float>(pair.v.theta), 1};
  });
  const auto table = resample(source, {60, 60, 40});  // 144,000 cells, two blocks
  ASSERT_TRUE(table.ok());
  for (const std::uint64_t cell :
       {std::uint64_t{0}, std::uint64_t{131'071}, std::uint64_t{131'072}, std::uint64_t{143'999}}) {
    const std::uint64_t row = cell / 40;
    const DirectionPair pair = pair_from_half_difference({merl_theta_h(static_cast<double>(row / 60) + 0.5, 60), 0,
                                                          merl_theta_d(static_cast<double>(row % 60) + 0.5, 60),
                                                          merl_phi_d(static_cast<double>(cell % 40) + 0.5, 40)});
    const double expected = is_above(pair) ? static_cast<float>(pair.i.theta) / kMerlScale[0] : -1;
    EXPECT_EQ(table->table.values[cell], expected) << cell;
  }
}

TEST(MerlResample, SaysWhatTheSourceLoses) {
  RgbFunctionSource source = constant_source({1, 1, 1});
  const auto nothing = resample(source, {2, 2, 2});
  EXPECT_FALSE(nothing->report.anisotropic_source_cut);
  EXPECT_FALSE(nothing->report.source_not_reciprocal);
  EXPECT_FALSE(nothing->report.channel_repeated);
  source.traits().isotropic = source.traits().reciprocal = false;
  const auto both = resample(source, {2, 2, 2});
  EXPECT_TRUE(both->report.anisotropic_source_cut);
  EXPECT_TRUE(both->report.source_not_reciprocal);
}

TEST(MerlResample, RepeatsASingleChannel) {
  const auto result = resample(constant_source({0.5f}), {1, 2, 2});
  ASSERT_TRUE(result.ok());
  EXPECT_TRUE(result->report.channel_repeated);
  EXPECT_NEAR(result->table.values[0], 0.5 * 1500, 1e-9);
  EXPECT_NEAR(result->table.values[4], 0.5 * 1500 / 1.15, 1e-9);
  EXPECT_NEAR(result->table.values[8], 0.5 * 1500 / 1.66, 1e-9);
}

TEST(MerlResample, RefusesOtherChannelCounts) {
  for (const std::size_t channels : {2u, 4u, 31u}) {
    const auto result = resample(constant_source(std::vector<float>(channels, 1)), {2, 2, 2});
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, ErrorCode::kUnsupported);
  }
}

TEST(MerlResample, RefusesShapesOutOfRange) {
  const RgbFunctionSource source = constant_source({1, 1, 1});
  for (const MerlShape& shape : {MerlShape{0, 2, 2}, MerlShape{2, 4097, 2}, MerlShape{4096, 4096, 4096}}) {
    const auto result = resample(source, shape);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().code, ErrorCode::kUsage);
  }
}

TEST(MerlResample, RefusesSourcesThatGiveNanAndNamesTheFirstCell) {
  const RgbFunctionSource source(3, [](const DirectionPair& pair) -> std::vector<float> {
    const double theta_d = half_difference_from_pair(pair).theta_d;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    return {theta_d > 0.3 ? nan : 1, theta_d < 0.3 ? nan : 1, 1};
  });
  const auto result = resample(source, {4, 9, 4});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidFile);
  EXPECT_NE(result.error().message.find("theta_h 0, theta_d 2, phi_d 0, channel R"), std::string::npos)
      << result.error().message;
}

TEST(MerlResample, ReportsGrowingProgressUpToOne) {
  std::vector<double> fractions;
  const auto result = resample(constant_source({1, 1, 1}), {30, 30, 2}, {[&](double fraction) {
                                 fractions.push_back(fraction);
                                 return true;
                               }});
  ASSERT_TRUE(result.ok());
  ASSERT_FALSE(fractions.empty());
  EXPECT_LE(fractions.size(), 257u);
  EXPECT_TRUE(std::ranges::is_sorted(fractions));
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST(MerlResample, StopsWhenAsked) {
  std::atomic<int> evaluations = 0;
  const RgbFunctionSource source(3, [&](const DirectionPair&) -> std::vector<float> {
    ++evaluations;
    return {1, 1, 1};
  });
  const auto result = resample(source, {100, 100, 4}, {[](double) { return false; }});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kIo);
  EXPECT_EQ(result.error().message, "interrupted");
  EXPECT_LT(evaluations, 20000);
}

}  // namespace
}  // namespace sbrdf::internal
