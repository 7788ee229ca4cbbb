// sbrdf atlas --layout paper.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

/// The numbers of the last line that eval prints.
std::string value_of_pair(const std::string& file) {
  const ProgramRun run = run_sbrdf({"eval", file}, {.input = "theta_i,phi_i,theta_v,phi_v\n30,20,50,200\n"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.out;
}

TEST(PaperLayout, WritesTheFourTexturesOfTable5AndReadsThemAgain) {
  const ScratchFolder folder;
  const std::string sliced = folder / "x.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", "kurt:fabric112", sliced, "--samples", "8911", "--placement", "14/36"}).exit_code, 0);
  const std::string prefix = folder / "x";
  const ProgramRun run = run_sbrdf({"atlas", sliced, prefix, "--layout", "paper", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json()["layout"], "paper");
  EXPECT_EQ(run.json()["texels"], 284'571);
  EXPECT_EQ(run.json()["bytes"], 284'571 * 12);
  EXPECT_EQ(folder.entries(), (std::vector<std::string>{"x.json", "x.sbrdf", "x_axial.exr", "x_crossings.exr",
                                                        "x_diagonal.exr", "x_horizontal.exr"}));
  const auto files = run.json()["files"];
  for (const auto& file : files) EXPECT_TRUE(std::filesystem::exists(file.get<std::string>())) << file;

  const std::string manifest = folder / "x.json";
  const ProgramRun compared =
      run_sbrdf({"compare", sliced, manifest, "--directions", "highlight", "--count", "20000", "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_LE(compared.json()["mre_percent"].get<double>(), 1);
  EXPECT_LE(compared.json()["rel_l1_percent"].get<double>(), 1);
  EXPECT_FALSE(value_of_pair(manifest).empty());
  EXPECT_EQ(run_sbrdf({"convert", manifest, folder / "y.npy", "--grid", "15:30:15:30"}).exit_code, 0);

  // Its own files are replaced, and told of.
  const ProgramRun again = run_sbrdf({"atlas", sliced, prefix, "--layout", "paper"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("284,571, 3,414,852 bytes, 3.3 MB"));
}

TEST(PaperLayout, SaysTheSameInEveryContainer) {
  const ScratchFolder folder;
  const std::string sliced = folder / "x.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", "kurt:fabric112", sliced, "--samples", "500", "--placement", "28/180"}).exit_code, 0);
  for (const std::string container : {"exr", "ktx2", "dds"}) {
    const ProgramRun run =
        run_sbrdf({"atlas", sliced, folder / container, "--layout", "paper", "--container", container, "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.json()["texel"], container == "exr" ? "rgb32f" : "rgba32f");
    EXPECT_EQ(value_of_pair(folder / (container + ".json")), value_of_pair(folder / "exr.json"));
  }
}

TEST(PaperLayout, SamplesASourceWithoutSlicesByThePlacement) {
  const ScratchFolder folder;
  const ProgramRun run = run_sbrdf({"atlas", "kurt:fabric112", folder / "x", "--layout", "paper", "--placement",
                                    "28/180", "--samples", "300", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  // e_n = 3, a_n = 2: 6 areas of 3 x 5, two of 6 x 3 x 360, and 10 x 270.
  EXPECT_EQ(run.json()["texels"], 90 + 2 * 6480 + 2700);
}

TEST(PaperLayout, RefusesWhatDoesNotFit) {
  const ScratchFolder folder;
  const std::string prefix = folder / "x";
  const std::string sliced = folder / "half.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", "kurt:fabric112", sliced, "--samples", "500", "--frame", "half-difference",
                       "--search-evaluations", "1"})
                .exit_code,
            0);
  expect_failure(run_sbrdf({"atlas", sliced, prefix, "--layout", "paper"}), 4, sliced, "half-difference");
  expect_failure(run_sbrdf({"atlas", sliced, prefix, "--layout", "paper", "--placement", "14/36"}), 1, sliced,
                 "slices already");
  for (const auto& [option, value] :
       {std::pair{"--texel", "e5b9g9r9"}, std::pair{"--max-error", "1"}, std::pair{"--placement", "14"}}) {
    const ProgramRun run = run_sbrdf({"atlas", "kurt:fabric112", prefix, "--layout", "paper", option, value});
    EXPECT_EQ(run.exit_code, 1) << option;
    EXPECT_THAT(run.err, HasSubstr(option));
  }
  EXPECT_EQ(run_sbrdf({"atlas", "kurt:fabric112", prefix, "--placement", "14/36"}).exit_code, 1);
  EXPECT_EQ(folder.entries(), std::vector<std::string>{"half.sbrdf"});
}

TEST(PaperLayout, MissesATextureByItsName) {
  const ScratchFolder folder;
  const std::string prefix = folder / "x";
  ASSERT_EQ(
      run_sbrdf({"atlas", "kurt:fabric112", prefix, "--layout", "paper", "--placement", "28/180", "--samples", "300"})
          .exit_code,
      0);
  std::filesystem::remove(folder / "x_diagonal.exr");
  const std::string manifest = folder / "x.json";
  const ProgramRun run = run_sbrdf({"eval", manifest}, {.input = "theta_i,phi_i,theta_v,phi_v\n30,20,50,200\n"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("x_diagonal.exr"));
}

}  // namespace
}  // namespace sbrdf::internal
