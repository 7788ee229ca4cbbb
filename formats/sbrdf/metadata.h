#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sbrdf::internal {

/// What metadata usually say: the content that zstd may refer back to, specs/sbrdf.md, section 8. Never changes.
[[nodiscard]] std::string_view metadata_dictionary();

/// One zstd frame.
[[nodiscard]] std::vector<std::byte> pack_metadata(std::string_view text);

/// Nothing unless the frame holds exactly `size` bytes.
[[nodiscard]] std::optional<std::string> unpack_metadata(std::span<const std::byte> packed, std::size_t size);

}  // namespace sbrdf::internal
