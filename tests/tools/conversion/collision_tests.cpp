#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/small_files.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

using testing::ElementsAre;

const std::string kCollisionGrid = "difference/0:45:45:45";

/// A table "in.npy" with its description, and a link to the folder that both lie in.
class Collisions : public testing::Test {
 protected:
  Collisions() {
    fs::create_directory(folder_ / "work");
    fs::create_directory_symlink("work", folder_ / "link");
    EXPECT_EQ(write("in.npy").exit_code, 0);
    description_ = read_text(at("in.npy.json"));
  }

  [[nodiscard]] std::string at(const std::string& name) const { return folder_ / ("work/" + name); }
  [[nodiscard]] ProgramRun write(const std::string& name, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"convert", "kurt:wood01", at(name), "--to", "npy", "--grid", kCollisionGrid});
    return run_sbrdf(more);
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_ / "work"))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  ScratchFolder folder_;
  std::string description_;
};

TEST_F(Collisions, OfAReportWithWhatIsReadOrWrittenAreRefusedBeforeAnythingIsWritten) {
  fs::create_symlink("out.npy.json", at("dangling.json"));
  fs::create_hard_link(at("in.npy.json"), at("hard.json"));
  const std::vector<std::string> before = names();
  const auto convert = [&](const std::string& report) {
    return run_sbrdf({"convert", at("in.npy"), at("out.npy"), "--report", report});
  };
  for (const std::string& report : {at("out.npy.json"), at("../work/out.npy.json"), folder_ / "link/out.npy.json",
                                    at("./out.npy.json"), at("dangling.json")}) {
    expect_failure(convert(report), 1, report, "is a file that is written, or belongs to one");
    EXPECT_EQ(names(), before);
  }
  for (const std::string& report : {at("in.npy.json"), folder_ / "link/in.npy.json", at("hard.json")}) {
    expect_failure(convert(report), 1, report, "is an input, which a report would replace");
    EXPECT_EQ(names(), before);
  }
  expect_failure(write("out.json", {"--report", folder_ / "link/out.json"}), 1, folder_ / "link/out.json",
                 "is a file that is written");
  EXPECT_EQ(names(), before);
  EXPECT_EQ(read_text(at("in.npy.json")), description_);
  EXPECT_EQ(convert(at("report.json")).exit_code, 0);
  EXPECT_EQ(convert(at("report.json")).exit_code, 0);  // an older one is replaced
}

TEST_F(Collisions, OfTheReportOfAFolderAreRefusedBeforeAnythingIsWritten) {
  const std::string out = folder_ / "out";
  const auto convert = [&](const std::string& report) {
    return run_sbrdf({"convert", folder_ / "work", out, "--to", "npy", "--report", report});
  };
  for (const std::string& report : {out + "/in.npy.json", out + "/../out/in.npy.json"}) {
    expect_failure(convert(report), 1, report, "is a file that is written, or belongs to one");
    EXPECT_FALSE(fs::exists(out));
  }
  for (const std::string& report : {at("in.npy.json"), folder_ / "link/in.npy.json"}) {
    expect_failure(convert(report), 1, report, "is an input, which a report would replace");
    EXPECT_FALSE(fs::exists(out));
  }
  const std::string entry = out + "/.sbrdf-convert/in.npy.json";
  expect_failure(convert(entry), 1, entry, "lies in the folder that tells what is done");
  EXPECT_FALSE(fs::exists(out));
  EXPECT_EQ(read_text(at("in.npy.json")), description_);
  EXPECT_EQ(convert(out + "/report.json").exit_code, 0);
}

TEST_F(Collisions, OfADescriptionWithAFileOfAnotherKindAreRefused) {
  write_bytes(at("out.npy.json"), bytes_of(R"({"mine": 1})"));
  expect_failure(write("out.npy"), 1, at("out.npy"), at("out.npy.json") + " is a file of another kind");
  EXPECT_EQ(read_text(at("out.npy.json")), R"({"mine": 1})");
  EXPECT_THAT(names(), ElementsAre("in.npy", "in.npy.json", "out.npy.json"));
  write_bytes(at("out.npy.json"), bytes_of(small_files::kKurtJson));
  expect_failure(run_sbrdf({"convert", "kurt:" + at("out.npy.json"), at("out.npy"), "--grid", kCollisionGrid}), 1,
                 at("out.npy"), at("out.npy.json") + " is an input");
  fs::remove(at("out.npy.json"));
  fs::create_directory(at("out.npy.json"));
  expect_failure(write("out.npy"), 2, at("out.npy"), "is a directory");
  EXPECT_FALSE(fs::exists(at("out.npy")));
}

TEST_F(Collisions, OfADescriptionWithOneOfItsKindAreNone) {
  EXPECT_EQ(write("in.npy", {"--type", "float64"}).exit_code, 0);
  EXPECT_NE(read_text(at("in.npy.json")), description_);
  write_bytes(at("in.npy.json"), {});
  EXPECT_EQ(write("in.npy").exit_code, 0);
  EXPECT_EQ(read_text(at("in.npy.json")), description_);
  EXPECT_EQ(run_sbrdf({"convert", at("in.npy"), at("in.npy"), "--type", "float64"}).exit_code, 0);
}

TEST_F(Collisions, OfAnOutputWithTheDescriptionOfAnInputAreRefused) {
  expect_failure(run_sbrdf({"convert", at("in.npy"), folder_ / "link/in.npy.json", "--to", "csv"}), 1,
                 folder_ / "link/in.npy.json", "belongs to an input");
  EXPECT_EQ(read_text(at("in.npy.json")), description_);
}

