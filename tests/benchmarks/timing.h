#pragma once

#include <algorithm>
#include <ctime>
#include <vector>

namespace sbrdf::internal {

/// Processor time, so that what else the machine does counts little [s].
inline double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Median of nine runs [s].
template <class Run>
double median_seconds(const Run& run) {
  std::vector<double> times;
  for (int k = 0; k < 9; ++k) {
    const double start = processor_seconds();
    run();
    times.push_back(processor_seconds() - start);
  }
  std::nth_element(times.begin(), times.begin() + 4, times.end());
  return times[4];
}

}  // namespace sbrdf::internal
