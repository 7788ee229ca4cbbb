// sbrdf atlas --theta-max, --directions and --used-by: smaller textures that say what they leave out.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

void write_text(const std::string& path, std::string_view text) { write_bytes(path, bytes_of(text)); }

const char* const kPairs = "theta_i,phi_i,theta_v,phi_v\n30,0,40,150\n35,10,42,160\n120,0,0,0\n";

class AtlasPart : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_sbrdf(plainly({"convert", "kurt:fabric112", sliced_, "--samples", "600", "--placement", "28/90"}))
                  .exit_code,
              0);
  }

  ProgramRun atlas(const std::string& name, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"atlas",       sliced_, folder_ / name, "--texel", "rgb32f",
                                          "--container", "exr",   "--max-error",  "5",       "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_sbrdf(arguments);
  }

  ScratchFolder folder_;
  std::string sliced_ = folder_ / "x.sbrdf";
};

TEST_F(AtlasPart, OfListedDirectionsHasTheirValuesAndNoOthers) {
  write_text(folder_ / "pairs.csv", kPairs);
  const ProgramRun whole = atlas("whole", {});
  const ProgramRun part = atlas("part", {"--directions", folder_ / "pairs.csv"});
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  ASSERT_EQ(part.exit_code, 0) << part.err;
  EXPECT_FALSE(whole.json().contains("cells_held"));
  EXPECT_LT(part.json()["cells_held"], part.json()["cells"]);
  EXPECT_LT(part.json()["texels"].get<int>(), whole.json()["texels"].get<int>() / 4);
  EXPECT_LE(part.json()["texels_of_all"], whole.json()["texels"]);
  RunOptions input;
  input.input = "theta_i,phi_i,theta_v,phi_v\n30,0,40,150\n35,10,42,160\n";
  // Both atlases may have other texels, but are as near to the slices.
  const ProgramRun expected = run_sbrdf({"eval", sliced_, "--json"}, input);
  const ProgramRun values = run_sbrdf({"eval", folder_ / "part.json", "--json"}, input);
  ASSERT_EQ(values.exit_code, 0) << values.err;
  for (std::size_t k = 0; k < 2; ++k) {
    const double want = expected.json()[k]["G"];
    EXPECT_NEAR(values.json()[k]["G"].get<double>(), want, 0.15 * want);
  }
  input.input = "theta_i,phi_i,theta_v,phi_v\n80,0,80,10\n";
  const ProgramRun left_out = run_sbrdf({"eval", folder_ / "part.json"}, input);
  EXPECT_EQ(left_out.exit_code, 0);
  EXPECT_THAT(left_out.out, HasSubstr("nan"));
  EXPECT_THAT(left_out.err, HasSubstr("1 of 1 pairs were not measured"));
}

TEST_F(AtlasPart, WhatIsLeftOutIsNoValueForAnyCommand) {
  ASSERT_EQ(atlas("part", {"--theta-max", "30"}).exit_code, 0);
  const std::string part = folder_ / "part.json";
  EXPECT_THAT(run_sbrdf({"info", part}).out, HasSubstr(" cells"));
  const auto compared = [&](const std::string& reference, const std::string& test) {
    return run_sbrdf({"compare", reference, test, "--random", "2000", "--json"}).json();
  };
  const auto there = compared(sliced_, part);
  const auto back = compared(part, sliced_);
  EXPECT_GT(there["unmeasured_directions"], 1000);
  EXPECT_EQ(there["unmeasured_directions"], back["unmeasured_directions"]);
  EXPECT_LT(there["mre_percent"], 40);
  EXPECT_EQ(there["false_values"]["count"], 0);
  const auto check = run_sbrdf({"check", part, "--json"}).json()[0];
  for (const auto& albedo : check["albedos"]) {
    EXPECT_GT(albedo["unmeasured_evaluations"], 0);
    EXPECT_LT(albedo["albedo"][0], 1);
  }
  EXPECT_THAT(run_sbrdf({"check", part}).out, HasSubstr("in part not measured"));
  const ProgramRun again = run_sbrdf({"atlas", part, folder_ / "again", "--samples", "100", "--max-error", "50"});
  EXPECT_THAT(again.err, HasSubstr("not everything was measured"));
}

