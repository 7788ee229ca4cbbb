#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace sbrdf::internal {

// Files that nobody means to convert but many people have: the reader of MERL tables would call them damaged tables.

/// What a file is that is certainly no BRDF but turns up among downloads: a web page instead of the file that was
/// meant, a pointer to it, or the file within an archive. With an article: "a web page (HTML)". Nothing otherwise.
/// `head` as in Format.
[[nodiscard]] std::optional<std::string_view> name_foreign(std::span<const std::byte> head);

/// For the same message: "a text file". Bytes above 127 count as letters, whatever their encoding. Nothing in the head
/// is a control character other than the white space of text.
[[nodiscard]] bool is_text(std::span<const std::byte> head);

}  // namespace sbrdf::internal
