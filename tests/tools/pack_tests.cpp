#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A folder with the materials fabric, velvet and wood of their own, and with a file that is none.
class Pack : public testing::Test {
 protected:
  Pack() {
    static const std::map<std::string, std::string> made = make_materials();
    std::filesystem::create_directory(folder_);
    for (const auto& [name, bytes] : made) write_bytes(file(name), bytes_of(bytes));
    write_bytes(folder_ + "/readme.txt", bytes_of("not a material"));
  }
  [[nodiscard]] static std::map<std::string, std::string> make_materials() {
    const ScratchFolder scratch;
    std::map<std::string, std::string> made;
    int samples = 40;
    for (const char* name : {"wood", "fabric", "velvet"}) {
      const std::string out = scratch / (std::string(name) + ".sbrdf");
      const auto run = run_sbrdf({"convert", "kurt:wood01", out, "--placement", "40/180", "--samples",
                                  std::to_string(samples += 20), "--domain", "log", "--metadata", "full"});
      if (run.exit_code != 0) throw std::runtime_error(run.err);
      made[name] = read_text(out);
    }
    return made;
  }
  [[nodiscard]] std::string file(const std::string& name) const { return folder_ + "/" + name + ".sbrdf"; }
  [[nodiscard]] ProgramRun pack(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"pack", folder_, bundle_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_sbrdf(arguments);
  }

  const ScratchFolder scratch_;
  const std::string folder_ = scratch_ / "materials";
  const std::string bundle_ = scratch_ / "all.sbrdfz";
};

