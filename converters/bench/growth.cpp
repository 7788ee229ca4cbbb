#include <algorithm>
#include <thread>
#include <utility>

#include "converters/bench/bench.h"
#include "converters/judge/heap.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kThreadBlock = 1024;  // pairs of a task
constexpr std::size_t kThreadPasses = 4;    // over all pairs: starting the threads is not what is measured
constexpr double kSamplesShare = 0.8;       // of the work of one method, as files are made
constexpr std::size_t kFewest = 1;

/// 1, 2, 4 ... and all.
std::vector<std::size_t> thread_counts() {
  const std::size_t all = std::max<std::size_t>(std::thread::hardware_concurrency(), kFewest);
  std::vector<std::size_t> counts;
  for (std::size_t count = 1; count < all; count *= 2) counts.push_back(count);
  counts.push_back(all);
  return counts;
}

class Growth {
 public:
  Growth(Workshop& workshop, const BenchSettings& settings, const VectorPairs& pairs)
      : workshop_(workshop),
        settings_(settings),
        pairs_(pairs),
        values_(pairs.size() * std::max<std::size_t>(workshop.source().channel_count(), 3)) {}

  Status along_samples(const Method& method, const Progress& progress) {
    StepwiseProgress steps(progress);
    const std::size_t count = settings_.growth_samples.size();
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint64_t samples = settings_.growth_samples[k];
      auto contender = open(method, samples, steps.step(1.0 / static_cast<double>(count - k)));
      if (!contender) return contender.error();
      const std::array works = {evaluation_work(**contender, pairs_, pairs_.size(), values_),
                                yardstick_work(pairs_, values_)};
      const std::vector<double> ns = times(works);
      GrowthRow row = row_of(method, GrowthAxis::kSamples, samples, ns[0], ns[1]);
      const std::uint64_t before = heap_bytes();
      contender->reset();
      const std::uint64_t after = heap_bytes();
      row.resident_bytes = before > after ? before - after : 0;
      rows_.push_back(std::move(row));
    }
    return ok_status();
  }

  Status along_batches_and_threads(const Method& method, const Progress& progress) {
    const auto contender = open(method, settings_.growth_batch_samples, progress);
    if (!contender) return contender.error();
    std::vector<TimedWork> works = {yardstick_work(pairs_, values_)};
    for (const std::size_t batch : settings_.batches) {
      works.push_back(evaluation_work(**contender, pairs_, batch, values_));
    }
    const std::vector<std::size_t> threads = thread_counts();
    for (const std::size_t count : threads) works.push_back(threaded_work(**contender, count));
    const std::vector<double> ns = times(works);
    for (std::size_t k = 0; k < settings_.batches.size(); ++k) {
      rows_.push_back(row_of(method, GrowthAxis::kBatch, settings_.batches[k], ns[1 + k], ns[0]));
    }
    for (std::size_t k = 0; k < threads.size(); ++k) {
      const double each = ns[1 + settings_.batches.size() + k] / kThreadPasses;
      rows_.push_back(row_of(method, GrowthAxis::kThreads, threads[k], each, ns[0]));
    }
    return ok_status();
  }

  [[nodiscard]] std::vector<GrowthRow> take() && { return std::move(rows_); }

 private:
  Result<std::unique_ptr<Contender>> open(const Method& method, std::uint64_t samples, const Progress& progress) {
    const auto place = [&](const Error& error) {
      return in_context(error, workshop_.material().name, method.name, samples_variant(samples).name);
    };
    const Result<FileBytes> file = workshop_.sliced_for_growth(samples, progress);
    if (!file) return place(file.error());
    Result<std::unique_ptr<Contender>> contender = method.open_sliced(**file);
    if (!contender) return place(contender.error());
    if (Status right = verify(**contender, workshop_.source(), pairs_, method.wild_percent); !right) {
      return place(right.error());
    }
    return contender;
  }

  [[nodiscard]] GrowthRow row_of(const Method& method, GrowthAxis axis, std::uint64_t at, double ns,
                                 double yardstick_ns) const {
    return {workshop_.material().name, std::string(method.name), axis, at, ns, yardstick_ns};
  }

  /// For one evaluation of each [ns].
  [[nodiscard]] std::vector<double> times(std::span<const TimedWork> works) const {
    std::vector<double> ns = median_seconds(works, settings_.timing);
    for (double& time : ns) time *= 1e9 / static_cast<double>(pairs_.size());
    return ns;
  }

  TimedWork threaded_work(const Contender& contender, std::size_t count) {
    return {[this, &contender, count]() -> std::optional<double> {
              const std::size_t channels = contender.channel_count();
              with_threads(count, [&] {
                for (std::size_t pass = 0; pass < kThreadPasses; ++pass) {
                  parallel_blocks(pairs_.size(), kThreadBlock, [&](std::size_t first, std::size_t size) {
                    contender.evaluate(std::span(pairs_.i).subspan(first, size),
                                       std::span(pairs_.v).subspan(first, size),
                                       std::span(values_).subspan(first * channels, size * channels));
                  });
                }
              });
              return std::nullopt;
            },
            Clock::kWall};
  }

  Workshop& workshop_;
  const BenchSettings& settings_;
  const VectorPairs& pairs_;
  std::vector<float> values_;
  std::vector<GrowthRow> rows_;
};

}  // namespace

Result<std::vector<GrowthRow>> measure_growth(Workshop& workshop, const BenchSettings& settings,
                                              const VectorPairs& pairs, const Progress& progress) {
  Growth growth(workshop, settings, pairs);
  StepwiseProgress steps(progress);
  for (const Method& method : bench_methods()) {
    if (method.open_sliced == nullptr || !method.left_out(workshop.source()).empty()) continue;
    if (Status done = growth.along_samples(method, steps.step(kSamplesShare)); !done) return done.error();
    if (Status done = growth.along_batches_and_threads(method, steps.step(kSamplesShare)); !done) return done.error();
  }
  if (!steps.finish()) return interrupted_error();
  return std::move(growth).take();
}

}  // namespace sbrdf::internal
