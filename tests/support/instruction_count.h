#pragma once

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <optional>

#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sbrdf::internal {

/// How many instructions `run` takes: a child does it step by step. What counts is the same on every run, whatever else
/// the machine does. Nothing where the system does not let a process trace its children.
template <class Run>
std::optional<std::uint64_t> count_instructions(const Run& run) {
  const pid_t child = fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(1);
    raise(SIGSTOP);
    run();
    raise(SIGSTOP);
    _exit(0);
  }
  int status = 0;
  const auto stopped = [&] {
    while (waitpid(child, &status, 0) < 0) {
      if (errno != EINTR) return false;
    }
    return WIFSTOPPED(status);
  };
  std::optional<std::uint64_t> steps;
  if (stopped()) {
    std::uint64_t count = 0;
    while (ptrace(PTRACE_SINGLESTEP, child, nullptr, nullptr) == 0 && stopped()) {
      if (WSTOPSIG(status) == SIGSTOP) {
        steps = count;
        break;
      }
      if (WSTOPSIG(status) != SIGTRAP) break;
      ++count;
    }
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
  }
  return steps;
}

}  // namespace sbrdf::internal
