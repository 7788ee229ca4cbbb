#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

TEST(Info, TellsThatCrossingsAreAsManyAsTheMethodSays) {
  struct Placement {
    const char* text;
    double elevation_step_deg, azimuth_step_deg;
    int crossings;
  };
  for (const auto& placement : {Placement{"28/180", 28, 180, 55}, {"14/36", 14, 36, 3781}, {"10/36", 10, 36, 6641}}) {
    const ScratchFolder folder;
    const std::string out = folder / "out.sbrdf";
    ASSERT_EQ(run_sbrdf(plainly({"convert", "kurt:fabric112", out, "--placement", placement.text, "--samples",
                                 std::to_string(placement.crossings)}))
                  .exit_code,
              0);
    const auto json = run_sbrdf({"info", out, "--json"}).json();
    EXPECT_EQ(json["samples"]["crossings"], placement.crossings);
    EXPECT_EQ(json["samples"]["adaptive"], 0);
    EXPECT_EQ(json["samples"]["total"], placement.crossings);
    EXPECT_EQ(json["placement"]["elevation_step_deg"], placement.elevation_step_deg);
    EXPECT_EQ(json["placement"]["azimuth_step_deg"], placement.azimuth_step_deg);
  }
}

TEST(Info, DescribesASlicedFile) {
  const ScratchFolder folder;
  const std::string file = folder / "any.name";
  ASSERT_EQ(
      run_sbrdf(plainly({"convert", "kurt:fabric112", folder / "a.sbrdf", "--placement", "14/36", "--samples", "3900"}))
          .exit_code,
      0);
  std::filesystem::rename(folder / "a.sbrdf", file);
  const auto json = run_sbrdf({"info", file, "--json"}).json();
  EXPECT_EQ(json["format"], "sbrdf");
  EXPECT_EQ(json["version"], "1.0");
  EXPECT_EQ(json["frame"], "elevation");
  EXPECT_EQ(json["domain"], "log");
  EXPECT_EQ(json["isotropic"], false);
  EXPECT_EQ(json["channels"], std::vector<std::string>({"R", "G", "B"}));
  EXPECT_EQ(json["placement"]["elevations_deg"], std::vector<double>({0, 14, 28, 42, 56, 70, 80}));
  EXPECT_EQ(json["samples"]["total"], 3900);
  EXPECT_EQ(json["bytes"], std::filesystem::file_size(file));
  EXPECT_EQ(json["metadata"]["source"]["format"], "kurt");
}

TEST(Info, DescribesMerlFilesAndModels) {
  const ScratchFolder folder;
  write_bytes(folder / "a", small_merl());
  const auto merl = run_sbrdf({"info", folder / "a", "--json"}).json();
  EXPECT_EQ(merl["format"], "merl");
  EXPECT_EQ(merl["isotropic"], true);
  EXPECT_EQ(merl["shape"], std::vector<int>({2, 2, 2}));
  EXPECT_EQ(merl["bytes"], 204);
  const auto model = run_sbrdf({"info", "kurt:wood01", "--json"}).json();
  EXPECT_EQ(model["format"], "kurt");
  EXPECT_EQ(model["reciprocal"], true);
  EXPECT_TRUE(model["bytes"].is_null());
}

