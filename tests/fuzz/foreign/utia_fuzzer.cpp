#include <array>
#include <random>

#include "converters/files/utia/utia.h"
#include "tests/fuzz/evaluate_everywhere.h"
#include "tests/fuzz/number_mutator.h"
#include "tests/fuzz/require.h"

// The reader of UTIA tables, at the smallest shape that has cells in all four angles: 3 x 6 x 6 numbers. Published
// sizes differ from it in the counts alone. What it accepts must evaluate to finite values and be written again.

namespace sbrdf::internal::fuzzing {
namespace {

constexpr UtiaShape kShape = {2, 3, 60, 120};

void run(const Bytes& bytes) {
  static_cast<void>(recognises_utia(bytes, utia_file_size(kUtiaStandard)));
  const UtiaConventions conventions[] = {
      {},
      {.gamma = UtiaGamma::kNone, .scale = 100, .white = 140, .extrapolated = true},
      {.gamma = UtiaGamma::kSrgbAfter, .scale = 100, .white = 140, .extrapolated = true}};
  for (const UtiaConventions& meant : conventions) {
    const auto source = make_utia_source(std::make_shared<MemorySource>(bytes), kShape, meant,
                                         {Negatives::kKeep, NonFinite::kUnmeasured});
    require(source.ok() || source.error().code == ErrorCode::kInvalidFile, "what is refused is no valid table");
    if (!source) continue;
    evaluate_everywhere(**source);
    MemorySink sink;
    Report report;
    require(write_utia(**source, kShape, sink, {}, report, {}).ok(), "a table can be written");
    require(std::move(sink).take().size() == bytes.size(), "and has the same size");
  }
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  std::minstd_rand random(seed);
  const auto kind = random() % 4;
  if (kind == 0) return LLVMFuzzerMutate(bytes, size, max_size);
  for (std::size_t times = 0; times < kind; ++times)
    sbrdf::internal::fuzzing::overwrite_number<double>({bytes, size}, 0, random);
  return size;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
