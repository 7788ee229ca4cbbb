// How fast sliced files are written and read, on one core. Verifies before it times anything.
//   codec_benchmark FILE.sbrdf ...
#include <algorithm>
#include <cstdio>
#include <vector>

#include "codec/coding/value_scaling.h"
#include "codec/evaluation/evaluator.h"
#include "codec/file/encoder.h"
#include "codec/file/reader.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/read_sliced.h"

namespace {

using namespace sbrdf::internal;

bool same(const SlicedBrdf& a, const SlicedBrdf& b) {
  return a.crossing_values == b.crossing_values && a.positions == b.positions && a.sample_counts == b.sample_counts &&
         a.sample_values == b.sample_values && a.guide == b.guide;
}

bool measure(const char* path) {
  const Result<DecodedSliced> given = read_sliced(path);
  if (!given) return false;
  for (const double precision : {0.0, 0.001, 0.01}) {
    SlicedBrdf wanted = given->sliced;
    round_to_precision(wanted, precision);
    const std::vector<std::byte> bytes = encode_sliced(given->sliced, given->lattice, {precision});
    const MemorySource source(bytes);
    const Result<SlicedReader> reader = SlicedReader::open(source);
    if (!reader || !same(reader->load_all().value(), wanted)) {
      std::fprintf(stderr, "%s: does not come back\n", path);
      return false;
    }
    const double megabytes =
        static_cast<double>((wanted.crossing_values.size() + wanted.sample_values.size()) * sizeof(float)) / 1e6;
    const double encode = median_seconds([&] { (void)encode_sliced(given->sliced, given->lattice, {precision}); });
    const double open = median_seconds([&] { (void)SlicedReader::open(source); });
    const double decode = median_seconds([&] { (void)reader->load_all(); });
    const double memory_copy = median_seconds([&] {
      std::vector<float> copy = wanted.crossing_values;
      copy.insert(copy.end(), wanted.sample_values.begin(), wanted.sample_values.end());
      (void)std::count(copy.begin(), copy.end(), -1.0F);
    });
    std::printf(
        "%-28s %8.4g %% %8zu bytes  encode %6.1f MB/s  open %7.3f ms  decode %6.1f MB/s  (%.2f ms; copying %.3f ms)\n",
        path, 100 * precision, bytes.size(), megabytes / encode, 1e3 * open, megabytes / decode, 1e3 * decode,
        1e3 * memory_copy);
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  bool ok = argc > 1;
  for (int k = 1; k < argc; ++k) ok = measure(argv[k]) && ok;
  return ok ? 0 : 1;
}