TEST_F(Pack, TellsTheSizeOfEveryMaterialAndOfTheWhole) {
  const auto run = pack({"--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, IsEmpty());
  const auto json = run.json();
  EXPECT_EQ(json["bundle"], bundle_);
  EXPECT_EQ(json["bundled_bytes"], std::filesystem::file_size(bundle_));
  std::vector<std::string> names;
  std::uintmax_t bundled = json["shared_bytes"];
  std::uintmax_t files = 0;
  for (const auto& material : json["materials"]) {
    names.push_back(material["name"]);
    EXPECT_EQ(material["file_bytes"], std::filesystem::file_size(file(names.back())));
    EXPECT_LT(material["bundled_bytes"], material["file_bytes"]);
    bundled += material["bundled_bytes"].get<std::uintmax_t>();
    files += material["file_bytes"].get<std::uintmax_t>();
  }
  EXPECT_THAT(names, ElementsAre("fabric", "velvet", "wood"));
  EXPECT_EQ(bundled, json["bundled_bytes"]);
  EXPECT_EQ(files, json["file_bytes"]);

  const auto table = pack();
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_THAT(table.err, IsEmpty());
  for (const char* word : {"fabric", "velvet", "wood", "total"}) EXPECT_THAT(table.out, HasSubstr(word));
}

// Of three small files the bundle's own header and index take more than is saved.
TEST_F(Pack, OfManyMaterialsIsSmallerThanTheirFiles) {
  for (const std::string name : {"fabric", "velvet", "wood"}) {
    for (int k = 0; k < 8; ++k) std::filesystem::copy_file(file(name), file(name + std::to_string(k)));
  }
  const auto run = pack({"--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = run.json();
  EXPECT_EQ(json["materials"].size(), 27U);
  EXPECT_LT(json["bundled_bytes"], json["file_bytes"]);
}

TEST_F(Pack, ListsWhatABundleHolds) {
  const auto packed = pack({"--json"});
  EXPECT_EQ(run_sbrdf({"pack", "--list", bundle_, "--json"}).out, packed.out);
  EXPECT_EQ(run_sbrdf({"pack", "--list", bundle_}).out, pack().out);
  expect_failure(run_sbrdf({"pack", "--list", file("wood")}), 3, file("wood"), "[SZ-1-1] not a bundle");
  expect_failure(run_sbrdf({"pack", "--list", scratch_ / "none"}), 2, scratch_ / "none", "cannot be opened");
}

TEST_F(Pack, WritesTheSameBytesEveryTime) {
  ASSERT_EQ(pack().exit_code, 0);
  const std::string first = read_text(bundle_);
  ASSERT_EQ(pack().exit_code, 0);
  EXPECT_EQ(read_text(bundle_), first);
  EXPECT_THAT(scratch_.entries(), ElementsAre("all.sbrdfz", "materials"));
}

TEST_F(Pack, MaterialsAreReadWhereverFilesAre) {
  ASSERT_EQ(pack().exit_code, 0);
  for (const std::string name : {"fabric", "velvet", "wood"}) {
    const std::string copy = scratch_ / (name + ".sbrdf");
    ASSERT_EQ(run_sbrdf({"convert", bundle_ + ":" + name, copy}).exit_code, 0);
    EXPECT_EQ(read_text(copy), read_text(file(name)));
    const auto info = run_sbrdf({"info", bundle_ + ":" + name});
    EXPECT_EQ(info.out, run_sbrdf({"info", file(name)}).out);
  }
  const RunOptions pair = {.input = "theta_i,phi_i,theta_v,phi_v\n30,0,30,180\n"};
  const auto eval = run_sbrdf({"eval", bundle_ + ":wood"}, pair);
  EXPECT_EQ(eval.exit_code, 0) << eval.err;
  EXPECT_EQ(eval.out, run_sbrdf({"eval", file("wood")}, pair).out);
}

TEST_F(Pack, FilesAndMaterialsMayHaveColonsInTheirNames) {
  std::filesystem::rename(file("wood"), folder_ + "/wood: oak.sbrdf");
  const std::string bundle = scratch_ / "my: all.sbrdfz";
  ASSERT_EQ(run_sbrdf({"pack", folder_, bundle}).exit_code, 0);
  EXPECT_EQ(run_sbrdf({"info", bundle + ":wood: oak"}).exit_code, 0);
  // A file before the first ':' is not in the way.
  write_bytes(scratch_ / "my", bytes_of("text"));
  EXPECT_EQ(run_sbrdf({"info", bundle + ":wood: oak"}).exit_code, 0);
  // And what is a file is no material.
  ASSERT_EQ(run_sbrdf({"convert", file("fabric"), bundle + ":velvet.sbrdf"}).exit_code, 0);
  std::filesystem::rename(bundle + ":velvet.sbrdf", bundle + ":velvet");
  EXPECT_EQ(run_sbrdf({"info", bundle + ":velvet"}).out, run_sbrdf({"info", file("fabric")}).out);
}

TEST_F(Pack, AsksForANameThatTheBundleHas) {
  ASSERT_EQ(pack().exit_code, 0);
  expect_failure(run_sbrdf({"info", bundle_ + ":wool"}), 1, bundle_ + ":wool", "wood, ");
  for (const std::string& text : {bundle_, bundle_ + ":"}) {
    expect_failure(run_sbrdf({"info", text}), 1, text, "a bundle of 3 materials");
    expect_failure(run_sbrdf({"info", text}), 1, text, "fabric, velvet, wood");
  }
  expect_failure(run_sbrdf({"info", file("wood") + ":wood"}), 1, file("wood") + ":wood", "holds one material");
  expect_failure(run_sbrdf({"info", scratch_ / "none:wood"}), 2, scratch_ / "none:wood", "cannot be opened");
}

TEST_F(Pack, ADamagedMaterialIsTold) {
  ASSERT_EQ(pack().exit_code, 0);
  auto bytes = read_bytes(bundle_);
  bytes.back() ^= std::byte{1};
  write_bytes(bundle_, bytes);
  expect_failure(run_sbrdf({"eval", bundle_ + ":wood"}), 3, bundle_ + ":wood", "[SB-1-7]");
  EXPECT_EQ(run_sbrdf({"eval", bundle_ + ":fabric"}, {.input = "theta_i,phi_i,theta_v,phi_v\n"}).exit_code, 0);
}

TEST_F(Pack, NamesEveryBadFileAndWritesNothing) {
  auto bytes = read_bytes(file("velvet"));
  bytes.back() ^= std::byte{1};
  write_bytes(file("velvet"), bytes);
  expect_failure(pack(), 3, file("velvet"), "[SB-1-7]");
  write_bytes(file("another"), bytes_of("text"));
  write_bytes(file("table"), small_merl());
  write_bytes(file("zipped"), bytes_of("\x1F\x8B\x08 and so on"));
  std::filesystem::create_directory(file("folder"));
  std::filesystem::create_symlink("nowhere", file("link"));
  ASSERT_EQ(mkfifo(file("pipe").c_str(), 0600), 0);
  std::filesystem::copy(file("wood"), folder_ + "/\xff.sbrdf");
  std::filesystem::copy(file("wood"), folder_ + "/wood.SBRDF");
  const ProgramRun run = pack();
  EXPECT_EQ(run.exit_code, 3);
  const std::vector<std::pair<std::string, std::string>> bad = {
      {file("another"), "text"},
      {file("folder"), "not an ordinary file"},
      {file("link"), "is a link to nowhere, which is not there"},
      {file("pipe"), "not an ordinary file"},
      {file("table"), "MERL table"},
      {file("velvet"), "[SB-1-7]"},
      {file("wood"), "has the same name in the bundle as wood.SBRDF"},
      {file("zipped"), "gzip"},
      {folder_ + "/?.sbrdf", "UTF-8"},
  };
  std::istringstream lines(run.err);
  for (const auto& [subject, fragment] : bad) {
    std::string line;
    std::getline(lines, line);
    EXPECT_THAT(line, testing::AllOf(testing::StartsWith("sbrdf: " + subject + ": "), HasSubstr(fragment)));
  }
  EXPECT_EQ(lines.peek(), EOF);
  EXPECT_THAT(scratch_.entries(), ElementsAre("materials"));
}

TEST_F(Pack, SkipsHiddenFilesAloud) {
  write_bytes(folder_ + "/._wood.sbrdf", bytes_of("what some systems put beside a file"));
  write_bytes(folder_ + "/.hidden.txt", bytes_of("of no concern"));
  const ProgramRun run = pack();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, testing::StartsWith("skipped ._wood.sbrdf: the name begins with a dot\nmaterial "));
  EXPECT_THAT(pack({"--json"}).json()["skipped"], ElementsAre("._wood.sbrdf"));
  EXPECT_EQ(run_sbrdf({"pack", "--list", bundle_, "--json"}).json()["materials"].size(), 3);
  write_bytes(file("bad"), {});
  EXPECT_THAT(pack().out, HasSubstr("skipped ._wood.sbrdf"));
}

TEST_F(Pack, TakesExtensionsInAnyCase) {
  std::filesystem::rename(file("wood"), folder_ + "/wood.SBRDF");
  std::filesystem::rename(file("velvet"), folder_ + "/velvet.Sbrdf");
  const std::string bundle = scratch_ / "ALL.SBRDFZ";
  const ProgramRun run = run_sbrdf({"pack", folder_, bundle, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json()["materials"].size(), 3);
  EXPECT_EQ(run_sbrdf({"info", bundle + ":wood"}).exit_code, 0);
}

TEST_F(Pack, LeavesAnOlderBundleAsItIsWhenItFails) {
  ASSERT_EQ(pack().exit_code, 0);
  const std::string before = read_text(bundle_);
  write_bytes(file("another"), {});
  EXPECT_EQ(pack().exit_code, 3);
  EXPECT_EQ(read_text(bundle_), before);
}

TEST_F(Pack, RefusesWhatItCannotDo) {
  const std::string empty = scratch_ / "empty";
  std::filesystem::create_directory(empty);
  expect_failure(run_sbrdf({"pack", empty, bundle_}), 1, empty, "no .sbrdf files");
  expect_failure(run_sbrdf({"pack", scratch_ / "none", bundle_}), 2, scratch_ / "none", "cannot be read");
  expect_failure(run_sbrdf({"pack", folder_, file("all")}), 1, file("all"), ".sbrdfz");
  const std::string nowhere = scratch_ / "none/all.sbrdfz";
  expect_failure(run_sbrdf({"pack", folder_, nowhere}), 2, nowhere, "none");
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"pack"}, {"pack", folder_}, {"pack", folder_, bundle_, "--list", bundle_}, {"pack", "--list"}}) {
    const auto run = run_sbrdf(arguments);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, HasSubstr("see 'sbrdf pack --help'"));
  }
}

TEST(PackHelp, HasAnExample) {
  const auto run = run_sbrdf({"pack", "--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("sbrdf pack materials/ materials.sbrdfz"));
}

}  // namespace
}  // namespace sbrdf::internal
