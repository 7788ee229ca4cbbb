#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/test_data.h"
#include "tests/tools/harness.h"
#include "tools/console/options.h"
#include "tools/io/direction_rows.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kHeader = "theta_i,phi_i,theta_v,phi_v\n";
const std::string kModel = "kurt:fabric112";

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// What follows the first `count` commas.
std::string after_commas(const std::string& line, int count) {
  std::size_t at = 0;
  for (int k = 0; k < count; ++k) at = line.find(',', at) + 1;
  return line.substr(at);
}

struct ReferenceRow {
  std::string angles;
  std::vector<double> f_r_cos;
};

std::map<std::string, std::vector<ReferenceRow>> read_reference(const std::filesystem::path& path) {
  std::map<std::string, std::vector<ReferenceRow>> files;
  for (const std::string& line : lines_of(read_text(path))) {
    if (line.starts_with('#') || line.starts_with("file,")) continue;
    const auto fields = split_fields(line);
    ReferenceRow row;
    for (std::size_t k = 1; k < 5; ++k) row.angles += (k > 1 ? "," : "") + std::string(fields[k]);
    for (std::size_t k = 5; k < 8; ++k) row.f_r_cos.push_back(parse_number(fields[k]).value());
    files[std::string(fields[0])].push_back(row);
  }
  return files;
}

/// Of the files that a table of values names, beside it.
void expect_reference_values(const std::filesystem::path& table, std::size_t row_count) {
  std::size_t rows = 0;
  for (const auto& [file, references] : read_reference(table)) {
    std::string input = kHeader;
    for (const ReferenceRow& row : references) input += row.angles + "\n";
    const ProgramRun run = run_sbrdf({"eval", (table.parent_path() / file).string(), "--cosine"}, {.input = input});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto lines = lines_of(run.out);
    ASSERT_EQ(lines.size(), references.size() + 1);
    EXPECT_EQ(lines[0], "theta_i,phi_i,theta_v,phi_v,R,G,B");
    for (std::size_t k = 0; k < references.size(); ++k, ++rows) {
      EXPECT_TRUE(lines[k + 1].starts_with(references[k].angles + ","));
      const auto fields = split_fields(lines[k + 1]);
      ASSERT_EQ(fields.size(), 7);
      for (std::size_t c = 0; c < 3; ++c) {
        const double expected = references[k].f_r_cos[c];
        const double tolerance = std::abs(expected) > 1e-4 ? 1e-4 * std::abs(expected) : 1e-7;
        EXPECT_NEAR(parse_number(fields[4 + c]).value(), expected, tolerance) << file << ", row " << k;
      }
    }
  }
  EXPECT_EQ(rows, row_count);
}

TEST(Eval, GivesTheReferenceValuesOfTheSmallRglFile) {
  expect_reference_values(SBRDF_SOURCE_DIR "/tests/vectors/rgl/small_reference.csv", 60);
}

TEST(Eval, GivesTheReferenceValuesOfMeasuredFiles) {
  SBRDF_FIND_TEST_DATA(table, "rgl/reference_values.csv");
  expect_reference_values(table, 900);
}

TEST(Eval, GivesTheSameTextForWholeTurnsMore) {
  const std::string input = kHeader +
                            "30,10.25,45,200.5\n"
                            "30,370.25,45,200.5\n"
                            "30,-349.75,45,920.5\n"
                            "30,3600010.25,45,-159.5\n";
  for (const char* file : {"kurt:fabric112", "kurt:Brushed alum"}) {
    const auto lines = lines_of(run_sbrdf({"eval", file}, {.input = input}).out);
    ASSERT_EQ(lines.size(), 5);
    for (std::size_t k = 2; k < lines.size(); ++k) EXPECT_EQ(after_commas(lines[k], 4), after_commas(lines[1], 4));
  }
}

TEST(Eval, KeepsRowsAsTheyWereAndFurtherColumns) {
  const std::string input = "theta_i, phi_i ,\"theta_v\",phi_v,note,more\r\n 30.0 ,0e0,+45,\"180\",\"a, b\",\r\n";
  const auto lines = lines_of(run_sbrdf({"eval", kModel}, {.input = input}).out);
  ASSERT_EQ(lines.size(), 2);
  EXPECT_EQ(lines[0], "theta_i, phi_i ,\"theta_v\",phi_v,note,more,R,G,B");
  EXPECT_TRUE(lines[1].starts_with(" 30.0 ,0e0,+45,\"180\",\"a, b\",,")) << lines[1];
}

