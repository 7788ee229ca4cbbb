#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "converters/files/format_table.h"
#include "tests/support/function_source.h"
#include "tests/support/small_files.h"
#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// What formats declare, seen from the command line.

TEST(FormatOptionsOfConvert, AllStandInTheHelpInAGroupOfTheFirstFormatThatHasThem) {
  const std::string help = run_sbrdf({"convert", "--help"}).out;
  std::set<std::string_view> seen;
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      if (!seen.insert(option.name).second) continue;
      const std::size_t group = help.find("For " + std::string(format.extension) + " files");
      ASSERT_NE(group, std::string::npos) << format.name;
      const std::size_t at = help.find("\n  --" + std::string(option.name) + " ");
      ASSERT_NE(at, std::string::npos) << option.name;
      EXPECT_GT(at, group) << option.name;
      EXPECT_THAT(help, HasSubstr(std::string(option.meaning)));
      EXPECT_THAT(help, HasSubstr(std::string(option.fallback)));
    }
  }
}

TEST(FormatOptionsOfConvert, ShapesAMerlTable) {
  const ScratchFolder folder;
  const std::string out = folder / "out.binary";
  ASSERT_EQ(run_sbrdf({"convert", "kurt:wood01", out, "--merl-shape", "4,5,6"}).exit_code, 0);
  EXPECT_EQ(std::filesystem::file_size(out), 12 + 24 * 120);
  EXPECT_EQ(run_sbrdf({"info", out, "--json"}).json()["shape"], (std::vector<int>{4, 5, 6}));
  const std::vector<std::byte> before = read_bytes(out);
  ASSERT_EQ(run_sbrdf({"convert", out, folder / "copy.binary"}).exit_code, 0);
  EXPECT_EQ(read_bytes(folder / "copy.binary"), before);
}

TEST(FormatOptionsOfConvert, NamesAMaterialOfABundle) {
  const ScratchFolder folder;
  const std::string bundle = folder / "all.sbrdfz";
  write_bytes(bundle, small_files::bundle());
  ASSERT_EQ(run_sbrdf({"convert", bundle, folder / "a.sbrdf", "--material", "a"}).exit_code, 0);
  ASSERT_EQ(run_sbrdf({"convert", bundle + ":a", folder / "b.sbrdf"}).exit_code, 0);
  EXPECT_EQ(read_bytes(folder / "a.sbrdf"), small_files::sliced());
  EXPECT_EQ(read_bytes(folder / "b.sbrdf"), small_files::sliced());
  expect_failure(run_sbrdf({"convert", bundle, folder / "c.sbrdf"}), 1, bundle, "2 materials");
  expect_failure(run_sbrdf({"convert", bundle, folder / "c.sbrdf", "--material", "c"}), 1, bundle, "no material 'c'");
}

TEST(FormatOptionsOfConvert, AreRefusedWhereTheyMeanNothing) {
  const ScratchFolder folder;
  const std::string sliced = folder / "out.sbrdf";
  const std::string table = folder / "out.binary";
  write_bytes(folder / "in.binary", small_merl());
  expect_failure(run_sbrdf({"convert", "kurt:wood01", sliced, "--merl-shape", "4,5,6"}), 1, sliced,
                 "--merl-shape is an option of .binary files, not of .sbrdf files that are written");
  expect_failure(run_sbrdf({"convert", "kurt:wood01", table, "--samples", "50"}), 1, table,
                 "--samples is an option of .sbrdf files, not of .binary files that are written");
  for (const std::string& in : {folder / "in.binary", std::string("kurt:wood01")}) {
    expect_failure(run_sbrdf({"convert", in, table, "--material", "a"}), 1, in, "--material is an option of .sbrdfz");
  }
  EXPECT_THAT(folder.entries(), ElementsAre("in.binary"));
}

TEST(FormatOptionsOfConvert, StandInTheMetadataAsGivenInTheOrderOfTheirDeclaration) {
  const ScratchFolder folder;
  const std::string out = folder / "out.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", "kurt:wood01", out, "--chunks", "split", "--no-mirrors", "--placement", "40/90",
                       "--domain", "linear", "--samples", "0500", "--metadata", "full"})
                .exit_code,
            0);
  EXPECT_EQ(run_sbrdf({"info", out, "--json"}).json()["metadata"]["command"],
            "sbrdf convert kurt:wood01 out.sbrdf --samples 0500 --domain linear --placement 40/90 --no-mirrors "
            "--chunks split --metadata full");
}

/// A sliced file with one channel.
std::vector<std::byte> grey_sliced() {
  const FunctionSource source([](const DirectionPair&, std::size_t) { return 0.25; }, {true, true, {"grey"}});
  MemorySink sink;
  Report report;
  const Options options = Options().set("samples", "60").set("placement", "40/180").set("values", "measured");
  EXPECT_TRUE(save_source(*find_writer(".sbrdf").value(), source, sink, options, report).ok());
  return std::move(sink).take();
}

