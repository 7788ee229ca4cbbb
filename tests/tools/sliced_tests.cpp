#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

/// fabric112, anisotropic, some hundred samples on several levels. Each is made once.
std::string sampled(const ScratchFolder& folder, const std::vector<std::string>& more = {"--precision", "0.1%"}) {
  static std::map<std::vector<std::string>, std::string> made;
  std::string file = folder / "fabric112.sbrdf";
  auto [entry, is_new] = made.try_emplace(more);
  if (is_new) {
    std::vector<std::string> command = {"convert",   "kurt:fabric112", file,       "--placement", "20/60",
                                        "--samples", "2000",           "--values", "measured"};
    command.insert(command.end(), more.begin(), more.end());
    EXPECT_EQ(run_sbrdf(command).exit_code, 0);
    entry->second = read_text(file);
  }
  write_bytes(file, bytes_of(entry->second));
  return file;
}

TEST(Precision, StandsInTheFile) {
  const ScratchFolder folder;
  EXPECT_DOUBLE_EQ(run_sbrdf({"info", sampled(folder, {"--precision", "2%"}), "--json"}).json()["precision_percent"],
                   2);
  EXPECT_DOUBLE_EQ(
      run_sbrdf({"info", sampled(folder, {"--precision", "lossless"}), "--json"}).json()["precision_percent"], 0);
}

TEST(Precision, IsToldInTheDecimalsOfTheFile) {
  const ScratchFolder folder;
  const std::string copy = folder / "copy.sbrdf";
  write_bytes(folder / "a.sbrdf", small_sliced());
  ASSERT_EQ(run_sbrdf({"convert", folder / "a.sbrdf", copy, "--precision", "0.68%"}).exit_code, 0);
  EXPECT_THAT(run_sbrdf({"info", copy}).out, testing::ContainsRegex("\nprecision_percent +0\\.68\n"));
}

TEST(Precision, OfACopyIsThatOfTheFileOrWhatIsAskedFor) {
  const ScratchFolder folder;
  const std::string lossless = sampled(folder, {"--precision", "lossless"});
  const std::string copy = folder / "copy.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", lossless, copy}).exit_code, 0);
  EXPECT_EQ(read_text(copy), read_text(lossless));
  ASSERT_EQ(run_sbrdf({"convert", lossless, copy, "--precision", "1%"}).exit_code, 0);
  EXPECT_LT(std::filesystem::file_size(copy), std::filesystem::file_size(lossless) / 4);
  const std::string again = folder / "again.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", copy, again}).exit_code, 0);
  EXPECT_EQ(read_text(again), read_text(copy)) << "a copy of a bounded file changes nothing";
}

TEST(Precision, OfACopyStaysWhenOnlyItsChunksChange) {
  const ScratchFolder folder;
  const std::string lossless = sampled(folder, {"--precision", "lossless"});
  const std::string split = folder / "split.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", lossless, split, "--chunks", "split"}).exit_code, 0);
  EXPECT_DOUBLE_EQ(run_sbrdf({"info", split, "--json"}).json()["precision_percent"], 0);
  EXPECT_EQ(run_sbrdf({"compare", lossless, split, "--random", "500", "--max-mre", "0"}).exit_code, 0);
}

TEST(Precision, OfACoarserCopyTakesTheOldErrorsOutOfTheMetadata) {
  const ScratchFolder folder;
  const std::string coarse = folder / "coarse.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", sampled(folder, {"--precision", "0.1%"}), coarse, "--precision", "20%"}).exit_code,
            0);
  const auto metadata = run_sbrdf({"info", coarse, "--json"}).json()["metadata"];
  EXPECT_FALSE(metadata.contains("error"));
  EXPECT_TRUE(metadata.contains("error_before_rounding"));
  EXPECT_DOUBLE_EQ(metadata["coded_before_percent"][0], 0.1);
}

TEST(Precision, IsAsCoarseAsAddsATenthToTheErrorUnlessTold) {
  const ScratchFolder folder;
  const auto mre_of = [&](const std::string& precision) {
    const auto info = run_sbrdf({"info", sampled(folder, {"--precision", precision}), "--json"}).json();
    return info["metadata"]["error"]["mre_percent"].get<double>();
  };
  const double exact = mre_of("lossless");
  const double fits = mre_of("auto");
  EXPECT_LE(fits, 1.15 * exact + 0.002);  // chosen on other directions
  const auto info = run_sbrdf({"info", sampled(folder, {"--metadata", "lean"}), "--json"}).json();
  EXPECT_EQ(info["metadata"]["error"]["mre_percent"], fits);
  const double percent = info["precision_percent"];
  EXPECT_GT(percent, 0);
  EXPECT_GT(mre_of(std::to_string(3 * percent) + "%"), 1.05 * exact);
}

