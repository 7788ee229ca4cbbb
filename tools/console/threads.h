#pragma once

#include <functional>

namespace sbrdf::internal {

/// Calls `work()` with as many threads as there is room for. Limits on processes (RLIMIT_NPROC, a container's) or on
/// memory otherwise end a program in the middle of its work, when it asks for the first thread. Results are the same on
/// any number.
void run_with_possible_threads(const std::function<void()>& work);

}  // namespace sbrdf::internal
