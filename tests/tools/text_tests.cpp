#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "codec/file/encoder.h"
#include "tests/tools/harness.h"
#include "tools/console/plain_text.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

// Some of every kind that a terminal acts upon, each in UTF-8.
const std::vector<std::string> kControls = {"\x01",         "\t",
                                            "\n",           "\r",
                                            "\x1B",         "\x7F",
                                            "\xC2\x80",     "\xC2\x85",
                                            "\xC2\x9B",     "\xC2\x9F",
                                            "\xD8\x9C",     "\xE2\x80\x8E",
                                            "\xE2\x80\x8F", "\xE2\x80\xA8",
                                            "\xE2\x80\xA9", "\xE2\x80\xAA",
                                            "\xE2\x80\xAE", "\xE2\x81\xA6",
                                            "\xE2\x81\xA9", "\xEF\xBB\xBF",
                                            "\xEF\xBF\xB9", "\xF3\xA0\x80\xA0"};
// Stray and cut, longer than needed, half of a pair, beyond the last.
const std::vector<std::string> kBroken = {"\x80",         "\xBF",         "\xC3",         "\xE2\x82",
                                          "\xC0\xAF",     "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80",
                                          "\xF8\x88\x80", "\xFF",         "\xFE"};

std::string hostile_text() {
  std::string text = "\x1B[31mred";
  for (const std::string& control : kControls) text += control + "x";
  for (const std::string& bytes : kBroken) text += bytes + "y";
  return text + std::string(9999, 'z') + "end of it";
}

