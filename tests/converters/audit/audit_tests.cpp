#include "converters/audit/audit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "converters/audit/tables/grid_ladder.h"
#include "converters/audit/tables/log_table.h"
#include "converters/audit/tables/table_coders.h"
#include "converters/audit/tables/tucker.h"
#include "converters/models/analytic.h"
#include "converters/tables/dense_source.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

std::unique_ptr<BrdfSource> isotropic_gloss() {
  return make_analytic_source({"gloss", {0.1, 0.05, 0.02}, {{{0.1, 0.1, 0.1}, 0.2, 0.3, 0.3, 0}}});
}

/// Two sources, of three and of four axes, and their subjects.
class AuditTables : public testing::Test {
 protected:
  std::unique_ptr<BrdfSource> gloss_ = isotropic_gloss();
  std::unique_ptr<BrdfSource> wood_ = make_analytic_source(kurt_material("wood01").value());
  AuditSubject isotropic_ = AuditSubject::make(*gloss_, 4000).value();
  AuditSubject anisotropic_ = AuditSubject::make(*wood_, 4000).value();
};

TEST_F(AuditTables, LaddersFallAndSayWhatTablesAreOffBy) {
  for (const AuditSubject* subject : {&isotropic_, &anisotropic_}) {
    GridLadder ladder(*subject);
    const std::size_t k = ladder.reach(8);
    ASSERT_LT(k, ladder.size());
    EXPECT_LE(ladder.step(k).percent, 8);
    if (k > 0) {
      EXPECT_GT(ladder.step(k - 1).percent, 8);
      EXPECT_GT(ladder.step(k).grid.node_count(), ladder.step(k - 1).grid.node_count());
    }
    EXPECT_EQ(ladder.step(k).grid.is_isotropic(), subject == &isotropic_);
    // As --grid has it, the same grid.
    const Grid read = parse_grid(grid_text(ladder.step(k).grid)).value();
    EXPECT_EQ(read.node_count(), ladder.step(k).grid.node_count());
    const double again = few_percent_of(*subject, table_of_source(subject->source(), read));
    EXPECT_NEAR(again, ladder.step(k).percent, 1e-6 * again);
  }
}

/// Logarithms and back, folded or not: the table of the source itself.
TEST_F(AuditTables, LogarithmsStandForTheTable) {
  for (const AuditSubject* subject : {&isotropic_, &anisotropic_}) {
    GridLadder ladder(*subject);
    const Grid& grid = ladder.step(3).grid;
    const LogTable table = make_log_table(*subject, grid, {}).value();
    EXPECT_EQ(table.counts[3] < grid.axes[3].size(), subject == &isotropic_);
    const DenseTable again = dense_table_of(table, table.planes);
    const DenseTable source = table_of_source(subject->source(), grid);
    for (std::uint64_t k = 0; k < grid.node_count(); ++k) {
      const GridNode node = grid.node(k);
      std::array<double, 3> a{}, b{};
      again.values->gather(std::span(&node, 1), a);
      source.values->gather(std::span(&node, 1), b);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(std::isnan(a[c]), std::isnan(b[c])) << grid.node_text(node);
        if (!std::isnan(b[c])) {
          ASSERT_NEAR(a[c], b[c], 1e-5 * std::abs(b[c])) << grid.node_text(node);
        }
      }
    }
    EXPECT_NEAR(few_percent_of(*subject, again), ladder.step(3).percent, 0.001);
  }
}

/// Colours beyond the gamut are below 0: their tables are as good as any.
TEST_F(AuditTables, NegativeValuesAreKept) {
  const FunctionSource source(
      [](const DirectionPair& pair, std::size_t c) {
        return (c == 0 ? -0.5 : 1) * std::cos(pair.i.theta) * std::cos(pair.v.theta);
      },
      {.isotropic = true, .reciprocal = true, .channels = {"R", "G", "B"}});
  const AuditSubject subject = AuditSubject::make(source, 2000).value();
  GridLadder ladder(subject);
  const LogTable table = make_log_table(subject, ladder.step(2).grid, {}).value();
  EXPECT_NEAR(few_percent_of(subject, dense_table_of(table, table.planes)), ladder.step(2).percent, 0.001);
  const LogScale scale = {1e-3};
  for (const double f : {-2.0, -1e-3, 0.0, 1e-6, 0.5, 1e4})
    EXPECT_NEAR(scale.value_of(scale.log_of(f)), f, 1e-9 * std::abs(f) + 1e-15);
  EXPECT_NEAR(scale.log_of(5), std::log(5 / 1e-3), 1e-6);
}

