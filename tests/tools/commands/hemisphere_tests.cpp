#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "codec/file/encoder.h"
#include "codec/frame/frame.h"
#include "converters/files/merl/merl_source.h"
#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

// What the program says of directions that nobody measured, seen from the command line.

constexpr std::array<std::int32_t, 3> kHemisphereShape = {15, 18, 12};
constexpr MerlShape kMerl = {15, 18, 12};
constexpr std::size_t kHemisphereCells = std::size_t{15} * 18 * 12;

/// Grey and smooth, -1 below the horizon.
std::vector<double> smooth_values() {
  std::vector<double> values(3 * kHemisphereCells, -1);
  for (std::size_t cell = 0; cell < kHemisphereCells; ++cell) {
    const DirectionPair pair = merl_cell_centre(kMerl, cell);
    if (!above_horizon(pair)) continue;
    const double theta_h = half_difference_from_pair(pair).theta_h;
    for (std::size_t c = 0; c < 3; ++c)
      values[c * kHemisphereCells + cell] = 100 + 500 * std::exp(-9 * theta_h * theta_h);
  }
  return values;
}

std::vector<double> with_holes() {
  std::vector<double> values = smooth_values();
  for (std::size_t cell = 0; cell < kHemisphereCells; ++cell) {
    if (half_difference_from_pair(merl_cell_centre(kMerl, cell)).theta_d < radians_from_degrees(70)) continue;
    for (std::size_t c = 0; c < 3; ++c) values[c * kHemisphereCells + cell] = -1;
  }
  return values;
}

const std::vector<std::string> kQuick = {"--samples", "300", "--search-evaluations", "9"};

ProgramRun convert(std::vector<std::string> arguments, const std::vector<std::string>& more = {}) {
  arguments.insert(arguments.begin(), "convert");
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_sbrdf(arguments);
}

double remark(const ProgramRun& run, const std::string& key) {
  const auto json = run.json();
  for (const auto& found : json["remarks"]) {
    if (found["key"] == key) return found["value"];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

TEST(ThetaMax, IsThatOfTheSourceOrThePapersAndIsTold) {
  const ScratchFolder folder;
  const std::string table = folder / "in.binary";
  const std::string out = folder / "out.sbrdf";
  write_bytes(table, merl_bytes(kHemisphereShape, smooth_values()));
  const auto told = [&](const std::vector<std::string>& arguments, const std::string& in) {
    std::vector<std::string> all = {in, out, "--json"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const ProgramRun run = convert(all, kQuick);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run_sbrdf({"info", out, "--json"}).json()["theta_max_deg"], remark(run, "theta_max_deg"));
    return remark(run, "theta_max_deg");
  };
  EXPECT_EQ(told({}, table), 90);
  EXPECT_EQ(told({}, "kurt:wood01"), 80);
  EXPECT_EQ(told({"--theta-max", "62.5"}, table), 62.5);
  EXPECT_EQ(told({"--theta-max", "62.504", "--frame", "half-difference"}, table), 62.5) << "in hundredths";
  EXPECT_EQ(told({"--theta-max", "85"}, "kurt:wood01"), 85);
  const ProgramRun placed = convert({table, out, "--placement", "40/180", "--samples", "300", "--json"});
  EXPECT_EQ(remark(placed, "theta_max_deg"), 80);
  const ProgramRun placed_further =
      convert({table, out, "--placement", "40/180", "--samples", "300", "--theta-max", "90", "--json"});
  EXPECT_EQ(remark(placed_further, "theta_max_deg"), 90);
  EXPECT_EQ(run_sbrdf({"info", out, "--json"}).json()["placement"]["elevations_deg"],
            (std::vector<double>{0, 40, 80, 90}));
}

TEST(ThetaMax, IsNamedInReportsOfBothDirections) {
  const ScratchFolder folder;
  const std::string sliced = folder / "out.sbrdf";
  const ProgramRun there = convert({"kurt:wood01", sliced, "--placement", "40/180", "--samples", "300"});
  EXPECT_THAT(there.out, HasSubstr("slices go up to theta_max = 80 degrees; in the 17.4 % of the hemisphere beyond"));
  EXPECT_THAT(run_sbrdf({"info", sliced}).out, ContainsRegex("\ntheta_max_deg +80\\.0\n"));
  const ProgramRun back = convert({sliced, folder / "back.binary", "--merl-shape", "15,18,12"});
  EXPECT_THAT(back.out, HasSubstr("have a direction beyond theta_max = 80 degrees"));
  EXPECT_THAT(back.out, HasSubstr("held at theta_max"));
}

TEST(ThetaMax, IsNamedWherePairsBeyondItAreEvaluated) {
  const ScratchFolder folder;
  const std::string sliced = folder / "out.sbrdf";
  ASSERT_EQ(convert({"kurt:wood01", sliced, "--placement", "40/180", "--samples", "300"}).exit_code, 0);
  const std::string part = folder / "part.sbrdf";
  const ProgramRun extracted = run_sbrdf({"extract", sliced, part, "--theta-max", "40"});
  EXPECT_THAT(extracted.out, HasSubstr("directions up to theta_max = 40 degrees"));
  const std::string header = "theta_i,phi_i,theta_v,phi_v\n";
  const RunOptions within = {.input = header + "40,0,20,180\n95,0,20,180\n"};
  const RunOptions beyond = {.input = header + "40,0,20,180\n20,0,41,180\n80,0,0,0\n"};
  EXPECT_EQ(run_sbrdf({"eval", part}, within).err, "");
  const ProgramRun run = run_sbrdf({"eval", part}, beyond);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err,
            "sbrdf: " + part +
                ": 2 of 3 pairs have a direction beyond theta_max = 40 degrees: the value held at theta_max\n");
  EXPECT_EQ(run_sbrdf({"eval", sliced}, beyond).err, "");
}

TEST(ThetaMax, IsRefusedWhereItCannotBe) {
  for (const char* text : {"0", "4.9", "90.1", "-80", "nan", "x"}) {
    const ProgramRun run = run_sbrdf({"convert", "kurt:wood01", "/nowhere/out.sbrdf", "--theta-max", text});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, HasSubstr("--theta-max"));
  }
}

