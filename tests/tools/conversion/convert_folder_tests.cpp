#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "converters/files/format_table.h"
#include "tests/support/small_files.h"
#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A folder to convert and one for what comes out.
class ConvertFolder : public testing::Test {
 protected:
  ConvertFolder() { fs::create_directory(in()); }

  [[nodiscard]] std::string in(const std::string& name = "") const {
    return folder_ / ("in" + (name.empty() ? "" : "/" + name));
  }
  [[nodiscard]] std::string out(const std::string& name = "") const {
    return folder_ / ("out" + (name.empty() ? "" : "/" + name));
  }

  void add(const std::string& name, const std::vector<std::byte>& bytes) const { write_bytes(in(name), bytes); }
  void add_tables(std::uint32_t count) const {
    for (std::uint32_t k = 0; k < count; ++k)
      add("m" + std::to_string(100 + k) + ".binary", small_files::merl({2, 3, k + 1}));
  }
  /// Tables of a few cells, quickly made.
  [[nodiscard]] std::vector<std::string> command(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"convert", in(), out(), "--to", "merl"};
    if (std::find(more.begin(), more.end(), "--merl-shape") == more.end())
      more.insert(more.end(), {"--merl-shape", "4,4,4"});
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  [[nodiscard]] ProgramRun run(const std::vector<std::string>& more = {}, const RunOptions& options = {}) const {
    return run_sbrdf(command(more), options);
  }
  /// Content by name, entries of the journal included.
  [[nodiscard]] static std::map<std::string, std::string> tree(const std::string& folder) {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) all[fs::relative(entry.path(), folder).string()] = read_text(entry.path());
    }
    return all;
  }
  [[nodiscard]] std::vector<std::string> outputs() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(out())) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  const ScratchFolder folder_;
};

/// How many files ended how, by the last line.
std::string sum_of(const ProgramRun& run) {
  const std::size_t end = run.out.rfind("; took");
  const std::size_t start = run.out.rfind('\n', end) + 1;
  return end == std::string::npos ? run.out : run.out.substr(start, end - start);
}

std::map<std::string, int> results(const nlohmann::ordered_json& report) {
  std::map<std::string, int> counts;
  for (const auto& file : report) ++counts[file["result"]];
  return counts;
}

/// Of each row that is read, and holds one material, a name for its files and a small one. New rows come in by
/// themselves.
std::vector<std::pair<std::string, std::vector<std::byte>>> one_of_each_format() {
  std::vector<std::pair<std::string, std::vector<std::byte>>> all;
  for (const Format& format : formats()) {
    if (!format.capabilities.has(Capability::kRead) || format.capabilities.has(Capability::kManyMaterials)) continue;
    // One that needs a second file or an option to say where its nodes are.
    const auto bytes = std::make_shared<OwnedMemorySource>(small_files::of(format.name));
    if (!open_source(bytes).ok()) continue;
    all.emplace_back(std::string(format.name) + "-N" + std::string(format.extension), small_files::of(format.name));
  }
  return all;
}

TEST_F(ConvertFolder, ConvertsSixtyFilesOfAllFormatsButForThreeThatItNames) {
  const auto kinds = one_of_each_format();
  for (std::size_t k = 0; k < 57; ++k) {
    std::string name = kinds[k % kinds.size()].first;
    name.replace(name.find("-N"), 2, "-" + std::to_string(k));
    add(name, kinds[k % kinds.size()].second);
  }
  std::vector<std::byte> cut = small_files::merl();
  cut.pop_back();
  add("bad-cut.binary", cut);
  add("bad-nan.binary", merl_bytes({2, 2, 2}, std::vector<double>(24, std::numeric_limits<double>::quiet_NaN())));
  add("bad-page.bsdf", bytes_of("<!DOCTYPE html><html><body>404</body></html>"));
  add("README.txt", bytes_of("Sixty materials."));
  add("LICENSE", bytes_of("Do as you like."));
  const std::string report = folder_ / "report.json";
  const ProgramRun done = run({"--report", report});
  EXPECT_EQ(done.exit_code, 3);
  EXPECT_EQ(sum_of(done), "57 converted, 0 kept, 3 failed, 2 skipped");
  EXPECT_EQ(std::count(done.out.begin(), done.out.end(), '\n'), 57 + 2 + 1);
  EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 3) << done.err;
  for (const char* name : {"bad-cut.binary", "bad-nan.binary", "bad-page.bsdf"}) {
    EXPECT_THAT(done.err, HasSubstr("sbrdf: " + in(name) + ": "));
  }
  EXPECT_EQ(outputs().size(), 57 + 1);  // and the journal
  EXPECT_EQ(results(nlohmann::ordered_json::parse(read_text(report))),
            (std::map<std::string, int>{{"converted", 57}, {"failed", 3}, {"skipped", 2}}));
  const ProgramRun again = run();
  EXPECT_EQ(again.exit_code, 3);
  EXPECT_EQ(sum_of(again), "0 converted, 57 kept, 3 failed, 2 skipped");
}

