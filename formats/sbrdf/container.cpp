#include "formats/sbrdf/container.h"

#include <zlib.h>

#include <cstring>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kVersionEnd = kContainerMagic.size() + 2;
constexpr unsigned kSizeBits = 28;  // of index_size: four bytes at most
constexpr std::size_t kMostHeader = kVersionEnd + kSizeBits / 7;

std::vector<std::byte> emit_header(std::uint64_t index_size, std::uint8_t major, std::uint8_t minor) {
  ByteWriter out;
  out.bytes(std::as_bytes(std::span(kContainerMagic)));
  out.number(major);
  out.number(minor);
  out.count(index_size);
  return std::move(out).take();
}

}  // namespace

bool is_container(std::span<const std::byte> bytes) {
  return bytes.size() >= kContainerMagic.size() &&
         std::memcmp(bytes.data(), kContainerMagic.data(), kContainerMagic.size()) == 0;
}

std::uint32_t checksum(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::uint64_t head_size_of(std::uint64_t index_size) {
  return emit_header(index_size, kContainerMajor, kContainerMinor).size() + index_size + kChecksumSize;
}

Result<ContainerHead> read_head(const ByteSource& source) {
  const Result<std::vector<std::byte>> start = read_start(source, kMostHeader);
  if (!start) return start.error();
  if (!is_container(*start)) return invalid_file("[SB-1-1] not a sliced BRDF file: wrong magic", 0);
  const Error truncated = invalid_file("[SB-1-4] truncated: the file ends within its head", source.size());
  ByteReader in(*start);
  in.bytes(kContainerMagic.size());
  ContainerHead head;
  head.major = in.u8();
  head.minor = in.u8();
  if (!in.ok()) return truncated;
  // First of all: what follows may mean something else in another version.
  if (head.major > kContainerMajor || head.major == 0) {
    return Error{ErrorCode::kUnsupported,
                 "[SB-1-3] version " + head.version() + " of the format; this program reads version 1", 4};
  }
  const std::uint64_t index_size = in.count(kSizeBits);
  if (!in.ok() && start->size() < kMostHeader) return truncated;
  if (!in.ok() || index_size > kMaxIndexSize) return invalid_file("[SB-1-5] an index of more than 2^25 bytes", 6);
  const std::uint64_t head_size = in.offset() + index_size + kChecksumSize;
  if (head_size > source.size()) return truncated;
  // What was read already is not read again.
  std::vector<std::byte> bytes = *start;
  bytes.resize(static_cast<std::size_t>(head_size));
  if (head_size > start->size()) {
    if (Status read = source.read(start->size(), std::span(bytes).subspan(start->size())); !read) return read.error();
  }
  const std::size_t checked = bytes.size() - kChecksumSize;
  ByteReader end(std::span<const std::byte>(bytes).subspan(checked));
  if (checksum(std::span(bytes).first(checked)) != end.u32()) {
    return invalid_file("[SB-1-6] header or index are damaged: their checksum does not match", checked);
  }
  bytes.resize(checked);
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(in.offset()));
  head.index = std::move(bytes);
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

std::vector<std::byte> emit_head(std::span<const std::byte> index, std::uint8_t major, std::uint8_t minor) {
  std::vector<std::byte> head = emit_header(index.size(), major, minor);
  head.insert(head.end(), index.begin(), index.end());
  std::vector<std::byte> sealed;
  append_chunk(sealed, head);
  return sealed;
}

std::vector<std::byte> emit_container(std::span<const std::byte> index, std::span<const std::byte> chunks,
                                      std::uint8_t major, std::uint8_t minor) {
  std::vector<std::byte> file = emit_head(index, major, minor);
  file.insert(file.end(), chunks.begin(), chunks.end());
  return file;
}

}  // namespace sbrdf::internal
