#include <algorithm>

#include "codec/file/reader.h"
#include "formats/core/byte_source.h"
#include "formats/sbrdf/container.h"
#include "tests/fuzz/require.h"
#include "tests/fuzz/sliced_file.h"

// Header and index of a sliced file, and all that is made of them before any chunk is read.

namespace sbrdf::internal::fuzzing {
namespace {

void run(const Bytes& bytes) {
  const MemorySource source(bytes);
  const Result<ContainerHead> head = read_head(source);
  const Result<SlicedReader> reader = SlicedReader::open(source);
  require(head.ok() || !reader.ok(), "what has no head cannot be opened");
  if (!head) return;
  require(is_container(bytes), "what has a head has the magic");
  require(head->chunks_offset() <= bytes.size(), "the index lies within the file");
  if (!reader) return;
  const SlicedIndex& index = reader->index();
  require(index.channels.size() == index.ranges.size(), "every channel has a range");
  std::uint64_t before = 0;
  for (int depth = 0; depth <= kMaxDepth; ++depth) {
    const std::uint64_t needed = reader->bytes_up_to(depth);
    require(before <= needed && needed <= bytes.size(), "greater depths need more bytes, but no more than there are");
    before = needed;
  }
  // Another program may have written the index in another way, but not one that says something else.
  const Bytes again = emit_index(index);
  const Result<SlicedIndex> parsed = parse_index(again, false);
  require(parsed.ok() && emit_index(*parsed) == again, "an index is written as it was read");
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  return sbrdf::internal::fuzzing::mutate_sliced(bytes, size, max_size, seed);
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
