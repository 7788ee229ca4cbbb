#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "codec/series/series_file.h"
#include "converters/files/sliced/series_source.h"
#include "formats/core/byte_reader.h"
#include "formats/sbrdf/container.h"
#include "tests/fuzz/evaluate_everywhere.h"
#include "tests/fuzz/require.h"

// Dense files: what is accepted comes back the same when it is written, and evaluates to finite values.

namespace sbrdf::internal::fuzzing {
namespace {

constexpr std::uint64_t kMostTable = std::uint64_t{1} << 22U;

void run(const Bytes& bytes) {
  const auto source = std::make_shared<MemorySource>(bytes);
  const Result<SeriesBrdf> brdf = decode_series(*source);
  if (!brdf) return;
  const Result<SeriesBrdf> again = decode_series(MemorySource(encode_series(*brdf)));
  require(again.ok() && again->coefficients == brdf->coefficients, "what is written can be read");
  const auto opened = open_series(source, MemoryLimit{kMostTable});
  if (opened) evaluate_everywhere(**opened);
}

// The checksum, and the size, of an index that changed.
std::size_t mend(std::uint8_t* bytes, std::size_t size, std::size_t max_size) {
  ByteReader in(std::as_bytes(std::span(bytes, size)));
  in.bytes(kContainerMagic.size() + 2);
  in.count(28);
  if (!in.ok() || in.remaining() < kChecksumSize) return size;
  const auto index = in.bytes(in.remaining() - kChecksumSize);
  const std::vector<std::byte> file = emit_head(index);
  if (file.size() > max_size) return size;
  std::memcpy(bytes, file.data(), file.size());
  return file.size();
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  size = LLVMFuzzerMutate(bytes, size, max_size);
  return seed % 8 == 0 ? size : sbrdf::internal::fuzzing::mend(bytes, size, max_size);
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
