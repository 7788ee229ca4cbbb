#include <array>
#include <cstring>
#include <random>

#include "converters/files/merl/merl_source.h"
#include "formats/merl/merl.h"
#include "tests/fuzz/evaluate_everywhere.h"
#include "tests/fuzz/number_mutator.h"
#include "tests/fuzz/require.h"

// The MERL reader: what it accepts must be written back bit for bit, and a source must evaluate to finite values.

namespace sbrdf::internal::fuzzing {
namespace {

void run(const Bytes& bytes) {
  const Result<MerlTable> table = parse_merl(bytes);
  require(table.ok() == recognises_merl(bytes, bytes.size()), "what is recognised can be parsed");
  if (!table) return;
  require(emit_merl(*table) == bytes, "a MERL table is written as it was read");
  const auto source = MerlSource::make(std::make_shared<MemorySource>(bytes));
  if (source) evaluate_everywhere(**source);
}

// Another shape, with as many values as it asks for.
std::size_t reshape(std::uint8_t* bytes, std::size_t size, std::size_t max_size, std::minstd_rand& random) {
  MerlShape shape{};
  for (auto& count : shape) count = 1 + static_cast<std::uint32_t>(random() % 5);
  const auto wanted = static_cast<std::size_t>(merl_file_size(shape));
  if (wanted > max_size) return size;
  for (std::size_t k = size; k < wanted; ++k) bytes[k] = k >= 40 ? bytes[k - 24] : 0;
  std::memcpy(bytes, shape.data(), kMerlHeaderSize);
  return wanted;
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  std::minstd_rand random(seed);
  const auto kind = random() % 8;
  if (kind < 3) size = LLVMFuzzerMutate(bytes, size, max_size);
  if (kind == 1 || kind == 3) size = sbrdf::internal::fuzzing::reshape(bytes, size, max_size, random);
  if (kind > 1)
    sbrdf::internal::fuzzing::overwrite_number<double>({bytes, size}, sbrdf::internal::kMerlHeaderSize, random);
  return size;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
