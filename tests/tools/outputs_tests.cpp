#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

/// One file of each kind, links to some of them, and files whose names say something else than their content.
class Outputs : public testing::Test {
 protected:
  Outputs() {
    fs::create_directory(folder_ / "materials");
    for (const char* name : {"a.sbrdf", "other.sbrdf", "materials/m.sbrdf", "sliced.binary", "sliced.sbrdfz"}) {
      write_bytes(at(name), small_sliced());
    }
    for (const char* name : {"a.binary", "table.sbrdf"}) write_bytes(at(name), small_merl());
    write_bytes(at("damaged.binary"), bytes_of("nothing that anybody knows"));
    write_bytes(at("model.json"), bytes_of(R"({"name": "n", "k_d": [0.1, 0.1, 0.1], "lobes": []})"));
    write_bytes(at("old.csv"), bytes_of("old"));
    EXPECT_EQ(run_sbrdf({"pack", at("materials"), at("all.sbrdfz")}).exit_code, 0);
    fs::create_symlink("a.sbrdf", at("link.csv"));
    fs::create_symlink("link.csv", at("link_to_link.csv"));
    fs::create_hard_link(at("a.sbrdf"), at("hard_link.csv"));
    fs::create_symlink("a.binary", at("table_link.sbrdf"));
    fs::create_symlink("all.sbrdfz", at("bundle_link.sbrdf"));
    fs::create_symlink("materials/m.sbrdf", at("material_link.sbrdfz"));
  }
  [[nodiscard]] std::string at(const std::string& name) const { return folder_ / name; }

  /// Words that begin with '@' are names in the folder.
  [[nodiscard]] std::vector<std::string> filled(std::vector<std::string> command) const {
    for (std::string& word : command) {
      if (const auto sign = word.find('@'); sign != std::string::npos) word.replace(sign, 1, folder_ / "");
    }
    return command;
  }
  [[nodiscard]] std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      if (entry.is_regular_file()) all[entry.path().string()] = read_text(entry.path());
    }
    return all;
  }

  const ScratchFolder folder_;
};

TEST_F(Outputs, ReplaceNoInputAndNoBrdfOfAnotherKind) {
  const auto before = contents();
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"codings", "@a.sbrdf", "--csv", "@a.sbrdf"},
           {"codings", "@a.sbrdf", "--csv", "@link.csv"},
           {"codings", "@a.sbrdf", "--csv", "@link_to_link.csv"},
           {"codings", "@link.csv", "--csv", "@hard_link.csv"},
           {"codings", "kurt:wood01", "@a.sbrdf", "--csv", "@materials/../a.sbrdf"},
           {"codings", "@a.sbrdf", "--csv", "@other.sbrdf"},
           {"codings", "@a.sbrdf", "--csv", "@a.binary"},
           {"codings", "@a.sbrdf", "--csv", "@damaged.binary"},
           {"codings", "@a.sbrdf", "--csv", "@all.sbrdfz"},
           {"codings", "@a.sbrdf", "--csv", "@model.json"},
           {"codings", "kurt:@model.json", "--csv", "@model.json"},
           {"codings", "@all.sbrdfz:m", "--csv", "@all.sbrdfz"},
           {"codings", "@all.sbrdfz:m", "--csv", "@bundle_link.sbrdf"},
           {"reproduce", "accuracy", "--csv", "@a.sbrdf"},
           {"reproduce", "placement", "--csv", "@a.binary"},
           {"convert", "@a.binary", "@table_link.sbrdf"},
           {"convert", "@a.sbrdf", "@table.sbrdf"},
           {"convert", "kurt:wood01", "@sliced.binary"},
           {"convert", "kurt:@model.json", "@sliced.binary"},
           {"convert", "@all.sbrdfz:m", "@bundle_link.sbrdf"},
           {"extract", "@a.sbrdf", "@table.sbrdf"},
           {"extract", "@all.sbrdfz:m", "@bundle_link.sbrdf"},
           {"pack", "@materials", "@sliced.sbrdfz"},
           {"pack", "@materials", "@material_link.sbrdfz"},
       }) {
    SCOPED_TRACE(testing::PrintToString(command));
    const std::vector<std::string> words = filled(command);
    expect_failure(run_sbrdf(words), 1, words.back(), "would replace; choose another name");
    EXPECT_TRUE(contents() == before);
  }
}

