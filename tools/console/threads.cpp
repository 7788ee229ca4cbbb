#include "tools/console/threads.h"

#include <cstddef>
#include <future>
#include <system_error>
#include <thread>
#include <vector>

#include "formats/core/parallel.h"

namespace sbrdf::internal {

namespace {

/// Up to `wanted`, the caller's included. Tried rather than asked: no call tells all limits. The threads live at the
/// same time, as the real ones will.
std::size_t possible_threads(std::size_t wanted) {
  std::promise<void> end;
  const std::shared_future<void> ended = end.get_future().share();
  std::vector<std::thread> threads;
  try {
    while (threads.size() + 1 < wanted) threads.emplace_back([ended] { ended.wait(); });
  } catch (const std::system_error&) {
    // What could be made is what there is.
  }
  end.set_value();
  for (std::thread& thread : threads) thread.join();
  return threads.size() + 1;
}

}  // namespace

void run_with_possible_threads(const std::function<void()>& work) {
  const std::size_t wanted = std::thread::hardware_concurrency();
  const std::size_t possible = possible_threads(wanted);
  if (possible < wanted) {
    with_threads(possible, work);
  } else {
    work();
  }
}

}  // namespace sbrdf::internal
