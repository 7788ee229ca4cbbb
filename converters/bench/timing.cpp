#include "converters/bench/timing.h"

#include <benchmark/benchmark.h>
#include <hwy/highway.h>
#include <hwy/targets.h>
#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

namespace sbrdf::internal {
namespace {

/// Keeps the times and prints nothing.
class QuietReporter final : public benchmark::BenchmarkReporter {
 public:
  explicit QuietReporter(std::span<const TimedWork> works) : works_(works), times_(works.size()) {}

  bool ReportContext(const Context& /*context*/) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.iterations == 0 || run.error_occurred) continue;
      const auto index = static_cast<std::size_t>(std::stoul(run.run_name.function_name));
      const bool processor = works_[index].clock == Clock::kProcessor;
      const double seconds = processor ? run.cpu_accumulated_time : run.real_accumulated_time;
      times_[index].push_back(seconds / static_cast<double>(run.iterations));
    }
  }

  [[nodiscard]] std::vector<double> medians() {
    std::vector<double> medians;
    for (std::vector<double>& times : times_) {
      const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
      std::nth_element(times.begin(), middle, times.end());
      medians.push_back(times.empty() ? 0 : *middle);
    }
    return medians;
  }

 private:
  std::span<const TimedWork> works_;
  std::vector<std::vector<double>> times_;  ///< [s], of each work
};

void set_up_once() {
  static const bool kDone = [] {
    std::string name = "sbrdf";
    std::string mixed = "--benchmark_enable_random_interleaving=true";
    std::array<char*, 3> arguments = {name.data(), mixed.data(), nullptr};
    int count = 2;
    benchmark::Initialize(&count, arguments.data());
    return true;
  }();
  std::ignore = kDone;
}

void time_work(const TimedWork& work, benchmark::State& state) {
  for (auto _ : state) {
    const std::optional<double> seconds = work.run();
    if (work.clock != Clock::kTold) continue;
    if (!seconds) return state.SkipWithError("did not happen");  // as when the run is interrupted: it would never end
    state.SetIterationTime(*seconds);
  }
}

std::uint64_t largest_cache_bytes() {
  std::uint64_t most = 0;
  for (const auto& cache : benchmark::CPUInfo::Get().caches) {
    most = std::max(most, static_cast<std::uint64_t>(std::max(cache.size, 0)));
  }
  return most;
}

}  // namespace

std::vector<double> median_seconds(std::span<const TimedWork> works, const TimingOptions& options) {
  set_up_once();
  for (std::size_t k = 0; k < works.size(); ++k) {
    const TimedWork& work = works[k];
    auto* registered = benchmark::RegisterBenchmark(std::to_string(k).c_str(),
                                                    [&work](benchmark::State& state) { time_work(work, state); });
    registered->Repetitions(options.repetitions)->MinTime(options.least_seconds);
    if (work.clock == Clock::kWall) registered->UseRealTime();
    if (work.clock == Clock::kTold) registered->UseManualTime();
  }
  QuietReporter reporter(works);
  benchmark::RunSpecifiedBenchmarks(&reporter, "all");
  benchmark::ClearRegisteredBenchmarks();
  return reporter.medians();
}

MemorySpeed measure_memory_speed(std::uint64_t least_bytes, const TimingOptions& options) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 30U;
  const std::uint64_t bytes = std::clamp(4 * largest_cache_bytes(), least_bytes, std::max(least_bytes, kMost));
  std::vector<std::uint64_t> from(bytes / sizeof(std::uint64_t), 1);
  std::vector<std::uint64_t> to(from.size());
  const std::array<TimedWork, 2> works = {{{[&] {
                                              benchmark::DoNotOptimize(
                                                  std::accumulate(from.begin(), from.end(), std::uint64_t{0}));
                                              return std::nullopt;
                                            },
                                            Clock::kProcessor},
                                           {[&] {
                                              std::copy(from.begin(), from.end(), to.begin());
                                              benchmark::ClobberMemory();
                                              return std::nullopt;
                                            },
                                            Clock::kProcessor}}};
  const std::vector<double> seconds = median_seconds(works, options);
  const double gigabytes = 1e-9 * static_cast<double>(from.size() * sizeof(std::uint64_t));
  return {bytes, gigabytes / seconds[0], gigabytes / seconds[1]};
}

std::string vector_target() {
  const auto usable = static_cast<std::uint64_t>(hwy::SupportedTargets()) & static_cast<std::uint64_t>(HWY_TARGETS);
  const std::uint64_t best = usable & (~usable + 1);  // the lower the bit, the wider the vectors
  return hwy::TargetName(static_cast<decltype(hwy::SupportedTargets())>(best));
}

}  // namespace sbrdf::internal