TEST_F(Outputs, ReplaceFilesOfTheSameKindAlsoInputsAndOtherFiles) {
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"convert", "@a.sbrdf", "@a.sbrdf", "--precision", "1%"},
           {"convert", "@a.binary", "@a.binary"},
           {"convert", "@a.sbrdf", "@damaged.binary"},
           {"extract", "@other.sbrdf", "@other.sbrdf", "--level", "1"},
           {"pack", "@materials", "@all.sbrdfz"},
           {"codings", "@a.sbrdf", "--csv", "@old.csv"},
           {"codings", "@a.sbrdf", "--csv", "@new.csv"},
       }) {
    SCOPED_TRACE(testing::PrintToString(command));
    EXPECT_EQ(run_sbrdf(filled(command)).err, "");
  }
  EXPECT_THAT(read_text(at("old.csv")), testing::StartsWith("material,"));
  EXPECT_EQ(run_sbrdf({"verify", at("a.sbrdf"), at("other.sbrdf"), at("all.sbrdfz")}).exit_code, 0);
}

TEST_F(Outputs, OfAMaterialInABundleAreThoseOfItsFile) {
  const std::string file = at("materials/m.sbrdf");
  const std::string material = at("all.sbrdfz:m");
  const RunOptions rows = {.input = "theta_i,phi_i,theta_v,phi_v\n30,0,30,180\n"};
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"info", "IN"},
                                             {"info", "IN", "--levels"},
                                             {"info", "kurt:wood01"},
                                             {"eval", "IN"},
                                             {"verify", "IN", "--json"},
                                             {"codings", "IN", "--json"},
                                             {"compare", "IN", "IN", "--random", "9", "--json"}}) {
    SCOPED_TRACE(testing::PrintToString(command));
    const auto with = [&](const std::string& in) {
      std::vector<std::string> words = command;
      for (std::string& word : words) word = word == "IN" ? in : word;
      const ProgramRun run = run_sbrdf(words, rows);
      EXPECT_EQ(run.exit_code, 0) << run.err;
      std::string out = run.out.substr(0, run.out.find("\"seconds\""));
      for (auto name = out.find(in); name != std::string::npos; name = out.find(in)) out.replace(name, in.size(), "IN");
      return out;
    };
    EXPECT_EQ(with(material), with(file));
  }
  ASSERT_EQ(run_sbrdf({"extract", file, at("part1.sbrdf"), "--level", "2"}).exit_code, 0);
  ASSERT_EQ(run_sbrdf({"extract", material, at("part2.sbrdf"), "--level", "2"}).exit_code, 0);
  EXPECT_EQ(read_text(at("part2.sbrdf")), read_text(at("part1.sbrdf")));
}

TEST_F(Outputs, OfCommandsOnSlicedFilesNeedSuchAndSayWhatThereIs) {
  const std::vector<std::vector<std::string>> commands = {
      {"extract", "IN", at("new.sbrdf")}, {"info", "IN", "--levels"}, {"verify", "IN"}};
  for (const std::vector<std::string>& command : commands) {
    const auto refused = [&](const std::string& in, int code, const std::string& fragment) {
      std::vector<std::string> words = command;
      for (std::string& word : words) word = word == "IN" ? in : word;
      expect_failure(run_sbrdf(words), code, in, fragment);
    };
    refused(at("a.binary"), 4, "MERL table");
    refused(at("model.json"), 4, "Kurt model");
    refused("kurt:wood01", 4, "is a model");
    refused(at("old.csv"), 3, "text");
    refused(at("missing"), 2, "No such file");
    refused(at("all.sbrdfz:x"), 1, "m");
    refused(at("a.sbrdf:m"), 1, "holds one material");
    if (command[0] != "verify") refused(at("all.sbrdfz"), 1, "a bundle of 1 material");
  }
}

}  // namespace
}  // namespace sbrdf::internal
