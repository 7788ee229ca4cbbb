#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace sbrdf::internal {

// Bytes as one zstd frame that states how many they are.

[[nodiscard]] std::vector<std::byte> pack_bytes(std::span<const std::byte> bytes);

/// Nothing unless `packed` is one frame, and nothing behind it, that holds exactly `size` bytes.
[[nodiscard]] std::optional<std::vector<std::byte>> unpack_bytes(std::span<const std::byte> packed, std::size_t size);

}  // namespace sbrdf::internal
