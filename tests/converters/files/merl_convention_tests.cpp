#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "codec/frame/frame.h"
#include "converters/files/format_table.h"
#include "converters/files/merl/merl_source.h"
#include "converters/tables/dense_source.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;
using Values = std::array<float, 3>;

std::shared_ptr<const ByteSource> bytes_of(Bytes bytes) {
  return std::make_shared<OwnedMemorySource>(std::move(bytes));
}

/// Smooth, positive and isotropic; reciprocal where `skew` is 0.
double smooth(const DirectionPair& pair, double skew) {
  const double i = pair.i.theta;
  const double v = pair.v.theta;
  return 0.3 + 0.1 * std::cos(i) * std::cos(v) + 0.05 * std::sin(i) * std::sin(v) * std::cos(pair.v.phi - pair.i.phi) +
         skew * (std::cos(i) - std::cos(v)) * std::cos(pair.v.phi - pair.i.phi);
}

FunctionSource source_of(double skew) {
  FunctionTraits traits{true, skew == 0, {"R", "G", "B"}};
  return FunctionSource([skew](const DirectionPair& pair,
                               std::size_t c) { return smooth(pair, skew) * (1 + 0.25 * static_cast<double>(c)); },
                        traits);
}

Result<Bytes> save(const BrdfSource& source, const Options& options) {
  MemorySink sink;
  Report report;
  if (Status saved = save_source(*find_writer(".binary").value(), source, sink, options, report); !saved) {
    return saved.error();
  }
  return std::move(sink).take();
}

Values value_of(const BrdfSource& source, const DirectionPair& pair) {
  Values values{};
  source.evaluate(std::span(&pair, 1), values);
  return values;
}

double stored_value(const Bytes& file, std::size_t value_size, std::uint64_t index) {
  if (value_size == 8) {
    double value;
    std::memcpy(&value, file.data() + 12 + 8 * index, 8);
    return value;
  }
  float value;
  std::memcpy(&value, file.data() + 12 + 4 * index, 4);
  return value;
}

TEST(MerlFloat32, IsReadAndWrittenWithTheSameValues) {
  const auto source = source_of(0);
  const Options shape = Options().set("merl-shape", "10,12,14");
  const Bytes wide = save(source, shape).value();
  const Bytes narrow = save(source, Options(shape).set("merl-type", "float32")).value();
  ASSERT_EQ(narrow.size(), 12U + 4 * 3 * 10 * 12 * 14);
  for (std::uint64_t k = 0; k < 3 * 10 * 12 * 14; ++k) {
    ASSERT_EQ(stored_value(narrow, 4, k), static_cast<float>(stored_value(wide, 8, k)));
  }
  // Half of a table of 64-bit floats has the same size.
  EXPECT_THAT(open_source(bytes_of(narrow)).error().message, testing::HasSubstr("--merl-float32"));
  EXPECT_FALSE(open_source(bytes_of(wide), Options().set("merl-float32")).ok());
  const auto opened = open_source(bytes_of(narrow), Options().set("merl-float32")).value();
  EXPECT_THAT(opened->traits().description, testing::HasSubstr("float32"));
  const DirectionPair pair = {{0.4, 0}, {0.7, 2}};
  EXPECT_NEAR(value_of(*opened, pair)[1], value_of(*open_source(bytes_of(wide)).value(), pair)[1], 1e-7);
  EXPECT_EQ(save(*opened, {}).value(), narrow);
}

// The published reader: int(90 sqrt(theta_h / 90)), int(theta_d), int(phi_d), each within its count.
TEST(MerlLookup, NearestIsThePublishedReadersCell) {
  const Bytes file = save(source_of(0), Options().set("merl-shape", "9,10,18")).value();
  const auto opened = open_source(bytes_of(file), Options().set("merl-lookup", "nearest")).value();
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int k = 0; k < 2000; ++k) {
    const DirectionPair pair = {{1.4 * unit(random), 6 * unit(random)}, {1.4 * unit(random), 6 * unit(random)}};
    const HalfDifference at = half_difference_from_pair(pair);
    const auto h = std::min(8, static_cast<int>(std::sqrt(at.theta_h / (kPi / 2)) * 9));
    const auto d = std::min(9, static_cast<int>(at.theta_d / (kPi / 2) * 10));
    const double phi_d = at.phi_d >= kPi ? at.phi_d - kPi : at.phi_d;
    const auto p = std::min(17, static_cast<int>(phi_d / kPi * 18));
    const auto cell = static_cast<std::uint64_t>(p + 18 * (d + 10 * h));
    const double stored = stored_value(file, 8, cell);
    if (stored < 0) continue;
    EXPECT_FLOAT_EQ(value_of(*opened, pair)[0], static_cast<float>(stored * kMerlScale[0]));
  }
  EXPECT_EQ(opened->table(), nullptr);
  EXPECT_EQ(opened->stored("merl"), nullptr);
}

