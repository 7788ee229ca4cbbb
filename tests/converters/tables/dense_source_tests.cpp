#include "converters/tables/dense_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "codec/frame/frame.h"
#include "converters/tables/sampled_table.h"
#include "converters/tables/tile_cache.h"
#include "formats/core/parallel.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A table whose value at a node is `f` of the four angles there [degrees].
template <class F>
DenseTable table_of(const Grid& grid, const F& f) {
  std::vector<double> values;
  for (std::uint64_t k = 0; k < grid.node_count(); ++k) {
    const GridNode n = grid.node(k);
    values.push_back(f(grid.axes[0].node_deg(n[0]), grid.axes[1].node_deg(n[1]), grid.axes[2].node_deg(n[2]),
                       grid.axes[3].node_deg(n[3])));
  }
  return table_in_memory(grid, 1, std::move(values));
}

DenseDescription described(const ValuePolicy& policy = {Negatives::kKeep, NonFinite::kUnmeasured}) {
  DenseDescription description;
  description.format = "test";
  description.channels = {"Y"};
  description.policy = policy;
  return description;
}

std::unique_ptr<BrdfSource> open(DenseTable table,
                                 const ValuePolicy& policy = {Negatives::kKeep, NonFinite::kUnmeasured}) {
  return DenseSource::make(std::move(table), described(policy)).value();
}

float value_at(const BrdfSource& source, double theta_i, double phi_i, double theta_v, double phi_v) {
  const DirectionPair pair = {{radians_from_degrees(theta_i), radians_from_degrees(phi_i)},
                              {radians_from_degrees(theta_v), radians_from_degrees(phi_v)}};
  float value = -99;
  source.evaluate(std::span(&pair, 1), std::span(&value, 1));
  return value;
}

bool measured_at(const BrdfSource& source, double theta_i, double phi_i, double theta_v, double phi_v) {
  const DirectionPair pair = {{radians_from_degrees(theta_i), radians_from_degrees(phi_i)},
                              {radians_from_degrees(theta_v), radians_from_degrees(phi_v)}};
  std::uint8_t flag = 9;
  source.measured(std::span(&pair, 1), std::span(&flag, 1));
  return flag == 1;
}

// Linear in each angle: what interpolation must give back everywhere, but where an azimuth closes.
TEST(DenseSource, GivesBackWhatIsLinearInEachAngle) {
  const auto linear = [](double a, double b, double c, double d) {
    return 1 + a / 90 + b / 360 + 2 * c / 90 + a * d / 20000;
  };
  const auto source = open(table_of(parse_grid("0,7,30,90:30:15:20").value(), linear));
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int k = 0; k < 1000; ++k) {
    const double a = 90 * unit(random), b = 330 * unit(random), c = 90 * unit(random), d = 340 * unit(random);
    EXPECT_NEAR(value_at(*source, a, b, c, d), linear(a, b, c, d), 2e-6);
  }
  EXPECT_NEAR(value_at(*source, 30, 345, 30, 0), (linear(30, 330, 30, 0) + linear(30, 0, 30, 0)) / 2, 1e-6);
  EXPECT_EQ(value_at(*source, 91, 0, 30, 0), 0);
}

TEST(DenseSource, TellsLightFromViewer) {
  const auto source =
      open(table_of(parse_grid("30:90:30:90").value(), [](double a, double b, double, double) { return 1 + a + b; }));
  EXPECT_FLOAT_EQ(value_at(*source, 60, 90, 30, 180), 151);
  EXPECT_FLOAT_EQ(value_at(*source, 30, 180, 60, 90), 211);
  EXPECT_FALSE(source->traits().isotropic);
  EXPECT_FALSE(source->traits().reciprocal);
}

