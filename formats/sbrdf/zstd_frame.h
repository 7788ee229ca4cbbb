#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace sbrdf::internal {

// Bytes as one zstd frame that states how many they are.

/// The smallest frame: a megabyte of texels takes 0.2 to 0.3 s.
inline constexpr int kZstdSmallest = 19;
/// Ten to twenty times as fast; smooth textures take 15 to 35 % more.
inline constexpr int kZstdQuick = 9;

[[nodiscard]] std::vector<std::byte> pack_bytes(std::span<const std::byte> bytes, int level = kZstdSmallest);

/// Nothing unless `packed` is one frame, and nothing behind it, that holds exactly `size` bytes.
[[nodiscard]] std::optional<std::vector<std::byte>> unpack_bytes(std::span<const std::byte> packed, std::size_t size);

}  // namespace sbrdf::internal
