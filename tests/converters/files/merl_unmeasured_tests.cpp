#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/frame/frame.h"
#include "converters/files/format_table.h"
#include "converters/files/merl/merl_source.h"
#include "converters/files/merl/merl_writer.h"
#include "converters/slicing/slicing.h"
#include "tests/support/function_source.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr MerlShape kShape = {15, 18, 12};

/// A smooth table; cells below the horizon hold -1.
MerlTable smooth_table(const MerlShape& shape = kShape) {
  MerlTable table{shape, std::vector<double>(3 * merl_cell_count(shape), -1)};
  for (std::uint64_t cell = 0; cell < merl_cell_count(shape); ++cell) {
    const DirectionPair pair = merl_cell_centre(shape, cell);
    if (!above_horizon(pair)) continue;
    const HalfDifference angles = half_difference_from_pair(pair);
    for (std::size_t c = 0; c < 3; ++c) {
      const double f_r = 0.1 * (1 + double(c)) + std::exp(-20 * angles.theta_h * angles.theta_h) + 0.1 * angles.theta_d;
      table.values[c * merl_cell_count(shape) + cell] = f_r / kMerlScale[c];
    }
  }
  return table;
}

void set_cell(MerlTable& table, std::uint64_t cell, double red, double green, double blue) {
  const std::uint64_t count = merl_cell_count(table.shape);
  table.values[cell] = red;
  table.values[count + cell] = green;
  table.values[2 * count + cell] = blue;
}

template <class Take>
std::vector<std::uint64_t> cells_where(const MerlShape& shape, const Take& take) {
  std::vector<std::uint64_t> cells;
  for (std::uint64_t cell = 0; cell < merl_cell_count(shape); ++cell) {
    const DirectionPair centre = merl_cell_centre(shape, cell);
    if (above_horizon(centre) && take(cell, half_difference_from_pair(centre))) cells.push_back(cell);
  }
  return cells;
}

std::shared_ptr<const ByteSource> file_of(const MerlTable& table) {
  return std::make_shared<OwnedMemorySource>(emit_merl(table));
}
Result<std::unique_ptr<BrdfSource>> open(const MerlTable& table, const Options& options = {}) {
  return open_source(file_of(table), options);
}

std::vector<std::uint8_t> flags_at_centres(const BrdfSource& source, const MerlShape& shape) {
  std::vector<DirectionPair> pairs;
  for (std::uint64_t cell = 0; cell < merl_cell_count(shape); ++cell) pairs.push_back(merl_cell_centre(shape, cell));
  std::vector<std::uint8_t> flags(pairs.size());
  source.measured(pairs, flags);
  return flags;
}

const Finding* finding(const BrdfSource& source, const std::string& what) {
  for (const Finding& found : source.findings()) {
    if (found.what.find(what) != std::string::npos) return &found;
  }
  return nullptr;
}

struct SavedMerl {
  MerlTable table;
  Report report;
};
Result<SavedMerl> save_merl(const BrdfSource& source, const Options& options = {}) {
  MemorySink sink;
  SavedMerl saved;
  if (Status status = save_source(*find_writer(".binary").value(), source, sink, options, saved.report); !status) {
    return status.error();
  }
  saved.table = parse_merl(std::move(sink).take()).value();
  return saved;
}

const Remark* remark(const Report& report, const std::string& key) {
  for (const Remark& found : report.remarks) {
    if (found.key == key) return &found;
  }
  return nullptr;
}

TEST(MerlMeasured, CentresOfMarksAreUnmeasuredAndThoseOfOtherCellsAreMeasured) {
  MerlTable table = smooth_table();
  const std::vector<std::uint64_t> marked =
      cells_where(kShape, [](std::uint64_t cell, const HalfDifference&) { return cell % 7 < 3; });
  for (const std::uint64_t cell : marked) set_cell(table, cell, -1, -2, -0.5);
  const auto source = open(table).value();
  std::vector<std::uint8_t> expected(merl_cell_count(kShape), 1);
  for (const std::uint64_t cell : marked) expected[cell] = 0;
  EXPECT_EQ(flags_at_centres(*source, kShape), expected);
  EXPECT_EQ(finding(*source, "cells unmeasured above the horizon")->count, marked.size());
  EXPECT_EQ(source->mask_grid(), (MaskGrid{MaskFrame::kHalfDifference, {1, 15, 18, 12}}));
}

