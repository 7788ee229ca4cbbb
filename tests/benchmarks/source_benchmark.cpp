// How long it takes to open a file of any format, to its first value, and how long an evaluation takes, on one core:
// opening as a ratio to a plain read of the file, evaluations as one to a plain trilinear look-up that is run beside
// them. Verifies before it times anything.
//   source_benchmark FILE ...
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <vector>

#include "converters/bench/yardstick.h"
#include "converters/files/by_name.h"
#include "formats/core/parallel.h"
#include "tests/benchmarks/timing.h"
#include "tests/benchmarks/vector_pairs.h"

namespace {

using namespace sbrdf::internal;

constexpr std::size_t kPairs = 200'000;

void read_plainly(const char* path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path, "rb"), &std::fclose);
  std::fseek(file.get(), 0, SEEK_END);
  const auto size = static_cast<std::size_t>(std::ftell(file.get()));
  std::rewind(file.get());
  const auto bytes = std::make_unique_for_overwrite<char[]>(size);
  if (std::fread(bytes.get(), 1, size, file.get()) != size) std::fprintf(stderr, "%s: cannot be read\n", path);
}

/// Of the process [bytes].
double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double size = 0;
  double resident = 0;
  file >> size >> resident;
  return 4096 * resident;
}

/// Largest difference of values from vectors and from angles, relative to the value or to a millionth of the largest.
double largest_difference(const BrdfSource& source, const VectorPairs& pairs, std::span<const float> values) {
  std::vector<DirectionPair> angles;
  for (std::size_t k = 0; k < kPairs; ++k) {
    angles.push_back({direction_from_vector(glm::dvec3(pairs.i[k])), direction_from_vector(glm::dvec3(pairs.v[k]))});
  }
  std::vector<float> expected(values.size());
  source.evaluate(angles, expected);
  const double least = 1e-6 * *std::max_element(expected.begin(), expected.end());
  double most = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    most = std::max(most, std::abs(values[k] - expected[k]) / std::max<double>(std::abs(expected[k]), least));
  }
  return most;
}

bool measure(const char* path, const VectorPairs& pairs, const TrilinearTable<double>& table) {
  const double before = resident_bytes();
  const Result<OpenedSource> opened = open_source(path);
  if (!opened) {
    std::fprintf(stderr, "%s: %s\n", path, opened.error().message.c_str());
    return false;
  }
  const BrdfSource& source = *opened->source;
  const std::size_t channels = source.channel_count();
  std::vector<float> one(channels);
  const auto first_value = [&](const BrdfSource& from) {
    from.evaluate_vectors(std::span(&pairs.i[0], 1), std::span(&pairs.v[0], 1), one);
  };
  first_value(source);
  const double resident = resident_bytes() - before;
  std::vector<float> single(kPairs * channels);
  std::vector<float> batch(kPairs * channels);
  const auto together = [&] { source.evaluate_vectors(pairs.i, pairs.v, batch); };
  const auto one_by_one = [&] {
    for (std::size_t k = 0; k < kPairs; ++k) {
      source.evaluate_vectors(std::span(&pairs.i[k], 1), std::span(&pairs.v[k], 1),
                              std::span(single).subspan(k * channels, channels));
    }
  };
  one_by_one();
  together();
  if (single != batch) {
    std::fprintf(stderr, "%s: a batch gives other bits than single calls\n", path);
    return false;
  }
  const double difference = largest_difference(source, pairs, batch);
  const double reading = median_seconds([&] { read_plainly(path); });
  const double opening = median_seconds([&] { (void)open_source(path); });
  const double to_first = median_seconds([&] { first_value(*open_source(path)->source); });
  std::vector<glm::vec3> looked_up(kPairs);
  const double yardstick = median_seconds([&] {
    for (std::size_t k = 0; k < kPairs; ++k) looked_up[k] = table.look_up(pairs.i[k], pairs.v[k]);
  });
  const double one_ratio = median_seconds(one_by_one) / yardstick;
  const double batch_ratio = median_seconds(together) / yardstick;
  std::printf("%-40s read %7.3f ms  open %5.2f x  first value %7.3f ms = %5.2f x  resident %5.2f MB = %5.2f x file\n",
              path, 1e3 * reading, opening / reading, 1e3 * to_first, to_first / reading, resident / 1e6,
              resident / static_cast<double>(opened->bytes.value_or(1)));
  std::printf("  times the look-up (%.0f ns): one by one %5.2f  together %5.2f  from angles within %.1e\n",
              1e9 * yardstick / kPairs, one_ratio, batch_ratio, difference);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const ThreadLimit one(1);
  const VectorPairs pairs = random_vector_pairs(kPairs);
  const TrilinearTable<double> table = make_yardstick();
  bool ok = argc > 1;
  for (int k = 1; k < argc; ++k) ok = measure(argv[k], pairs, table) && ok;
  return ok ? 0 : 1;
}