TEST(Precision, CountsTowardsATarget) {
  const ScratchFolder folder;
  const std::string file = folder / "a.sbrdf";
  const ProgramRun run = run_sbrdf({"convert", "kurt:wood01", file, "--target-mre", "4", "--precision", "2%",
                                    "--placement", "28/180", "--values", "measured", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LE(run_sbrdf({"info", file, "--json"}).json()["metadata"]["error"]["mre_percent"], 4);
}

TEST(Precision, IsAMatterOfSlicedFiles) {
  const ScratchFolder folder;
  for (const auto& option : {std::vector<std::string>{"--precision", "1%"}, {"--chunks", "split"}}) {
    std::vector<std::string> command = {"convert", "kurt:wood01", folder / "a.binary"};
    command.insert(command.end(), option.begin(), option.end());
    EXPECT_EQ(run_sbrdf(command).exit_code, 1);
  }
  EXPECT_TRUE(folder.entries().empty());
}

TEST(Precision, RefusesWhatIsNoPrecision) {
  const ScratchFolder folder;
  for (const char* text : {"0", "-1%", "nan", "60%", "0.1 %", "low", "%", ""}) {
    const ProgramRun run = run_sbrdf({"convert", "kurt:wood01", folder / "a.sbrdf", "--precision", text});
    EXPECT_EQ(run.exit_code, 1) << text;
    EXPECT_THAT(run.err, HasSubstr("--precision")) << text;
  }
  EXPECT_TRUE(folder.entries().empty());
}

TEST(Metadata, TellWhereTheFileComesFrom) {
  const ScratchFolder folder;
  const std::string table = folder / "table.binary";
  write_bytes(table, small_merl());
  const std::string file = folder / "a.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", table, file, "--samples", "300", "--search-evaluations", "3", "--metadata", "full"})
                .exit_code,
            0);
  const auto metadata = run_sbrdf({"info", file, "--json"}).json()["metadata"];
  // Another program's opinion.
  const ProgramRun sum = run_command({"sha256sum", table});
  EXPECT_EQ(metadata["source"]["sha256"], sum.out.substr(0, 64));
  EXPECT_EQ(metadata["command"],
            "sbrdf convert table.binary a.sbrdf --samples 300 --search-evaluations 3 --metadata full");
  EXPECT_EQ(metadata["quantity"], "f_r, 1/sr, without cosine");
  EXPECT_TRUE(metadata.contains("colour"));
  // A copy may have less.
  const std::string lean = folder / "lean.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", file, lean, "--metadata", "lean"}).exit_code, 0);
  const auto left = run_sbrdf({"info", lean, "--json"}).json()["metadata"];
  EXPECT_EQ(left["source"]["sha256"], sum.out.substr(0, 16));
  EXPECT_EQ(left["error"]["mre_percent"], metadata["error"]["mre_percent"]);
  EXPECT_FALSE(left.contains("command"));
  const std::string none = folder / "none.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", file, none, "--metadata", "none"}).exit_code, 0);
  EXPECT_LT(std::filesystem::file_size(none), std::filesystem::file_size(lean));
  EXPECT_LT(std::filesystem::file_size(lean), std::filesystem::file_size(file) - 100);
  EXPECT_EQ(run_sbrdf({"compare", none, file, "--random", "500", "--max-mre", "0"}).exit_code, 0);
}

TEST(Levels, TakeMoreBytesAndComeCloser) {
  const ScratchFolder folder;
  const std::string file = sampled(folder, {"--chunks", "split", "--precision", "0.1%"});
  const auto rows = run_sbrdf({"info", file, "--levels", "--json"}).json();
  ASSERT_GT(rows.size(), 2U);
  for (std::size_t k = 1; k < rows.size(); ++k) {
    EXPECT_EQ(rows[k]["level"], k);
    EXPECT_GE(rows[k]["bytes"], rows[k - 1]["bytes"]);
    EXPECT_GT(rows[k]["samples"], rows[k - 1]["samples"]);
    EXPECT_LT(rows[k]["rel_l1_percent"], rows[k - 1]["rel_l1_percent"]);
  }
  EXPECT_GT(rows[1]["bytes"], rows[0]["bytes"]);
  EXPECT_EQ(rows.back()["rel_l1_percent"], 0.0);
  EXPECT_EQ(rows.back()["samples"], 2000);
  const auto against = run_sbrdf({"info", file, "--levels", "--against", "kurt:fabric112", "--json"}).json();
  EXPECT_GT(against.back()["rel_l1_percent"], 0.1);
  EXPECT_THAT(run_sbrdf({"info", file, "--levels"}).out, HasSubstr("bytes to read"));
}