bool is_utf8(const std::string& text) {
  try {
    return !nlohmann::json(text).dump().empty();
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

/// What people see; line feeds only at the ends of lines.
void expect_harmless(const std::string& text) {
  EXPECT_TRUE(is_utf8(text)) << testing::PrintToString(text);
  for (const std::string& control : kControls) {
    EXPECT_TRUE(control == "\n" || text.find(control) == std::string::npos) << testing::PrintToString(control);
  }
  EXPECT_THAT(text, testing::Not(HasSubstr("end of it")));
}

TEST(OneLine, KeepsTextOfAnyLanguage) {
  for (const std::string text :
       {"", "plain text, 1 < 2",
        "Gr\xC3\xB6\xC3\x9F"
        "e",
        "\xE8\xB5\xA4\xE3\x81\x84", "\xD7\x90\xD7\x93\xD7\x95\xD7\x9D", "\xF0\x9F\xA7\xB5 thread", "-- \\ \" ?"}) {
    EXPECT_EQ(one_line(text), text);
    EXPECT_EQ(escape_controls(text), text);
  }
}

TEST(OneLine, ReplacesWhatControlsATerminal) {
  for (const std::string& control : kControls) EXPECT_EQ(one_line("a" + control + "b"), "a?b");
  for (const std::string& bytes : kBroken) {
    EXPECT_EQ(one_line("a" + bytes + "b"), "a" + std::string(bytes.size(), '?') + "b");
    EXPECT_EQ(one_line("a" + bytes), "a" + std::string(bytes.size(), '?'));
  }
  EXPECT_EQ(one_line(std::string("a\0b", 3)), "a?b");
}

TEST(OneLine, CutsBetweenCharacters) {
  const std::string thread = "\xF0\x9F\xA7\xB5";
  std::string text;
  for (int k = 0; k < 10; ++k) text += thread;
  EXPECT_EQ(one_line(text, 10), text);
  EXPECT_EQ(one_line(text + "x", 10), text.substr(0, 7 * thread.size()) + "...");
  EXPECT_EQ(character_count(text), 10);
  EXPECT_EQ(character_count(one_line(hostile_text())), kMostCharacters);
}

TEST(EscapeControls, KeepsTheMeaningOfJson) {
  for (const std::string& control : kControls) {
    const nlohmann::json json = {{"key " + control, "value " + control}};
    const std::string text = escape_controls(json.dump());
    EXPECT_EQ(nlohmann::json::parse(text), json);
    EXPECT_EQ(text.find(control), std::string::npos) << text;
  }
}

/// Every place of a file that holds text holds the worst.
class HostileText : public testing::Test {
 protected:
  HostileText() {
    DecodedSliced decoded = decode_sliced(small_sliced()).value();
    decoded.sliced.channels = {"R" + text_, "\x1B]0;title\x07", ""};
    nlohmann::json metadata = {{"command", "plain"}};
    for (const std::string& control : kControls) metadata["key " + control + std::string(999, 'k')] = control + "value";
    metadata["long"] = std::string(9999, 'z') + "end of it";
    decoded.sliced.metadata = metadata.dump();
    write_bytes(file_, encode_sliced(decoded.sliced, decoded.lattice));
  }
  static ProgramRun run(const std::vector<std::string>& command) {
    SCOPED_TRACE(testing::PrintToString(command));
    ProgramRun run = run_sbrdf(command, {.input = "theta_i,phi_i,theta_v,phi_v\n1,2,3,4\n"});
    expect_harmless(run.err);
    const bool is_json = std::find(command.begin(), command.end(), "--json") != command.end();
    if (!is_json) {
      expect_harmless(run.out);
    } else if (run.exit_code == 0) {
      EXPECT_FALSE(run.json().empty());  // throws for bytes that are not UTF-8
      for (const std::string& control : kControls) {
        EXPECT_TRUE(control == "\n" || run.out.find(control) == std::string::npos) << testing::PrintToString(control);
      }
    }
    return run;
  }

  const std::string text_ = hostile_text();
  const ScratchFolder folder_;
  const std::string file_ = folder_ / "a.sbrdf";
};

TEST_F(HostileText, InFilesReachesNoTerminal) {
  const std::vector<std::vector<std::string>> commands = {
      {"info", file_},
      {"info", file_, "--levels"},
      {"eval", file_},
      {"compare", file_, file_, "--random", "9"},
      {"convert", file_, folder_ / "b.sbrdf"},
      {"extract", file_, folder_ / "c.sbrdf"},
      {"verify", file_},
      {"codings", file_},
  };
  for (std::vector<std::string> command : commands) {
    const ProgramRun table = run(command);
    EXPECT_EQ(table.exit_code, 0) << table.err;
    command.emplace_back("--json");
    EXPECT_EQ(run(command).exit_code, 0);
  }
}

TEST_F(HostileText, OfEvalIsAHeaderOfOneLineThatEvalTakes) {
  const ProgramRun once = run({"eval", file_});
  EXPECT_EQ(std::count(once.out.begin(), once.out.end(), '\n'), 2);
  EXPECT_EQ(run_sbrdf({"eval", file_}, {.input = once.out}).out, once.out);
}

// What a file system takes as a name: anything but '/' and the byte 0.
TEST_F(HostileText, InNamesOfFilesReachesNoTerminal) {
  std::string name = "n\n\x1B[31m";
  for (const std::string& control : kControls) name += control;
  const std::string named = folder_ / (name + "\xFF.sbrdf");
  write_bytes(named, small_sliced());
  const std::string bundle = folder_ / (name + ".sbrdfz");
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"info", named + "x"},
           {"verify", named, named + "x"},
           {"compare", named, named, "--random", "9"},
           {"convert", named, named + ".sbrdf"},
           {"convert", named, folder_ / (name + "/x.sbrdf")},
           {"convert", named, named + "." + name},
           {"extract", named, named + ".b.sbrdf"},
           {"codings", named, "--csv", folder_ / (name + ".csv")},
           {"pack", folder_.path(), bundle},
           {"pack", "--list", bundle},
           {"info", bundle + ":" + name},
           {name},
           {"info", file_, "--" + name},
           {"info", file_, name},
           {"compare", file_, file_, "--step", name},
           {"convert", file_, folder_ / "b.sbrdf", "--placement", name},
           {"info", "kurt:" + name},
       }) {
    run(command);
  }
}

TEST_F(HostileText, InAModelOrATextReachesNoTerminal) {
  write_bytes(folder_ / "model.json", bytes_of(R"({"name": "n\u001b[31m\u009b\u202e", "k_d": [0.1, 0.1, 0.1],
      "lobes": [{"k_s": [1, 1, 1], "f_0": 1, "m_x": 0.5, "m_y": 0.5, "alpha": 0}]})"));
  EXPECT_EQ(run({"info", "kurt:" + (folder_ / "model.json")}).exit_code, 3);
  write_bytes(folder_ / "broken.json", bytes_of("{\"" + text_));
  EXPECT_EQ(run({"info", "kurt:" + (folder_ / "broken.json")}).exit_code, 3);
  write_bytes(folder_ / "text.binary", bytes_of(text_));
  EXPECT_EQ(run({"info", folder_ / "text.binary"}).exit_code, 3);
  for (const std::string& line :
       {text_, "theta_i,phi_i,theta_v,phi_v\n" + text_, "theta_i,phi_i,theta_v,phi_v," + text_ + "," + text_}) {
    const ProgramRun run = run_sbrdf({"eval", "kurt:wood01"}, {.input = line});
    EXPECT_EQ(run.exit_code, 3);
    expect_harmless(run.err);
  }
}

}  // namespace
}  // namespace sbrdf::internal
