#include "formats/os/interrupt.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>

namespace sbrdf::internal {
namespace {

constexpr std::array<int, 3> kCaught = {SIGINT, SIGTERM, SIGHUP};

std::atomic<int> first_signal = 0;
std::atomic<const char*> doomed_path = nullptr;
// Holds a byte once a signal came: what waits for input waits for this as well, so that no signal falls between a look
// at the flag and the wait.
std::array<int, 2> wake_pipe = {-1, -1};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<const char*>::is_always_lock_free,
              "a signal handler may use lock-free atomics only");

extern "C" void handle_signal(int signal) {
  int none = 0;
  if (first_signal.compare_exchange_strong(none, signal)) {
    const int saved = errno;
    [[maybe_unused]] const ssize_t written = write(wake_pipe[1], "", 1);
    errno = saved;
    return;
  }
  if (const char* path = doomed_path.load()) unlink(path);
  _exit(128 + signal);
}

bool wait_until_ready(int descriptor, short events) {
  // poll passes over the pipe where there was none to be had: its number is then negative.
  std::array<pollfd, 2> waiting = {pollfd{descriptor, events, 0}, pollfd{wake_pipe[0], POLLIN, 0}};
  while (!interrupted()) {
    if (poll(waiting.data(), waiting.size(), -1) > 0 && waiting[0].revents != 0) break;
  }
  return !interrupted();
}

}  // namespace

void catch_interrupts() {
  if (pipe2(wake_pipe.data(), O_CLOEXEC | O_NONBLOCK) != 0) wake_pipe = {-1, -1};
  for (const int signal : kCaught) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = handle_signal;
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
  }
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  sigaction(SIGXFSZ, &ignore, nullptr);
}

void stop_catching_interrupts() {
  for (const int signal : kCaught) {
    struct sigaction now {};
    sigaction(signal, nullptr, &now);
    if (now.sa_handler == handle_signal) std::signal(signal, SIG_DFL);
  }
}

bool wait_for_input(int descriptor) { return wait_until_ready(descriptor, POLLIN); }
bool wait_for_output(int descriptor) { return wait_until_ready(descriptor, POLLOUT); }

bool interrupted() { return first_signal.load() != 0; }

int interrupt_exit_code() { return 128 + first_signal.load(); }

void remove_on_abort(const char* path) { doomed_path.store(path); }

}  // namespace sbrdf::internal