TEST(Levels, AreThoseOfSlicedFilesOnly) {
  const ScratchFolder folder;
  const std::string table = folder / "a.binary";
  write_bytes(table, small_merl());
  expect_failure(run_sbrdf({"info", table, "--levels"}), 4, table, "levels of detail are those of sliced files");
  EXPECT_EQ(run_sbrdf({"info", table, "--against", "kurt:wood01"}).exit_code, 1);
}

TEST(Extract, WritesASmallerFileThatAgreesBelowItsTheta) {
  const ScratchFolder folder;
  const std::string file = sampled(folder);
  const std::string part = folder / "part.sbrdf";
  const auto json = run_sbrdf({"extract", file, part, "--theta-max", "40", "--json"}).json();
  EXPECT_LT(json["bytes_out"], json["bytes_in"]);
  EXPECT_LE(json["bytes_read"], json["bytes_in"]);
  EXPECT_EQ(json["bytes_out"], std::filesystem::file_size(part));
  EXPECT_LT(json["difference_rel_l1_percent"], 1.0);
  const auto info = run_sbrdf({"info", part, "--json"}).json();
  EXPECT_EQ(info["placement"]["elevations_deg"], std::vector<double>({0, 20, 40}));
  EXPECT_TRUE(info["metadata"].contains("error_of_whole"));
  EXPECT_EQ(info["metadata"]["extracted"]["theta_max_deg"], 40);
  // On the nodes both are the same samples.
  const RunOptions rows = {.input = "theta_i,phi_i,theta_v,phi_v\n20,0,40,180\n20,30,20,90\n"};
  EXPECT_EQ(run_sbrdf({"eval", part}, rows).out, run_sbrdf({"eval", file}, rows).out);
  EXPECT_EQ(run_sbrdf({"verify", part}).exit_code, 0);
}

TEST(Extract, WorksForEveryThetaItTakes) {
  const ScratchFolder folder;
  const std::string file = sampled(folder);
  const std::string part = folder / "part.sbrdf";
  for (const char* theta : {"1", "3.5", "90"}) {
    EXPECT_EQ(run_sbrdf({"extract", file, part, "--theta-max", theta}).exit_code, 0) << theta;
  }
}

TEST(Extract, OfAPartKeepsTheLimitsOfThePart) {
  const ScratchFolder folder;
  const std::string part = folder / "part.sbrdf";
  ASSERT_EQ(run_sbrdf({"extract", sampled(folder), part, "--theta-max", "40", "--level", "1"}).exit_code, 0);
  const std::string again = folder / "again.sbrdf";
  ASSERT_EQ(run_sbrdf({"extract", part, again, "--theta-max", "80"}).exit_code, 0);
  const auto metadata = run_sbrdf({"info", again, "--json"}).json()["metadata"];
  EXPECT_EQ(metadata["extracted"]["theta_max_deg"], 40);
  EXPECT_EQ(metadata["extracted"]["max_level"], 1);
  EXPECT_EQ(metadata["extracted_before"].size(), 1U);
}

TEST(Extract, LeavesOutFinerLevels) {
  const ScratchFolder folder;
  const std::string file = sampled(folder, {"--chunks", "split", "--precision", "0.1%"});
  const std::string coarse = folder / "coarse.sbrdf";
  const auto json = run_sbrdf({"extract", file, coarse, "--level", "0", "--json"}).json();
  EXPECT_EQ(json["samples_out"], run_sbrdf({"info", file, "--json"}).json()["samples"]["crossings"]);
  EXPECT_LT(json["bytes_read"], json["bytes_in"]);
}

