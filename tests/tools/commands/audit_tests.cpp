#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* kAuditedGloss =
    R"({"name": "gloss", "k_d": [0.1, 0.05, 0.02], "lobes": [{"k_s": [0.1, 0.1, 0.1], "f_0": 0.2, "m_x": 0.3,)"
    R"( "m_y": 0.3, "alpha": 0}]})";

/// Fast ways, at an error that little reaches.
std::vector<std::string> quickly(std::vector<std::string> arguments) {
  static const std::vector<std::string> kMore = {"--rel-l1", "25",           "--rel-l1", "15",
                                                 "--count",  "1000",         "--method", "table, half floats",
                                                 "--method", "table, fpzip", "--method", "table, zstd"};
  arguments.insert(arguments.end(), kMore.begin(), kMore.end());
  return arguments;
}

TEST(AuditCommand, TellsTheSameInEveryForm) {
  const ScratchFolder folder;
  const std::string file = folder / "gloss.json";
  write_bytes(file, bytes_of(kAuditedGloss));
  const std::string out = folder / "out";
  const ProgramRun run = run_sbrdf(quickly({"audit", file, "--out", out, "--json"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_EQ(read_text(out + "/audit.json"), run.out);
  const Json json = run.json();
  const Json rows = json.at("materials").at(0).at("rows");
  ASSERT_EQ(rows.size(), 6U);
  for (const Json& row : rows) {
    EXPECT_TRUE(row.at("reached").get<bool>()) << row;
    EXPECT_LE(row.at("off_grid_rel_l1_percent"), row.at("target_rel_l1_percent"));
    EXPECT_EQ(row.at("bits"), 8 * row.at("bytes").get<std::uint64_t>());
    EXPECT_EQ(row.at("bytes"),
              row.at("overhead_bytes").get<std::uint64_t>() + row.at("payload_bytes").get<std::uint64_t>());
  }
  EXPECT_EQ(json.at("totals").size(), 6U);
  const std::string csv = read_text(out + "/audit.csv");
  EXPECT_THAT(csv, testing::StartsWith("material,target_rel_l1_percent,method,setting,reached,bytes,bits,"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
  const std::string page = read_text(out + "/audit.md");
  for (const char* chart : {"bytes-25-percent.svg", "bytes-15-percent.svg"}) {
    EXPECT_THAT(page, HasSubstr(std::string("(") + chart + ")"));
    EXPECT_THAT(read_text(out + "/" + chart), HasSubstr("table, zstd"));
    EXPECT_EQ(run_command({"rsvg-convert", out + "/" + chart, "-o", folder / "chart.png"}).exit_code, 0);
  }
  const ProgramRun table = run_sbrdf(quickly({"audit", file}));
  EXPECT_THAT(table.out, HasSubstr("table, fpzip"));
  EXPECT_THAT(table.out, HasSubstr("1.00 x"));
}

/// The figures of a file that anybody can measure by another command.
TEST(AuditCommand, AgreesWithCompare) {
  const ScratchFolder folder;
  const std::string file = folder / "gloss.json";
  write_bytes(file, bytes_of(kAuditedGloss));
  const Json row =
      run_sbrdf({"audit", file, "--method", "MERL", "--rel-l1", "50", "--json"}).json()["materials"][0]["rows"][0];
  const std::string merl = folder / "gloss.binary";
  ASSERT_EQ(run_sbrdf({"convert", file, merl}).exit_code, 0);
  EXPECT_EQ(row["bytes"], fs::file_size(merl));
  const Json compared = run_sbrdf({"compare", file, merl, "--directions", "highlight", "--count", "200000",
                                   "--theta-max", "80", "--json"})
                            .json();
  EXPECT_NEAR(row["off_grid_rel_l1_percent"], compared["rel_l1_percent"],
              0.1 * compared["rel_l1_percent"].get<double>());
}

TEST(AuditCommand, NamesWhatIsWrong) {
  const ScratchFolder folder;
  const std::string bad = folder / "bad.binary";
  write_bytes(bad, bytes_of("no material"));
  expect_failure(run_sbrdf({"audit", folder / "none.bsdf"}), 2, folder / "none.bsdf", "");
  expect_failure(run_sbrdf(quickly({"audit", bad})), 3, bad, "");
  EXPECT_THAT(run_sbrdf({"audit", "kurt:wood01", "--method", "magic"}).err, HasSubstr("no method \"magic\""));
  for (const std::string target : {"0", "-1", "101", "x", "nan"}) {
    EXPECT_EQ(run_sbrdf({"audit", "kurt:wood01", "--rel-l1", target}).exit_code, 1) << target;
  }
  EXPECT_EQ(run_sbrdf({"audit", "kurt:wood01", "--count", "10"}).exit_code, 1);
  EXPECT_EQ(run_sbrdf({"audit"}).exit_code, 1);
  EXPECT_THAT(run_sbrdf({"audit", "kurt:wood01", "kurt:wood01"}).err, HasSubstr("twice"));
  // What fails does not stop the rest, and nothing that others made is replaced.
  const ProgramRun both = run_sbrdf(quickly({"audit", bad, "kurt:wood01", "--json"}));
  EXPECT_EQ(both.exit_code, 3);
  EXPECT_TRUE(both.json()["materials"][0].contains("error"));
  EXPECT_EQ(both.json()["materials"][1]["rows"].size(), 6U);
  fs::create_directory(folder / "out");
  write_bytes(folder / "out/audit.json", bytes_of(kAuditedGloss));
  EXPECT_EQ(run_sbrdf(quickly({"audit", "kurt:wood01", "--out", folder / "out"})).exit_code, 1);
  EXPECT_EQ(read_text(folder / "out/audit.json"), kAuditedGloss);
}

/// The text of an audit without resident bytes.
std::string but_for_residents(const std::string& text) {
  Json json = Json::parse(text);
  for (Json& material : json.at("materials")) {
    if (!material.contains("rows")) continue;
    for (Json& row : material.at("rows")) row.erase("resident_bytes");
  }
  return json.dump(1);
}

/// 40 files in six formats, two of them no materials.
void fill(const fs::path& folder) {
  fs::create_directories(folder / "below");
  const std::vector<std::string> extensions = {".csv", ".npy", ".exr", ".h5", ".json", ".binary"};
  for (std::size_t k = 0; k < 38; ++k) {
    const std::string extension = extensions[k % extensions.size()];
    const fs::path file = folder / (k % 3 == 0 ? "below" : "") / ("m" + std::to_string(k) + extension);
    const double roughness = 0.5 + 0.01 * static_cast<double>(k);
    const std::string model = (folder / "model.json").string();
    write_bytes(model,
                bytes_of("{\"name\": \"m\", \"k_d\": [0.1, 0.2, 0.1], \"lobes\": [{\"k_s\": [0.1, 0.1, 0.1], "
                         "\"f_0\": 0.5, \"m_x\": " +
                         std::to_string(roughness) + ", \"m_y\": " + std::to_string(roughness) + ", \"alpha\": 0}]}"));
    if (extension == ".json") {
      fs::rename(model, file);
      continue;
    }
    std::vector<std::string> convert = {"convert", model, file.string()};
    if (extension == ".binary") {
      convert.insert(convert.end(), {"--merl-shape", "12,8,12"});
    } else {
      convert.insert(convert.end(), {"--grid", "difference/0:10:10:15"});
    }
    ASSERT_EQ(run_sbrdf(convert).exit_code, 0) << file;
  }
  fs::remove(folder / "model.json");
  write_bytes(folder / "damaged.binary", bytes_of("nothing"));
  write_bytes(folder / "other.bsdf", bytes_of("nothing"));
}

TEST(AuditCommand, GoesOnWhereItWasInterrupted) {
  const ScratchFolder folder;
  fill(folder / "materials");
  const auto audit = [&](const std::string& out) {
    return std::vector<std::string>{"audit",    folder / "materials", "--out",   out,    "--rel-l1", "25",
                                    "--method", "table, half floats", "--count", "1000", "--method", "table, zstd"};
  };
  fs::create_directory(folder / "one");
  fs::create_directory(folder / "two");
  const std::string whole = folder / "one/out";
  const std::string resumed = folder / "two/out";
  const ProgramRun at_once = run_sbrdf(audit(whole));
  EXPECT_EQ(at_once.exit_code, 3) << "two are no materials: " << at_once.err;
  EXPECT_THAT(at_once.err, HasSubstr("damaged.binary"));
  EXPECT_THAT(at_once.err, HasSubstr("other.bsdf"));

  RunningSbrdf running(audit(resumed));
  for (int line = 0; line < 9; ++line) static_cast<void>(running.read_line());
  running.signal(SIGINT);
  EXPECT_EQ(running.wait(), 128 + SIGINT);
  EXPECT_FALSE(fs::exists(resumed + "/audit.csv")) << "a report is whole or not there";
  std::vector<std::pair<fs::path, std::string>> noted_files;
  for (const auto& entry : fs::directory_iterator(resumed + "/.sbrdf-audit")) {
    const std::string text = read_text(entry.path());
    // The last one may have been in the middle of its rows.
    if (Json::parse(text).at("rows").size() == 2) noted_files.emplace_back(entry.path(), text);
  }
  EXPECT_GE(noted_files.size(), 7U);
  EXPECT_LT(noted_files.size(), 38U) << "it was to be interrupted before its end";

  EXPECT_EQ(run_sbrdf(audit(resumed)).exit_code, 3);
  EXPECT_EQ(read_text(resumed + "/bytes-25-percent.svg"), read_text(whole + "/bytes-25-percent.svg"));
  // Resident bytes are of the machine and the moment, all else is of the files.
  EXPECT_EQ(but_for_residents(read_text(resumed + "/audit.json")), but_for_residents(read_text(whole + "/audit.json")));
  EXPECT_EQ(std::count_if(noted_files.begin(), noted_files.end(),
                          [&](const auto& before) { return read_text(before.first) == before.second; }),
            std::ptrdiff_t(noted_files.size()))
      << "what was done is kept as it was";
  const Json json = Json::parse(read_text(whole + "/audit.json"));
  EXPECT_EQ(json.at("materials").size(), 40U);
  EXPECT_EQ(json.at("totals").at(0).at("materials"), 38U);
  // A third run has nothing to do but to look.
  const auto before = std::chrono::steady_clock::now();
  EXPECT_EQ(run_sbrdf(audit(resumed)).exit_code, 3);
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(20));
}

/// A fast audit of two materials: their folder, and that of the report.
class AuditOfTwo : public testing::Test {
 protected:
  AuditOfTwo() {
    fs::create_directory(in_);
    write_bytes(in_ + "/a.json", bytes_of(kAuditedGloss));
    std::string rough = kAuditedGloss;
    rough.replace(rough.find("0.3,"), 3, "0.6");
    write_bytes(in_ + "/b.json", bytes_of(rough));
  }
  [[nodiscard]] ProgramRun audit(const std::string& out, const std::vector<std::string>& more = {},
                                 const RunOptions& options = {}) const {
    std::vector<std::string> arguments = {"audit", in_,        "--out", out,        "--count",
                                          "1000",  "--method", "UTIA",  "--method", "table, fpzip"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    if (more.empty()) arguments.insert(arguments.end(), {"--rel-l1", "25"});
    return run_sbrdf(arguments, options);
  }

  ScratchFolder folder_;
  std::string in_ = folder_ / "in";
  std::string out_ = folder_ / "out";
};

TEST_F(AuditOfTwo, TellsOfEachAndLosesNothingWhereOutputIsLost) {
  const ProgramRun run = audit(out_);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr(in_ + "/a.json: 25 %: "));
  EXPECT_THAT(run.out, HasSubstr(in_ + "/b.json: 25 %: "));
  EXPECT_THAT(run.out, HasSubstr("2 of 2"));
  const std::string before = read_text(out_ + "/audit.csv");
  RunOptions full;
  full.output_to_full_device = true;
  EXPECT_EQ(audit(out_, {}, full).exit_code, 2);
  EXPECT_EQ(read_text(out_ + "/audit.csv"), before);
}

TEST_F(AuditOfTwo, DoesAgainWhatTheJournalDoesNotSay) {
  ASSERT_EQ(audit(out_).exit_code, 0);
  const std::string whole = but_for_residents(read_text(out_ + "/audit.json"));
  const std::vector<std::pair<std::string, Json>> changes = {{"reached", "yes"},
                                                             {"bytes", -5},
                                                             {"bytes", 1e300},
                                                             {"bytes", "12"},
                                                             {"bytes", 0},
                                                             {"setting", ""},
                                                             {"method", "no"},
                                                             {"method", nullptr},
                                                             {"overhead_bytes", 1u << 30U},
                                                             {"off_grid_mre_percent", "?"}};
  for (const auto& [key, value] : changes) {
    for (const auto& entry : fs::directory_iterator(out_ + "/.sbrdf-audit")) {
      Json journal = Json::parse(read_text(entry.path()));
      journal.at("rows").at(0)[key] = value;
      write_bytes(entry.path(), bytes_of(journal.dump()));
    }
    const ProgramRun again = audit(out_);
    EXPECT_EQ(again.exit_code, 0) << key << value << again.err;
    EXPECT_EQ(but_for_residents(read_text(out_ + "/audit.json")), whole) << key << value;
  }
  for (const char* text : {"", "{", "[]", "{\"work\": 1}", "{\"work\": \"x\", \"rows\": {}}"}) {
    for (const auto& entry : fs::directory_iterator(out_ + "/.sbrdf-audit")) write_bytes(entry.path(), bytes_of(text));
    EXPECT_EQ(audit(out_).exit_code, 0) << text;
    EXPECT_EQ(but_for_residents(read_text(out_ + "/audit.json")), whole) << text;
  }
}

TEST_F(AuditOfTwo, FurtherTargetsAreAddedWithTheDigitsOfReports) {
  ASSERT_EQ(audit(out_).exit_code, 0);
  const ProgramRun more =
      audit(out_, {"--rel-l1", "33.33333333", "--rel-l1", "25", "--rel-l1", "25.00000001", "--json"});
  ASSERT_EQ(more.exit_code, 0) << more.err;
  const Json json = more.json();
  EXPECT_EQ(json.at("totals").size(), 4U) << "two targets, two ways";
  EXPECT_EQ(json.at("materials").at(0).at("rows").size(), 4U);
  EXPECT_TRUE(fs::exists(out_ + "/bytes-33.3333-percent.svg"));
  const auto journal = [&] {
    std::string all;
    for (const auto& entry : fs::directory_iterator(out_ + "/.sbrdf-audit")) all += read_text(entry.path());
    return all.size();
  };
  const auto size = journal();
  ASSERT_EQ(audit(out_, {"--rel-l1", "33.33333333"}).exit_code, 0);
  EXPECT_EQ(journal(), size) << "all of it was there";
}

TEST_F(AuditOfTwo, ReportsAreNoMaterials) {
  EXPECT_THAT(audit(in_).err, HasSubstr("is the folder that is read"));
  EXPECT_EQ(fs::exists(in_ + "/.sbrdf-audit"), false);
  ASSERT_EQ(audit(in_ + "/report").exit_code, 0);
  const ProgramRun other = audit(in_ + "/other");
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_THAT(other.out, HasSubstr("2 of 2"));
  const ProgramRun twice = run_sbrdf({"audit", in_ + "/a.json", in_ + "/../in/a.json"});
  EXPECT_EQ(twice.exit_code, 1);
  EXPECT_THAT(twice.err, HasSubstr("twice"));
}

}  // namespace
}  // namespace sbrdf::internal