TEST(Info, ReadsTheParametersOfAModelFromAFile) {
  const ScratchFolder folder;
  write_bytes(folder / "mine.json", bytes_of(R"({"name": "mine\u001b[31m", "k_d": [0.1, 0.1, 0.1], "lobes": []})"));
  const ProgramRun refused = run_sbrdf({"info", "kurt:" + (folder / "mine.json")});
  EXPECT_EQ(refused.err.find('\x1B'), std::string::npos);
  write_bytes(folder / "mine.json", bytes_of(R"({"name": "mine", "k_d": [0.1, 0.1, 0.1], "lobes":
      [{"k_s": [1, 1, 1], "f_0": 0.5, "m_x": 0.1, "m_y": 0.2, "alpha": 0.5}]})"));
  const ProgramRun run = run_sbrdf({"info", "kurt:" + (folder / "mine.json")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("mine"));
}

TEST(Compare, GivesAllFigures) {
  const ScratchFolder folder;
  const std::string test = folder / "test.sbrdf";
  ASSERT_EQ(run_sbrdf({"convert", "kurt:fabric112", test, "--placement", "14/36", "--samples", "8911", "--refine",
                       "measured"})
                .exit_code,
            0);
  const ProgramRun run = run_sbrdf({"compare", "kurt:fabric112", test, "--random", "20000", "--seed", "7", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const auto json = run.json();
  EXPECT_NEAR(json["mre_percent"], 0.93, 0.1);
  for (const char* key : {"rel_l1_percent", "rmse", "max_abs", "psnr_db", "seconds"}) EXPECT_GT(json[key], 0) << key;
  EXPECT_EQ(json["directions"], 20000);
  EXPECT_EQ(json["floor"], 0);
  EXPECT_EQ(json["step_deg"], 2);
  EXPECT_EQ(json["theta_max_deg"], 80);
  EXPECT_EQ(json["symmetrised"], false);
  EXPECT_EQ(json["mre_left_out"], 0);
  const auto again =
      run_sbrdf({"compare", "kurt:fabric112", test, "--random", "20000", "--seed", "7", "--json"}).json();
  EXPECT_EQ(again["mre_percent"], json["mre_percent"]);
}

TEST(Compare, OfASourceWithItselfHasNoFinitePsnr) {
  const ScratchFolder folder;
  write_bytes(folder / "a", small_merl());
  const auto json = run_sbrdf({"compare", folder / "a", folder / "a", "--step", "10", "--json"}).json();
  EXPECT_EQ(json["mre_percent"], 0);
  EXPECT_EQ(json["max_abs"], 0);
  EXPECT_TRUE(json["psnr_db"].is_null());
  EXPECT_EQ(json["directions"], 9 * 9 * 36);
  EXPECT_EQ(json["grid_directions"], 9 * 9 * 36 * 36);
}

TEST(Compare, StatesUnitsAndTheFloor) {
  const ProgramRun run =
      run_sbrdf({"compare", "kurt:fabric112", "kurt:fabric002", "--random", "99", "--floor", "0.001", "--symmetrise"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* text : {"floor 0.001 1/sr", " %", " dB", "seed 1", "mean of f(i,v) and f(v,i)"}) {
    EXPECT_THAT(run.out, HasSubstr(text));
  }
}

TEST(Compare, GivesAllFiguresBetweenTheNodesOfTheGrid) {
  for (const std::string directions : {"random", "highlight"}) {
    const auto json = run_sbrdf({"compare", "kurt:fabric112", "kurt:fabric002", "--directions", directions, "--count",
                                 "3000", "--seed", "7", "--json"})
                          .json();
    EXPECT_EQ(json["drawn"], directions);
    EXPECT_EQ(json["directions"], 3000);
    EXPECT_EQ(json["seed"], 7);
    EXPECT_FALSE(json.contains("step_deg"));
    EXPECT_GT(json["floor"], 0.0001);
    ASSERT_EQ(json["channels"].size(), 3);
    for (const auto& figures : {json, json["channels"][2]}) {
      for (const char* key : {"mre_percent", "rel_l1_percent", "cosine_rel_l1_percent", "rmse", "psnr_db"}) {
        EXPECT_GT(figures[key], 0) << key;
      }
      EXPECT_LE(figures["relative_p99_percent"], figures["relative_p999_percent"]);
      EXPECT_LE(figures["relative_p999_percent"], figures["max_relative_percent"]);
      for (const char* place : {"max_abs_at", "max_relative_at"}) {
        for (const char* angle : {"theta_i_deg", "phi_i_deg", "theta_v_deg", "phi_v_deg"}) {
          EXPECT_GE(figures[place][angle], 0);
          EXPECT_LE(figures[place][angle], angle[0] == 't' ? 80 : 360);
        }
      }
      const auto& at = figures["max_abs_at"];
      EXPECT_NEAR(std::abs(at["reference"].get<double>() - at["test"].get<double>()), figures["max_abs"], 1e-6);
    }
    EXPECT_EQ(json["channels"][2]["max_abs_at"]["channel"], json["channels"][2]["name"]);
  }
}

TEST(Compare, GivesTheValuesThatEvalGivesWhereTheErrorIsLargest) {
  const auto json =
      run_sbrdf({"compare", "kurt:fabric112", "kurt:fabric002", "--directions", "random", "--count", "500", "--json"})
          .json();
  const auto& at = json["max_abs_at"];
  RunOptions options;
  options.input = "theta_i,phi_i,theta_v,phi_v\n" + at["theta_i_deg"].dump() + "," + at["phi_i_deg"].dump() + "," +
                  at["theta_v_deg"].dump() + "," + at["phi_v_deg"].dump() + "\n";
  const std::string row = run_sbrdf({"eval", "kurt:fabric002"}, options).out;
  std::istringstream words(row.substr(row.find('\n') + 1));
  std::vector<double> numbers;
  for (std::string word; std::getline(words, word, ',');) numbers.push_back(std::stod(word));
  const std::size_t channel = at["channel"] == "R" ? 4 : at["channel"] == "G" ? 5 : 6;
  EXPECT_NEAR(numbers.at(channel), at["test"], 1e-5);
}

TEST(Compare, WarnsOfFalseValues) {
  const ScratchFolder folder;
  const auto diffuse = [&](const std::string& name, const std::string& k_d) {
    write_bytes(folder / name, bytes_of(R"({"name": "diffuse", "k_d": [)" + k_d + R"(], "lobes": []})"));
    return "kurt:" + (folder / name);
  };
  const std::string dark = diffuse("dark.json", "0.1, 0.1, 0.1");
  const std::string bright = diffuse("bright.json", "0.1, 0.1, 0.4");
  const std::vector<std::string> compare = {"compare", dark, bright, "--directions", "random", "--count", "300"};
  const ProgramRun run = run_sbrdf(compare);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, testing::ContainsRegex("false values +300 above 3 times"));
  EXPECT_THAT(run.err, HasSubstr(bright + ": warning: false values: 300 above 3 times"));
  EXPECT_THAT(run.err, HasSubstr("worst, 4 times, B at theta_i "));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1);
  std::vector<std::string> with_json = compare;
  with_json.push_back("--json");
  const auto found = run_sbrdf(with_json).json()["false_values"];
  EXPECT_EQ(found["count"], 300);
  EXPECT_EQ(found["strict"]["count"], 300);
  EXPECT_EQ(found["strict"]["too_large"], 300);
  EXPECT_EQ(found["complete"], true);
  EXPECT_EQ(found["worst_at"]["channel"], "B");
  EXPECT_EQ(run_sbrdf({"compare", bright, dark, "--random", "300"}).err, "");
}

TEST(Compare, FailsAboveALimit) {
  const std::vector<std::string> base = {"compare", "kurt:fabric112", "kurt:fabric002", "--random", "500"};
  const auto with = [&](const std::string& option, const std::string& limit) {
    std::vector<std::string> arguments = base;
    arguments.insert(arguments.end(), {option, limit});
    return run_sbrdf(arguments);
  };
  expect_failure(with("--max-mre", "0.5"), 5, "kurt:fabric002", "MRE");
  expect_failure(with("--max-rel-l1", "0.5"), 5, "kurt:fabric002", "rel L1");
  EXPECT_EQ(with("--max-mre", "1e9").exit_code, 0);
  EXPECT_EQ(with("--max-rel-l1", "1e9").exit_code, 0);
}

TEST(Compare, FailsALimitOnAnMreThatNoValueEntered) {
  const ScratchFolder folder;
  const std::string black = "kurt:" + (folder / "black.json");
  write_bytes(folder / "black.json", bytes_of(R"({"name": "black", "k_d": [0, 0, 0], "lobes": []})"));
  const std::vector<std::string> base = {"compare", black, "kurt:wood01", "--random", "500"};
  const auto with = [&](std::vector<std::string> options) {
    options.insert(options.begin(), base.begin(), base.end());
    return run_sbrdf(options);
  };
  expect_failure(with({"--max-mre", "1e9"}), 5, "kurt:wood01", "f = 0 in all 1,500 values");
  EXPECT_EQ(with({"--max-mre", "1e9", "--floor", "0.001"}).exit_code, 0);
  const ProgramRun unlimited = with({});
  EXPECT_EQ(unlimited.exit_code, 0);
  EXPECT_THAT(unlimited.out, testing::ContainsRegex("MRE +-"));
  EXPECT_TRUE(with({"--json"}).json()["mre_percent"].is_null());
}

TEST(Compare, RefusesWrongUsage) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--step", "0"},
      {"--step", "-2"},
      {"--step", "nan"},
      {"--theta-max", "91"},
      {"--random", "0"},
      {"--random", "1.5"},
      {"--random", "-1"},
      {"--seed", "3"},
      {"--floor", "-1"},
      {"--floor", "inf"},
      {"--max-mre", "low"},
      {"--max-mre", "-0.1"},
      {"--random", "1e12"},
      {"one more"},
      {"--count", "9"},
      {"--directions", "x"},
      {"--directions", "grid", "--count", "9"},
      {"--directions", "random", "--count", "0"},
      {"--directions", "random", "--random", "9"},
      {"--directions", "highlight", "--step", "2"},
      {"--directions", "random", "--theta-max", "0"},
  };
  for (const auto& options : wrong) {
    std::vector<std::string> arguments = {"compare", "kurt:wood01", "kurt:wood01"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProgramRun run = run_sbrdf(arguments);
    EXPECT_EQ(run.exit_code, 1) << testing::PrintToString(options) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

TEST(Compare, ShowsProgressOnATerminalAndWipesItOff) {
  RunningSbrdf program({"compare", "kurt:fabric112", "kurt:fabric135"}, Output::kTerminal);
  EXPECT_THAT(program.read_up_to('%'), testing::MatchesRegex("\r.*comparing \\[=* *\\] +[0-9]+ "));
  program.signal(SIGINT);
  EXPECT_THAT(program.read_line(), testing::EndsWith("\r\x1B[Ksbrdf: interrupted\r"));
  EXPECT_EQ(program.wait(), 130);
}

TEST(Formats, AreAllListed) {
  const auto json = run_sbrdf({"formats", "--json"}).json();
  std::map<std::string, std::pair<bool, bool>> uses;
  for (const auto& format : json["formats"]) uses[format["name"]] = {format["read"], format["write"]};
  EXPECT_EQ(uses["rgl"], std::pair(true, true));
  EXPECT_EQ(uses["zemax"], std::pair(true, false));
  EXPECT_EQ(json["models"][0]["materials"].size(), 10);
  const std::string text = run_sbrdf({"formats"}).out;
  for (const char* word : {".sbrdf", ".binary", ".bsdf", "kurt:", "fabric112"}) EXPECT_THAT(text, HasSubstr(word));
}

TEST(Program, HelpsWithAnExampleForEveryCommand) {
  for (const char* command : {"convert", "info", "compare", "eval", "formats"}) {
    const ProgramRun run = run_sbrdf({command, "--help"});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_EQ(run.err, "");
    const auto example = run.out.find("Example");
    ASSERT_NE(example, std::string::npos) << run.out;
    EXPECT_THAT(run.out.substr(example), HasSubstr(std::string("sbrdf ") + command));
    EXPECT_THAT(run.out, HasSubstr("--json"));
    EXPECT_THAT(run_sbrdf({"--help"}).out, HasSubstr(command));
  }
}

TEST(Program, TellsItsVersion) {
  EXPECT_THAT(run_sbrdf({"--version"}).out, testing::MatchesRegex("sbrdf [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(Program, RefusesWrongUsageInOneLine) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{}, {"frobnicate"}, {"--frobnicate"}, {"info"}, {"convert", "kurt:wood01"}}) {
    const ProgramRun run = run_sbrdf(arguments);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_THAT(run.err, testing::StartsWith("sbrdf: "));
  }
  EXPECT_THAT(run_sbrdf({"frobnicate"}).err, HasSubstr("'frobnicate'"));
}

TEST(Program, FailsWhereItsOutputIsLost) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no device that is always full here";
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"formats"}, {"formats", "--json"}, {"info", "kurt:wood01"}, {"--help"}}) {
    const ProgramRun run = run_sbrdf(arguments, {.output_to_full_device = true});
    expect_failure(run, 2, "standard output", "No space left on device");
  }
  const ProgramRun run = run_sbrdf({"eval", "kurt:wood01"},
                                   {.input = "theta_i,phi_i,theta_v,phi_v\n1,2,3,4\n", .output_to_full_device = true});
  expect_failure(run, 2, "standard output", "No space left on device");
}

}  // namespace
}  // namespace sbrdf::internal
