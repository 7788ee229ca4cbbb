#include <array>
#include <cstring>
#include <random>
#include <vector>

#include "converters/files/ngan/ngan.h"
#include "formats/ngan/ngan.h"
#include "tests/fuzz/evaluate_everywhere.h"
#include "tests/fuzz/number_mutator.h"
#include "tests/fuzz/require.h"

// The reader of anisotropic tables: what it accepts must evaluate to finite values and be copied bit for bit, whatever
// its numbers are taken to mean.

namespace sbrdf::internal::fuzzing {
namespace {

void run(const Bytes& bytes) {
  const Result<NganHeader> header = parse_ngan_header(bytes, bytes.size());
  require(!header || recognises_ngan(bytes, bytes.size()), "what can be parsed is recognised");
  if (!header) return;
  require(ngan_file_size(*header) == bytes.size(), "a table has the size that its header asks for");
  const std::array<Options, 3> ways = {
      Options(), Options().set("ngan-channels", "interleaved").set("ngan-other-half", "plane"),
      Options().set("ngan-position", "edge").set("ngan-scale", "1e4").set("ngan-other-half", "unmeasured")};
  for (const Options& options : ways) {
    const auto source = open_ngan(std::make_shared<MemorySource>(bytes), options);
    if (source) evaluate_everywhere(**source);
  }
  const auto source = open_ngan(std::make_shared<MemorySource>(bytes), {});
  if (!source || (*source)->stored("ngan") == nullptr) return;
  MemorySink sink;
  Report report;
  require(save_ngan(**source, sink, {}, report, {}).ok(), "a table can be copied");
  require(std::move(sink).take() == bytes, "a copy has the same bits");
}

// Another shape, with as many values as it asks for.
std::size_t reshape(std::uint8_t* bytes, std::size_t size, std::size_t max_size, std::minstd_rand& random) {
  NganHeader header;
  for (auto& count : header.counts) count = 1 + static_cast<std::uint32_t>(random() % 4);
  header.half = random() % 2 == 1;
  header.channels = 1 + static_cast<std::uint32_t>(random() % 4);
  const auto wanted = static_cast<std::size_t>(ngan_file_size(header));
  if (wanted > max_size) return size;
  for (std::size_t k = size; k < wanted; ++k) bytes[k] = k >= 80 ? bytes[k - 16] : 0;
  const auto head = emit_ngan_header(header);
  std::memcpy(bytes, head.data(), head.size());
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
    sbrdf::internal::fuzzing::overwrite_number<float>({bytes, size}, sbrdf::internal::kNganHeaderSize, random);
  return size;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