TEST_F(AtlasPart, FilesOfAnAtlasAreReplacedByNothingElse) {
  ASSERT_EQ(atlas("whole", {}).exit_code, 0);
  const std::string before = read_text(folder_ / "whole.exr");
  const ProgramRun run = run_sbrdf({"convert", folder_ / "whole.json", folder_ / "whole.exr", "--grid", "30:60:30:60"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("belongs to an input"));
  write_text(folder_ / "other.json", read_text(folder_ / "whole.json"));
  const ProgramRun own = run_sbrdf({"atlas", folder_ / "other.json", folder_ / "whole", "--container", "exr"});
  EXPECT_EQ(own.exit_code, 1);
  EXPECT_THAT(own.err, HasSubstr("belongs to one"));
  EXPECT_EQ(read_text(folder_ / "whole.exr"), before);
}

TEST_F(AtlasPart, AnAtlasIsReplacedAsAWhole) {
  ASSERT_EQ(atlas("x", {}).exit_code, 0);
  const ProgramRun ktx2 = run_sbrdf({"atlas", sliced_, folder_ / "x", "--max-error", "50"});
  ASSERT_EQ(ktx2.exit_code, 0) << ktx2.err;
  EXPECT_THAT(ktx2.err, HasSubstr("x.exr: removed"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.exr"));
  ASSERT_EQ(atlas("x", {}).exit_code, 0) << "and back";
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.ktx2"));
  // What another manifest was named after stays.
  ASSERT_EQ(run_sbrdf({"atlas", sliced_, folder_ / "y", "--layout", "paper"}).exit_code, 0);
  ASSERT_EQ(run_sbrdf({"atlas", sliced_, folder_ / "y", "--max-error", "50"}).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "y_axial.exr"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "x.exr"));
}

TEST_F(AtlasPart, NamesThatAManifestCannotHoldAreRefused) {
  for (const std::string name : {"a\\b", ".", "..", ""}) {
    const ProgramRun run = atlas(name, {});
    EXPECT_EQ(run.exit_code, 1) << name;
    EXPECT_THAT(run.err, HasSubstr("OUT_PREFIX")) << name;
  }
  EXPECT_EQ(atlas(std::string(300, 'n'), {}).exit_code, 2);
  for (const std::string option : {"--directions", "--used-by"}) {
    EXPECT_THAT(atlas("x", {option, ""}).err, HasSubstr("no file is named"));
  }
  EXPECT_EQ(folder_.entries().size(), 1U);
}

TEST_F(AtlasPart, UpToAThetaIsSmallerTheSmallerItIs) {
  double before = 0;
  for (const std::string theta : {"15", "45", "90"}) {
    const ProgramRun run = atlas("x" + theta, {"--theta-max", theta});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_GT(run.json()["cells_held"].get<double>(), before);
    before = run.json()["cells_held"];
    EXPECT_LE(run.json()["errors"]["to_slices"]["mre_percent"].get<double>(), 20);
  }
}

TEST_F(AtlasPart, OfASceneSaysWhatItSaves) {
  write_text(folder_ / "hall.json", R"({"cameras": [{"position": [0, 2, 5], "target": [0, 0, 0], "fov_deg": 30}],
      "lights": [{"position": [1, 3, 0]}], "objects": [{"shape": "plane", "center": [0, 0, 0], "normal": [0, 1, 0],
      "width": 4, "height": 4}]})");
  const ProgramRun run = atlas("hall-floor", {"--used-by", folder_ / "hall.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(run.json()["texels"].get<int>(), run.json()["texels_of_all"].get<int>() / 2);
  EXPECT_LE(run.json()["errors"]["to_slices"]["mre_percent"].get<double>(), 10);
  const ProgramRun table = run_sbrdf({"atlas", sliced_, folder_ / "hall-floor", "--used-by", folder_ / "hall.json"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr(" cells, "));
}

TEST_F(AtlasPart, IsRefusedWithWhatIsWrong) {
  const std::string scene = folder_ / "scene.json";
  write_text(scene, R"({"cameras": []})");
  expect_failure(atlas("y", {"--used-by", scene}), 3, scene, "scene: ");
  expect_failure(atlas("y", {"--used-by", folder_ / "none.json"}), 2, folder_ / "none.json", "");
  write_text(folder_ / "bad.csv", "theta_i,phi_i,theta_v,phi_v\n30,0,x,150\n");
  expect_failure(atlas("y", {"--directions", folder_ / "bad.csv"}), 3, folder_ / "bad.csv", "line 2");
  write_text(folder_ / "empty.csv", "theta_i,phi_i,theta_v,phi_v\n");
  expect_failure(atlas("y", {"--directions", folder_ / "empty.csv"}), 3, folder_ / "empty.csv",
                 "no pair of directions");
  const ProgramRun both = atlas("y", {"--theta-max", "30", "--directions", folder_ / "bad.csv"});
  EXPECT_EQ(both.exit_code, 1);
  EXPECT_THAT(both.err, HasSubstr("exclude each other"));
  EXPECT_EQ(atlas("y", {"--theta-max", "0"}).exit_code, 1);
  const ProgramRun paper = run_sbrdf({"atlas", sliced_, folder_ / "y", "--layout", "paper", "--theta-max", "30"});
  EXPECT_EQ(paper.exit_code, 1);
  EXPECT_THAT(paper.err, HasSubstr("--layout engine"));
  for (const std::string& name : folder_.entries()) EXPECT_NE(name.substr(0, 2), "y.") << name;
}

}  // namespace
}  // namespace sbrdf::internal
