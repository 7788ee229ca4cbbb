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

// The container of a sliced BRDF file, specs/sbrdf.md: a header, an index, and chunks that lie end to end. It knows
// nothing of what the chunks hold.

inline constexpr std::array<std::uint8_t, 8> kContainerMagic = {0x89, 'S', 'B', 'R', 'D', 'F', 0x0D, 0x0A};
inline constexpr std::uint16_t kContainerMajor = 1;
inline constexpr std::uint16_t kContainerMinor = 0;
inline constexpr std::size_t kHeaderSize = 32;
inline constexpr std::uint32_t kMaxIndexSize = 1U << 24U;
inline constexpr std::size_t kChecksumSize = 4;

/// True when the magic is there, whatever follows.
[[nodiscard]] bool is_container(std::span<const std::byte> bytes);

/// CRC-32 as in zlib and PNG (reflected polynomial EDB88320 hex).
[[nodiscard]] std::uint32_t checksum(std::span<const std::byte> bytes);

/// Header and index of a file, checked.
struct ContainerHead {
  std::uint16_t major = kContainerMajor;
  std::uint16_t minor = kContainerMinor;
  std::vector<std::byte> index;

  /// Where the first chunk begins [bytes from the start].
  [[nodiscard]] std::uint64_t chunks_offset() const { return kHeaderSize + index.size(); }
  [[nodiscard]] std::string version() const { return std::to_string(major) + "." + std::to_string(minor); }
};

/// Reads header and index and nothing else. Refuses another magic [SB-1-1], a newer major version (kUnsupported,
/// [SB-1-3]), a damaged header [SB-1-2], a file of another size than it says [SB-1-4], an index above 2^24 bytes or
/// damaged [SB-1-5], [SB-1-6].
[[nodiscard]] Result<ContainerHead> read_head(const ByteSource& source);

/// A chunk of `size` bytes, checksum included, at `offset`; gives its payload. [SB-1-7]
[[nodiscard]] Result<std::vector<std::byte>> read_chunk(const ByteSource& source, std::uint64_t offset,
                                                        std::uint64_t size);

/// Payload and checksum, appended to `file`. An empty payload is no chunk at all: nothing is appended.
void append_chunk(std::vector<std::byte>& file, std::span<const std::byte> payload);

/// A whole file: header, index, and the chunks as append_chunk made them.
[[nodiscard]] std::vector<std::byte> emit_container(std::span<const std::byte> index, std::span<const std::byte> chunks,
                                                    std::uint16_t major = kContainerMajor,
                                                    std::uint16_t minor = kContainerMinor);

}  // namespace sbrdf::internal
