#include "formats/sbrdf/container.h"

#include <zlib.h>

#include <cstring>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kHeaderChecked = kHeaderSize - kChecksumSize;  // the header's own checksum stands at its end

}  // namespace

bool is_container(std::span<const std::byte> bytes) {
  return bytes.size() >= kContainerMagic.size() &&
         std::memcmp(bytes.data(), kContainerMagic.data(), kContainerMagic.size()) == 0;
}

std::uint32_t checksum(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

Result<ContainerHead> read_head(const ByteSource& source) {
  Result<std::vector<std::byte>> header = read_range(source, 0, std::min<std::uint64_t>(kHeaderSize, source.size()));
  if (!header) return header.error();
  if (!is_container(*header)) return invalid_file("[SB-1-1] not a sliced BRDF file: wrong magic", 0);
  ByteReader in(*header);
  in.bytes(kContainerMagic.size());
  ContainerHead head;
  head.major = in.u16();
  head.minor = in.u16();
  const std::uint32_t index_size = in.u32();
  const std::uint64_t file_size = in.u64();
  const std::uint32_t index_checksum = in.u32();
  const std::uint32_t header_checksum = in.u32();
  if (!in.ok()) return invalid_file("[SB-1-4] truncated: the header has 32 bytes", source.size());
  // First of all: what follows may mean something else in another version.
  if (head.major > kContainerMajor || head.major == 0) {
    return Error{ErrorCode::kUnsupported,
                 "[SB-1-3] version " + head.version() + " of the format; this program reads version 1", 8};
  }
  if (checksum(std::span(*header).first(kHeaderChecked)) != header_checksum) {
    return invalid_file("[SB-1-2] the header is damaged: its checksum does not match", kHeaderChecked);
  }
  if (file_size != source.size()) {
    return invalid_file("[SB-1-4] the file has " + std::to_string(source.size()) + " bytes, its header says " +
                            std::to_string(file_size),
                        16);
  }
  if (index_size > kMaxIndexSize || index_size > file_size - kHeaderSize) {
    return invalid_file("[SB-1-5] an index of " + std::to_string(index_size) + " bytes does not fit", 12);
  }
  Result<std::vector<std::byte>> index = read_range(source, kHeaderSize, index_size);
  if (!index) return index.error();
  if (checksum(*index) != index_checksum) {
    return invalid_file("[SB-1-6] the index is damaged: its checksum does not match", kHeaderSize);
  }
  head.index = *std::move(index);
  return head;
}

Result<std::vector<std::byte>> read_chunk(const ByteSource& source, std::uint64_t offset, std::uint64_t size) {
  Result<std::vector<std::byte>> bytes = read_range(source, offset, size);
  if (!bytes) return bytes;
  if (bytes->size() <= kChecksumSize) return invalid_file("[SB-1-7] a chunk without content", offset);
  const std::size_t payload = bytes->size() - kChecksumSize;
  const std::span<const std::byte> all(*bytes);
  ByteReader end(all.subspan(payload));
  if (checksum(all.first(payload)) != end.u32()) {
    return invalid_file("[SB-1-7] a chunk is damaged: its checksum does not match", offset);
  }
  bytes->resize(payload);
  return bytes;
}

void append_chunk(std::vector<std::byte>& file, std::span<const std::byte> payload) {
  if (payload.empty()) return;
  ByteWriter out;
  out.bytes(payload);
  out.number(checksum(payload));
  const std::vector<std::byte> bytes = std::move(out).take();
  file.insert(file.end(), bytes.begin(), bytes.end());
}

std::vector<std::byte> emit_container(std::span<const std::byte> index, std::span<const std::byte> chunks,
                                      std::uint16_t major, std::uint16_t minor) {
  ByteWriter out;
  out.bytes(std::as_bytes(std::span(kContainerMagic)));
  out.number(major);
  out.number(minor);
  out.number(static_cast<std::uint32_t>(index.size()));
  out.number(static_cast<std::uint64_t>(kHeaderSize + index.size() + chunks.size()));
  out.number(checksum(index));
  std::vector<std::byte> header = std::move(out).take();
  ByteWriter file;
  file.bytes(header);
  file.number(checksum(header));
  file.bytes(index);
  file.bytes(chunks);
  return std::move(file).take();
}

}  // namespace sbrdf::internal
