#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sbrdf::internal {

/// What metadata usually say, which packed ones may refer back to, specs/sbrdf.md, section 8. Never changes.
[[nodiscard]] std::string_view metadata_dictionary();

/// As raw DEFLATE data.
[[nodiscard]] std::vector<std::byte> pack_metadata(std::string_view text);

/// Nothing unless the data hold exactly `size` bytes and end where `packed` does.
[[nodiscard]] std::optional<std::string> unpack_metadata(std::span<const std::byte> packed, std::size_t size);

}  // namespace sbrdf::internal