TEST(Convert, TakesWhatEvalPrints) {
  const ScratchFolder folder;
  write_bytes(folder / "parameters.json", small_files::bytes_of(small_files::kKurtJson));
  write_bytes(folder / "no extension", small_merl());
  write_bytes(folder / "slices", small_sliced());
  write_bytes(folder / "grey:1.sbrdf", grey_sliced());
  write_bytes(folder / "bundle", small_files::bundle());
  write_bytes(folder / "tensors", small_files::of("rgl"));
  write_bytes(folder / "bins", small_files::of("ngan"));
  write_bytes(folder / "directions", small_files::of("utia"));
  for (const std::string& in :
       {std::string("kurt:wood01"), "kurt:" + (folder / "parameters.json"), folder / "parameters.json",
        folder / "no extension", folder / "slices", folder / "grey:1.sbrdf", (folder / "bundle") + ":b",
        folder / "tensors", folder / "bins", folder / "directions"}) {
    const ProgramRun eval = run_sbrdf({"eval", in}, {.input = "theta_i,phi_i,theta_v,phi_v\n10,0,20,30\n"});
    ASSERT_EQ(eval.exit_code, 0) << in << eval.err;
    const std::vector<std::vector<std::string>> outputs = {
        plainly({"convert", in, folder / "out.sbrdf", "--samples", "60", "--placement", "40/180"}),
        {"convert", in, folder / "out.binary", "--merl-shape", "6,6,6"},
        {"convert", in, folder / "out.dat", "--ngan-shape", "3,3,6,4"}};
    for (const std::vector<std::string>& arguments : outputs) {
      const ProgramRun run = run_sbrdf(arguments);
      EXPECT_EQ(run.exit_code, 0) << in << run.err;
      EXPECT_EQ(run_sbrdf({"info", arguments[2]}).exit_code, 0) << in;
    }
  }
}

TEST(Convert, WritesNoFileThatNothingReads) {
  const ScratchFolder folder;
  write_bytes(folder / "black.json", small_files::bytes_of(R"({"name": "black", "k_d": [0, 0, 0], "lobes": []})"));
  const std::string in = "kurt:" + (folder / "black.json");
  EXPECT_EQ(run_sbrdf({"eval", in}, {.input = "theta_i,phi_i,theta_v,phi_v\n10,0,20,30\n"}).exit_code, 0);
  expect_failure(run_sbrdf({"convert", in, folder / "out.binary"}), 3, in, "no value of the source is positive");
  expect_failure(run_sbrdf({"convert", in, folder / "out.sbrdf", "--samples", "60", "--placement", "40/180"}), 3, in,
                 "is positive");
  EXPECT_THAT(folder.entries(), ElementsAre("black.json"));
}

TEST(ConvertInterrupted, WhileWritingATableLeavesNothing) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const ScratchFolder folder;
    RunningSbrdf program({"convert", "kurt:fabric112", folder / "out.binary", "--merl-shape", "1000,1000,200"},
                         Output::kTerminal);
    EXPECT_THAT(program.read_up_to('%'), HasSubstr("converting"));
    program.signal(signal);
    EXPECT_EQ(program.wait(), 128 + signal);
    EXPECT_THAT(folder.entries(), IsEmpty());
  }
}

/// The program with at most so much memory of its own; mapped files do not count.
ProgramRun run_within(int mib, std::vector<std::string> arguments) {
  std::vector<std::string> command = {"sh", "-c", "ulimit -d " + std::to_string(mib * 1024) + " && exec \"$0\" \"$@\"",
                                      SBRDF_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_command(command);
}

// 202 MB, through 150 MB of which TBB's threads take their part: the file is never in memory as a whole.
TEST(LargeTable, IsWrittenReadCopiedAndComparedWithoutItsSizeInMemory) {
  const ScratchFolder folder;
  const std::string table = folder / "a.binary";
  const std::string copy = folder / "b.binary";
  constexpr int kLimit = 150;
  const ProgramRun written = run_within(kLimit, {"convert", "kurt:wood01", table, "--merl-shape", "200,200,210"});
  ASSERT_EQ(written.exit_code, 0) << written.err;
  EXPECT_EQ(std::filesystem::file_size(table), 12 + 24 * 8'400'000);
  const ProgramRun copied = run_within(kLimit, {"convert", table, copy});
  ASSERT_EQ(copied.exit_code, 0) << copied.err;
  const ProgramRun compared = run_within(kLimit, {"compare", table, copy, "--random", "20000", "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_EQ(compared.json()["rel_l1_percent"], 0);
  const ProgramRun sampled =
      run_within(kLimit, {"convert", table, folder / "c.sbrdf", "--samples", "60", "--placement", "40/180"});
  EXPECT_EQ(sampled.exit_code, 0) << sampled.err;
}

}  // namespace
}  // namespace sbrdf::internal
