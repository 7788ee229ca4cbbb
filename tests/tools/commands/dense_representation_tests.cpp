#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

const char* const kGloss = R"({"name": "gloss", "k_d": [0.3, 0.1, 0.05],
 "lobes": [{"k_s": [0.2, 0.2, 0.2], "f_0": 0.1, "m_x": 0.2, "m_y": 0.2, "alpha": 0.5}]})";

class DenseRepresentation : public testing::Test {
 protected:
  DenseRepresentation() { write_bytes(in_, bytes_of(kGloss)); }

  // Of what compare, which has no part in choosing, says.
  double rel_l1(const std::string& file) {
    return run_sbrdf({"compare", in_, file, "--directions", "highlight", "--count", "20000", "--seed", "5", "--json"})
        .json()["rel_l1_percent"];
  }

  ScratchFolder folder_;
  std::string in_ = folder_ / "gloss.json";
  std::string out_ = folder_ / "out.sbrdf";
};

TEST_F(DenseRepresentation, IsAFileForEveryCommand) {
  const ProgramRun run =
      run_sbrdf({"convert", in_, out_, "--representation", "dense", "--target-rel-l1", "3", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(std::filesystem::file_size(out_), 120U);
  EXPECT_LE(rel_l1(out_), 3.6);
  const auto info = run_sbrdf({"info", out_, "--json"}).json();
  EXPECT_EQ(info["representation"], "dense");
  EXPECT_EQ(info["bytes"], std::filesystem::file_size(out_));
  EXPECT_LE(info["metadata"]["error"]["rel_l1_percent"], 3.3);
  EXPECT_GT(info["coefficients"], 5);
  EXPECT_EQ(run_sbrdf({"verify", out_}).exit_code, 0);
  EXPECT_EQ(run_sbrdf({"check", out_}).exit_code, 0);
  // A copy is the same; slices of it, a table, and an atlas are as good.
  const std::string copy = folder_ / "copy.sbrdf";
  EXPECT_EQ(run_sbrdf({"convert", out_, copy}).exit_code, 0);
  EXPECT_EQ(read_text(copy), read_text(out_));
  for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
           {folder_ / "sliced.sbrdf", "--samples", "400", "--search-evaluations", "20"}, {folder_ / "table.binary"}}) {
    std::vector<std::string> arguments = {"convert", out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(run_sbrdf(arguments).exit_code, 0);
    EXPECT_LE(rel_l1(more[0]), 5);
  }
}

TEST_F(DenseRepresentation, AutoTakesTheOneThatServesBetterAndSaysWhy) {
  const ProgramRun small = run_sbrdf({"convert", in_, out_, "--representation", "auto", "--target-rel-l1", "4"});
  ASSERT_EQ(small.exit_code, 0) << small.err;
  EXPECT_THAT(small.out, HasSubstr("dense: "));
  EXPECT_EQ(run_sbrdf({"info", out_, "--json"}).json()["representation"], "dense");
  const ProgramRun open = run_sbrdf({"convert", in_, out_, "--representation", "auto"});
  ASSERT_EQ(open.exit_code, 0) << open.err;
  EXPECT_THAT(open.out, HasSubstr("slices: nothing asks for an error or a size"));
  EXPECT_FALSE(run_sbrdf({"info", out_, "--json"}).json().contains("representation"));
}

TEST_F(DenseRepresentation, RefusesWhatItCannotBe) {
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"--samples", "100"}, {"--frame", "elevation"}, {"--precision", "1%"}, {"--chunks", "split"}}) {
    const ProgramRun run = run_sbrdf({"convert", in_, out_, "--representation", "dense", wrong[0], wrong[1]});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, HasSubstr(wrong[0] + " is of slices"));
    EXPECT_FALSE(std::filesystem::exists(out_));
  }
  const ProgramRun never =
      run_sbrdf({"convert", in_, out_, "--representation", "dense", "--max-bytes", "20", "--metadata", "none"});
  EXPECT_EQ(never.exit_code, 5);
  EXPECT_THAT(never.err, HasSubstr("no dense table is so small"));
  ASSERT_EQ(run_sbrdf({"convert", in_, out_, "--representation", "dense", "--max-bytes", "80"}).exit_code, 0);
  EXPECT_LE(std::filesystem::file_size(out_), 80U);
  // Without slices there are no parts of them.
  EXPECT_EQ(run_sbrdf({"extract", out_, folder_ / "part.sbrdf", "--theta-max", "40"}).exit_code, 4);
  EXPECT_EQ(run_sbrdf({"info", out_, "--levels"}).exit_code, 4);
  EXPECT_NE(run_sbrdf({"pack", folder_ / "all.sbrdfz", out_}).exit_code, 0);
}

TEST_F(DenseRepresentation, IsSmallerThanSlicesOfAMeasuredMaterial) {
  SBRDF_FIND_TEST_DATA(data, "rgl/vch_silk_blue_rgb.bsdf");
  const std::string slices = folder_ / "slices.sbrdf";
  for (const auto& [file, representation] : {std::pair{out_, "dense"}, std::pair{slices, "sliced"}}) {
    const ProgramRun run =
        run_sbrdf({"convert", data.string(), file, "--representation", representation, "--target-rel-l1", "5"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto error = run_sbrdf({"compare", data.string(), file, "--symmetrise", "--directions", "random", "--count",
                                  "50000", "--json"})
                           .json()["rel_l1_percent"];
    EXPECT_LE(error, 5.5) << representation;
  }
  // Metadata with a checksum, findings and what symmetrising changed, counted in.
  ASSERT_EQ(
      run_sbrdf({"convert", data.string(), folder_ / "small.sbrdf", "--representation", "dense", "--max-bytes", "150"})
          .exit_code,
      0);
  EXPECT_LE(std::filesystem::file_size(folder_ / "small.sbrdf"), 150U);
  EXPECT_LT(std::filesystem::file_size(out_), 0.8 * static_cast<double>(std::filesystem::file_size(slices)));
}

}  // namespace
}  // namespace sbrdf::internal
