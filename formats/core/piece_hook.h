#pragma once

#include <atomic>

namespace sbrdf::internal {

/// What a process wants done after each piece of a file that a library has read, if anything: one that gives a library
/// so much time and no more (formats/os/trial.h) gives it anew then. Called from any thread.
inline std::atomic<void (*)()> piece_hook = nullptr;

inline void piece_done() {
  if (void (*hook)() = piece_hook.load(std::memory_order_relaxed)) hook();
}

}  // namespace sbrdf::internal