TEST_F(AuditTables, CodersKeepToTheirBoundsAndGetFiner) {
  for (const AuditSubject* subject : {&isotropic_, &anisotropic_}) {
    GridLadder ladder(*subject);
    const LogTable table = make_log_table(*subject, ladder.step(2).grid, {}).value();
    for (const TableCoder& coder : table_coders()) {
      std::size_t last_bytes = 0;
      double last_off = 1e9;
      for (const std::size_t setting : {std::size_t{1}, coder.setting_count / 2, coder.setting_count - 1}) {
        const auto bytes = coder.encode(table, setting);
        const Planes planes = coder.decode(bytes, table).value();
        ASSERT_EQ(planes.size(), table.planes.size());
        double off = 0;
        for (std::size_t c = 0; c < planes.size(); ++c) {
          ASSERT_EQ(planes[c].size(), table.planes[c].size());
          for (std::size_t k = 0; k < planes[c].size(); ++k) {
            off = std::max(off, static_cast<double>(std::abs(planes[c][k] - table.planes[c][k])));
          }
        }
        EXPECT_LE(off, last_off) << coder.name << setting;
        EXPECT_GE(bytes.size(), last_bytes) << coder.name << setting;
        last_off = off;
        last_bytes = bytes.size();
        if (coder.approximate != nullptr) {
          EXPECT_EQ(coder.approximate(table, setting), planes) << coder.name;
        }
      }
      EXPECT_LT(last_off, 0.002) << coder.name;
      EXPECT_LT(last_bytes, table.planes.size() * table.node_count() * sizeof(float)) << coder.name;
    }
  }
}

TEST_F(AuditTables, CodersRefuseWhatIsCutOff) {
  GridLadder ladder(isotropic_);
  const LogTable table = make_log_table(isotropic_, ladder.step(1).grid, {}).value();
  for (const TableCoder& coder : table_coders()) {
    auto bytes = coder.encode(table, 4);
    bytes.resize(bytes.size() / 3);
    const auto planes = coder.decode(bytes, table);
    ASSERT_FALSE(planes) << coder.name;
    EXPECT_EQ(planes.error().code, ErrorCode::kInvalidFile);
  }
}

/// With all directions of each axis a decomposition is the table itself, but for half floats: 12 in the logarithm, each
/// number to 1/2048.
TEST_F(AuditTables, TuckerWithEverythingIsTheTable) {
  GridLadder ladder(isotropic_);
  const Grid& grid = ladder.step(2).grid;
  const LogTable table = make_log_table(isotropic_, grid, {}).value();
  const TuckerFamily family(table);
  const Tucker whole = family.keep(0);
  for (std::size_t axis = 0; axis < 5; ++axis) EXPECT_LE(whole.ranks[axis], whole.nodes[axis]);
  const auto source = make_tucker_source(isotropic_, table, whole);
  for (std::uint64_t k = 0; k < grid.node_count(); ++k) {
    const GridNode node = grid.node(k);
    const DirectionPair pair = grid.pair_of(node);
    if (pair.i.theta > 1.5 || pair.v.theta > 1.5) continue;
    std::array<float, 3> value{}, expected{};
    source->evaluate(std::span(&pair, 1), value);
    isotropic_.source().evaluate(std::span(&pair, 1), expected);
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(value[c], expected[c], 0.025 * expected[c]) << grid.node_text(node);
  }
  const Tucker few = family.keep(1e-3);
  EXPECT_LT(few.number_count(), whole.number_count() / 4);
}

AuditRow row_of(const std::vector<AuditRow>& rows, const std::string& method, double target) {
  for (const AuditRow& row : rows) {
    if (row.method == method && row.target_percent == target) return row;
  }
  ADD_FAILURE() << method;
  return {};
}