TEST(MerlMeasured, BetweenCellsTheGreaterWeightDecides) {
  MerlTable table = smooth_table();
  for (const std::uint64_t cell :
       cells_where(kShape, [](std::uint64_t k, const HalfDifference&) { return k / 12 % 18 >= 10; })) {
    set_cell(table, cell, -1, -1, -1);
  }
  const auto source = open(table).value();
  for (const double theta_d : {47.6, 49.9, 50.1, 52.0}) {
    const DirectionPair pair = pair_from_half_difference({0.05, 0, radians_from_degrees(theta_d), 1});
    std::uint8_t flag = 2;
    source->measured(std::span(&pair, 1), std::span(&flag, 1));
    EXPECT_EQ(flag, theta_d < 50 ? 1 : 0) << theta_d;
  }
}

TEST(MerlMeasured, MarksBelowTheHorizonSayNothing) {
  const auto source = open(smooth_table()).value();
  EXPECT_EQ(source->mask_grid(), std::nullopt);
  EXPECT_EQ(finding(*source, "above the horizon"), nullptr);
  const std::vector<std::uint8_t> flags = flags_at_centres(*source, kShape);
  EXPECT_EQ(std::count(flags.begin(), flags.end(), 0), 0);
}

TEST(MerlNonFinite, CellsAreMarksUnlessTheFileIsToBeRefused) {
  MerlTable table = smooth_table();
  const std::uint64_t first = 5 * 12 + 4;
  set_cell(table, first, 1, kNan, 1);
  set_cell(table, 9 * 12, std::numeric_limits<double>::infinity(), -1, 1);
  set_cell(table, 9 * 12 + 1, 1, 1, -1e300);
  const auto source = open(table).value();
  const Finding* found = finding(*source, "NaN");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->count, 3U);
  EXPECT_THAT(found->what, HasSubstr("the first at theta_h 0, theta_d 9, phi_d 0, channel R"));
  EXPECT_EQ(flags_at_centres(*source, kShape)[first], 0);
  EXPECT_EQ(source->stored("merl"), nullptr) << "a copy would not say what was read";

  const auto refused = open(table, Options().set("non-finite", "refuse"));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidFile);
  EXPECT_THAT(refused.error().message, HasSubstr("3 of 9720 MERL values"));
}

TEST(MerlNonFinite, ATableWithoutAnythingElseIsRefused) {
  MerlTable table = smooth_table({1, 1, 2});
  set_cell(table, 0, kNan, 5, 5);
  set_cell(table, 1, kNan, 5, 5);
  EXPECT_FALSE(open(table).ok());
}

TEST(MerlNegatives, StayBecomeZeroOrMakeMarksOfTheirCells) {
  MerlTable table = smooth_table();
  const std::uint64_t cell = 4 * 12 + 3;
  set_cell(table, cell, -30, 50, 70);
  const auto value = [&](const BrdfSource& source) {
    const DirectionPair pair = merl_cell_centre(kShape, cell);
    std::vector<float> values(3);
    source.evaluate(std::span(&pair, 1), values);
    return values;
  };
  const auto keep = open(table).value();
  EXPECT_NEAR(value(*keep)[0], -30 * kMerlScale[0], 1e-6);
  EXPECT_NE(keep->stored("merl"), nullptr);
  const auto clamp = open(table, Options().set("negatives", "clamp")).value();
  EXPECT_NEAR(value(*clamp)[0], 0, 1e-6);
  EXPECT_NEAR(value(*clamp)[1], 50 * kMerlScale[1], 1e-6);
  EXPECT_EQ(clamp->stored("merl"), nullptr);
  EXPECT_EQ(flags_at_centres(*clamp, kShape)[cell], 1);
  const auto marks = open(table, Options().set("negatives", "unmeasured")).value();
  EXPECT_EQ(flags_at_centres(*marks, kShape)[cell], 0);
  for (const auto* source : {&keep, &clamp, &marks}) {
    EXPECT_EQ(finding(**source, "some negative channel")->count, 1U);
  }
}

