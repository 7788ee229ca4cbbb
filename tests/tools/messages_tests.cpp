#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

/// A command and an option of it whose value is to be a number or a count.
struct NumericOption {
  std::vector<std::string> command;
  bool whole = false;
};

std::vector<NumericOption> numeric_options(const ScratchFolder& folder) {
  const std::string out = folder / "a.sbrdf";
  return {{{"compare", "kurt:wood01", "kurt:wood01", "--step"}},
          {{"compare", "kurt:wood01", "kurt:wood01", "--floor"}},
          {{"compare", "kurt:wood01", "kurt:wood01", "--random"}, true},
          {{"convert", "kurt:wood01", out, "--samples"}, true},
          {{"convert", "kurt:wood01", out, "--target-mre"}},
          {{"extract", "kurt:wood01", out, "--theta-max"}},
          {{"extract", "kurt:wood01", out, "--level"}, true},
          {{"codings", "kurt:wood01", "--samples"}, true},
          {{"stress", "--seed"}, true}};
}

TEST(Numbers, ThatAreAbsurdAreCalledWhatTheyAre) {
  const ScratchFolder folder;
  for (const NumericOption& option : numeric_options(folder)) {
    const auto refused = [&](const std::string& text, const std::string& fragment) {
      std::vector<std::string> command = option.command;
      command.back() += "=" + text;  // not a word of its own, which "-1" would not be
      SCOPED_TRACE(testing::PrintToString(command));
      const ProgramRun run = run_sbrdf(command);
      expect_failure(run, 1, option.command.back(), fragment);
      EXPECT_THAT(run.err, HasSubstr(" --help'"));
    };
    const std::string no_number =
        option.whole ? "is not a whole number of 0 or more in decimal digits" : "is not a decimal number";
    for (const std::string text : {" ", " 5", "5 ", "0x10", "nan", "inf", "1e", "five", "--5", "5,5", "1e5x"}) {
      refused(text, "'" + text + "' " + no_number);
    }
    if (option.whole) {
      refused("99999999999999999999", "99999999999999999999 is out of range; it must be ");
      for (const std::string text : {"-0", "-1", "+1", "1.5", "1e3"}) refused(text, "'" + text + "' " + no_number);
    } else {
      for (const std::string text : {"1e400", "-1e400", "1e-400"}) {
        refused(text, text + " is too large for a number, or too close to 0");
      }
      refused("-1", "-1 is out of range; it must be ");
    }
  }
}

TEST(Numbers, ThatAreMinusZeroAreZero) {
  EXPECT_EQ(run_sbrdf({"compare", "kurt:wood01", "kurt:wood01", "--random", "9", "--floor", "-0", "--json"})
                .json()["floor"]
                .dump(),
            "0.0");
}

TEST(Links, ThatLeadNowhereAreCalledWhatTheyAre) {
  const ScratchFolder folder;
  const std::string link = folder / "link.sbrdf";
  std::filesystem::create_symlink("nowhere.sbrdf", link);
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"info", link},
                                             {"info", link, "--levels"},
                                             {"eval", link},
                                             {"verify", link},
                                             {"codings", link},
                                             {"compare", link, "kurt:wood01"},
                                             {"compare", "kurt:wood01", link},
                                             {"convert", link, folder / "out.sbrdf"},
                                             {"extract", link, folder / "out.sbrdf"},
                                             {"pack", "--list", link}}) {
    SCOPED_TRACE(testing::PrintToString(command));
    expect_failure(run_sbrdf(command), 2, link, "is a link to nowhere.sbrdf, which is not there");
  }
  expect_failure(run_sbrdf({"pack", folder.path(), folder / "out.sbrdfz"}), 2, link, "is a link to nowhere.sbrdf");
  // Writing through it makes the file that it leads to.
  write_bytes(folder / "a.sbrdf", small_sliced());
  EXPECT_EQ(run_sbrdf({"convert", folder / "a.sbrdf", link}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(read_text(folder / "nowhere.sbrdf"), read_text(folder / "a.sbrdf"));
}

TEST(Paths, ThatAreTooLongOrStrangeAreCalledWhatTheyAre) {
  const ScratchFolder folder;
  write_bytes(folder / "a.sbrdf", small_sliced());
  const std::string name = folder / (std::string(300, 'n') + ".sbrdf");
  std::string deep = folder / "d";
  while (deep.size() < 5000) deep += "/deep";
  for (const std::string& path : {name, deep + "/a.sbrdf"}) {
    for (const std::vector<std::string>& command :
         std::vector<std::vector<std::string>>{{"info", path},
                                               {"verify", path},
                                               {"extract", folder / "a.sbrdf", path},
                                               {"convert", folder / "a.sbrdf", path}}) {
      const ProgramRun run = run_sbrdf(command);
      EXPECT_EQ(run.exit_code, 2);
      EXPECT_THAT(run.err, testing::AllOf(HasSubstr("File name too long"), testing::EndsWith("\n")));
    }
  }
  const std::string strange = folder / "two\nlines 'quoted' \"twice\"\t$HOME *.sbrdf";
  EXPECT_EQ(run_sbrdf({"convert", folder / "a.sbrdf", strange}).exit_code, 0);
  EXPECT_EQ(run_sbrdf({"verify", strange}).exit_code, 0);
  EXPECT_EQ(run_sbrdf({"verify", "--json", strange}).json()[0]["file"], strange);
}

TEST(Threads, ThatCannotBeMadeAreDoneWithout) {
  const ScratchFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  const RunOptions limited = {.without_privileges = true, .most_processes = 1};
  setenv("LSAN_OPTIONS", "detect_leaks=0", 1);  // the search for leaks needs a thread of its own
  setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
  const ProgramRun run = run_sbrdf({"compare", "kurt:wood01", "kurt:fabric112", "--random", "9000", "--json"}, limited);
  if (run.exit_code == 97) GTEST_SKIP() << "the folder of the program is closed to the user nobody";
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ProgramRun free = run_sbrdf({"compare", "kurt:wood01", "kurt:fabric112", "--random", "9000", "--json"});
  EXPECT_EQ(run.json()["mre_percent"], free.json()["mre_percent"]);
  EXPECT_EQ(
      run_sbrdf(plainly({"convert", "kurt:wood01", folder / "a.sbrdf", "--placement", "40/90", "--samples", "300"}),
                limited)
          .err,
      "");
  unsetenv("LSAN_OPTIONS");
  unsetenv("ASAN_OPTIONS");
}

}  // namespace
}  // namespace sbrdf::internal
