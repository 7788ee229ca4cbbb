#include "tests/tools/harness.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <grp.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tests/support/test_data.h"

namespace sbrdf::internal {
namespace {

constexpr int kNobody = 65534;
constexpr int kPatience = 300'000;  // milliseconds for one line, or for a program to end, on a slow machine
constexpr int kNap = 2;             // milliseconds

struct Streams {
  int in, out, err;
};

int open_or_throw(const std::string& path, int flags) {
  const int number = ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  if (number < 0) throw std::runtime_error("cannot open " + path);
  return number;
}

// The sanitizers end a program with 1, which is the code of a usage error here.
void make_sanitizers_stand_out() {
  for (const char* name : {"ASAN_OPTIONS", "UBSAN_OPTIONS", "LSAN_OPTIONS"}) {
    const char* before = std::getenv(name);
    setenv(name, ((before != nullptr ? std::string(before) + ":" : "") + "exitcode=99").c_str(), 1);
  }
}

[[noreturn]] void become(const std::vector<std::string>& command, const RunOptions& options, const Streams& streams) {
  dup2(streams.in, STDIN_FILENO);
  dup2(streams.out, STDOUT_FILENO);
  dup2(streams.err, STDERR_FILENO);
  for (const int number : options.closed) ::close(number);
  make_sanitizers_stand_out();
  // A shell may have started the tests with these ignored.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
  if (options.largest_file) {
    const rlimit limit = {*options.largest_file, *options.largest_file};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  if (options.most_processes) {
    const rlimit limit = {*options.most_processes, *options.most_processes};
    setrlimit(RLIMIT_NPROC, &limit);
  }
  if (options.without_privileges && geteuid() == 0 &&
      (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0)) {
    _exit(98);
  }
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  _exit(97);
}

pid_t start(const std::vector<std::string>& command, const RunOptions& options, const Streams& streams) {
  const pid_t pid = fork();
  if (pid == 0) become(command, options, streams);
  if (pid < 0) throw std::runtime_error("cannot fork");
  return pid;
}

struct Ends {
  int reading, writing;
};

Ends make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipes");
  return {ends[0], ends[1]};
}

Ends make_terminal() {
  const int reading = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  std::array<char, 64> name{};
  if (reading < 0 || grantpt(reading) != 0 || unlockpt(reading) != 0 ||
      ptsname_r(reading, name.data(), name.size()) != 0) {
    throw std::runtime_error("no terminals");
  }
  return {reading, open_or_throw(name.data(), O_RDWR | O_NOCTTY)};
}

int wait_for(pid_t pid, rusage* usage = nullptr) {
  int status = 0;
  for (int waited = 0; wait4(pid, &status, WNOHANG, usage) == 0; waited += kNap) {
    if (waited > kPatience) ::kill(pid, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(kNap));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// False where the process had ended before.
bool send(pid_t pid, const SentSignal& signal) {
  std::this_thread::sleep_for(signal.after);
  siginfo_t end = {};
  // Looks without taking the end away from wait_for.
  if (waitid(P_PID, static_cast<id_t>(pid), &end, WEXITED | WNOHANG | WNOWAIT) == 0 && end.si_pid == pid) return false;
  return ::kill(pid, signal.number) == 0;
}

}  // namespace

ScratchFolder::ScratchFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "sbrdf-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  path_ = name;
  // Another user runs the program in some tests.
  std::filesystem::permissions(path_, std::filesystem::perms::others_exec | std::filesystem::perms::others_read,
                               std::filesystem::perm_options::add);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::vector<std::string> ScratchFolder::entries() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path_))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

std::string read_text(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_bytes(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void write_bytes(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

ProgramRun run_command(const std::vector<std::string>& command, const RunOptions& options) {
  const ScratchFolder folder;
  write_bytes(folder / "in", bytes_of(options.input));
  const Streams streams = {
      open_or_throw(folder / "in", O_RDONLY),
      options.output_to_full_device ? open_or_throw("/dev/full", O_WRONLY)
                                    : open_or_throw(folder / "out", O_RDWR | O_CREAT),
      open_or_throw(folder / "err", O_RDWR | O_CREAT),
  };
  ProgramRun run;
  const pid_t pid = start(command, options, streams);
  if (options.signal) run.ended_before_signal = !send(pid, *options.signal);
  rusage usage{};
  run.exit_code = wait_for(pid, &usage);
  run.peak_memory = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  for (const int number : {streams.in, streams.out, streams.err}) ::close(number);
  if (!options.output_to_full_device) run.out = read_text(folder / "out");
  run.err = read_text(folder / "err");
  return run;
}

ProgramRun run_sbrdf(const std::vector<std::string>& arguments, const RunOptions& options) {
  std::vector<std::string> command = {SBRDF_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_command(command, options);
}

int open_once_read(const std::string& pipe) {
  for (int waited = 0; waited < kPatience; waited += kNap) {
    // Refused while nobody reads.
    const int writer = ::open(pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (writer >= 0) return writer;
    std::this_thread::sleep_for(std::chrono::milliseconds(kNap));
  }
  throw std::runtime_error("nobody reads " + pipe);
}

RunningSbrdf::RunningSbrdf(const std::vector<std::string>& arguments, Output output) {
  const Ends to = make_pipe();
  const Ends from = output == Output::kPipe ? make_pipe() : make_terminal();
  std::vector<std::string> command = {SBRDF_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  pid_ = start(command, {}, {to.reading, from.writing, from.writing});
  ::close(to.reading);
  ::close(from.writing);
  input_ = to.writing;
  output_ = from.reading;
}

RunningSbrdf::~RunningSbrdf() {
  if (pid_ >= 0) {
    ::kill(pid_, SIGKILL);
    wait();
  }
  ::close(output_);
}

void RunningSbrdf::write(std::string_view text) const {
  if (::write(input_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    throw std::runtime_error("cannot write to the program");
  }
}

std::string RunningSbrdf::read_up_to(char last) const {
  std::string line;
  char c = 0;
  while (true) {
    pollfd waiting = {output_, POLLIN, 0};
    if (poll(&waiting, 1, kPatience) <= 0 || ::read(output_, &c, 1) != 1) return line;
    if (c == last) return line;
    line += c;
  }
}

void RunningSbrdf::signal(int number) const { ::kill(pid_, number); }

int RunningSbrdf::wait() {
  if (input_ >= 0) ::close(std::exchange(input_, -1));
  return wait_for(std::exchange(pid_, -1));
}

std::vector<std::byte> merl_bytes(std::array<std::int32_t, 3> shape, std::span<const double> values) {
  std::vector<std::byte> bytes(sizeof(shape) + values.size_bytes());
  std::memcpy(bytes.data(), shape.data(), sizeof(shape));
  std::memcpy(bytes.data() + sizeof(shape), values.data(), values.size_bytes());
  return bytes;
}

std::vector<std::byte> small_merl() {
  std::vector<double> values(24);
  std::iota(values.begin(), values.end(), 1.0);
  return merl_bytes({2, 2, 2}, values);
}

std::vector<std::byte> small_sliced() {
  return read_bytes(SBRDF_SOURCE_DIR "/tests/vectors/sbrdf/accept/elevation-isotropic-odd-steps.sbrdf");
}

std::vector<std::string> plainly(std::vector<std::string> convert) {
  convert.insert(convert.end(), {"--values", "measured", "--precision", "lossless"});
  return convert;
}

void expect_failure(const ProgramRun& run, int exit_code, const std::string& subject, const std::string& fragment) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  EXPECT_THAT(run.err, testing::StartsWith("sbrdf: " + subject + ": "));
  EXPECT_THAT(run.err, testing::HasSubstr(fragment));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_THAT(run.err, testing::EndsWith("\n"));
}

}  // namespace sbrdf::internal
