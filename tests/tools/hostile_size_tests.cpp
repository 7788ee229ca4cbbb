#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "codec/file/reader.h"
#include "tests/support/hostile_files.h"
#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kShare = 0.2;
constexpr std::uint64_t kMostMemory = 100'000'000;

#ifdef SBRDF_SANITIZED_PROGRAM
constexpr bool kMeasuresMemory = false;  // the sanitizer's own is far more
#else
constexpr bool kMeasuresMemory = true;
#endif

/// Every command that reads a sliced file; IN is the file, MATERIAL what names the material in it.
const std::vector<std::vector<std::string>> kCommands = {
    {"info", "MATERIAL"},
    {"verify", "IN"},
    {"eval", "MATERIAL"},
    {"compare", "MATERIAL", "kurt:wood01", "--random", "9"},
    {"compare", "kurt:wood01", "MATERIAL", "--random", "9"},
    {"convert", "MATERIAL", "OUT.sbrdf"},
    {"convert", "MATERIAL", "OUT.binary"},
    {"extract", "IN", "OUT.sbrdf", "--level", "1"},
    {"codings", "MATERIAL"},
};

/// By name, and made when they are first needed: that takes longer than most tests do.
class HostileSizes : public testing::TestWithParam<const char*> {
 protected:
  HostileSizes() { write_bytes(file_, hostile().bytes); }

  [[nodiscard]] static const HostileCase& hostile() {
    static const std::vector<HostileCase> cases = hostile_cases(kShare);
    return *std::find_if(cases.begin(), cases.end(), [](const HostileCase& one) { return one.name == GetParam(); });
  }
  [[nodiscard]] bool bundled() const { return hostile().name.ends_with(".sbrdfz"); }

  [[nodiscard]] ProgramRun run(std::vector<std::string> words, const std::vector<std::string>& more = {}) const {
    for (std::string& word : words) {
      if (word == "IN") word = file_;
      if (word == "MATERIAL") word = bundled() ? file_ + ":a" : file_;
      if (word.starts_with("OUT")) word = folder_ / word;
    }
    words.insert(words.end(), more.begin(), more.end());
    return run_sbrdf(words, {.input = "theta_i,phi_i,theta_v,phi_v\n10,0,20,30\n"});
  }

  void expect_refused(const ProgramRun& run) const {
    EXPECT_EQ(run.exit_code, 4) << run.err;
    EXPECT_THAT(run.err, HasSubstr("MiB of memory"));
    EXPECT_THAT(run.err, HasSubstr("--memory-limit "));
    expect_little_memory(run);
  }

  static void expect_little_memory(const ProgramRun& run) {
    if (kMeasuresMemory) {
      EXPECT_LT(run.peak_memory, kMostMemory);
    }
  }

  ScratchFolder folder_;
  std::string file_ = folder_ / hostile().name;
};

TEST_P(HostileSizes, AreRefusedByEveryCommandThatReadsSamples) {
  for (const std::vector<std::string>& command : kCommands) {
    if (command[0] == "info" || (bundled() && command[0] == "extract")) continue;
    SCOPED_TRACE(command[0]);
    expect_refused(run(command));
  }
  EXPECT_EQ(folder_.entries(), std::vector<std::string>{hostile().name});
}

TEST_P(HostileSizes, AreToldByInfoWithoutReadingSamples) {
  const ProgramRun told = run({"info", "MATERIAL", "--json"});
  expect_little_memory(told);
  const bool needed_at_once = hostile().name == "lattice.sbrdf" || hostile().name == "metadata.sbrdf" ||
                              hostile().name == "mask.sbrdf" || bundled();  // specs/sbrdf.md, section 12
  if (needed_at_once) {
    expect_refused(told);
    return;
  }
  ASSERT_EQ(told.exit_code, 0) << told.err;
  EXPECT_EQ(told.json()["bytes"], hostile().bytes.size());
}