TEST(Eval, TakesAHeaderWithoutRowsAndAnUnfinishedLastLine) {
  EXPECT_EQ(run_sbrdf({"eval", kModel}, {.input = kHeader}).out, "theta_i,phi_i,theta_v,phi_v,R,G,B\n");
  EXPECT_EQ(run_sbrdf({"eval", kModel, "--json"}, {.input = kHeader}).out, "[]\n");
  const std::string marked = "\xEF\xBB\xBF" + kHeader;
  const auto whole = run_sbrdf({"eval", kModel}, {.input = marked + "1,2,3,4\n\n\n"});
  EXPECT_EQ(whole.exit_code, 0) << whole.err;
  EXPECT_EQ(lines_of(whole.out).size(), 2);
  EXPECT_EQ(run_sbrdf({"eval", kModel}, {.input = kHeader + "1,2,3,4"}).out, whole.out);
}

TEST(Eval, MultipliesByTheCosineAccuratelyAtGrazing) {
  const std::string input = kHeader + "30,0,60,180\n30,0,89.999,180\n30,0,90,180\n";
  const auto plain = lines_of(run_sbrdf({"eval", kModel}, {.input = input}).out);
  const auto scaled = lines_of(run_sbrdf({"eval", kModel, "--cosine"}, {.input = input}).out);
  ASSERT_EQ(scaled.size(), 4);
  const auto ratio = [&](std::size_t row) {
    return parse_number(split_fields(scaled[row])[4]).value() / parse_number(split_fields(plain[row])[4]).value();
  };
  EXPECT_NEAR(ratio(1), 0.5, 1e-8);
  EXPECT_NEAR(ratio(2) / 1.7453292519057202e-5, 1, 1e-7);
  EXPECT_EQ(after_commas(scaled[3], 4), "0,0,0");
}

TEST(Eval, PrintsAnArrayOfObjects) {
  const ProgramRun run = run_sbrdf({"eval", kModel, "--json"},
                                   {.input = "theta_i,phi_i,theta_v,phi_v,note\n30,0,45,180,a\n10,0,10,20,7\n"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = run.json();
  ASSERT_EQ(json.size(), 2);
  EXPECT_EQ(json[0]["theta_v"], 45);
  EXPECT_EQ(json[0]["note"], "a");
  EXPECT_GT(json[1]["B"], 0);
}

TEST(Eval, GivesZeroBelowTheHorizonInEveryFormat) {
  const ScratchFolder folder;
  write_bytes(folder / "a.binary", small_merl());
  write_bytes(folder / "a.sbrdf", small_sliced());
  const std::string rows = kHeader + "90.001,0,45,180\n30,0,90.001,180\n100,0,170,5\n180,0,180,0\n";
  for (const std::string& file : {kModel, folder / "a.binary", folder / "a.sbrdf"}) {
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--cosine"}}) {
      std::vector<std::string> command = {"eval", file};
      command.insert(command.end(), more.begin(), more.end());
      const ProgramRun run = run_sbrdf(command, {.input = rows});
      ASSERT_EQ(run.exit_code, 0) << run.err;
      const auto lines = lines_of(run.out);
      ASSERT_EQ(lines.size(), 5);
      for (std::size_t k = 1; k < lines.size(); ++k) EXPECT_EQ(after_commas(lines[k], 4), "0,0,0") << lines[k];
    }
  }
  EXPECT_THAT(run_sbrdf({"eval", "--help"}).out, HasSubstr("0 where a theta is above 90 degrees"));
}

TEST(Eval, TakesWhatItPrints) {
  const std::string input =
      "theta_i,phi_i,theta_v,phi_v,\"a \"\"quoted\"\", name\"\r\n30,0,45,180,x\n 30 ,0,45,\"7\",\"y, "
      "z\"\n91,0,45,180,\n";
  for (const std::string& file : {kModel, std::string("kurt:wood01")}) {
    const ProgramRun once = run_sbrdf({"eval", file}, {.input = input});
    ASSERT_EQ(once.exit_code, 0) << once.err;
    const ProgramRun twice = run_sbrdf({"eval", file}, {.input = once.out});
    EXPECT_EQ(twice.err, "");
    EXPECT_EQ(twice.out, once.out);
    EXPECT_EQ(run_sbrdf({"eval", file, "--json"}, {.input = once.out}).out,
              run_sbrdf({"eval", file, "--json"}, {.input = input}).out);
  }
  EXPECT_EQ(run_sbrdf({"eval", kModel}, {.input = run_sbrdf({"eval", "kurt:wood01"}, {.input = input}).out}).out,
            run_sbrdf({"eval", kModel}, {.input = input}).out);
}

TEST(EvalInput, WithARepeatedNameIsRefusedBeforeAnythingIsWritten) {
  const auto with = [](const std::string& names) {
    return kHeader.substr(0, kHeader.size() - 1) + names + "\n1,2,3,4\n";
  };
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {",note,note", "note"},      {",R", "R"},       {",G,x", "G"},
      {",R,G,B,x", "B"},           {",R,R,G,B", "R"}, {",theta_i", "theta_i"},
      {",\"a,b\",\"a,b\"", "a,b"}, {",B,G,R", "B"}};
  for (const auto& [names, name] : wrong) {
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"eval", kModel}, {"eval", kModel, "--json"}}) {
      const ProgramRun run = run_sbrdf(command, {.input = with(names)});
      expect_failure(run, 3, "standard input: line 1", "two columns with the name '" + name + "'");
      EXPECT_EQ(run.out, "");
    }
  }
}

