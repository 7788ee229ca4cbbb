#include "formats/os/trial.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <string_view>
#include <utility>

#include "formats/core/interrupted.h"
#include "formats/core/piece_hook.h"
#include "formats/os/descriptor.h"
#include "formats/os/files.h"
#include "formats/os/interrupt.h"

namespace sbrdf::internal {
namespace {

constexpr const char* kProgram = "/proc/self/exe";
constexpr std::string_view kWord = "--try-file";  // argv[1] of a trial
constexpr std::size_t kPiece = std::size_t{1} << 20U;
constexpr int kDone = 96;         // the exit code of a trial that came to its end
constexpr int kKept = 3;          // number of the descriptor that the process keeps open
constexpr int kNotStarted = 127;  // what a process that could not be loaded ends with

std::atomic<bool> allowed = false;

/// A copy of the bytes: the very same ones, as what is on the disk may change. A number below 0 where there is no room,
/// or files may not be so large.
Result<Descriptor> copy_of(const ByteSource& bytes) {
  Descriptor file(::memfd_create("trial", MFD_CLOEXEC));
  std::vector<std::byte> piece;
  for (std::uint64_t done = 0; file.number() >= 0 && done < bytes.size();) {
    piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, bytes.size() - done)));
    if (Status read = bytes.read(done, piece); !read) return read.error();
    errno = 0;
    const ssize_t put = ::pwrite(file.number(), piece.data(), piece.size(), static_cast<off_t>(done));
    if (put <= 0 && errno != EINTR) return Descriptor(-1);
    if (put > 0) done += static_cast<std::uint64_t>(put);
  }
  return file;
}

/// The bytes as a file. A large one is not copied, nor is one for which there is no room.
Result<Descriptor> file_of(const ByteSource& bytes) {
  const bool named = !bytes.path().empty();
  if (!named || bytes.size() <= kMapFrom) {
    Result<Descriptor> copy = copy_of(bytes);
    if (!copy || copy->number() >= 0 || !named) return copy;
  }
  return Descriptor(::open(bytes.path().c_str(), O_RDONLY | O_CLOEXEC));
}

/// Standard input is the file; what is printed goes nowhere. The process keeps one end of a pipe until it is over,
/// which the other end tells. 0 where none starts.
pid_t start(const Descriptor& file, const Descriptor& end, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"sbrdf", std::string(kWord)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&actions, file.number(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, end.number(), kKept);
  for (const int printed : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, printed, "/dev/null", O_WRONLY, 0);
  }
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  sigset_t deadly = none;
  sigaddset(&deadly, SIGXCPU);
  posix_spawnattr_setsigdefault(&attributes, &deadly);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  pid_t process = 0;
  if (::posix_spawn(&process, kProgram, &actions, &attributes, argv.data(), environ) != 0) process = 0;
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return process;
}

TrialEnd end_of(int status) {
  if (WIFSIGNALED(status)) return WTERMSIG(status) == SIGXCPU ? TrialEnd::kEndless : TrialEnd::kFell;
  if (WEXITSTATUS(status) == kDone) return TrialEnd::kSurvived;
  return WEXITSTATUS(status) == kNotStarted ? TrialEnd::kImpossible : TrialEnd::kFell;
}

/// From now on. Three calls of the system are little beside a piece.
void begin_time() {
  rusage used = {};
  rlimit limit = {};
  ::getrusage(RUSAGE_SELF, &used);
  ::getrlimit(RLIMIT_CPU, &limit);
  const auto until = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec + 1 + kTrialSeconds);
  limit.rlim_cur = std::min(until, limit.rlim_max);
  ::setrlimit(RLIMIT_CPU, &limit);
}

}  // namespace

void allow_trials() {
  // Who ignores it, as the parent of this process may have made it do, cannot wait for its own.
  std::signal(SIGCHLD, SIG_DFL);
  allowed = true;
}

Result<TrialEnd> try_apart(const ByteSource& bytes, const std::vector<std::string>& arguments) {
  if (!allowed) return TrialEnd::kImpossible;
  const Result<Descriptor> file = file_of(bytes);
  if (!file) return file.error();
  std::array<int, 2> ends = {-1, -1};
  if (file->number() < 0 || ::pipe2(ends.data(), O_CLOEXEC) != 0) return TrialEnd::kImpossible;
  const Descriptor reading(ends[0]);
  pid_t process = 0;
  {
    const Descriptor writing(ends[1]);
    process = start(*file, writing, arguments);
  }
  if (process == 0) return TrialEnd::kImpossible;
  // The end of the process is that of the pipe, which can be waited for along with a signal.
  const bool ended = wait_for_input(reading.number());
  if (!ended) ::kill(process, SIGKILL);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) return TrialEnd::kImpossible;
  }
  if (!ended || interrupted()) return interrupted_error();
  return end_of(status);
}

bool is_trial(int argc, char** argv) {
  if (argc < kTrialArguments || argv[1] != kWord) return false;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // who waits for it may be killed
  const rlimit none = {0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  begin_time();
  piece_hook = begin_time;
  return true;
}

void end_trial(bool tried) { ::_exit(tried ? kDone : kNotStarted); }

}  // namespace sbrdf::internal
