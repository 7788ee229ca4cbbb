#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#if SBRDF_WITH_TBB
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

// The only place that knows how work is spread over threads: oneTBB, or nothing at all where the library was built
// without it (SBRDF_WITH_TBB=OFF). Callers give the same results either way: each task writes what is its own.

namespace sbrdf::internal {

/// Calls `task(k)` once for each k in [0, count), in any order, from any number of threads.
template <class Task>
void parallel_for(std::uint64_t count, const Task& task) {
#if SBRDF_WITH_TBB
  tbb::parallel_for(std::uint64_t{0}, count, task);
#else
  for (std::uint64_t k = 0; k < count; ++k) task(k);
#endif
}

/// Calls `task(first, size)` for parts of [0, count) that cover it once, of about `block` each: for work on spans,
/// where a single element is too little for a task.
template <class Task>
void parallel_blocks(std::size_t count, std::size_t block, const Task& task) {
#if SBRDF_WITH_TBB
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, block),
                    [&](const auto& range) { task(range.begin(), range.size()); });
#else
  for (std::size_t first = 0; first < count; first += block) task(first, std::min(block, count - first));
#endif
}

/// Calls `task(k)` once for each k in [0, count), in parts of about `block`.
template <class Task>
void for_all(std::size_t count, std::size_t block, const Task& task) {
  parallel_blocks(count, block, [&](std::size_t first, std::size_t size) {
    for (std::size_t k = first; k < first + size; ++k) task(k);
  });
}

/// Calls `work()`, in which at most `count` threads take part, the caller's included: for a machine that has room for
/// no more. With 1, no thread is ever asked for.
template <class Work>
void with_threads(std::size_t count, const Work& work) {
#if SBRDF_WITH_TBB
  tbb::task_arena(static_cast<int>(count)).execute(work);
#else
  static_cast<void>(count);
  work();
#endif
}

/// At most `count` threads work while this lives; for tests that compare.
class ThreadLimit {
 public:
#if SBRDF_WITH_TBB
  explicit ThreadLimit(std::size_t count) : control_(tbb::global_control::max_allowed_parallelism, count) {}

 private:
  tbb::global_control control_;
#else
  explicit ThreadLimit(std::size_t /*count*/) {}
#endif
};

}  // namespace sbrdf::internal
