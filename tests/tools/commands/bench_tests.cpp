#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <sstream>

#include "converters/bench/methods.h"
#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

constexpr const char* kGloss =
    R"({"name": "gloss", "k_d": [0.1, 0.05, 0.02], "lobes": [{"k_s": [0.1, 0.1, 0.1], "f_0": 0.2, "m_x": 0.3,)"
    R"( "m_y": 0.3, "alpha": 0}]})";
constexpr const char* kHead =
    "material,method,variant,samples,single_ns,single_ratio,batch_ns,batch_ratio,yardstick_ns,first_value_ms,"
    "resident_bytes,file_bytes,grid_mre_percent,grid_rel_l1_percent,off_grid_mre_percent,off_grid_rel_l1_percent,"
    "machine";
constexpr const char* kGrowthHead = "material,method,against,at,ns,ratio,yardstick_ns,resident_bytes,machine";

/// Cells of a line, of which those in quotes hold commas.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells = {""};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) cells.emplace_back();
    if (c != '"' && (c != ',' || quoted)) cells.back() += c;
  }
  return cells;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Each row of the table says what its object says.
void expect_agreement(const std::string& csv, const char* head, const Json& rows, const std::string& machine) {
  const std::vector<std::string> lines = lines_of(csv);
  ASSERT_EQ(lines.size(), rows.size() + 1);
  EXPECT_EQ(lines[0], head);
  const std::vector<std::string> keys = cells_of(head);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::vector<std::string> cells = cells_of(lines[k + 1]);
    ASSERT_EQ(cells.size(), keys.size()) << lines[k + 1];
    EXPECT_EQ(cells.back(), machine);
    EXPECT_EQ(rows[k].size() + 1, keys.size());
    for (std::size_t c = 0; c + 1 < keys.size(); ++c) {
      const Json& value = rows[k].at(keys[c]);
      if (value.is_null()) {
        EXPECT_EQ(cells[c], "");
      } else if (value.is_string()) {
        EXPECT_EQ(cells[c], value.get<std::string>());
      } else {
        EXPECT_EQ(std::stod(cells[c]), value.get<double>()) << keys[c];
      }
    }
  }
}

class Bench : public testing::Test {
 protected:
  Bench() { write_bytes(model_, bytes_of(kGloss)); }

  ScratchFolder folder_;
  std::string model_ = folder_ / "gloss.json";
  std::string source_ = "kurt:" + model_;
  std::string out_ = folder_ / "out";
};

TEST_F(Bench, WritesTablesThatAgreeAndChartsIntoAFolder) {
  const ProgramRun run = run_sbrdf({"bench", source_, "--quick", "--out", out_, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const Json json = run.json();
  EXPECT_EQ(read_text(out_ + "/bench.json"), run.out);
  const std::string machine = json.at("machine").at("line");
  expect_agreement(read_text(out_ + "/bench.csv"), kHead, json.at("rows"), machine);
  expect_agreement(read_text(out_ + "/growth.csv"), kGrowthHead, json.at("growth"), machine);

  std::set<std::string> methods;
  for (const Json& row : json.at("rows")) {
    methods.insert(row.at("method"));
    for (const char* key : {"single_ns", "batch_ns", "yardstick_ns", "first_value_ms"})
      EXPECT_GT(row.at(key), 0) << row;
    EXPECT_LT(row.at("off_grid_mre_percent"), 10) << row;
  }
  for (const Method& method : bench_methods()) {
    EXPECT_EQ(methods.count(std::string(method.name)), method.name == "dense 4-D table" ? 0U : 1U) << method.name;
  }
  EXPECT_EQ(json.at("left_out").size(), 1U);

  const std::string page = read_text(out_ + "/bench.md");
  for (const char* chart :
       {"gloss-json-time", "gloss-json-bytes", "growth-samples", "growth-batch", "growth-threads"}) {
    const std::string file = std::string(chart) + ".svg";
    EXPECT_THAT(read_text(out_ + "/" + file), testing::EndsWith("</svg>\n"));
    EXPECT_THAT(read_text(out_ + "/" + file), HasSubstr(machine));
    EXPECT_THAT(page, HasSubstr("(" + file + ")"));
    EXPECT_EQ(run_command({"rsvg-convert", out_ + "/" + file, "-o", folder_ / "chart.png"}).exit_code, 0) << file;
  }
  EXPECT_THAT(page, HasSubstr(machine));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(out_), {}), 9);
  // Again, over what is there: which is what a benchmark wrote.
  write_bytes(out_ + "/growth.csv", bytes_of("old"));
  const ProgramRun again = run_sbrdf({"bench", source_, "--quick", "--out", out_});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr(machine));
  EXPECT_THAT(again.out, HasSubstr("plain trilinear look-up"));
  EXPECT_THAT(read_text(out_ + "/growth.csv"), testing::StartsWith(kGrowthHead));
}