TEST_F(ConvertFolder, MakesTheFilesThatSingleConversionsMake) {
  for (const auto& [name, bytes] : one_of_each_format()) add(name, bytes);
  for (const std::vector<std::string>& how : {std::vector<std::string>{"--to", "merl", "--merl-shape", "4,4,4"},
                                              plainly({"--to", "sbrdf", "--placement", "40/180", "--samples", "60"})}) {
    std::vector<std::string> whole = {"convert", in(), out()};
    whole.insert(whole.end(), how.begin(), how.end());
    ASSERT_EQ(run_sbrdf(whole).err, "");
    for (const auto& [name, bytes] : one_of_each_format()) {
      std::vector<std::string> single = {
          "convert", in(name), folder_ / fs::path(name).stem().string() + (how[1] == "merl" ? ".binary" : ".sbrdf")};
      single.insert(single.end(), how.begin(), how.end());
      ASSERT_EQ(run_sbrdf(single).err, "");
      EXPECT_TRUE(read_text(out(fs::path(single[2]).filename().string())) == read_text(single[2])) << single[2];
    }
  }
}

// Signals come after the first lines of output, when more is left to do than they take to arrive.
TEST_F(ConvertFolder, InterruptedTwiceDoesTheRestOnly) {
  constexpr int kFiles = 40;
  add_tables(kFiles);
  const std::string report = folder_ / "report.json";
  int kept = 0;
  for (int turn = 0; turn < 2; ++turn) {
    RunningSbrdf program(command({"--report", report}));
    for (int k = 0; k < kept + 2; ++k) EXPECT_THAT(program.read_line(), HasSubstr(k < kept ? "kept" : "converted"));
    program.signal(SIGINT);
    ASSERT_EQ(program.wait(), 130);
    const auto told = results(nlohmann::ordered_json::parse(read_text(report)));
    EXPECT_EQ(told.count("failed"), 0);
    EXPECT_EQ(told.count("kept") == 0 ? 0 : told.at("kept"), kept);
    kept += told.at("converted");
    ASSERT_LT(kept, kFiles);
    EXPECT_EQ(outputs().size(), kept + 1U);
  }
  const ProgramRun rest = run();
  EXPECT_EQ(sum_of(rest),
            std::to_string(kFiles - kept) + " converted, " + std::to_string(kept) + " kept, 0 failed, 0 skipped");
  EXPECT_EQ(rest.exit_code, 0);
}

TEST_F(ConvertFolder, KilledTwiceDoesTheRestOnlyAndLeavesNothingHalfWritten) {
  constexpr int kFiles = 40;
  add_tables(kFiles);
  int whole = 0;
  for (int turn = 0; turn < 2; ++turn) {
    RunningSbrdf program(command());
    for (int k = 0; k < whole + 3; ++k) EXPECT_NE(program.read_line(), "");
    program.signal(SIGKILL);
    ASSERT_EQ(program.wait(), 128 + SIGKILL);
    whole = static_cast<int>(std::distance(fs::directory_iterator(out(".sbrdf-convert")), {}));
    EXPECT_GE(whole, 3 * (turn + 1));
    ASSERT_LT(whole, kFiles);
    for (const std::string& name : outputs())
      EXPECT_THAT(name, testing::MatchesRegex("m[0-9]+\\.binary|\\.sbrdf-convert"));
  }
  EXPECT_EQ(sum_of(run()),
            std::to_string(kFiles - whole) + " converted, " + std::to_string(whole) + " kept, 0 failed, 0 skipped");
  const auto interrupted = tree(out());
  fs::remove_all(out());
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_TRUE(tree(out()) == interrupted);
}

