#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>
#include <vector>

#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Convert, CopiesMerlBitForBitWithNegativeCells) {
  const ScratchFolder folder;
  std::vector<double> values(90, 0.25);
  values[0] = values[30] = values[60] = -1;  // a mark: every channel of a cell
  values[31] = -0.0625;                      // one channel only
  values[62] = 1e-310;
  write_bytes(folder / "in.binary", merl_bytes({2, 3, 5}, values));
  const ProgramRun run = run_sbrdf({"convert", folder / "in.binary", folder / "out.binary", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(read_bytes(folder / "in.binary"), read_bytes(folder / "out.binary"));
  const auto findings = run.json()["in"]["findings"];
  ASSERT_EQ(findings.size(), 3);  // the mark, that it lies above the horizon, the channel
  for (const auto& finding : findings) EXPECT_EQ(finding["count"], 1);
}

TEST(Convert, CopiesAMerlFileOfTheUsualShapeBitForBit) {
  const ScratchFolder folder;
  ASSERT_EQ(run_sbrdf({"convert", "kurt:wood01", folder / "a.binary"}).exit_code, 0);
  ASSERT_EQ(run_sbrdf({"convert", folder / "a.binary", folder / "b.binary"}).exit_code, 0);
  EXPECT_EQ(std::filesystem::file_size(folder / "a.binary"), 34992012);
  EXPECT_TRUE(read_bytes(folder / "a.binary") == read_bytes(folder / "b.binary"));
}

TEST(Convert, CopiesSlicedFilesUnlessAskedToSampleThemAgain) {
  const ScratchFolder folder;
  const std::string in = folder / "in.sbrdf";
  const std::string out = folder / "out.sbrdf";
  write_bytes(in, small_sliced());
  ASSERT_EQ(run_sbrdf({"convert", in, out}).exit_code, 0);
  EXPECT_EQ(read_bytes(in), read_bytes(out));
  const ProgramRun run =
      run_sbrdf(plainly({"convert", in, out, "--samples", "500", "--domain", "linear", "--placement", "40/90"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(read_bytes(in), read_bytes(out));
  EXPECT_EQ(run_sbrdf({"info", out, "--json"}).json()["domain"], "linear");
}

TEST(Convert, TakesTheSamePathForInAndOut) {
  const ScratchFolder folder;
  const std::string file = folder / "both.binary";
  write_bytes(file, small_merl());
  EXPECT_EQ(run_sbrdf({"convert", file, file}).exit_code, 0);
  EXPECT_EQ(read_bytes(file), small_merl());
  EXPECT_THAT(folder.entries(), ElementsAre("both.binary"));
}

TEST(Convert, ReportsWhatItReadAndWrote) {
  const ScratchFolder folder;
  const std::string out = folder / "out.SBRDF";
  const ProgramRun run =
      run_sbrdf(plainly({"convert", "kurt:fabric112", out, "--samples", "900", "--placement", "28/60", "--json"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = run.json();
  EXPECT_EQ(json["in"]["format"], "kurt");
  EXPECT_TRUE(json["in"]["bytes"].is_null());
  EXPECT_EQ(json["out"]["path"], out);
  EXPECT_EQ(json["out"]["format"], "sbrdf");
  EXPECT_EQ(json["out"]["bytes"], std::filesystem::file_size(out));
  EXPECT_EQ(json["remarks"][0]["key"], "samples");
  EXPECT_EQ(json["remarks"][0]["value"], 900);
  EXPECT_GT(json["seconds"], 0);
}

TEST(Convert, IsQuietOnStandardErrorInAPipe) {
  const ScratchFolder folder;
  const ProgramRun run =
      run_sbrdf({"convert", "kurt:Brushed alum", folder / "out.sbrdf", "--placement", "28/60", "--samples", "900"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out, HasSubstr("900 samples"));
}

/// A table that is zero but for cells within a degree of the horizon, which all held-back directions miss.
std::string nearly_black(const ScratchFolder& folder) {
  constexpr std::size_t kHeld = 90;
  constexpr std::size_t kCells = kHeld * kHeld * 180;
  std::vector<double> values(3 * kCells);
  for (std::size_t channel = 0; channel < 3; ++channel) values[channel * kCells + (kHeld - 1) * kHeld * 180] = 1;
  write_bytes(folder / "black.binary", merl_bytes({90, 90, 180}, values));
  return folder / "black.binary";
}

TEST(Convert, SaysThatAllHeldBackValuesAreZeroInsteadOfAnErrorThatIsNoNumber) {
  const ScratchFolder folder;
  const std::string in = nearly_black(folder);
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--samples", "400", "--placement", "30/60", "--theta-max", "90"},
        {"--samples", "400", "--frame", "half-difference", "--search-evaluations", "20"},
        {"--samples", "400", "--search-evaluations", "20"}}) {
    std::vector<std::string> arguments = {"convert", in, folder / "out.sbrdf"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramRun run = run_sbrdf(arguments);
    EXPECT_THAT(run.out + run.err, testing::Not(testing::ContainsRegex("nan|inf %")));
    EXPECT_THAT(run.out + run.err, testing::AnyOf(HasSubstr("the source is zero on all of these directions"),
                                                  HasSubstr("held-back directions, where all values are zero")));
    EXPECT_THAT(run.exit_code, testing::AnyOf(0, 4));
  }
}

TEST(Convert, RefusesATargetWhereAllHeldBackValuesAreZero) {
  const ScratchFolder folder;
  const std::string in = nearly_black(folder);
  for (const char* option : {"--target-mre", "--target-rel-l1"}) {
    expect_failure(run_sbrdf({"convert", in, folder / "out.sbrdf", option, "3"}), 5, in,
                   "the source is zero on all held-back directions");
  }
}

TEST(Convert, EndsWithADifferenceWhereATargetIsOutOfReachAndSaysHowFarItCame) {
  const ScratchFolder folder;
  for (const auto& [option, value, what] :
       {std::array{"--target-mre", "0.001", "%, was reached with "},
        {"--target-rel-l1", "0.001", "%, was reached with "},
        {"--max-bytes", "60", "no file fits into 60 bytes: the smallest takes "}}) {
    // With so large a gap no more samples find a place, however many are tried.
    expect_failure(run_sbrdf({"convert", "kurt:wood01", folder / "out.sbrdf", option, value, "--placement", "28/180",
                              "--minimum-gap", "20", "--values", "measured"}),
                   5, "kurt:wood01", what);
  }
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(Convert, RefusesFewerSamplesThanCrossings) {
  const ScratchFolder folder;
  const std::string out = folder / "out.sbrdf";
  for (const char* in : {"kurt:fabric112", "kurt:fabric041"}) {
    expect_failure(run_sbrdf({"convert", in, out, "--samples", "3780", "--placement", "14/36"}), 1, in,
                   "3780 samples are fewer than the 3781 crossings");
  }
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(Convert, RefusesFewerSamplesThanAnyStructureTakes) {
  const ScratchFolder folder;
  for (const char* samples : {"1", "10"}) {
    expect_failure(run_sbrdf({"convert", "kurt:fabric112", folder / "out.sbrdf", "--samples", samples}), 1,
                   "kurt:fabric112", std::string("too few samples for any structure: ") + samples);
  }
}

TEST(Convert, RefusesWrongUsage) {
  const ScratchFolder folder;
  const std::string out = folder / "out.sbrdf";
  const std::vector<std::vector<std::string>> wrong = {
      {"--samples", "0"},
      {"--samples", "-1"},
      {"--samples", "1e4"},
      {"--samples", "many"},
      {"--samples", "99999999999"},
      {"--samples", "99999999999999999999999"},
      {"--samples"},
      {"--placement", "14"},
      {"--placement", "14/"},
      {"--placement", "/36"},
      {"--placement", "14/36/2"},
      {"--placement", "14:36"},
      {"--placement", "-14/36"},
      {"--placement", "0/36"},
      {"--placement", "nan/36"},
      {"--placement", "14/inf"},
      {"--placement", " 14/36"},
      {"--frame", "sideways"},
      {"--domain", "cubic"},
      {"--minimum-gap", "-1"},
      {"--minimum-gap", "x"},
      {"--unknown"},
      {"one more"},
      {"--samples", "9000", "--samples", "9001"},
  };
  for (const auto& options : wrong) {
    std::vector<std::string> arguments = {"convert", "kurt:wood01", out};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramRun run = run_sbrdf(arguments);
    EXPECT_EQ(run.exit_code, 1) << testing::PrintToString(options) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_THAT(run.err, testing::EndsWith("see 'sbrdf convert --help'\n"));
  }
  // Numbers, but not of a placement that can be.
  expect_failure(run_sbrdf({"convert", "kurt:wood01", out, "--placement", "14/37"}), 1, "kurt:wood01", "");
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(Convert, RefusesOptionsOfWhichOneWouldHaveNoEffectAndNamesBoth) {
  const ScratchFolder folder;
  const std::vector<std::vector<std::string>> wrong = {
      {"--samples", "500", "--target-mre", "3"},
      {"--target-rel-l1", "3", "--samples", "500"},
      {"--samples", "500", "--max-bytes", "9000"},
      {"--target-mre", "3", "--target-rel-l1", "3"},
      {"--target-mre", "3", "--max-bytes", "9000"},
      {"--max-bytes", "9000", "--target-rel-l1", "3"},
      {"--placement", "14/36", "--search-evaluations", "10"},
      {"--placement", "paper", "--search-evaluations", "10"},
      {"--placement", "14/36", "--frame", "half-difference"},
      {"--frame", "half-difference", "--placement", "paper"},
  };
  for (const auto& options : wrong) {
    std::vector<std::string> arguments = {"convert", "kurt:wood01", folder / "out.sbrdf"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramRun run = run_sbrdf(arguments);
    EXPECT_EQ(run.exit_code, 1) << testing::PrintToString(options) << run.err;
    EXPECT_THAT(run.err, HasSubstr(options[0]));
    EXPECT_THAT(run.err, HasSubstr(options[2]));
    EXPECT_THAT(run.err, testing::EndsWith("see 'sbrdf convert --help'\n"));
  }
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(Convert, SearchesInTheElevationFrameToo) {
  const ScratchFolder folder;
  const ProgramRun run = run_sbrdf({"convert", "kurt:wood01", folder / "out.sbrdf", "--frame", "elevation",
                                    "--search-evaluations", "2", "--samples", "400"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("after 2 structures tried"));
}

TEST(Convert, SaysThatATargetMustBeGreaterThanZero) {
  const ScratchFolder folder;
  for (const char* option : {"--target-mre", "--target-rel-l1"}) {
    for (const char* value : {"-1", "0", "-0", "1000.1"}) {
      const ProgramRun run = run_sbrdf({"convert", "kurt:wood01", folder / "out.sbrdf", option, value});
      EXPECT_EQ(run.exit_code, 1);
      EXPECT_THAT(run.err, HasSubstr(std::string(option) + ": " + value +
                                     " is out of range; it must be greater than 0 and at most 1000"));
    }
  }
}

TEST(ConvertOutput, NeedsAKnownExtension) {
  const ScratchFolder folder;
  for (const char* name : {"out.xyz", "out.obj", "out", "out.", ".sbrdf"}) {
    expect_failure(run_sbrdf({"convert", "kurt:wood01", folder / name}), 1, folder / name,
                   "use one of .sbrdf, .binary");
  }
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(ConvertOutput, TakesOptionsOnSlicesForSlicedFilesOnly) {
  const ScratchFolder folder;
  const std::string out = folder / "out.binary";
  expect_failure(run_sbrdf({"convert", "kurt:wood01", out, "--samples", "9000"}), 1, out, ".sbrdf");
  expect_failure(run_sbrdf({"convert", "kurt:wood01", out, "--domain", "log"}), 1, out, ".sbrdf");
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(ConvertOutput, NeedsAFolderThatExists) {
  const ScratchFolder folder;
  const std::string out = folder / "missing/out.sbrdf";
  expect_failure(run_sbrdf({"convert", "kurt:wood01", out}), 2, out, "missing");
  write_bytes(folder / "file", {});
  expect_failure(run_sbrdf({"convert", "kurt:wood01", folder / "file/out.sbrdf"}), 2, folder / "file/out.sbrdf", "");
  EXPECT_THAT(folder.entries(), ElementsAre("file"));
}

TEST(ConvertOutput, IsCheckedBeforeTheInputIsRead) {
  const ScratchFolder folder;
  const std::string out = folder / "missing/out.sbrdf";
  expect_failure(run_sbrdf({"convert", folder / "missing.binary", out}), 2, out, "");
}

TEST(ConvertOutput, MayNotBeADirectory) {
  const ScratchFolder folder;
  const std::string out = folder / "out.sbrdf";
  std::filesystem::create_directory(out);
  expect_failure(run_sbrdf({"convert", "kurt:wood01", out}), 2, out, "is a directory");
  EXPECT_TRUE(std::filesystem::is_directory(out));
}

TEST(ConvertOutput, MayNotBeADeviceOrAPipe) {
  const ScratchFolder folder;
  const std::string out = folder / "out.sbrdf";
  ASSERT_EQ(mkfifo(out.c_str(), 0600), 0);
  expect_failure(run_sbrdf({"convert", "kurt:wood01", out}), 2, out, "not an ordinary file");
  EXPECT_THAT(folder.entries(), ElementsAre("out.sbrdf"));
}

TEST(ConvertOutput, NeedsAFolderThatTakesFiles) {
  if (geteuid() == 0 && access(SBRDF_PROGRAM, X_OK) != 0) GTEST_SKIP() << "the program cannot be run by nobody";
  const ScratchFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  const std::string out = folder / "out.sbrdf";
  const ProgramRun run =
      run_sbrdf({"convert", "kurt:wood01", out, "--placement", "14/36"}, {.without_privileges = true});
  if (run.exit_code == 97) GTEST_SKIP() << "the folder of the program is closed to the user nobody";
  expect_failure(run, 2, out, "Permission denied");
  EXPECT_THAT(folder.entries(), IsEmpty());
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
}

TEST(ConvertOutput, MayNotBeAFileThatMayNotBeWritten) {
  const ScratchFolder folder;
  const std::string out = folder / "out.sbrdf";
  write_bytes(out, bytes_of("old"));
  std::filesystem::permissions(out, std::filesystem::perms(0444));
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  const ProgramRun run =
      run_sbrdf({"convert", "kurt:wood01", out, "--placement", "14/36"}, {.without_privileges = true});
  if (run.exit_code == 97) GTEST_SKIP() << "the folder of the program is closed to the user nobody";
  expect_failure(run, 2, out, "Permission denied");
  EXPECT_EQ(read_text(out), "old");
  EXPECT_THAT(folder.entries(), ElementsAre("out.sbrdf"));
}

TEST(ConvertOutput, LeavesNothingWhereTheSystemTakesNoFile) {
  if (!std::filesystem::is_directory("/proc/self")) GTEST_SKIP() << "no /proc here";
  expect_failure(run_sbrdf({"convert", "kurt:wood01", "/proc/out.sbrdf"}), 2, "/proc/out.sbrdf", "/proc");
}

TEST(ConvertOutput, LeavesTheOldFileWhenTheNewOneGrowsTooLarge) {
  const ScratchFolder folder;
  const std::string out = folder / "out.sbrdf";
  write_bytes(out, bytes_of("old"));
  expect_failure(run_sbrdf(plainly({"convert", "kurt:fabric112", out, "--placement", "14/36"}), {.largest_file = 4096}),
                 2, out, "File too large");
  EXPECT_EQ(read_text(out), "old");
  EXPECT_THAT(folder.entries(), ElementsAre("out.sbrdf"));
}

// In a mount namespace of its own, which ends with the command.
TEST(ConvertOutput, LeavesTheOldFileWhenTheDiskIsFull) {
  const ScratchFolder folder;
  const auto in_namespace = [&](const std::string& flags, const std::string& script) {
    return run_command({"unshare", flags, "sh", "-c", script, SBRDF_PROGRAM, folder.path().string()});
  };
  const std::string mounted = R"(mount -t tmpfs -o size=16k none "$1" && cd "$1")";
  std::string flags = "-m";
  if (in_namespace(flags, mounted).exit_code != 0) flags = "-rm";
  if (const ProgramRun probe = in_namespace(flags, mounted); probe.exit_code != 0) {
    GTEST_SKIP() << "no small file system can be mounted here: " << probe.err;
  }
  const ProgramRun run =
      in_namespace(flags, mounted +
                              " && printf old > out.sbrdf && { \"$0\" convert kurt:fabric112 "
                              "out.sbrdf --placement 14/36 --values measured --precision lossless; code=$?; } && "
                              "ls -A && cat out.sbrdf && exit $code");
  expect_failure(run, 2, "out.sbrdf", "No space left on device");
  EXPECT_EQ(run.out, "out.sbrdf\nold");
}

TEST(ConvertOutput, KeepsPermissionsAndFollowsLinks) {
  const ScratchFolder folder;
  const std::string target = folder / "target.sbrdf";
  const std::string link = folder / "link.sbrdf";
  write_bytes(target, bytes_of("old"));
  std::filesystem::permissions(target, std::filesystem::perms(0640));
  std::filesystem::create_symlink(target, link);
  ASSERT_EQ(run_sbrdf(plainly({"convert", "kurt:wood01", link, "--placement", "28/60", "--samples", "600"})).exit_code,
            0);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(run_sbrdf({"info", target, "--json"}).json()["samples"]["total"], 600);
  EXPECT_EQ(std::filesystem::status(target).permissions(), std::filesystem::perms(0640));
  EXPECT_THAT(folder.entries(), ElementsAre("link.sbrdf", "target.sbrdf"));
}

TEST(ConvertInterrupted, WhileReadingLeavesNothing) {
  const ScratchFolder folder;
  const std::string in = folder / "in.binary";
  ASSERT_EQ(mkfifo(in.c_str(), 0600), 0);
  RunningSbrdf program({"convert", in, folder / "out.binary"});
  const int writer = open_once_read(in);
  program.signal(SIGINT);
  EXPECT_EQ(program.read_line(), "sbrdf: interrupted");
  EXPECT_EQ(program.wait(), 130);
  close(writer);
  EXPECT_THAT(folder.entries(), ElementsAre("in.binary"));
}

TEST(ConvertInterrupted, WhileSamplingLeavesNothing) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const ScratchFolder folder;
    const std::string in = folder / "in.json";
    ASSERT_EQ(mkfifo(in.c_str(), 0600), 0);
    RunningSbrdf program({"convert", "kurt:" + in, folder / "out.sbrdf", "--placement", "6/12", "--samples", "350000"});
    // It has begun when it reads.
    const int writer = open_once_read(in);
    const std::string model = R"({"name": "shiny", "k_d": [0.1, 0.1, 0.1],
        "lobes": [{"k_s": [0.1, 0.1, 0.1], "f_0": 1, "m_x": 0.1, "m_y": 0.05, "alpha": 0.5}]})";
    ASSERT_EQ(write(writer, model.data(), model.size()), static_cast<ssize_t>(model.size()));
    close(writer);
    program.signal(signal);
    EXPECT_EQ(program.wait(), 128 + signal);
    EXPECT_THAT(folder.entries(), ElementsAre("in.json"));
  }
}

}  // namespace
}  // namespace sbrdf::internal
