#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "tests/support/test_data.h"
#include "tests/tools/harness.h"

namespace sbrdf::internal {
namespace {

using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kHeader = "theta_i,phi_i,theta_v,phi_v\n";

std::string many_rows(int count) {
  std::string rows = kHeader;
  for (int k = 0; k < count; ++k) rows += "30,0,45," + std::to_string(k) + "\n";
  return rows;
}

/// A folder in which every command finds something to do.
class Workplace {
 public:
  explicit Workplace(int materials = 2) {
    std::filesystem::create_directory(folder_ / "materials");
    for (int k = 0; k < materials; ++k) write_bytes(material(k), small_sliced());
    write_bytes(folder_ / "in.sbrdf", small_sliced());
    EXPECT_EQ(run_sbrdf({"pack", folder_ / "materials", folder_ / "in.sbrdfz"}).exit_code, 0);
    std::filesystem::create_directory(out_);
  }
  [[nodiscard]] std::string material(int k) const { return folder_ / ("materials/m" + std::to_string(k) + ".sbrdf"); }
  [[nodiscard]] std::string in(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::string out(const std::string& name) const { return (out_ / name).string(); }
  [[nodiscard]] std::vector<std::string> outputs() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(out_)) names.push_back(entry.path().filename());
    return names;
  }
  void clear() const {
    for (const std::string& name : outputs()) std::filesystem::remove(out_ / name);
  }

 private:
  ScratchFolder folder_;
  std::filesystem::path out_ = folder_.path() / "out";
};

/// All commands, each quickly done.
std::vector<std::vector<std::string>> all_commands(const Workplace& place) {
  return {
      {"--help"},
      {"--version"},
      {"formats"},
      {"formats", "--json"},
      {"info", place.in("in.sbrdf")},
      {"eval", "kurt:wood01"},
      {"eval", "kurt:wood01", "--json"},
      {"compare", "kurt:wood01", "kurt:wood01", "--random", "9"},
      {"convert", place.in("in.sbrdf"), place.out("a.sbrdf")},
      {"extract", place.in("in.sbrdf"), place.out("b.sbrdf"), "--level", "2"},
      {"verify", place.in("in.sbrdf"), place.in("in.sbrdfz")},
      {"codings", place.in("in.sbrdf"), "--csv", place.out("c.csv")},
      {"pack", place.in("materials"), place.out("d.sbrdfz")},
      {"pack", "--list", place.in("in.sbrdfz")},
      {"reproduce", "--help"},
      {"stress", "--help"},
  };
}

TEST(ClosedDescriptors, MakeNoCommandHangOrLoseOutputInSilence) {
  const Workplace place;
  for (const std::vector<std::string>& command : all_commands(place)) {
    for (unsigned closed = 1; closed < 8; ++closed) {
      SCOPED_TRACE(testing::PrintToString(command) + " with closed descriptors " + std::to_string(closed));
      RunOptions options = {.input = kHeader + "30,0,45,180\n"};
      for (const int number : {0, 1, 2}) {
        if ((closed >> static_cast<unsigned>(number) & 1U) != 0) options.closed.push_back(number);
      }
      const ProgramRun run = run_sbrdf(command, options);
      const bool no_input = (closed & 1U) != 0 && command[0] == "eval";
      const bool no_output = (closed & 2U) != 0;
      EXPECT_EQ(run.exit_code, no_input || no_output ? 2 : 0) << run.err;
      if (no_output || no_input) {
        EXPECT_THAT(run.err, HasSubstr((closed & 4U) == 0 ? "Bad file descriptor" : ""));
      } else {
        EXPECT_NE(run.out, "");
        EXPECT_EQ(run.err, "");
      }
      // Nothing was written into a file instead of to a descriptor of the same number.
      for (const std::string& name : place.outputs())
        EXPECT_THAT(read_text(place.out(name)), testing::Not(HasSubstr("took")));
    }
  }
}

struct LongWork {
  std::string name;
  std::vector<std::string> command;
  std::string input = {};
};

void PrintTo(const LongWork& work, std::ostream* out) { *out << work.name; }

class Signals : public testing::TestWithParam<LongWork> {
 protected:
  [[nodiscard]] ProgramRun run(std::optional<SentSignal> signal = {}) const {
    std::vector<std::string> command = GetParam().command;
    for (std::string& word : command) {
      if (word.starts_with("OUT")) word = place_.out("a" + word.substr(3));
      if (word == "DIR") word = place_.in("materials");
    }
    return run_sbrdf(command, {.input = GetParam().input, .signal = signal});
  }
  [[nodiscard]] std::string output() const {
    const std::vector<std::string> names = place_.outputs();
    return names.empty() ? "" : read_text(place_.out(names[0]));
  }