TEST(Eval, AnswersALineBeforeTheNextOneComes) {
  RunningSbrdf program({"eval", kModel});
  program.write(kHeader);
  EXPECT_EQ(program.read_line(), "theta_i,phi_i,theta_v,phi_v,R,G,B");
  for (const std::string row : {"30,0,45,180", "10,0,20,90"}) {
    program.write(row + "\n");
    EXPECT_THAT(program.read_line(), testing::StartsWith(row + ","));
  }
  EXPECT_EQ(program.wait(), 0);
}

TEST(Eval, StopsWhenInterrupted) {
  RunningSbrdf program({"eval", kModel});
  program.write(kHeader);
  EXPECT_NE(program.read_line(), "");
  program.signal(SIGINT);
  EXPECT_EQ(program.read_line(), "sbrdf: interrupted");
  EXPECT_EQ(program.wait(), 130);
}

TEST(Eval, WritesManyRowsInOrder) {
  std::string input = kHeader;
  for (int k = 0; k < 20000; ++k) input += "30,0,45," + std::to_string(k) + "\n";
  const auto lines = lines_of(run_sbrdf({"eval", kModel}, {.input = input}).out);
  ASSERT_EQ(lines.size(), 20001);
  for (std::size_t k = 0; k < 20000; ++k) {
    ASSERT_TRUE(lines[k + 1].starts_with("30,0,45," + std::to_string(k) + ","));
    ASSERT_EQ(after_commas(lines[k + 1], 4), after_commas(lines[k % 360 + 1], 4)) << k;
  }
}

