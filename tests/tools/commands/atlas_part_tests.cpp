// sbrdf atlas --theta-max, --directions and --used-by: smaller textures that say what they leave out.
#include <cmath>
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