  const Workplace place_ = Workplace(30);
};

// At moments drawn anew each time, from the first to the last. How long the work takes depends on what else the machine
// does, so the last moment is that of the latest run that came to its end.
TEST_P(Signals, EndTheProgramAtEveryMomentWithTheirCodeAndNothingHalfDone) {
  using Clock = std::chrono::steady_clock;
  constexpr std::array<int, 4> kSignals = {SIGINT, SIGTERM, SIGHUP, SIGKILL};
  constexpr std::size_t kStops = 8;
  constexpr int kMostRuns = 200;
  auto start = Clock::now();
  ASSERT_EQ(run().exit_code, 0);
  std::chrono::duration<double> whole = Clock::now() - start;
  const std::string complete = output();
  const unsigned seed = std::random_device()();
  std::mt19937 random(seed);
  std::size_t stopped = 0;
  for (int k = 0; k < kMostRuns && stopped < kStops; ++k) {
    const int signal = kSignals[stopped % kSignals.size()];
    const double after = std::uniform_real_distribution<double>(0, whole.count())(random);
    SCOPED_TRACE(testing::Message() << "signal " << signal << " after " << after << " s, seed " << seed);
    place_.clear();
    start = Clock::now();
    const ProgramRun done = run(SentSignal{signal, std::chrono::microseconds(static_cast<long>(1e6 * after))});
    EXPECT_THAT(done.err, AnyOf("", "sbrdf: interrupted\n"));
    if (!place_.outputs().empty()) {
      EXPECT_THAT(place_.outputs(), ElementsAre(testing::StartsWith("a.")));
      EXPECT_TRUE(output() == complete);
    }
    if (done.exit_code != 0) {
      EXPECT_EQ(done.exit_code, 128 + signal);
      ++stopped;
    } else {
      EXPECT_EQ(output().size(), complete.size());
      whole = std::min<std::chrono::duration<double>>(whole, Clock::now() - start);
    }
  }
  EXPECT_EQ(stopped, kStops);
}

INSTANTIATE_TEST_SUITE_P(
    Tools, Signals,
    testing::Values(LongWork{"ConvertToSlices",
                             {"convert", "kurt:Brushed alum", "OUT.sbrdf", "--placement", "28/60", "--samples", "500"}},
                    LongWork{"ConvertToMerl", {"convert", "kurt:wood01", "OUT.binary"}},
                    LongWork{"Compare", {"compare", "kurt:wood01", "kurt:wood01", "--random", "500000"}},
                    LongWork{"Eval", {"eval", "kurt:wood01"}, many_rows(200'000)},
                    LongWork{"Pack", {"pack", "DIR", "OUT.sbrdfz"}}),
    [](const auto& tested) { return tested.param.name; });

TEST(Signal, ASecondOneDoesNotWait) {
  const ScratchFolder folder;
  RunningSbrdf program({"convert", "kurt:Brushed alum", folder / "a.sbrdf", "--placement", "6/12"});
  program.signal(SIGTERM);
  program.signal(SIGINT);
  EXPECT_THAT(program.wait(), AnyOf(128 + SIGTERM, 128 + SIGINT));
  EXPECT_THAT(folder.entries(), IsEmpty());
}

/// The exit code of `eval` as a last line of its errors, and a reader that does as it likes; "$1" is a file that holds
/// the number of the process.
ProgramRun eval_into(const std::string& setting, const std::string& reader) {
  const ScratchFolder folder;
  const std::string writer = R"({ sh -c 'echo $$ > "$1"; exec "$0" eval kurt:wood01' "$0" "$1"; echo $? >&2; })";
  return run_command({"sh", "-c", setting + writer + " | " + reader, SBRDF_PROGRAM, folder / "pid"},
                     {.input = many_rows(100'000)});
}

TEST(Signal, ReachesAProgramWhoseReaderRests) {
  // It has begun when its first line comes. The reader goes away only once the program has, or after five seconds.
  const char* const reader = R"({ read line; kill -INT $(cat "$1"); k=0
      while kill -0 $(cat "$1") 2> /dev/null && test $k -lt 100; do sleep 0.05; k=$((k + 1)); done; })";
  EXPECT_EQ(eval_into("", reader).err, "sbrdf: interrupted\n130\n");
}

TEST(Signal, EndsAProgramWhoseReaderHasGone) {
  const ProgramRun run = eval_into("", "head -1");
  EXPECT_EQ(run.out, kHeader.substr(0, kHeader.size() - 1) + ",R,G,B\n");
  EXPECT_EQ(run.err, std::to_string(128 + SIGPIPE) + "\n");
  EXPECT_EQ(eval_into("trap '' PIPE; ", "head -1").err, "sbrdf: standard output: Broken pipe\n2\n");
}

}  // namespace
}  // namespace sbrdf::internal
