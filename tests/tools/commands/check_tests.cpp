#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "converters/files/merl/merl_source.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

constexpr std::array<std::int32_t, 3> kShape = {15, 18, 12};
constexpr std::size_t kCells = std::size_t{15} * 18 * 12;

/// Numbers on disk of a table that is f_r = `f` everywhere.
std::vector<double> constant_values(double f) {
  std::vector<double> values(3 * kCells);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = f / kMerlScale[k / kCells];
  return values;
}

TEST(CheckCommand, SaysThatAWhiteTableIsPlausibleAndItsAlbedoOne) {
  const ScratchFolder folder;
  const std::string file = folder / "white.binary";
  write_bytes(file, merl_bytes(kShape, constant_values(1 / 3.14159265358979)));
  const ProgramRun run = run_sbrdf({"check", file, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = run.json();
  ASSERT_EQ(json.size(), 1U);
  EXPECT_EQ(json[0]["verdict"], "plausible");
  ASSERT_EQ(json[0]["albedos"].size(), 7U);
  for (const auto& albedo : json[0]["albedos"]) {
    for (const double value : albedo["albedo"]) EXPECT_NEAR(value, 1, 1e-4) << albedo.dump();
    EXPECT_EQ(albedo["accuracy_reached"], true);
  }
  EXPECT_EQ(json[0]["reciprocity"]["by_construction"], true);
  const ProgramRun told = run_sbrdf({"check", file});
  for (const char* word : {"theta_i 85", "reciprocal by construction", "verdict", "plausible", "1.0000"}) {
    EXPECT_THAT(told.out, HasSubstr(word));
  }
}

TEST(CheckCommand, HoldsFiguresAgainstLimitsAndJudgesEveryFile) {
  const ScratchFolder folder;
  const std::string white = folder / "white.binary";
  const std::string large = folder / "large.binary";
  write_bytes(white, merl_bytes(kShape, constant_values(0.3)));
  write_bytes(large, merl_bytes(kShape, constant_values(0.3 * 1500)));
  const ProgramRun free = run_sbrdf({"check", large, white, "--json"});
  EXPECT_EQ(free.exit_code, 0);
  EXPECT_EQ(free.json()[0]["verdict"], "suspicious: 2 remarks");
  EXPECT_EQ(free.json()[0]["remarks"][1]["topic"], "scale");
  EXPECT_EQ(free.json()[1]["verdict"], "plausible");
  EXPECT_EQ(run_sbrdf({"check", white, "--max-albedo", "1", "--max-spikes", "0"}).exit_code, 0);
  expect_failure(run_sbrdf({"check", large, white, "--max-albedo", "1", "--json"}), 5, large,
                 "the highest albedo 1414 is above the limit of 1");
  const ProgramRun both = run_sbrdf({"check", large, folder / "none.binary", white, "--max-albedo", "1", "--json"});
  EXPECT_EQ(both.exit_code, 2) << "what cannot be read is worse";
  ASSERT_EQ(both.json().size(), 3U);
  EXPECT_THAT(both.json()[1]["error"].get<std::string>(), HasSubstr("No such file"));
}

TEST(CheckCommand, SaysWhatIsMissingOrNegative) {
  const ScratchFolder folder;
  const std::string file = folder / "holes.binary";
  std::vector<double> values = constant_values(0.2);
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    if (cell % 12 < 6) values[cell] = -1;                                                           // red only
    if (cell / 12 % 18 < 2) values[cell] = values[kCells + cell] = values[2 * kCells + cell] = -1;  // a mark
  }
  write_bytes(file, merl_bytes(kShape, values));
  const auto json = run_sbrdf({"check", file, "--json"}).json()[0];
  EXPECT_GT(json["shares"]["negative"]["percent"], 30);
  EXPECT_GT(json["shares"]["unmeasured"]["percent"], 2);
  EXPECT_EQ(json["shares"]["out_of_gamut"]["worst_at"]["channel"], "R");
  expect_failure(run_sbrdf({"check", file, "--max-negative", "1"}), 5, file, "the negative share");
  expect_failure(run_sbrdf({"check", file, "--max-unmeasured", "1"}), 5, file, "the unmeasured share");
  EXPECT_EQ(run_sbrdf({"check", file, "--max-negative", "101"}).exit_code, 1);
}

TEST(CheckCommand, FindsAModelPlausible) {
  const ProgramRun run = run_sbrdf({"check", "kurt:wood01", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json()[0]["suspicious"], 0) << run.json()[0]["remarks"].dump();
}

TEST(CheckCommand, HelpsWithAnExample) {
  const ProgramRun run = run_sbrdf({"check", "--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("Examples:\n  sbrdf check"));
  for (const char* option : {"--max-albedo", "--max-reciprocity", "--max-negative", "--max-unmeasured", "--max-spikes",
                             "--accuracy", "--json", "--memory-limit"}) {
    EXPECT_THAT(run.out, HasSubstr(option));
  }
}

}  // namespace
}  // namespace sbrdf::internal