TEST(MerlWriter, MarksWhatTheSourceDidNotMeasure) {
  MerlTable table = smooth_table();
  for (const std::uint64_t cell : {100U, 101U, 500U}) set_cell(table, cell, kNan, 1, 1);
  const SavedMerl saved = save_merl(*open(table).value()).value();
  EXPECT_EQ(saved.table.shape, kShape) << "the shape of the source";
  for (std::uint64_t k = 0; k < table.values.size(); ++k) {
    const std::uint64_t cell = k % merl_cell_count(kShape);
    const bool hole = cell == 100 || cell == 101 || cell == 500;
    if (hole) {
      EXPECT_EQ(saved.table.values[k], -1) << k;
    } else {
      EXPECT_NEAR(saved.table.values[k], table.values[k], 1e-6 * std::abs(table.values[k])) << k;
    }
  }
  EXPECT_EQ(remark(saved.report, "unmeasured_cells")->value, 3);
}

FunctionSource source_of(std::function<double(const DirectionPair&, std::size_t)> function) {
  return FunctionSource(std::move(function), {.isotropic = true, .reciprocal = true});
}

TEST(MerlWriter, KeepsClampsOrMarksNegatives) {
  const FunctionSource source = source_of([](const DirectionPair& pair, std::size_t c) {
    const double theta_d = half_difference_from_pair(pair).theta_d;
    return theta_d > 1 ? -0.5 : theta_d > 0.5 && c == 1 ? -0.25 : 0.75;
  });
  const auto written = [&](const char* policy) {
    return save_merl(source, Options().set("merl-shape", "6,6,4").set("negatives", policy)).value();
  };
  const SavedMerl keep = written("keep");
  const SavedMerl clamp = written("clamp");
  const SavedMerl unmeasured = written("unmeasured");
  const MerlShape shape = {6, 6, 4};
  const std::uint64_t count = merl_cell_count(shape);
  std::size_t some = 0;
  std::size_t all = 0;
  for (std::uint64_t cell = 0; cell < count; ++cell) {
    if (!above_horizon(merl_cell_centre(shape, cell))) continue;
    const auto at = [&](const SavedMerl& saved, std::size_t c) { return saved.table.values[c * count + cell]; };
    const std::size_t negative = (at(keep, 0) < 0 ? 1 : 0) + (at(keep, 1) < 0 ? 1 : 0) + (at(keep, 2) < 0 ? 1 : 0);
    some += negative == 1 ? 1 : 0;
    all += negative == 3 ? 1 : 0;
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(at(clamp, c), std::max(at(keep, c), 0.0));
      EXPECT_EQ(at(unmeasured, c), negative > 0 ? -1 : at(keep, c));
    }
  }
  ASSERT_GT(some, 0U);
  ASSERT_GT(all, 0U);
  for (const SavedMerl* saved : {&keep, &clamp, &unmeasured}) {
    EXPECT_EQ(remark(saved->report, "some_negative_cells")->value, some);
    EXPECT_EQ(remark(saved->report, "all_negative_cells")->value, all);
  }
  EXPECT_THAT(remark(clamp.report, "all_negative_cells")->text, HasSubstr("0 in their place"));
  EXPECT_THAT(remark(unmeasured.report, "all_negative_cells")->text, HasSubstr("marked -1"));
}

TEST(MerlWriter, RefusesValuesThatAreNotFiniteUnlessTheyAreToBeMarked) {
  const FunctionSource source = source_of(
      [](const DirectionPair& pair, std::size_t) { return half_difference_from_pair(pair).theta_d > 1 ? kNan : 0.75; });
  EXPECT_EQ(save_merl(source, Options().set("merl-shape", "6,6,4")).error().code, ErrorCode::kInvalidFile);
  const SavedMerl saved =
      save_merl(source, Options().set("merl-shape", "6,6,4").set("non-finite", "unmeasured")).value();
  const MerlShape shape = {6, 6, 4};
  const auto cells = cells_where(shape, [](std::uint64_t, const HalfDifference& angles) { return angles.theta_d > 1; });
  EXPECT_EQ(remark(saved.report, "non_finite_cells")->value, cells.size());
  for (const std::uint64_t cell : cells) EXPECT_EQ(saved.table.values[cell], -1);
}