TEST(UnmeasuredDirections, AreToldByInfoAndKeptByPartsAndCopies) {
  const ScratchFolder folder;
  const std::string table = folder / "in.binary";
  const std::string sliced = folder / "out.sbrdf";
  write_bytes(table, merl_bytes(kHemisphereShape, with_holes()));
  EXPECT_THAT(run_sbrdf({"info", table}).out, HasSubstr("cells unmeasured above the horizon"));
  const ProgramRun run = convert({table, sliced}, kQuick);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("samples at directions that were not measured"));
  ASSERT_EQ(run_sbrdf({"extract", sliced, folder / "part.sbrdf", "--level", "1"}).exit_code, 0);
  ASSERT_EQ(convert({sliced, folder / "copy.sbrdf", "--precision", "1%"}).exit_code, 0);
  ASSERT_EQ(convert({sliced, folder / "again.sbrdf"}, kQuick).exit_code, 0);
  const auto mask = decode_sliced(read_bytes(sliced)).value().sliced.mask;
  ASSERT_NE(mask, nullptr);
  for (const char* name : {"part.sbrdf", "copy.sbrdf", "again.sbrdf"}) {
    const auto other = decode_sliced(read_bytes(folder / name)).value().sliced.mask;
    ASSERT_NE(other, nullptr) << name;
    EXPECT_EQ(*other, *mask) << name;
    const auto told = run_sbrdf({"info", folder / name, "--json"}).json()["mask"];
    EXPECT_EQ(told["cells"], (std::vector<int>{1, 15, 18, 12}));
    EXPECT_EQ(told["frame"], "half-difference");
  }
}

TEST(NonFiniteValues, OfAMerlTableAreHolesThatAreToldUnlessRefused) {
  const ScratchFolder folder;
  std::vector<double> values = smooth_values();
  values[0] = std::numeric_limits<double>::quiet_NaN();
  values[2 * kHemisphereCells + 30] = std::numeric_limits<double>::infinity();
  const std::string in = folder / "in.binary";
  write_bytes(in, merl_bytes(kHemisphereShape, values));
  const ProgramRun run = convert({in, folder / "out.sbrdf"}, kQuick);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 of 3,240 cells with a value that is NaN, infinite"));
  EXPECT_THAT(run.out, HasSubstr("the first at theta_h 0, theta_d 0, phi_d 0, channel R"));
  const ProgramRun refused = convert({in, folder / "refused.sbrdf", "--non-finite", "refuse"});
  expect_failure(refused, 3, in, "2 of 9720 MERL values are NaN, infinite");
  EXPECT_THAT(refused.err, HasSubstr("(at byte 12)"));
}

TEST(NegativeValues, AreWhatThePolicySaysOnTheWayInAndOut) {
  const ScratchFolder folder;
  std::vector<double> values = smooth_values();
  values[5] = -3;
  const std::string in = folder / "in.binary";
  const std::string out = folder / "out.binary";
  write_bytes(in, merl_bytes(kHemisphereShape, values));
  const auto red_and_green = [&](const char* policy) {
    const ProgramRun run = convert({in, out, "--negatives", policy});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const MerlTable table = parse_merl(read_bytes(out)).value();
    return std::array<double, 2>{table.values[5], table.values[kHemisphereCells + 5]};
  };
  EXPECT_EQ(red_and_green("keep")[0], -3);
  EXPECT_NEAR(red_and_green("clamp")[0], 0, 1e-6);
  EXPECT_NEAR(red_and_green("clamp")[1], values[kHemisphereCells + 5], 1e-3);
  EXPECT_EQ(red_and_green("unmeasured"), (std::array<double, 2>{-1, -1}));
  EXPECT_THAT(run_sbrdf({"convert", "--help"}).out, HasSubstr("--negatives keep|clamp|unmeasured"));
  expect_failure(convert({"kurt:wood01", folder / "out.sbrdf", "--negatives", "clamp"}), 1, "kurt:wood01",
                 "--negatives is an option of .binary files");
}

}  // namespace
}  // namespace sbrdf::internal