TEST_F(ConvertFolder, DoesAgainWhatOtherOptionsHaveAnEffectOn) {
  add_tables(2);
  add("bundle.sbrdfz", small_files::bundle());
  EXPECT_EQ(sum_of(run({"--material", "a"})), "3 converted, 0 kept, 0 failed, 0 skipped");
  EXPECT_EQ(sum_of(run({"--material", "a"})), "0 converted, 3 kept, 0 failed, 0 skipped");
  EXPECT_EQ(sum_of(run({"--material", "b"})), "1 converted, 2 kept, 0 failed, 0 skipped");
  EXPECT_EQ(sum_of(run({"--material", "b", "--merl-shape", "4,4,5"})), "3 converted, 0 kept, 0 failed, 0 skipped");
  EXPECT_EQ(sum_of(run({"--material", "b", "--merl-shape", "4,4,5"})), "0 converted, 3 kept, 0 failed, 0 skipped");
}

TEST_F(ConvertFolder, DoesAgainWhatSomebodyChanged) {
  add_tables(8);
  add("m100.binary.json", bytes_of("{}"));
  ASSERT_EQ(run().exit_code, 0);
  const auto before = tree(out());
  fs::resize_file(out("m100.binary"), 100);
  std::string text = read_text(out("m101.binary"));
  text.back() ^= 1;
  write_bytes(out("m101.binary"), bytes_of(text));
  fs::remove(out("m102.binary"));
  write_bytes(out(".sbrdf-convert/m103.binary.json"), bytes_of("{\"work\":"));
  fs::remove(out(".sbrdf-convert/m104.binary.json"));
  EXPECT_EQ(sum_of(run()), "5 converted, 3 kept, 0 failed, 1 skipped");
  EXPECT_TRUE(tree(out()) == before);

  add("m105.binary", small_files::merl({3, 3, 3}));
  fs::last_write_time(in("m106.binary"), fs::file_time_type::clock::now());  // its content is the same
  add("m100.binary.json", bytes_of("{ }"));
  EXPECT_EQ(sum_of(run()), "2 converted, 6 kept, 0 failed, 1 skipped");
}

TEST_F(ConvertFolder, InShardsAtOnceMakesWhatOneRunMakes) {
  for (const auto& [name, bytes] : one_of_each_format()) add(name, bytes);
  add_tables(3);
  const auto words = [&](const std::string& folder, const std::string& shard) {
    return plainly({"convert", in(), folder_ / folder, "--to", ".sbrdf", "--placement", "40/180", "--samples", "60",
                    "--shard", shard});
  };
  ASSERT_EQ(run_sbrdf(words("one", "1/1")).err, "");
  RunningSbrdf first(words("two", "1/2"));
  RunningSbrdf second(words("two", "2/2"));
  EXPECT_EQ(first.wait(), 0);
  EXPECT_EQ(second.wait(), 0);
  const auto one = tree(folder_ / "one");
  EXPECT_EQ(one.size(), 2 * (3 + one_of_each_format().size()));
  EXPECT_TRUE(one == tree(folder_ / "two"));
  EXPECT_THAT(sum_of(run_sbrdf(words("two", "1/1"))), testing::StartsWith("0 converted, "));
}

TEST_F(ConvertFolder, MayBeDoneByTwoRunsOfTheSameFilesAtOnce) {
  add_tables(9);
  RunningSbrdf first(command());
  RunningSbrdf second(command());
  EXPECT_EQ(first.wait(), 0);
  EXPECT_EQ(second.wait(), 0);
  const auto both = tree(out());
  EXPECT_EQ(sum_of(run()), "0 converted, 9 kept, 0 failed, 0 skipped");
  fs::remove_all(out());
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_TRUE(both == tree(out()));
}

TEST_F(ConvertFolder, KeepsWholeNamesWhereTwoFilesWouldBecomeOne) {
  add("a.binary", small_files::of("merl"));
  add("a.bsdf", small_files::of("rgl"));
  add("b.binary", small_files::of("merl"));
  ASSERT_EQ(run().err, "");
  EXPECT_THAT(outputs(), ElementsAre(".sbrdf-convert", "a.binary.binary", "a.bsdf.binary", "b.binary"));
}

TEST_F(ConvertFolder, GoesIntoSubfoldersButNotIntoItsOwnOutputs) {
  fs::create_directory(in("sub"));
  add("a.binary", small_files::merl());
  add("sub/a.binary", small_files::merl());
  const std::vector<std::string> words = {"convert", in(), in("out"), "--to", "binary", "--recursive"};
  for (const std::string expected :
       {"2 converted, 0 kept, 0 failed, 1 skipped", "0 converted, 2 kept, 0 failed, 1 skipped"}) {
    const ProgramRun done = run_sbrdf(words);
    EXPECT_EQ(done.err, "");
    EXPECT_EQ(sum_of(done).substr(0, 27), expected.substr(0, 27));
  }
  EXPECT_TRUE(fs::exists(in("out/sub/a.binary")));
  expect_failure(run_sbrdf({"convert", in("sub"), in(), "--to", "merl", "--recursive"}), 1, in(),
                 "holds the folder that is read");
}

