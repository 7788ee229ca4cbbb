// How long one evaluation of sliced files takes, on one core, as a ratio to a plain trilinear look-up in a table of 90
// x 90 x 180 half and difference angles that is run beside it. Verifies before it times anything, and says how far the
// values of this machine's sets of instructions (SSE4, AVX2 ...) are apart.
//   evaluation_benchmark FILE.sbrdf ...
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <hwy/targets.h>

#include "codec/evaluation/evaluator.h"
#include "codec/evaluation/vector_evaluator.h"
#include "converters/bench/yardstick.h"
#include "tests/benchmarks/timing.h"
#include "tests/benchmarks/vector_pairs.h"
#include "tests/support/read_sliced.h"

namespace {

using namespace sbrdf::internal;

constexpr std::size_t kPairs = 200'000;

/// For one pair [ns].
template <class Run>
double nanoseconds(const Run& run) {
  return 1e9 * median_seconds(run) / kPairs;
}

/// Largest difference from the same in long double, relative to the value or to a millionth of the largest.
double largest_error(const VectorEvaluator& evaluator, const BasicEvaluator<long double>& exact,
                     const VectorPairs& pairs) {
  std::vector<float> values(evaluator.channel_count());
  std::vector<long double> expected(values.size());
  double most = 0;
  for (std::size_t k = 0; k < 5000; ++k) {
    const glm::dvec3 i(pairs.i[k]);
    const glm::dvec3 v(pairs.v[k]);
    evaluator.evaluate(std::span(&pairs.i[k], 1), std::span(&pairs.v[k], 1), values);
    exact.evaluate({direction_from_vector(i), direction_from_vector(v)}, expected);
    for (std::size_t c = 0; c < values.size(); ++c) {
      const auto e = static_cast<double>(expected[c]);
      most = std::max(most, std::abs(values[c] - e) / std::max(std::abs(e), 1e-6));
    }
  }
  return most;
}

/// Largest difference of two sets of instructions, relative to the largest channel of the pair.
double largest_difference_of_targets(const VectorEvaluator& evaluator, const VectorPairs& pairs,
                                     const std::vector<float>& expected) {
  const std::size_t channels = evaluator.channel_count();
  std::vector<float> values(expected.size());
  float most = 0;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    hwy::GetChosenTarget().Update(left & -left);
    evaluator.evaluate(pairs.i, pairs.v, values);
    for (std::size_t k = 0; k < values.size(); k += channels) {
      float largest = 0;
      float apart = 0;
      for (std::size_t c = k; c < k + channels; ++c) {
        largest = std::max(largest, std::abs(expected[c]));
        apart = std::max(apart, std::abs(values[c] - expected[c]));
      }
      if (apart > 0) most = std::max(most, apart / largest);
    }
  }
  hwy::GetChosenTarget().DeInit();
  return most;
}

bool measure(const char* path, const VectorPairs& pairs, const TrilinearTable<double>& table) {
  const Result<DecodedSliced> given = read_sliced(path);
  if (!given) return false;
  const VectorEvaluator evaluator(given->sliced, given->lattice);
  const BasicEvaluator<long double> exact(given->sliced, given->lattice);
  const std::size_t channels = evaluator.channel_count();
  std::vector<float> batch(kPairs * channels);
  std::vector<float> single(kPairs * channels);
  const auto one_by_one = [&] {
    for (std::size_t k = 0; k < kPairs; ++k) {
      evaluator.evaluate(std::span(&pairs.i[k], 1), std::span(&pairs.v[k], 1),
                         std::span(single).subspan(k * channels, channels));
    }
  };
  const auto together = [&] { evaluator.evaluate(pairs.i, pairs.v, batch); };
  one_by_one();
  together();
  if (single != batch) {
    std::fprintf(stderr, "%s: a batch gives other bits than single calls\n", path);
    return false;
  }
  const double error = largest_error(evaluator, exact, pairs);
  const double apart = largest_difference_of_targets(evaluator, pairs, batch);
  const Evaluator plain(given->sliced, given->lattice);
  const double angles_ns = nanoseconds([&] {
    for (std::size_t k = 0; k < kPairs; ++k) {
      plain.evaluate({direction_from_vector(glm::dvec3(pairs.i[k])), direction_from_vector(glm::dvec3(pairs.v[k]))},
                     std::span(single).subspan(k * channels, channels));
    }
  });
  // All channels are kept: of those that are not, the compiler leaves the look-up out, which takes a quarter less then.
  std::vector<glm::vec3> looked_up(kPairs);
  const double yardstick = nanoseconds([&] {
    for (std::size_t k = 0; k < kPairs; ++k) looked_up[k] = table.look_up(pairs.i[k], pairs.v[k]);
  });
  const double single_ns = nanoseconds(one_by_one);
  const double batch_ns = nanoseconds(together);
  const std::size_t values = given->sliced.sample_count() * channels * sizeof(float);
  std::printf("%s: %zu samples, %zu bytes = %.1f x values, largest error %.1e, sets of instructions %.1e apart\n", path,
              given->sliced.sample_count(), evaluator.bytes(),
              static_cast<double>(evaluator.bytes()) / static_cast<double>(values), error, apart);
  std::printf("  times the look-up (%.0f ns): through angles %5.2f  one by one %5.2f  together %5.2f\n", yardstick,
              angles_ns / yardstick, single_ns / yardstick, batch_ns / yardstick);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const VectorPairs pairs = random_vector_pairs(kPairs);
  const TrilinearTable<double> table = make_yardstick();
  bool ok = argc > 1;
  for (int k = 1; k < argc; ++k) ok = measure(argv[k], pairs, table) && ok;
  return ok ? 0 : 1;
}