TEST(DenseSource, LeavesHolesOutAndTellsWhereTheyAre) {
  const auto holes = [](double a, double, double c, double) { return a == 30 && c == 30 ? kNaN : 2.0; };
  const auto source = open(table_of(parse_grid("30:90:30:90").value(), holes));
  EXPECT_FLOAT_EQ(value_at(*source, 30, 0, 30, 0), 0);
  EXPECT_FLOAT_EQ(value_at(*source, 31, 0, 30, 0), 2);
  EXPECT_FALSE(measured_at(*source, 31, 0, 30, 0));
  EXPECT_TRUE(measured_at(*source, 46, 0, 30, 0));
  ASSERT_TRUE(source->mask_grid().has_value());
  ASSERT_EQ(source->traits().findings.size(), 1U);
  EXPECT_EQ(source->traits().findings[0].count, 16U);
}

TEST(DenseSource, DoesWithNegativesAsItIsTold) {
  const auto table = [] {
    return table_of(parse_grid("30:90:30:90").value(), [](double a, double, double, double) { return a - 10; });
  };
  EXPECT_FLOAT_EQ(value_at(*open(table()), 0, 0, 30, 0), -10);
  EXPECT_FLOAT_EQ(value_at(*open(table(), {Negatives::kClamp, NonFinite::kUnmeasured}), 0, 0, 30, 0), 0);
  const auto unmeasured = open(table(), {Negatives::kUnmeasured, NonFinite::kUnmeasured});
  EXPECT_FALSE(measured_at(*unmeasured, 0, 0, 30, 0));
  EXPECT_THAT(open(table())->traits().findings[0].what, testing::HasSubstr("some negative channel"));
}

TEST(DenseSource, RefusesWhatIsNoReflectance) {
  const Grid grid = parse_grid("30:90:30:90").value();
  const auto nothing =
      DenseSource::make(table_of(grid, [](double, double, double, double) { return 0.0; }), described());
  EXPECT_THAT(nothing.error().message, testing::HasSubstr("no value of the table is positive"));
  const auto infinite = DenseSource::make(
      table_of(grid, [](double a, double b, double, double) { return a == 60 && b == 90 ? 1e39 : 1.0; }),
      described({Negatives::kKeep, NonFinite::kRefuse}));
  EXPECT_THAT(infinite.error().message, testing::HasSubstr("theta_i 60, phi_i 90, theta_v 0, phi_v 0 degrees"));
}

TEST(DenseSource, ExtrapolatesWithoutBecomingNegative) {
  Grid grid = parse_grid("utia").value();
  grid.axes[0] = GridAxis(even_nodes(0, 15, 6), Ends::kExtrapolated);
  const auto falling = open(table_of(grid, [](double a, double, double, double) { return 76 - a; }));
  EXPECT_NEAR(value_at(*falling, 75.5, 0, 0, 0), 0.5, 1e-5);
  EXPECT_EQ(value_at(*falling, 85, 0, 0, 0), 0);
  EXPECT_EQ(falling->traits().theta_max_deg, 75);
}

TEST(SampleTable, CopiesATableOfTheSameGridAndEvaluatesAnyOther) {
  const Grid grid = parse_grid("30:90:30:90").value();
  const auto exact = [](double a, double b, double, double) { return a == 30 && b == 0 ? kNaN : 1 + a / 7 + b / 1e9; };
  const auto source = open(table_of(grid, exact));
  for (const bool same : {true, false}) {
    TableRequest request;
    request.grid = same ? grid : parse_grid("30:180:30:90").value();
    std::vector<double> all;
    const auto take = [&](const TableBlock&, std::span<const double> values) -> Status {
      all.insert(all.end(), values.begin(), values.end());
      return ok_status();
    };
    const auto losses = sample_table(*source, request, rows_of(request.grid), take, {}).value();
    EXPECT_EQ(losses.copied, same);
    EXPECT_EQ(losses.unmeasured, 4U * 4);
    ASSERT_EQ(all.size(), request.grid.node_count());
    for (std::uint64_t k = 0; k < all.size(); ++k) {
      const GridNode n = request.grid.node(k);
      const double value = exact(request.grid.axes[0].node_deg(n[0]), request.grid.axes[1].node_deg(n[1]), 0, 0);
      if (std::isnan(value)) {
        EXPECT_TRUE(std::isnan(all[k]));
      } else {
        EXPECT_EQ(all[k], same ? value : static_cast<double>(static_cast<float>(value)));
      }
    }
  }
}

