// How long the conversion of files into slices takes, as a ratio to loading them; how it and evaluating many pairs gain
// from a second thread; and how sampling grows with the number of samples.
//   conversion_benchmark [FILE ...]
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/models/analytic.h"
#include "converters/slicing/slicing.h"
#include "formats/core/parallel.h"
#include "tests/benchmarks/timing.h"
#include "tests/benchmarks/vector_pairs.h"

namespace {

using namespace sbrdf::internal;

constexpr std::size_t kPairs = 1'000'000;

/// The elevation frame with slices every ten degrees, in the log domain: nothing is searched.
SliceOptions fixed_structure(std::uint64_t samples, bool fitted) {
  SliceOptions options;
  options.stop = SampleCount{samples};
  options.structure = Placement{10, 10};
  options.domain = DomainKind::kLog;
  options.fit_values = fitted;
  options.precision = 0.001;
  return options;
}

std::size_t convert(const BrdfSource& source, const SliceOptions& options) {
  const Result<Slicing> slicing = slice_source(source, options);
  return slicing ? encode_sliced(slicing->sliced, slicing->lattice, encoding_of(*slicing, options)).size() : 0;
}

/// Of the wall; median of nine [s].
template <class Run>
double median_wall_seconds(const Run& run) {
  std::array<double, 9> times;
  for (double& time : times) {
    const auto start = std::chrono::steady_clock::now();
    run();
    time = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  std::nth_element(times.begin(), times.begin() + 4, times.end());
  return times[4];
}

/// How many times faster two threads are than one.
template <class Run>
double gain_of_two(const Run& run) {
  const auto with = [&](std::size_t threads) {
    const ThreadLimit limit(threads);
    return median_wall_seconds(run);
  };
  const double one = with(1);
  return one / with(2);
}

bool measure(const char* path) {
  const Result<OpenedSource> opened = open_source(path);
  if (!opened) {
    std::fprintf(stderr, "%s: %s\n", path, opened.error().message.c_str());
    return false;
  }
  const BrdfSource& source = *opened->source;
  for (const bool fitted : {false, true}) {
    const SliceOptions options = fixed_structure(4096, fitted);
    const std::size_t bytes = convert(source, options);
    if (bytes == 0) return false;
    double load = 0;
    double conversion = 0;
    {
      const ThreadLimit one(1);
      load = median_seconds([&] { (void)open_source(path); });
      conversion = median_seconds([&] { convert(*open_source(path)->source, options); });
    }
    const double gain = gain_of_two([&] { convert(source, options); });
    std::printf(
        "%-32s %s values: %zu bytes, load %6.2f ms, converted in %7.2f ms = %5.2f x load; two threads %4.2f x\n", path,
        fitted ? "fitted  " : "measured", bytes, 1e3 * load, 1e3 * conversion, conversion / load, gain);
  }
  const VectorPairs pairs = random_vector_pairs(kPairs);
  std::vector<float> values(kPairs * source.channel_count());
  const double gain = gain_of_two([&] { evaluate_in_parallel(source, pairs.i, pairs.v, values); });
  std::printf("%-32s a million pairs: two threads %4.2f x\n", path, gain);
  return true;
}

/// Times of sampling an analytic material, and the power of the number that they grow with.
void measure_growth() {
  const ThreadLimit one(1);
  const auto source = make_analytic_source(kurt_material("fabric112").value());
  std::vector<double> x;
  std::vector<double> y;
  for (const std::uint64_t samples : {1'000, 3'000, 10'000, 30'000, 100'000, 350'000}) {
    SliceOptions options = fixed_structure(samples, false);
    options.structure = Placement{40, 72};
    const double start = processor_seconds();
    const Result<Slicing> slicing = slice_source(*source, options);
    const double seconds = processor_seconds() - start;
    if (!slicing) return std::fprintf(stderr, "%s\n", slicing.error().message.c_str()), void();
    const double count = static_cast<double>(slicing->sliced.sample_count());
    std::printf("sampling %7.0f samples: %8.2f ms, %6.2f ns per n log2 n\n", count, 1e3 * seconds,
                1e9 * seconds / (count * std::log2(count)));
    x.push_back(std::log(count));
    y.push_back(std::log(seconds));
  }
  double mean_x = 0;
  double mean_y = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    mean_x += x[k] / static_cast<double>(x.size());
    mean_y += y[k] / static_cast<double>(x.size());
  }
  double products = 0;
  double squares = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    products += (x[k] - mean_x) * (y[k] - mean_y);
    squares += (x[k] - mean_x) * (x[k] - mean_x);
  }
  std::printf("fitted: time grows as n^%.3f; n log n would be about n^%.3f here\n", products / squares,
              1 + std::log(std::log2(350'000.0) / std::log2(1'000.0)) / std::log(350.0));
}

}  // namespace

int main(int argc, char** argv) {
  // oneTBB takes as many threads as are allowed when it is first used, and no more later on.
  parallel_for(1000, [](std::uint64_t) {});
  bool ok = true;
  for (int k = 1; k < argc; ++k) ok = measure(argv[k]) && ok;
  measure_growth();
  return ok ? 0 : 1;
}
