#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// The container of a sliced BRDF file, specs/sbrdf.md: a head, which is a few bytes of header, an index and a checksum
// of both, and chunks that lie end to end. It knows nothing of what index and chunks hold.

inline constexpr std::array<std::uint8_t, 4> kContainerMagic = {0x89, 'S', 'B', 'F'};
inline constexpr std::uint8_t kContainerMajor = 1;
inline constexpr std::uint8_t kContainerMinor = 0;
inline constexpr std::uint32_t kMaxIndexSize = 1U << 25U;
inline constexpr std::size_t kChecksumSize = 4;

/// True when the magic is there, whatever follows.
[[nodiscard]] bool is_container(std::span<const std::byte> bytes);

/// CRC-32 as in zlib and PNG (reflected polynomial EDB88320 hex).
[[nodiscard]] std::uint32_t checksum(std::span<const std::byte> bytes);

/// Bytes of header, index and checksum, by the size of the index.
[[nodiscard]] std::uint64_t head_size_of(std::uint64_t index_size);

/// Header and index of a file, checked.
struct ContainerHead {
  std::uint8_t major = kContainerMajor;
  std::uint8_t minor = kContainerMinor;
  std::vector<std::byte> index;

  /// Where the first chunk begins [bytes from the start].
  [[nodiscard]] std::uint64_t chunks_offset() const { return head_size_of(index.size()); }
  [[nodiscard]] std::string version() const { return std::to_string(major) + "." + std::to_string(minor); }
};

/// Reads the head and nothing else. Refuses another magic [SB-1-1], a newer major version (kUnsupported, [SB-1-3]), a
/// file that ends within its head [SB-1-4], an index above 2^25 bytes [SB-1-5], a damaged head [SB-1-6].
[[nodiscard]] Result<ContainerHead> read_head(const ByteSource& source);

/// A chunk of `size` bytes, checksum included, at `offset`; gives its payload. [SB-1-7]
[[nodiscard]] Result<std::vector<std::byte>> read_chunk(const ByteSource& source, std::uint64_t offset,
                                                        std::uint64_t size);

/// Payload and checksum, appended to `file`. An empty payload is no chunk at all: nothing is appended.
void append_chunk(std::vector<std::byte>& file, std::span<const std::byte> payload);

/// A head with its checksum.
[[nodiscard]] std::vector<std::byte> emit_head(std::span<const std::byte> index, std::uint8_t major = kContainerMajor,
                                               std::uint8_t minor = kContainerMinor);
/// A whole file: the head, and the chunks as append_chunk made them.
[[nodiscard]] std::vector<std::byte> emit_container(std::span<const std::byte> index, std::span<const std::byte> chunks,
                                                    std::uint8_t major = kContainerMajor,
                                                    std::uint8_t minor = kContainerMinor);

}  // namespace sbrdf::internal