/// As far as it says that it is measured.
class LimitedSource final : public BrdfSource {
 public:
  explicit LimitedSource(double theta_max_deg) {
    traits_.channels = {"grey"};
    traits_.isotropic = traits_.reciprocal = true;
    traits_.theta_max_deg = theta_max_deg;
    traits_.beyond_theta_max = "a guess";
  }
  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> /*pairs*/, std::span<float> values) const override {
    std::fill(values.begin(), values.end(), 1.0F);
  }

 private:
  SourceTraits traits_;
};

TEST(MerlWriter, CountsCellsBeyondWhatTheSourceMeasured) {
  for (const double theta_max : {40.0, 80.0}) {
    const SavedMerl saved = save_merl(LimitedSource(theta_max), Options().set("merl-shape", "15,18,12")).value();
    const double limit = radians_from_degrees(theta_max);
    std::size_t beyond = 0;
    for (const std::uint64_t cell : cells_where(kShape, [](auto...) { return true; })) {
      const DirectionPair pair = merl_cell_centre(kShape, cell);
      beyond += pair.i.theta > limit || pair.v.theta > limit ? 1 : 0;
    }
    const Remark* told = remark(saved.report, "cells_beyond_theta_max");
    ASSERT_NE(told, nullptr);
    EXPECT_EQ(told->value, beyond);
    EXPECT_THAT(told->text, HasSubstr("a guess"));
  }
  EXPECT_EQ(remark(save_merl(LimitedSource(90), Options().set("merl-shape", "15,18,12")).value().report,
                   "cells_beyond_theta_max"),
            nullptr);
}

/// Through a sliced file and back: `table` sliced, and the table written of that.
MerlTable there_and_back(const MerlTable& table, Report& report, std::string& metadata) {
  const auto source = open(table).value();
  MemorySink sink;
  Options options;
  options.set("samples", "400").set("search-evaluations", "12");
  const Status saved = save_source(*find_writer(".sbrdf").value(), *source, sink, options, report);
  EXPECT_TRUE(saved) << saved.error().message;
  const auto sliced = open_source(std::make_shared<OwnedMemorySource>(std::move(sink).take())).value();
  metadata = sliced->sliced()->sliced.metadata;
  return save_merl(*sliced, Options().set("merl-shape", "15,18,12")).value().table;
}

// The whole way that an unmeasured direction goes.
TEST(MerlUnmeasured, ComeBackAsMarksByWayOfASlicedFileAndNoOthersDo) {
  MerlTable table = smooth_table();
  const auto holes = cells_where(
      kShape, [](std::uint64_t, const HalfDifference& angles) { return angles.theta_d > radians_from_degrees(70); });
  ASSERT_FALSE(holes.empty());
  for (const std::uint64_t cell : holes) set_cell(table, cell, -1, -1, -1);
  Report report;
  std::string metadata;
  const MerlTable back = there_and_back(table, report, metadata);
  const auto marks =
      cells_where(kShape, [&](std::uint64_t cell, const HalfDifference&) { return back.values[cell] < 0; });
  EXPECT_EQ(marks, holes);
  // Black directions would be told by an error that is no better than theirs: none of them entered it.
  EXPECT_LT(remark(report, "held_back_rel_l1_percent")->value, 10);
  EXPECT_GT(remark(report, "filled_samples")->value, 0);
  EXPECT_THAT(metadata, HasSubstr("\"filled_samples\":"));
}

TEST(MerlUnmeasured, AreNotTheBusinessOfATableWithoutThem) {
  Report report;
  std::string metadata;
  there_and_back(smooth_table(), report, metadata);
  EXPECT_EQ(remark(report, "filled_samples"), nullptr);
  EXPECT_EQ(metadata.find("filled_samples"), std::string::npos);
}

}  // namespace
}  // namespace sbrdf::internal