TEST(Extract, LeavesNothingBehindWhenItFails) {
  const ScratchFolder folder;
  const std::string text = folder / "text.sbrdf";
  write_bytes(text, bytes_of("no sliced file"));
  expect_failure(run_sbrdf({"extract", text, folder / "out.sbrdf"}), 3, text, "a text file");
  const std::string missing = folder / "missing.sbrdf";
  expect_failure(run_sbrdf({"extract", missing, folder / "out.sbrdf"}), 2, missing, "cannot be opened");
  const std::string file = sampled(folder);
  EXPECT_EQ(run_sbrdf({"extract", file, folder / "out.sbrdf", "--theta-max", "0"}).exit_code, 1);
  EXPECT_EQ(run_sbrdf({"extract", file, folder / "out.sbrdf", "--level", "17"}).exit_code, 1);
  EXPECT_EQ(run_sbrdf({"extract", file, folder / "out.binary"}).exit_code, 1);
  EXPECT_EQ(run_sbrdf({"extract", file, folder / "no-folder/out.sbrdf"}).exit_code, 2);
  EXPECT_THAT(folder.entries(), testing::ElementsAre("fabric112.sbrdf", "text.sbrdf"));
}

TEST(Verify, NamesEveryBadFileAndChecksTheOthers) {
  const ScratchFolder folder;
  const std::string good = folder / "good.sbrdf";
  write_bytes(good, small_sliced());
  std::vector<std::byte> bytes = small_sliced();
  bytes.back() ^= std::byte{1};
  const std::string flipped = folder / "flipped.sbrdf";
  write_bytes(flipped, bytes);
  bytes = small_sliced();
  bytes.pop_back();
  const std::string cut = folder / "cut.sbrdf";
  write_bytes(cut, bytes);
  const ProgramRun run = run_sbrdf({"verify", flipped, good, cut});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr(flipped + ": [SB-1-7]"));
  EXPECT_THAT(run.err, HasSubstr(cut + ": [SB-3-2]"));
  EXPECT_THAT(run.out, HasSubstr(good));
  const auto json = run_sbrdf({"verify", good, flipped, "--json"}).json();
  EXPECT_EQ(json[0]["ok"], true);
  EXPECT_EQ(json[1]["ok"], false);
  EXPECT_EQ(run_sbrdf({"verify", good}).exit_code, 0);
}

TEST(Verify, ChecksEveryMaterialOfABundle) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "in");
  for (const char* name : {"in/a.sbrdf", "in/b.sbrdf"}) write_bytes(folder / name, small_sliced());
  const std::string bundle = folder / "all.sbrdfz";
  ASSERT_EQ(run_sbrdf({"pack", folder / "in", bundle}).exit_code, 0);
  const auto json = run_sbrdf({"verify", bundle, "--json"}).json();
  EXPECT_EQ(json[0]["ok"], true);
  EXPECT_EQ(json[0]["materials"], 2);
  std::string bytes = read_text(bundle);
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  write_bytes(bundle, bytes_of(bytes));
  expect_failure(run_sbrdf({"verify", bundle}), 3, bundle, "b: [SB-1-7]");
}

TEST(Codings, StatesSizesThatFilesHave) {
  const ScratchFolder folder;
  const std::string file = sampled(folder, {"--precision", "lossless"});
  const std::string csv = folder / "codings.csv";
  const auto row = run_sbrdf({"codings", file, "--csv", csv, "--json"}).json()[0];
  EXPECT_EQ(row["samples"], 2000);
  EXPECT_EQ(row["values"], 6000);
  EXPECT_EQ(row["lossless_bytes"], std::filesystem::file_size(file));
  const std::string bounded = folder / "bounded.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", file, bounded, "--precision", "0.1%"}).exit_code, 0);
  constexpr double kMetadata = 40;  // a copy says in its metadata that it is one
  EXPECT_NEAR(row["tenth_percent_bytes"], static_cast<double>(std::filesystem::file_size(bounded)), kMetadata);
  EXPECT_LT(row["one_percent_bytes"], row["tenth_percent_bytes"]);
  EXPECT_LT(row["entropy_bytes"], row["stream_bytes"]);
  EXPECT_THAT(read_text(csv), HasSubstr("fabric112.sbrdf\",2000,6000,"));
  EXPECT_THAT(run_sbrdf({"codings", "kurt:wood01", "--samples", "100", "--placement", "paper"}).out,
              HasSubstr("kurt:wood01"));
}

TEST(Codings, FailsForWhatCannotBeRead) {
  EXPECT_EQ(run_sbrdf({"codings", "kurt:no-such-material"}).exit_code, 1);
  EXPECT_EQ(run_sbrdf({"codings"}).exit_code, 1);
}

}  // namespace
}  // namespace sbrdf::internal
