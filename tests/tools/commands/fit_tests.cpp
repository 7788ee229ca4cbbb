#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

TEST(FitCommand, WritesParametersThatEveryCommandReads) {
  const ScratchFolder folder;
  const std::string out = folder / "wood.json";
  const ProgramRun run = run_sbrdf({"fit", "kurt:wood01", out, "--lobes", "2", "--starts", "12"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* word : {"wrote", "17 numbers", "4,000 pairs", "MRE 0.00", "k_d 0.1548", "m_x 1.701"}) {
    EXPECT_THAT(run.out, HasSubstr(word));
  }
  EXPECT_THAT(run_sbrdf({"info", out}).out, HasSubstr("Kurt model wood, 2 lobes"));
  const auto compared = run_sbrdf({"compare", "kurt:wood01", out, "--step", "20", "--json"}).json();
  EXPECT_LT(compared["mre_percent"], 0.01);
  const auto json = run_sbrdf({"fit", "kurt:wood01", out, "--metric", "cube-root", "--json"}).json();
  EXPECT_EQ(json["bytes"], std::filesystem::file_size(out));
  EXPECT_EQ(json["parameters"]["lobes"].size(), 1U);
  EXPECT_EQ(json["metric"], "cube-root");
  EXPECT_GT(json["mre_percent"], 0.1) << "one lobe is not enough";
  EXPECT_EQ(json["reciprocity_difference_percent"], 0);
}

TEST(FitCommand, NamesWhatIsWrongAndWritesNothing) {
  const ScratchFolder folder;
  const std::string out = folder / "fit.json";
  expect_failure(run_sbrdf({"fit", "kurt:nobody", out}), 1, "kurt:nobody", "there is no Kurt material");
  expect_failure(run_sbrdf({"fit", folder / "none.bsdf", out}), 2, folder / "none.bsdf", "");
  expect_failure(run_sbrdf({"fit", "kurt:wood01", folder / "fit.txt"}), 1, folder / "fit.txt", "must end with .json");
  expect_failure(run_sbrdf({"fit", "kurt:wood01", folder / "no/fit.json"}), 2, folder / "no/fit.json", "");
  for (const std::string lobes : {"0", "7", "x"}) {
    const ProgramRun run = run_sbrdf({"fit", "kurt:wood01", out, "--lobes", lobes});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, HasSubstr("--lobes"));
  }
  EXPECT_EQ(run_sbrdf({"fit", "kurt:wood01", out, "--model", "phong"}).exit_code, 1);
  write_bytes(out, bytes_of("{\"sbrdf\":\"atlas\",\"version\":1}"));
  const ProgramRun kept = run_sbrdf({"fit", "kurt:wood01", out});
  EXPECT_NE(kept.exit_code, 0) << "a file of another kind is not replaced";
  EXPECT_TRUE(std::filesystem::exists(out));
}

TEST(FitCommand, FitsOtherModels) {
  const ScratchFolder folder;
  for (const std::string model : {"ward", "ggx"}) {
    const std::string out = folder / (model + ".json");
    const auto json = run_sbrdf({"fit", "kurt:Purple satin", out, "--model", model, "--starts", "6", "--json"}).json();
    EXPECT_EQ(json["model"], model);
    EXPECT_EQ(json["parameters"]["model"], model);
    const auto info = run_sbrdf({"info", out, "--json"}).json();
    EXPECT_EQ(info["format"], model);
    const auto compared =
        run_sbrdf({"compare", "kurt:Purple satin", out, "--directions", "highlight", "--count", "20000", "--json"})
            .json();
    EXPECT_NEAR(compared["rel_l1_percent"], json["rel_l1_percent"], 0.1 * json["rel_l1_percent"].get<double>());
  }
}

}  // namespace
}  // namespace sbrdf::internal
