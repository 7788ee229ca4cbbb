#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "converters/files/format_table.h"
#include "tests/support/small_files.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string kGrid = "difference/0:30:30:30";
const RunOptions kRow = {.input = "theta_i,phi_i,theta_v,phi_v\n30,0,30,180\n"};

/// An array without anything that says where its nodes are, and a MERL table.
class ReadingOptions : public testing::Test {
 protected:
  ReadingOptions() {
    EXPECT_EQ(run_sbrdf({"convert", "kurt:wood01", array_, "--grid", kGrid}).exit_code, 0);
    std::filesystem::remove(array_ + ".json");
    write_bytes(table_, small_files::merl());
  }
  /// Each command that takes them, on these files.
  [[nodiscard]] static std::vector<std::vector<std::string>> commands(const std::string& file) {
    return {{"info", file}, {"eval", file}, {"check", file}, {"compare", file, "kurt:wood01", "--random", "99"}};
  }
  [[nodiscard]] static ProgramRun run(std::vector<std::string> command, const std::vector<std::string>& options) {
    command.insert(command.end(), options.begin(), options.end());
    return run_sbrdf(command, kRow);
  }

  ScratchFolder folder_;
  const std::string array_ = folder_ / "array.npy";
  const std::string table_ = folder_ / "table.binary";
};

TEST_F(ReadingOptions, OfAllFormatsAreThoseOfEveryCommandThatReads) {
  for (const char* command : {"info", "eval", "check", "compare"}) {
    const std::string help = run_sbrdf({command, "--help"}).out;
    for (const Format& format : formats()) {
      for (const OptionSpec& option : format.options) {
        if (option.name == "material" || !reads_with(format, option.name)) continue;
        EXPECT_THAT(help, HasSubstr("\n  --" + std::string(option.name))) << command;
      }
    }
    EXPECT_THAT(help, testing::Not(HasSubstr("--samples"))) << command;
  }
}

TEST_F(ReadingOptions, SayWhatAFileDoesNot) {
  for (const std::vector<std::string>& command : commands(array_)) {
    expect_failure(run(command, {}), 1, array_, "--grid");
    const ProgramRun told = run(command, {"--grid", kGrid});
    EXPECT_EQ(told.exit_code, 0) << told.err;
  }
  const ProgramRun row = run({"eval", array_}, {"--grid", kGrid});
  EXPECT_EQ(row.out, run({"convert", array_, folder_ / "whole.npy"}, {"--grid", kGrid}).exit_code == 0
                         ? run({"eval", folder_ / "whole.npy"}, {}).out
                         : "");
}

TEST_F(ReadingOptions, ThatNoInputHasAreRefused) {
  for (const std::vector<std::string>& command : commands(table_)) {
    expect_failure(run(command, {"--zemax-zeros", "black"}), 1, table_,
                   "--zemax-zeros is an option of reading .bsdf files");
    EXPECT_EQ(run(command, {"--merl-lookup", "nearest"}).exit_code, 0);
  }
  expect_failure(run({"eval", "kurt:wood01"}, {"--grid", kGrid}), 1, "kurt:wood01", "--grid is an option of reading");
  expect_failure(run({"info", array_}, {"--grid", "7:7:7:7"}), 1, "--grid", "does not divide");
}

TEST_F(ReadingOptions, HoldForEachInputThatHasThem) {
  EXPECT_EQ(run({"compare", array_, table_, "--random", "9"}, {"--grid", kGrid, "--merl-lookup", "nearest"}).exit_code,
            0);
  const ProgramRun both = run({"compare", array_, array_, "--random", "99", "--json"}, {"--grid", kGrid});
  EXPECT_EQ(both.json()["rel_l1_percent"], 0);
  EXPECT_EQ(run({"check", table_, array_}, {"--grid", kGrid}).exit_code, 0);
}

TEST_F(ReadingOptions, NameAMaterialOfABundle) {
  const std::string bundle = folder_ / "all.sbrdfz";
  write_bytes(bundle, small_files::bundle());
  EXPECT_EQ(run({"eval", bundle}, {"--material", "a"}).out, run({"eval", bundle + ":a"}, {}).out);
  EXPECT_THAT(run({"info", bundle}, {"--material", "a"}).out, StartsWith("format"));
}

}  // namespace
}  // namespace sbrdf::internal