TEST_P(HostileSizes, AreNotPacked) {
  if (bundled()) return;  // packed already
  expect_refused(run({"pack", folder_.path().string(), "OUT.sbrdfz"}));
  EXPECT_EQ(folder_.entries(), std::vector<std::string>{hostile().name});
}

INSTANTIATE_TEST_SUITE_P(Tools, HostileSizes,
                         testing::Values("crossings.sbrdf", "samples.sbrdf", "sample_channels.sbrdf", "lattice.sbrdf",
                                         "metadata.sbrdf", "mask.sbrdf", "head.sbrdfz"),
                         [](const auto& tested) {
                           const std::string name = tested.param;
                           return name.substr(0, name.find('.'));
                         });

TEST(HostileCases, AreAllTried) { EXPECT_EQ(hostile_cases(kShare).size(), 7U); }

/// Small enough to be read at all, too large for the limit.
std::vector<std::byte> demanding_file() {
  return hostile_file({.frame = elevation_frame(40, 180, {.isotropic = true}).value(), .depth = 16});
}

TEST(MemoryLimitOption, LetsEveryCommandReadWhatItRefusedBefore) {
  const ScratchFolder folder;
  const std::string file = folder / "large.sbrdf";
  write_bytes(file, demanding_file());
  const ProgramRun refused = run_sbrdf({"verify", file});
  ASSERT_EQ(refused.exit_code, 4) << refused.err;
  const std::string option = "--memory-limit ";
  const std::size_t at = refused.err.find(option) + option.size();
  const std::string limit = refused.err.substr(at, refused.err.find(' ', at) - at);
  for (std::vector<std::string> command : kCommands) {
    if (command[0] == "codings" || command.back() == "OUT.binary") continue;
    for (std::string& word : command) {
      if (word == "IN" || word == "MATERIAL") word = file;
      if (word.starts_with("OUT")) word = folder / word;
    }
    if (command[0] == "convert" || command[0] == "extract") std::filesystem::remove(folder / "OUT.sbrdf");
    command.insert(command.end(), {"--memory-limit", std::to_string(2 * std::stoul(limit))});
    const ProgramRun run = run_sbrdf(command, {.input = "theta_i,phi_i,theta_v,phi_v\n10,0,20,30\n"});
    EXPECT_THAT(run.err, Not(HasSubstr("memory"))) << command[0];
  }
}

TEST(MemoryLimitOption, LowersTheLimitToo) {
  const ScratchFolder folder;
  const std::string file = folder / "a.sbrdf";
  write_bytes(file, small_sliced());
  EXPECT_EQ(run_sbrdf({"verify", file, "--memory-limit", "1"}).exit_code, 0);
  const std::string large = folder / "large.sbrdf";
  write_bytes(large, demanding_file());
  expect_failure(run_sbrdf({"verify", large, "--memory-limit", "1"}), 4, large, "the limit is 1 MiB");
}

TEST(MemoryLimitOption, TakesWholeNumbersOnly) {
  for (const char* text : {"0", "-1", "1.5", "much", "2000000000000000"}) {
    const ProgramRun run = run_sbrdf({"verify", "nothing.sbrdf", "--memory-limit", text});
    EXPECT_EQ(run.exit_code, 1) << text;
    EXPECT_THAT(run.err, HasSubstr("--memory-limit"));
  }
}

TEST(Info, ReadsIndexAndMetadataButNoSamples) {
  const ScratchFolder folder;
  const std::string file = folder / "a.sbrdf";
  std::vector<std::byte> bytes = small_sliced();
  write_bytes(file, bytes);
  const ProgramRun whole = run_sbrdf({"info", file});
  bytes[bytes.size() - 6] ^= std::byte{1};  // in the last chunk
  write_bytes(file, bytes);
  EXPECT_EQ(run_sbrdf({"info", file}).out, whole.out);
  expect_failure(run_sbrdf({"verify", file}), 3, file, "[SB-1-7]");
}

}  // namespace
}  // namespace sbrdf::internal