TEST_F(Bench, RefusesBadInputsBeforeItMeasures) {
  expect_failure(run_sbrdf({"bench", folder_ / "none.binary", "--out", out_}), 2, folder_ / "none.binary",
                 "No such file");
  write_bytes(folder_ / "text.binary", bytes_of("no BRDF"));
  expect_failure(run_sbrdf({"bench", source_, folder_ / "text.binary", "--out", out_}), 3, folder_ / "text.binary", "");
  expect_failure(run_sbrdf({"bench", source_, source_, "--out", out_}), 1, source_, "is given twice");
  EXPECT_FALSE(std::filesystem::exists(out_)) << "the folder was made for nothing";
  EXPECT_EQ(run_sbrdf({"bench", "--out"}).exit_code, 1);
}

TEST_F(Bench, RefusesFoldersThatItCannotWriteTo) {
  expect_failure(run_sbrdf({"bench", source_, "--quick", "--out", model_}), 2, model_, "the folder cannot be made");
  expect_failure(run_sbrdf({"bench", source_, "--quick", "--out", folder_ / "a/b"}), 2, folder_ / "a/b",
                 "the folder cannot be made");
  std::filesystem::create_directory(out_);
  std::filesystem::permissions(out_, std::filesystem::perms(0555));
  std::filesystem::permissions(folder_.path(), std::filesystem::perms(0755));
  expect_failure(run_sbrdf({"bench", source_, "--quick", "--out", out_}, {.without_privileges = true}), 2, out_,
                 "bench.csv");
}

TEST_F(Bench, ReplacesNothingThatIsNoneOfItsOwn) {
  std::filesystem::create_directory(out_);
  write_bytes(out_ + "/bench.json", bytes_of(kGloss));
  expect_failure(run_sbrdf({"bench", source_, "--quick", "--out", out_}), 1, out_,
                 "bench.json: there is a file of another kind");
  std::filesystem::remove(out_ + "/bench.json");
  write_bytes(out_ + "/bench.csv", small_merl());
  expect_failure(run_sbrdf({"bench", source_, "--quick", "--out", out_}), 1, out_, "bench.csv: ");
  std::filesystem::remove(out_ + "/bench.csv");
  std::filesystem::create_symlink(model_, out_ + "/bench.json");
  expect_failure(run_sbrdf({"bench", source_, "--quick", "--out", out_}), 1, out_, "bench.json: is an input");
  EXPECT_EQ(read_text(model_), kGloss);
}

TEST_F(Bench, LeavesNothingBehindWhenItIsInterrupted) {
  for (const auto after : {std::chrono::milliseconds(100), std::chrono::milliseconds(900)}) {
    const ProgramRun run = run_sbrdf({"bench", source_, "--out", out_}, {.signal = SentSignal{SIGINT, after}});
    EXPECT_EQ(run.exit_code, 130);
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(run.err, "sbrdf: interrupted\n");
    EXPECT_FALSE(std::filesystem::exists(out_));
  }
}

}  // namespace
}  // namespace sbrdf::internal
