#include "formats/sbrdf/container.h"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "formats/core/byte_reader.h"

namespace sbrdf {
namespace {

constexpr std::size_t kHeaderSize = 16;
constexpr std::size_t kEntrySize = 40;
constexpr std::uint32_t kMaxChunks = 4096;
constexpr int kZstdLevel = 19;
constexpr std::uint64_t kMaxRatio = 32'768;  // what a small file can make a reader allocate

enum class Coding : std::uint32_t { kRaw = 0, kZstd = 1 };

struct Entry {
  std::string name;
  Coding coding = Coding::kRaw;
  std::uint64_t offset = 0;
  std::uint64_t stored_size = 0;
  std::uint64_t decoded_size = 0;
  std::uint64_t checksum = 0;
};

std::uint64_t checksum(std::span<const std::byte> bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

Error invalid(std::string message, std::uint64_t offset) {
  return {ErrorCode::kInvalidFile, std::move(message), offset};
}

Result<Entry> parse_entry(ByteReader& in) {
  const std::uint64_t at = in.offset();
  Entry entry;
  entry.name = in.text(4);
  const std::uint32_t coding = in.u32();
  entry.offset = in.u64();
  entry.stored_size = in.u64();
  entry.decoded_size = in.u64();
  entry.checksum = in.u64();
  if (!in.ok()) return in.error();
  if (coding > 1) {
    return Error{ErrorCode::kUnsupported, "chunk " + entry.name + ": unknown coding " + std::to_string(coding), at + 4};
  }
  const auto visible = [](char c) { return c > ' ' && c <= '~'; };
  if (!std::all_of(entry.name.begin(), entry.name.end(), visible)) {
    return invalid("the name of a chunk is not four visible characters", at);
  }
  entry.coding = static_cast<Coding>(coding);
  if (entry.decoded_size > kMaxChunkSize) return invalid("chunk " + entry.name + ": larger than 2^30 bytes", at + 24);
  if (entry.decoded_size / kMaxRatio > entry.stored_size) {
    return invalid("chunk " + entry.name + ": decodes to more than 32,768 times its size", at + 24);
  }
  if (entry.coding == Coding::kRaw && entry.decoded_size != entry.stored_size) {
    return invalid("chunk " + entry.name + ": raw, but its sizes differ", at + 16);
  }
  return entry;
}

Result<Chunk> decode(const Entry& entry, std::span<const std::byte> stored) {
  if (checksum(stored) != entry.checksum) {
    return invalid("chunk " + entry.name + ": checksum does not match", entry.offset);
  }
  Chunk chunk{entry.name, {}};
  if (entry.coding == Coding::kRaw) {
    chunk.bytes.assign(stored.begin(), stored.end());
    return chunk;
  }
  if (ZSTD_getFrameContentSize(stored.data(), stored.size()) != entry.decoded_size) {
    return invalid("chunk " + entry.name + ": zstd frame of another size", entry.offset);
  }
  chunk.bytes.resize(entry.decoded_size);
  const std::size_t size = ZSTD_decompress(chunk.bytes.data(), chunk.bytes.size(), stored.data(), stored.size());
  if (ZSTD_isError(size) != 0 || size != entry.decoded_size) {
    return invalid("chunk " + entry.name + ": zstd frame does not decode", entry.offset);
  }
  return chunk;
}

}  // namespace

std::span<const std::byte> Container::find(std::string_view name) const {
  const auto found = std::find_if(chunks.begin(), chunks.end(), [&](const Chunk& chunk) { return chunk.name == name; });
  return found == chunks.end() ? std::span<const std::byte>() : std::span<const std::byte>(found->bytes);
}

bool Container::has(std::string_view name) const {
  return std::any_of(chunks.begin(), chunks.end(), [&](const Chunk& chunk) { return chunk.name == name; });
}

bool is_container(std::span<const std::byte> bytes) {
  return bytes.size() >= kContainerMagic.size() &&
         std::memcmp(bytes.data(), kContainerMagic.data(), kContainerMagic.size()) == 0;
}

Result<Container> parse_container(std::span<const std::byte> bytes) {
  if (!is_container(bytes)) return invalid("not a sliced BRDF file: wrong magic", 0);
  ByteReader in(bytes);
  in.bytes(kContainerMagic.size());
  Container container;
  container.major = in.u16();
  container.minor = in.u16();
  const std::uint32_t count = in.u32();
  if (!in.ok()) return in.error();
  if (container.major > kContainerMajor) {
    return Error{ErrorCode::kUnsupported,
                 "version " + std::to_string(container.major) + "." + std::to_string(container.minor) +
                     " is newer than this program, which reads up to major version " + std::to_string(kContainerMajor),
                 8};
  }
  if (count > kMaxChunks) return invalid(std::to_string(count) + " chunks; at most 4096 are allowed", 12);
  const std::size_t table_size = kHeaderSize + count * kEntrySize;
  // Before any entry is believed: damage is damage, whatever it looks like.
  ByteReader ahead(bytes);
  const std::uint64_t expected = checksum(ahead.bytes(table_size));
  const std::uint64_t stated = ahead.u64();
  if (!ahead.ok()) return ahead.error();
  if (stated != expected) return invalid("header checksum does not match", table_size);
  std::vector<Entry> entries;
  std::uint64_t decoded_size = 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    Result<Entry> entry = parse_entry(in);
    if (!entry) return entry.error();
    const auto same_name = [&](const Entry& other) { return other.name == entry->name; };
    if (std::any_of(entries.begin(), entries.end(), same_name)) {
      return invalid("two chunks " + entry->name, kHeaderSize + k * kEntrySize);
    }
    decoded_size += entry->decoded_size;
    if (decoded_size > kMaxChunkSize)
      return invalid("the chunks decode to more than 2^30 bytes", kHeaderSize + k * kEntrySize);
    entries.push_back(*std::move(entry));
  }
  in.u64();  // the checksum
  for (const Entry& entry : entries) {
    if (entry.offset != in.offset())
      return invalid("chunk " + entry.name + " is not where the last one ends", in.offset());
    const auto stored = in.bytes(entry.stored_size);
    if (!in.ok()) return in.error();
    Result<Chunk> chunk = decode(entry, stored);
    if (!chunk) return chunk.error();
    container.chunks.push_back(*std::move(chunk));
  }
  if (in.remaining() != 0) return invalid(std::to_string(in.remaining()) + " bytes after the last chunk", in.offset());
  return container;
}

std::vector<std::byte> emit_container(std::span<const Chunk> chunks) {
  std::vector<std::vector<std::byte>> stored;
  for (const Chunk& chunk : chunks) {
    std::vector<std::byte> packed(ZSTD_compressBound(chunk.bytes.size()));
    const std::size_t size =
        ZSTD_compress(packed.data(), packed.size(), chunk.bytes.data(), chunk.bytes.size(), kZstdLevel);
    const bool smaller = ZSTD_isError(size) == 0 && size < chunk.bytes.size();
    packed.resize(smaller ? size : 0);
    stored.push_back(smaller ? std::move(packed) : chunk.bytes);
  }
  ByteWriter out;
  out.bytes(std::as_bytes(std::span(kContainerMagic)));
  out.number(kContainerMajor);
  out.number(kContainerMinor);
  out.number(static_cast<std::uint32_t>(chunks.size()));
  std::uint64_t offset = kHeaderSize + chunks.size() * kEntrySize + sizeof(std::uint64_t);
  for (std::size_t k = 0; k < chunks.size(); ++k) {
    const Coding coding = stored[k].size() < chunks[k].bytes.size() ? Coding::kZstd : Coding::kRaw;
    out.text(chunks[k].name);
    out.number(static_cast<std::uint32_t>(coding));
    out.number(offset);
    out.number(static_cast<std::uint64_t>(stored[k].size()));
    out.number(static_cast<std::uint64_t>(chunks[k].bytes.size()));
    out.number(checksum(stored[k]));
    offset += stored[k].size();
  }
  const std::vector<std::byte> table = std::move(out).take();
  ByteWriter file;
  file.bytes(table);
  file.number(checksum(table));
  for (const auto& block : stored) file.bytes(block);
  return std::move(file).take();
}

}  // namespace sbrdf
