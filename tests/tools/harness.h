#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace sbrdf::internal {

/// A folder of its own for a test, removed with all that is in it.
class ScratchFolder {
 public:
  ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::string operator/(std::string_view name) const { return (path_ / name).string(); }
  /// Names of what is in it, hidden files too, sorted.
  [[nodiscard]] std::vector<std::string> entries() const;

 private:
  std::filesystem::path path_;
};

std::vector<std::byte> bytes_of(std::string_view text);
std::string read_text(const std::filesystem::path& path);
void write_bytes(const std::filesystem::path& path, std::span<const std::byte> bytes);

struct SentSignal {
  int number = 0;
  std::chrono::microseconds after = {};  ///< from the start of the process
};

struct RunOptions {
  std::string input = {};                            ///< standard input
  std::optional<std::uint64_t> largest_file = {};    ///< RLIMIT_FSIZE [bytes]
  bool without_privileges = false;                   ///< where the test is root, the program runs as nobody
  bool output_to_full_device = false;                ///< standard output is a device that takes nothing
  std::optional<std::uint64_t> most_processes = {};  ///< RLIMIT_NPROC, threads included
  std::vector<int> closed = {};                      ///< of the descriptors 0, 1 and 2
  std::optional<SentSignal> signal = {};
};

struct ProgramRun {
  int exit_code = 0;  ///< 128 + signal where a signal ended it
  std::string out;
  std::string err;
  bool ended_before_signal = false;
  std::uint64_t peak_memory = 0;  ///< resident at most [bytes]

  [[nodiscard]] nlohmann::ordered_json json() const { return nlohmann::ordered_json::parse(out); }
};

/// The program sbrdf with these arguments, to its end.
ProgramRun run_sbrdf(const std::vector<std::string>& arguments, const RunOptions& options = {});

/// The same for any command, looked up in PATH.
ProgramRun run_command(const std::vector<std::string>& command, const RunOptions& options = {});

/// Opens a named pipe for writing as soon as a program reads from it; the caller closes it.
int open_once_read(const std::string& pipe);

/// Where the output and the errors of a RunningSbrdf go.
enum class Output : std::uint8_t { kPipe, kTerminal };

/// The program beside the test, which writes its input and reads its output and its errors, both in one stream.
class RunningSbrdf {
 public:
  explicit RunningSbrdf(const std::vector<std::string>& arguments, Output output = Output::kPipe);
  RunningSbrdf(const RunningSbrdf&) = delete;
  RunningSbrdf& operator=(const RunningSbrdf&) = delete;
  ~RunningSbrdf();

  void write(std::string_view text) const;
  /// Up to the next `last`, without it; what there is at the end of the output, or when nothing came for a minute.
  [[nodiscard]] std::string read_up_to(char last) const;
  [[nodiscard]] std::string read_line() const { return read_up_to('\n'); }
  void signal(int number) const;
  /// Closes its input and waits; 128 + signal where a signal ended it.
  int wait();

 private:
  int pid_ = -1;
  int input_ = -1;
  int output_ = -1;
};

/// A MERL file: three counts, then values, whatever they are.
std::vector<std::byte> merl_bytes(std::array<std::int32_t, 3> shape, std::span<const double> values);
/// 2 x 2 x 2 cells whose values rise from 1.
std::vector<std::byte> small_merl();
/// An isotropic sliced file of few samples.
std::vector<std::byte> small_sliced();
/// A `convert` that has nothing to choose and fits nothing, which takes most of the time: for files whose values are no
/// concern of a test.
std::vector<std::string> plainly(std::vector<std::string> convert);

/// The program failed with this code and told it in one line that begins with "sbrdf: SUBJECT: " and has `fragment` in
/// it.
void expect_failure(const ProgramRun& run, int exit_code, const std::string& subject, const std::string& fragment);

}  // namespace sbrdf::internal