TEST(SampleTable, GivesBlocksOfAnyShapeTheSameValues) {
  FunctionTraits traits{false, false, {"a", "b"}};
  const FunctionSource source(
      [](const DirectionPair& p, std::size_t c) { return 1 + p.i.theta + 3 * p.v.phi + static_cast<double>(c); },
      traits);
  TableRequest request;
  request.grid = parse_grid("15:40:30:60").value();
  const auto fill = [&](std::array<std::uint32_t, 4> block) {
    std::vector<double> all(request.grid.node_count() * 2);
    const auto take = [&](const TableBlock& b, std::span<const double> values) -> Status {
      std::size_t at = 0;
      for (std::uint64_t k = 0; k < b.node_count(); ++k) {
        std::uint64_t rest = k;
        GridNode node = b.first;
        for (std::size_t axis = 4; axis-- > 0;) {
          node[axis] += static_cast<std::uint32_t>(rest % b.count[axis]);
          rest /= b.count[axis];
        }
        for (std::size_t c = 0; c < 2; ++c) all[2 * request.grid.index(node) + c] = values[at++];
      }
      return ok_status();
    };
    EXPECT_TRUE(sample_table(source, request, block, take, {}).ok());
    return all;
  };
  const std::vector<double> rows = fill(rows_of(request.grid));
  EXPECT_EQ(fill({3, 2, 3, 4}), rows);
  EXPECT_EQ(fill({7, 9, 4, 6}), rows);
  const ThreadLimit one(1);
  EXPECT_EQ(fill({1, 1, 1, 1}), rows);
}

TEST(SampleTable, HoldsWhatIsTooLargeAndCountsIt) {
  FunctionTraits traits{false, false, {"Y"}};
  const FunctionSource source([](const DirectionPair& p, std::size_t) { return p.i.theta > 1 ? 1e6 : 1.0; }, traits);
  TableRequest request;
  request.grid = parse_grid("30:90:30:90").value();
  request.largest = 65504;
  double most = 0;
  const auto take = [&](const TableBlock&, std::span<const double> values) -> Status {
    for (const double v : values) most = std::max(most, v);
    return ok_status();
  };
  const auto losses = sample_table(source, request, {1, 1, 4, 4}, take, {}).value();
  EXPECT_EQ(most, 65504);
  EXPECT_EQ(losses.clamped, 2U * 4 * 4 * 4);
}

TEST(TiledValues, AreThoseOfTheTableInAnyOrderAndOnAnyThreads) {
  const TiledValues::Box shape = {5, 7, 6, 9};
  std::atomic<int> reads = 0;
  const auto value = [](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, std::size_t channel) {
    return 1000 * a + 100 * b + 10 * c + d + 0.1 * static_cast<double>(channel);
  };
  const TiledValues tiled(shape, 2, {2, 3, 4, 4}, 1,
                          [&](const GridNode& first, const TiledValues::Box& count, std::span<double> values) {
                            ++reads;
                            std::size_t at = 0;
                            for (std::uint32_t a = 0; a < count[0]; ++a)
                              for (std::uint32_t b = 0; b < count[1]; ++b)
                                for (std::uint32_t c = 0; c < count[2]; ++c)
                                  for (std::uint32_t d = 0; d < count[3]; ++d)
                                    for (std::size_t k = 0; k < 2; ++k)
                                      values[at++] = value(first[0] + a, first[1] + b, first[2] + c, first[3] + d, k);
                          });
  parallel_for(2000, [&](std::uint64_t k) {
    std::mt19937_64 random(k);
    std::array<GridNode, 3> nodes;
    for (GridNode& node : nodes) {
      for (std::size_t axis = 0; axis < 4; ++axis) node[axis] = static_cast<std::uint32_t>(random() % shape[axis]);
    }
    std::array<double, 6> values{};
    tiled.gather(nodes, values);
    for (std::size_t n = 0; n < 3; ++n) {
      EXPECT_EQ(values[2 * n + 1], value(nodes[n][0], nodes[n][1], nodes[n][2], nodes[n][3], 1));
    }
  });
  EXPECT_GT(reads, 54);  // some were dropped and read again
}

}  // namespace
}  // namespace sbrdf::internal