TEST_F(ConvertFolder, RefusesWhatMakesNoSense) {
  add_tables(1);
  const std::string table = in("m100.binary");
  expect_failure(run_sbrdf({"convert", in(), in(), "--to", "sbrdf"}), 1, in(), "choose another one");
  expect_failure(run_sbrdf({"convert", in(), out()}), 2, in(), "is a directory; '--to FORMAT'");
  expect_failure(run_sbrdf({"convert", in(), out(), "--to", "klems"}), 1, "--to", "use one of sbrdf (.sbrdf)");
  expect_failure(run({"--samples", "50"}), 1, out(), "--samples is an option of .sbrdf files");
  expect_failure(run({"--shard", "3/2"}), 1, "--shard", "'3/2' is not one of several parts");
  expect_failure(run_sbrdf({"convert", table, folder_ / "a.sbrdf", "--shard", "1/2"}), 1, "--shard", "for a folder");
  expect_failure(run_sbrdf({"convert", table, folder_ / "a.sbrdf", "--recursive"}), 1, "--recursive", "for a folder");
  expect_failure(run({"--report", table}), 1, table, "must end with .json");
  fs::remove(table);
  expect_failure(run(), 1, in(), "holds nothing to convert");
  EXPECT_THAT(folder_.entries(), ElementsAre("in"));
}

TEST_F(ConvertFolder, DoesNotReplaceBrdfsOfAnotherKindOrItsInput) {
  add_tables(2);
  fs::create_directory(out());
  write_bytes(out("m100.binary"), small_files::sliced());
  fs::create_symlink(in("m101.binary"), out("m101.binary"));
  const auto before = tree(in());
  const ProgramRun done = run();
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_THAT(done.err, HasSubstr("there is a .sbrdf file of that name"));
  EXPECT_THAT(done.err, HasSubstr("is a link to the file that is read"));
  EXPECT_TRUE(read_bytes(out("m100.binary")) == small_files::sliced());
  EXPECT_TRUE(tree(in()) == before);
}

TEST_F(ConvertFolder, NeedsAFolderThatTakesFiles) {
  add_tables(2);
  write_bytes(out(), {});
  expect_failure(run(), 2, out(), "");
  fs::remove(out());
  fs::create_directory(out());
  fs::permissions(out(), fs::perms(0555));
  const ProgramRun closed = run({}, {.without_privileges = true});
  if (closed.exit_code == 97) GTEST_SKIP() << "the folder of the program is closed to the user nobody";
  expect_failure(closed, 2, out(), "Permission denied");
}

TEST_F(ConvertFolder, NamesEveryFileForWhichThereIsNoRoomAndConvertsThemLater) {
  add_tables(3);
  const ProgramRun full = run({}, {.largest_file = 1000});
  EXPECT_EQ(full.exit_code, 2);
  EXPECT_EQ(sum_of(full), "0 converted, 0 kept, 3 failed, 0 skipped");
  EXPECT_EQ(std::count(full.err.begin(), full.err.end(), '\n'), 3);
  EXPECT_THAT(full.err, HasSubstr("sbrdf: " + out("m100.binary") + ": cannot be written: File too large"));
  EXPECT_THAT(outputs(), ElementsAre(".sbrdf-convert"));
  EXPECT_EQ(sum_of(run()), "3 converted, 0 kept, 0 failed, 0 skipped");
}

TEST_F(ConvertFolder, SaysSoWhereThereIsRoomForAnOutputButNotForItsEntry) {
  add("a.binary", small_files::merl({1, 1, 1}));
  const ProgramRun full = run({"--merl-shape", "1,1,1"}, {.largest_file = 600});
  EXPECT_EQ(full.exit_code, 0);
  EXPECT_THAT(full.err, HasSubstr("sbrdf: " + out("a.binary") + ": a later run will convert it again: "));
  EXPECT_EQ(sum_of(run({"--merl-shape", "1,1,1"})), "1 converted, 0 kept, 0 failed, 0 skipped");
}