TEST(EvalInput, IsRefusedByLine) {
  const auto refused = [](const std::string& input, const std::string& line, const std::string& fragment) {
    ProgramRun run = run_sbrdf({"eval", kModel}, {.input = input});
    expect_failure(run, 3, "standard input: " + line, fragment);
    return run;
  };
  refused("", "empty", "theta_i,phi_i,theta_v,phi_v");
  refused("30,0,45,180\n", "line 1", "header");
  refused("theta_i,phi_i,theta_o,phi_o\n", "line 1", "header");
  refused("phi_i,theta_i,theta_v,phi_v\n", "line 1", "header");
  refused("\n" + kHeader, "line 1", "header");
  refused(kHeader + "1,2,3\n", "line 2", "3 fields");
  refused(kHeader + "1,2,3,4,5\n", "line 2", "5 fields");
  refused(kHeader + "1,2,3,4\n\n1,2,3,4\n", "line 3", "empty");
  refused(kHeader + "1,2,3,4\n1,two,3,4\n", "line 3", "phi_i");
  refused(kHeader + "1,2,,4\n", "line 2", "theta_v");
  refused(kHeader + "1,2,3,4x\n", "line 2", "phi_v");
  refused(kHeader + "0x10,2,3,4\n", "line 2", "theta_i");
  refused(kHeader + "nan,2,3,4\n", "line 2", "theta_i");
  refused(kHeader + "1,inf,3,4\n", "line 2", "phi_i");
  refused(kHeader + "1,1e999,3,4\n", "line 2", "phi_i");
  refused(kHeader + "-0.001,2,3,4\n", "line 2", "0 to 180");
  refused(kHeader + "1,2,180.001,4\n", "line 2", "theta_v");
  refused(kHeader + "1,2,-91,4\n", "line 2", "theta_v");
  refused(kHeader + std::string(2 << 20, '1'), "line 2", "longer");
  const ProgramRun run = refused(kHeader + "1,2,3,4\n5,6,7,8\nx\n", "line 4", "");
  EXPECT_EQ(lines_of(run.out).size(), 3) << "rows before the bad one are answered";
}

TEST(Eval, TellsWhatWasNotMeasured) {
  const ScratchFolder folder;
  const std::string table = folder / "table.binary";
  std::vector<double> values(3 * 8, 1.0);
  for (const std::size_t cell : {0, 1, 8, 9, 16, 17}) values[cell] = -1;  // both at the mirror direction
  write_bytes(table, merl_bytes({2, 2, 2}, values));
  const RunOptions rows = {.input = kHeader + "0,0,0,0\n0,0,89,0\n0,0,95,0\n"};
  const ProgramRun run = run_sbrdf({"eval", table}, rows);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto lines = lines_of(run.out);
  EXPECT_EQ(lines[1], "0,0,0,0,nan,nan,nan");
  EXPECT_THAT(lines[2], testing::Not(HasSubstr("nan")));
  EXPECT_EQ(lines[3], "0,0,95,0,0,0,0");
  EXPECT_THAT(run.err, HasSubstr("1 of 3 pairs were not measured: nan"));

  const auto json = run_sbrdf({"eval", table, "--json"}, rows);
  EXPECT_TRUE(json.json()[0]["R"].is_null());
  EXPECT_TRUE(json.json()[1]["R"].is_number());
  EXPECT_THAT(json.err, HasSubstr("not measured: null"));

  const auto filled = run_sbrdf({"eval", table, "--filled"}, rows);
  EXPECT_THAT(filled.out, testing::Not(HasSubstr("nan")));
  EXPECT_THAT(filled.err, HasSubstr("1 of 3 pairs were not measured: their values are filled in"));
  EXPECT_EQ(run_sbrdf({"eval", kModel, "--cosine"}, rows).err, "");
}

TEST(ParseNumber, TakesTheWholeTextOrNothing) {
  EXPECT_EQ(parse_number("-1.5e3"), -1500);
  EXPECT_EQ(parse_number("+.5"), 0.5);
  for (const char* text : {"", " 1", "1 ", "1,", "0x1", "nan", "inf", "-inf", "1e999", "++1", "+-1", "1e", "one"}) {
    EXPECT_EQ(parse_number(text), std::nullopt) << text;
  }
}

TEST(ParseCount, TakesTheWholeTextOrNothing) {
  EXPECT_EQ(parse_count("010"), 10);
  EXPECT_EQ(parse_count("18446744073709551615"), 18446744073709551615U);
  for (const char* text : {"", "-1", "+1", "1.0", "1e3", "18446744073709551616", " 1"}) {
    EXPECT_EQ(parse_count(text), std::nullopt) << text;
  }
}

TEST(CsvField, IsQuotedWhereNeeded) {
  EXPECT_EQ(csv_field("R"), "R");
  EXPECT_EQ(csv_field("a,\"b\""), "\"a,\"\"b\"\"\"");
  EXPECT_THAT(split_fields(" a , \"b,c\",\t,d"), ElementsAre("a", "b,c", "", "d"));
}

}  // namespace
}  // namespace sbrdf::internal