TEST(MerlPosition, EdgeMeansTheLowerEdgeOfEachAxis) {
  const auto source = source_of(0);
  const Options options = Options().set("merl-shape", "20,20,36").set("merl-position", "edge");
  const Bytes file = save(source, options).value();
  for (const auto& [h, d, p] : {std::array{3, 5, 7}, std::array{10, 0, 0}, std::array{4, 8, 35}}) {
    const DirectionPair pair =
        pair_from_half_difference({std::pow(h / 20.0, 2) * kPi / 2, 0, d / 20.0 * kPi / 2, p / 36.0 * kPi});
    ASSERT_TRUE(above_horizon(pair));
    const auto cell = static_cast<std::uint64_t>(p + 36 * (d + 20 * h));
    EXPECT_NEAR(stored_value(file, 8, cell) * kMerlScale[0], smooth(pair, 0), 1e-7);
  }
  const auto right = open_source(bytes_of(file), Options().set("merl-position", "edge")).value();
  const auto wrong = open_source(bytes_of(file)).value();
  double right_error = 0, wrong_error = 0;
  for (double theta = 0.1; theta < 1.2; theta += 0.1) {
    const DirectionPair pair = {{theta, 0.2}, {0.8, 1.9}};
    right_error += std::abs(value_of(*right, pair)[0] - smooth(pair, 0));
    wrong_error += std::abs(value_of(*wrong, pair)[0] - smooth(pair, 0));
  }
  EXPECT_LT(right_error, 0.1 * wrong_error);
  // A copy is one only where it means the same.
  EXPECT_EQ(save(*right, Options().set("merl-position", "edge")).value(), file);
  EXPECT_NE(save(*right, {}).value(), file);
}

class MerlTurnTest : public testing::TestWithParam<bool> {};

bool reads_as_full(const Bytes& file) { return !open_source(bytes_of(file)).value()->traits().reciprocal; }

// With marks below the horizon, and with values everywhere.
TEST_P(MerlTurnTest, IsToldByTheContent) {
  // Without marks only reciprocity tells, so the material must nearly have it.
  const double skew = GetParam() ? 0.005 : 0.05;
  const auto source = source_of(skew);
  for (const char* turn : {"half", "full"}) {
    Bytes file = save(source, Options().set("merl-shape", "16,16,40").set("merl-turn", turn)).value();
    if (GetParam()) {
      const auto filled = [&](std::uint64_t cell) {
        const MerlConvention convention = {MerlPosition::kCentre,
                                           std::string(turn) == "full" ? MerlTurn::kFull : MerlTurn::kHalf};
        return smooth(merl_cell_pair({16, 16, 40}, convention, cell), skew) * 1000;
      };
      for (std::uint64_t k = 0; k < 3 * 16 * 16 * 40; ++k) {
        if (stored_value(file, 8, k) > 0) continue;
        const double value = filled(k % (16 * 16 * 40));
        std::memcpy(file.data() + 12 + 8 * k, &value, 8);
      }
    }
    EXPECT_EQ(reads_as_full(file), std::string(turn) == "full") << turn << GetParam();
  }
}
INSTANTIATE_TEST_SUITE_P(WithAndWithoutMarks, MerlTurnTest, testing::Bool());

TEST(MerlTurn, FullKeepsBothOrdersApart) {
  const auto source = source_of(0.05);
  const Bytes file = save(source, Options().set("merl-shape", "60,60,120").set("merl-turn", "full")).value();
  const auto opened = open_source(bytes_of(file)).value();
  EXPECT_FALSE(opened->traits().reciprocal);
  const DirectionPair pair = {{0.3, 0}, {1.0, 0.8}};
  EXPECT_NEAR(value_of(*opened, pair)[0], smooth(pair, 0.05), 2e-3);
  EXPECT_NEAR(value_of(*opened, {pair.v, pair.i})[0], smooth({pair.v, pair.i}, 0.05), 2e-3);
  EXPECT_EQ(save(*opened, {}).value(), file);
}

TEST(MerlTurn, UndecidedIsSaid) {
  FunctionTraits traits{true, true, {"R", "G", "B"}};
  const FunctionSource constant([](const DirectionPair&, std::size_t) { return 0.25; }, traits);
  Bytes file = save(constant, Options().set("merl-shape", "8,8,24")).value();
  for (std::uint64_t k = 0; k < 3 * 8 * 8 * 24; ++k) {
    const double value = 100;
    std::memcpy(file.data() + 12 + 8 * k, &value, 8);
  }
  const auto opened = open_source(bytes_of(file)).value();
  EXPECT_TRUE(opened->traits().reciprocal);
  ASSERT_EQ(opened->traits().findings.size(), 1U);
  EXPECT_THAT(opened->traits().findings[0].what, testing::HasSubstr("--merl-turn full"));
}

// The general evaluator of dense tables is another program than that of MERL tables.
TEST(MerlTable, SaysTheSameAsItsCellsInterpolatedAsAGrid) {
  for (const char* position : {"centre", "edge"}) {
    const Options options = Options().set("merl-position", position);
    const Bytes file = save(source_of(0), Options(options).set("merl-shape", "30,30,60")).value();
    const auto opened = open_source(bytes_of(file), options).value();
    ASSERT_NE(opened->table(), nullptr);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int k = 0; k < 500; ++k) {
      const DirectionPair pair = {{1.4 * unit(random), 6 * unit(random)}, {1.4 * unit(random), 6 * unit(random)}};
      Values other{};
      interpolate_table(*opened->table(), std::span(&pair, 1), other);
      EXPECT_NEAR(other[2], value_of(*opened, pair)[2], 1e-6);
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