TEST(Audit, KeepsEachWayToItsErrorAndTellsRatios) {
  const auto source = isotropic_gloss();
  AuditSettings settings;
  settings.targets = {20, 8};
  settings.directions = 3000;
  settings.methods = {
      "table, floats", "table, half floats", "table, zstd",         "Tucker", "HDF5", "OpenEXR", "MERL", "UTIA",
      "fit, Kurt",     "fit, GGX",           "uniform, barycentric"};
  const std::vector<AuditRow> rows = audit_material(*source, settings).value();
  ASSERT_EQ(rows.size(), 2 * settings.methods.size());
  for (const double target : settings.targets) {
    std::uint64_t least = UINT64_MAX;
    for (const AuditRow& row : rows) {
      if (row.target_percent != target) continue;
      EXPECT_TRUE(row.found()) << row.method << row.note;
      EXPECT_LE(row.overhead, row.bytes) << row.method;
      EXPECT_EQ(row.reached, row.off_grid_rel_l1_percent <= target) << row.method;
      EXPECT_EQ(row.reached, row.ratio > 0) << row.method;
      if (row.reached) least = std::min(least, row.bytes);
    }
    for (const AuditRow& row : rows) {
      if (row.target_percent != target || !row.reached) continue;
      EXPECT_NEAR(row.ratio, static_cast<double>(row.bytes) / static_cast<double>(least), 1e-9);
    }
  }
  // What these are made of is known.
  EXPECT_EQ(row_of(rows, "MERL", 20).bytes, 34'992'012U);
  EXPECT_EQ(row_of(rows, "MERL", 20).overhead, 12U);
  EXPECT_EQ(row_of(rows, "UTIA", 20).bytes, 1'990'656U);
  EXPECT_LT(row_of(rows, "fit, Kurt", 8).off_grid_rel_l1_percent, 0.01) << "it is such a model";
  const AuditRow floats = row_of(rows, "table, floats", 8);
  const AuditRow halves = row_of(rows, "table, half floats", 8);
  EXPECT_EQ(floats.bytes - floats.overhead, 2 * (halves.bytes - halves.overhead)) << "the same grid";
  EXPECT_GT(floats.overhead, 500U) << "the head of the array, and the file that says where its nodes are";
  EXPECT_GE(row_of(rows, "table, floats", 8).bytes, row_of(rows, "table, floats", 20).bytes);
  const std::vector<std::vector<AuditRow>> twice = {rows, rows};
  const std::vector<AuditTotal> totals = total(twice);
  ASSERT_EQ(totals.size(), rows.size());
  EXPECT_EQ(totals[0].materials, 2U);
  EXPECT_EQ(totals[0].bytes, 2 * rows[0].bytes);
  EXPECT_NEAR(totals[0].mean_bytes, static_cast<double>(rows[0].bytes), 1e-6 * totals[0].mean_bytes);
}

TEST(Audit, SaysWhyAWayIsLeftOut) {
  AuditSettings settings;
  settings.methods = {"MERL", "RGL", "fit, Ward"};
  settings.targets = {10};
  settings.directions = 1000;
  const auto wood = make_analytic_source(kurt_material("wood01").value());
  EXPECT_THAT(audit_material(*wood, settings).value()[0].note, HasSubstr("anisotropic"));
  const FunctionSource four([](const DirectionPair&, std::size_t) { return 1.0; },
                            {.isotropic = true, .reciprocal = true, .channels = {"a", "b", "c", "d"}});
  const auto of_four = audit_material(four, settings).value();
  for (const AuditRow& row : of_four) {
    EXPECT_FALSE(row.found());
    EXPECT_FALSE(row.reached);
    EXPECT_THAT(row.note, HasSubstr("3 channels"));
  }
  const FunctionSource grey(
      [](const DirectionPair& p, std::size_t) { return 1.0 + std::cos(p.i.theta) * std::cos(p.v.theta); },
      {.isotropic = true, .reciprocal = true, .channels = {"Y"}});
  const auto rows = audit_material(grey, settings).value();
  EXPECT_TRUE(row_of(rows, "fit, Ward", 10).found()) << "one channel is fitted as three";
}

TEST(Audit, RefusesWhatItCannotJudge) {
  const FunctionSource black([](const DirectionPair&, std::size_t) { return 0.0; }, {.channels = {"Y"}});
  const auto rows = audit_material(black, {});
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().code, ErrorCode::kInvalidFile);
  const std::vector<std::string> names = {"sliced", "shell sort"};
  EXPECT_TRUE(check_methods(std::span(names).first(1)).ok());
  EXPECT_THAT(check_methods(names).error().message, HasSubstr("\"shell sort\""));
  Progress stop;
  stop.report = [](double) { return false; };
  const auto stopped = audit_material(*isotropic_gloss(), {}, nullptr, stop);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, interrupted_error().code);
}

}  // namespace
}  // namespace sbrdf::internal
