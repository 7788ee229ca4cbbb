#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf {

// The container of a sliced BRDF file, specs/sbrdf.md: a header with a table of chunks, then the chunks one after the
// other. It knows nothing of what is in them.

inline constexpr std::array<std::uint8_t, 8> kContainerMagic = {0x89, 'S', 'B', 'R', 'D', 'F', 0x0D, 0x0A};
inline constexpr std::uint16_t kContainerMajor = 0;
inline constexpr std::uint16_t kContainerMinor = 1;
/// All chunks together decode to no more than this many bytes.
inline constexpr std::uint64_t kMaxChunkSize = 1ULL << 30U;

/// One chunk, decoded. `name` has four ASCII characters.
struct Chunk {
  std::string name;
  std::vector<std::byte> bytes;
};

struct Container {
  std::uint16_t major = kContainerMajor;
  std::uint16_t minor = kContainerMinor;
  std::vector<Chunk> chunks;

  /// The bytes of the first chunk of that name; an empty span with no such chunk is told apart by `has`.
  [[nodiscard]] std::span<const std::byte> find(std::string_view name) const;
  [[nodiscard]] bool has(std::string_view name) const;
};

/// True when the magic is there, whatever follows.
[[nodiscard]] bool is_container(std::span<const std::byte> bytes);

/// Refuses wrong magic, a newer major version (kUnsupported), a damaged table or chunk (XXH3-64 checksums over both),
/// chunks that are not laid end to end, every truncated prefix and every trailing byte.
[[nodiscard]] Result<Container> parse_container(std::span<const std::byte> bytes);

/// Chunks are compressed with zstd where that makes them smaller. The same chunks give the same bytes.
[[nodiscard]] std::vector<std::byte> emit_container(std::span<const Chunk> chunks);

}  // namespace sbrdf