// Names from where the program is started say the same as those from the root.
TEST_F(Collisions, AreSeenBetweenNamesOfEveryKind) {
  const auto convert = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"env", "-C", folder_ / "work", SBRDF_PROGRAM, "convert"});
    return run_command(arguments);
  };
  fs::create_symlink("out.csv", at("to_out.json"));
  const std::vector<std::string> before = names();
  for (const std::string report : {"./out.npy.json", "../work/out.npy.json", "out.npy.json"}) {
    for (const std::string& out : {std::string("out.npy"), std::string("./out.npy"), at("out.npy")}) {
      expect_failure(convert({"in.npy", out, "--report", report}), 1, report, "is a file that is written");
    }
  }
  expect_failure(convert({"in.npy", "./out.json", "--to", "csv", "--report", "out.json"}), 1, "out.json",
                 "is a file that is written");
  expect_failure(convert({"in.npy", "out.csv", "--report", "to_out.json"}), 1, "to_out.json",
                 "is a file that is written");
  expect_failure(convert({"../work", "../out", "--to", "npy", "--report", "./../out/in.npy.json"}), 1,
                 "./../out/in.npy.json", "is a file that is written");
  expect_failure(convert({"../work", "../out", "--to", "npy", "--report", "./../out/.sbrdf-convert/new.json"}), 1,
                 "./../out/.sbrdf-convert/new.json", "lies in the folder that tells what is done");
  EXPECT_EQ(names(), before);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Collisions, OfAReportWithAnythingButAnOlderReportAreRefused) {
  EXPECT_EQ(write("other.npy").exit_code, 0);
  write_bytes(at("mine.json"), bytes_of(R"({"mine": 1})"));
  for (const std::string name : {"other.npy.json", "mine.json"}) {
    const std::string kept = read_text(at(name));
    expect_failure(run_sbrdf({"convert", at("in.npy"), at("out.csv"), "--report", at(name)}), 1, at(name),
                   "there is a file of another kind of that name");
    EXPECT_EQ(read_text(at(name)), kept);
    EXPECT_FALSE(fs::exists(at("out.csv")));
  }
}

TEST_F(Collisions, WithADescriptionThatIsNotThereYetAreRefused) {
  fs::remove(at("in.npy.json"));
  expect_failure(run_sbrdf({"convert", at("in.npy"), at("in.npy.json"), "--to", "csv", "--grid", kCollisionGrid}), 1,
                 at("in.npy.json"), "belongs to an input");
  expect_failure(
      run_sbrdf({"convert", at("in.npy"), at("out.csv"), "--grid", kCollisionGrid, "--report", at("./in.npy.json")}), 1,
      at("./in.npy.json"), "is an input");
  fs::create_symlink("out.npy", at("out.npy.json"));
  expect_failure(write("out.npy"), 1, at("out.npy"), "is a link to it");
  EXPECT_THAT(names(), ElementsAre("in.npy", "out.npy.json"));
}

/// A link to an array in another folder.
class LinksToArrays : public Collisions {
 protected:
  LinksToArrays() { fs::create_symlink("work/in.npy", link_); }
  const std::string link_ = folder_ / "linked.npy";
};

TEST_F(LinksToArrays, FindTheDescriptionBesideTheArray) {
  EXPECT_EQ(run_sbrdf({"info", link_}).exit_code, 0);
  EXPECT_EQ(run_sbrdf({"convert", "kurt:fabric112", link_, "--grid", "45:90:45:90"}).exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(link_));
  EXPECT_FALSE(fs::exists(link_ + ".json"));
  EXPECT_EQ(run_sbrdf({"info", at("in.npy"), "--json"}).json()["isotropic"], false);
}

TEST_F(LinksToArrays, PreferTheOneBesideThemselves) {
  write_bytes(link_ + ".json", bytes_of(description_));
  fs::remove(at("in.npy.json"));
  EXPECT_EQ(run_sbrdf({"info", link_}).exit_code, 0);
  EXPECT_EQ(run_sbrdf({"convert", "kurt:fabric112", link_, "--grid", "45:90:45:90"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(at("in.npy.json")));
  EXPECT_EQ(run_sbrdf({"info", link_, "--json"}).json()["isotropic"], false);
}

TEST_F(LinksToArrays, KeepBothPlacesOfTheirDescriptionFromReports) {
  for (const std::string& report : {link_ + ".json", at("in.npy.json")}) {
    expect_failure(run_sbrdf({"convert", link_, folder_ / "out.csv", "--report", report}), 1, report, "is an input");
    expect_failure(run_sbrdf({"convert", "kurt:fabric112", link_, "--grid", "45:90:45:90", "--report", report}), 1,
                   report, "is a file that is written");
  }
}

TEST_F(LinksToArrays, InAFolderAreConvertedAgainAfterAChangeOfTheDescription) {
  const std::vector<std::string> convert = {"convert", folder_ / "links", folder_ / "out", "--to", "csv", "--json"};
  fs::create_directory(folder_ / "links");
  fs::create_symlink("../work/in.npy", folder_ / "links/a.npy");
  EXPECT_EQ(run_sbrdf(convert).json()[0]["result"], "converted");
  EXPECT_EQ(run_sbrdf(convert).json()[0]["result"], "kept");
  std::string other = description_;
  other.replace(other.find("theta_max\":90"), 13, "theta_max\":80");
  write_bytes(at("in.npy.json"), bytes_of(other));
  EXPECT_EQ(run_sbrdf(convert).json()[0]["result"], "converted");
}

}  // namespace
}  // namespace sbrdf::internal
