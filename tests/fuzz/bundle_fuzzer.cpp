#include <algorithm>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "codec/file/reader.h"
#include "formats/core/byte_source.h"
#include "formats/sbrdf/bundle.h"
#include "formats/sbrdf/container.h"
#include "tests/fuzz/require.h"

// Bundles of sliced files: header, index, dictionary, heads, and the files that are put together from them.

namespace sbrdf::internal::fuzzing {
namespace {

constexpr std::size_t kMostRepacked = 8;  // materials; choosing a dictionary takes long

void put_checksum(Bytes& bytes, std::size_t first, std::size_t size, std::size_t at) {
  const std::uint32_t sum = checksum(std::span(bytes).subspan(first, size));
  std::memcpy(bytes.data() + at, &sum, sizeof(sum));
}

/// Makes the size of the file and all checksums fit what is there, as far as it can be found.
void mend(Bytes& bytes) {
  constexpr std::size_t kIndexSize = 12;
  constexpr std::size_t kFileSize = 16;
  constexpr std::size_t kIndexChecksum = 24;
  constexpr std::size_t kHeaderChecksum = 28;
  if (bytes.size() < kBundleHeaderSize) return;
  const std::uint64_t file_size = bytes.size();
  std::memcpy(bytes.data() + kFileSize, &file_size, sizeof(file_size));
  std::uint32_t index_size = 0;
  std::memcpy(&index_size, bytes.data() + kIndexSize, sizeof(index_size));
  if (index_size > bytes.size() - kBundleHeaderSize) return;
  put_checksum(bytes, kBundleHeaderSize, index_size, kIndexChecksum);
  put_checksum(bytes, 0, kHeaderChecksum, kHeaderChecksum);
  const MemorySource source(bytes);
  const Result<BundleReader> reader = BundleReader::open(source);
  if (!reader) return;
  if (const std::size_t size = reader->dictionary_size(); size != 0) {
    put_checksum(bytes, kBundleHeaderSize + index_size, size, kBundleHeaderSize + index_size + size);
  }
  for (const BundleEntry& entry : reader->entries()) {
    put_checksum(bytes, entry.offset, entry.stored_size, entry.offset + entry.stored_size);
  }
}

Bytes read_whole(const ByteSource& source) {
  Result<Bytes> whole = read_range(source, 0, source.size());
  require(whole.ok(), "a file of a bundle in memory can be read");
  return *std::move(whole);
}

/// A file, and whether it is a sliced one.
struct Unpacked {
  std::string name;
  Bytes file;
  bool sliced = false;
};

Unpacked unpack(const BundleEntry& entry, const ByteSource& material) {
  Unpacked unpacked = {entry.name, read_whole(material), false};
  require(unpacked.file.size() == entry.file_size(), "a file has the size that the index says");
  const std::size_t half = unpacked.file.size() / 2;
  const Result<Bytes> rest = read_range(material, half, unpacked.file.size() - half);
  require(rest.ok() && std::ranges::equal(*rest, std::span(unpacked.file).subspan(half)), "a part is as in the whole");
  const MemorySource source(unpacked.file);
  if (const Result<SlicedReader> reader = SlicedReader::open(source)) {
    unpacked.sliced = reader->metadata().ok();
  }
  return unpacked;
}

/// What was unpacked is in a bundle that is made of it.
void repack(const std::vector<Unpacked>& all) {
  std::vector<BundleInput> inputs;
  for (const Unpacked& unpacked : all) inputs.push_back({unpacked.name, unpacked.file});
  const Result<Bytes> bundle = emit_bundle(inputs);
  require(bundle.ok(), "files that could be read can be packed");
  const MemorySource source(*bundle);
  const Result<BundleReader> reader = BundleReader::open(source);
  require(reader.ok(), "what was packed can be opened");
  for (const Unpacked& unpacked : all) {
    const auto material = reader->material(unpacked.name);
    require(material.ok() && read_whole(**material) == unpacked.file, "files come back bit for bit");
  }
}

void run(const Bytes& bytes) {
  const MemorySource source(bytes);
  const Result<BundleReader> reader = BundleReader::open(source);
  if (!reader) return;
  require(is_bundle(bytes), "what can be opened has the magic");
  std::vector<Unpacked> all;
  bool whole = true;
  for (const BundleEntry& entry : reader->entries()) {
    require(check_material_name(entry.name).ok(), "names are such as may be written");
    require(entry.offset + entry.bundled_size() <= bytes.size(), "materials lie within the file");
    require(reader->find(entry.name).ok(), "a name in the index is found");
    const auto material = reader->material(entry);
    if (material.ok()) all.push_back(unpack(entry, **material));
    whole = whole && material.ok() && all.back().sliced;
  }
  if (whole && all.size() <= kMostRepacked) repack(all);
}

}  // namespace
}  // namespace sbrdf::internal::fuzzing

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t max_size, unsigned seed) {
  const std::size_t mutated = LLVMFuzzerMutate(bytes, size, max_size);
  // One in eight keeps what does not fit.
  if (std::minstd_rand(seed)() % 8 == 0) return mutated;
  sbrdf::internal::fuzzing::Bytes mended = sbrdf::internal::fuzzing::copy_of(bytes, mutated);
  sbrdf::internal::fuzzing::mend(mended);
  std::memcpy(bytes, mended.data(), mutated);
  return mutated;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  sbrdf::internal::fuzzing::run(sbrdf::internal::fuzzing::copy_of(bytes, size));
  return 0;
}