TEST_F(ConvertFolder, ShowsProgressAndTheTimeLeftOnATerminal) {
  for (const char* name : {"a.json", "b.json"}) add(name, bytes_of(small_files::kKurtJson));
  RunningSbrdf program({"convert", in(), out(), "--to", "merl", "--merl-shape", "300,300,200"}, Output::kTerminal);
  EXPECT_THAT(program.read_up_to('%'), testing::MatchesRegex("\r.*converting \\[=* *\\] +[0-9]+ "));
  EXPECT_THAT(program.read_up_to('t'), HasSubstr(" lef"));
  program.signal(SIGINT);
  EXPECT_EQ(program.wait(), 130);
  EXPECT_THAT(outputs(), ElementsAre(".sbrdf-convert"));
}

TEST_F(ConvertFolder, PrintsTheReportsAsJson) {
  add("a.binary", small_files::merl());
  add("b.binary", bytes_of("nothing"));
  add("c.md", bytes_of("nothing"));
  const std::string report = folder_ / "report.json";
  const ProgramRun done = run({"--json", "--report", report});
  const auto json = done.json();
  EXPECT_EQ(json, nlohmann::ordered_json::parse(read_text(report)));
  ASSERT_EQ(json.size(), 3);
  EXPECT_EQ(json[0]["result"], "skipped");
  EXPECT_EQ(json[0]["reason"], "it is a document");
  EXPECT_EQ(json[1]["result"], "converted");
  EXPECT_EQ(json[1]["in"]["path"], in("a.binary"));
  EXPECT_EQ(json[1]["out"]["path"], out("a.binary"));
  EXPECT_EQ(json[1]["out"]["bytes"], fs::file_size(out("a.binary")));
  EXPECT_EQ(json[2]["result"], "failed");
  EXPECT_EQ(json[2]["error"]["code"], 3);
  // What is kept is told in the same words, but for the time.
  auto kept = run({"--json"}).json()[1];
  EXPECT_EQ(kept["result"], "kept");
  auto converted = json[1];
  converted["result"] = "kept";
  converted["seconds"] = nullptr;
  EXPECT_EQ(kept, converted);
}

TEST(ConvertReport, OfASingleFileIsWhatItPrintsAsJson) {
  const ScratchFolder folder;
  const std::string table = folder / "a.binary";
  const std::string report = folder / "report.json";
  write_bytes(table, small_files::merl());
  const std::vector<std::string> words = {"convert", table,    folder / "b.binary", "--merl-shape",
                                          "4,4,4",   "--json", "--report",          report};
  for (int turn = 0; turn < 2; ++turn) {  // the second time it replaces a report
    const ProgramRun run = run_sbrdf(words);
    ASSERT_EQ(run.err, "");
    EXPECT_EQ(run.json(), nlohmann::ordered_json::parse(read_text(report)));
    EXPECT_EQ(run.json()["result"], "converted");
    EXPECT_EQ(run.json()["in"]["bytes"], fs::file_size(table));
    EXPECT_EQ("sbrdf " + run.json()["version"].get<std::string>() + "\n", run_sbrdf({"--version"}).out);
    EXPECT_EQ(run.json()["options"], (nlohmann::ordered_json{{"merl-shape", "4,4,4"}}));
    EXPECT_EQ(run_command({"sha256sum", table}).out.substr(0, 64), run.json()["in"]["sha256"]);
  }
}

TEST(ConvertReport, IsNotWrittenWhereNothingWasConvertedOrInThePlaceOfABrdf) {
  const ScratchFolder folder;
  write_bytes(folder / "model.json", bytes_of(small_files::kKurtJson));
  expect_failure(run_sbrdf({"convert", folder / "none", folder / "b.binary", "--report", folder / "report.json"}), 2,
                 folder / "none", "No such file");
  for (const std::string& in : {folder / "model.json", std::string("kurt:wood01")}) {
    expect_failure(run_sbrdf({"convert", in, folder / "b.binary", "--report", folder / "model.json"}), 1,
                   folder / "model.json", "would replace");
  }
  EXPECT_THAT(folder.entries(), ElementsAre("model.json"));
}

TEST(ConvertTo, ChoosesTheFormatWhateverTheExtension) {
  const ScratchFolder folder;
  ASSERT_EQ(run_sbrdf({"convert", "kurt:wood01", folder / "a.xyz", "--to", "MERL", "--merl-shape", "4,4,4"}).err, "");
  EXPECT_EQ(run_sbrdf({"info", folder / "a.xyz", "--json"}).json()["format"], "merl");
}

}  // namespace
}  // namespace sbrdf::internal
