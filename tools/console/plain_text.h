#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sbrdf::internal {

/// What is cut off [characters]: longer text is of no use on a terminal, and may be an attack on its reader.
inline constexpr std::size_t kMostCharacters = 2000;

/// Text from files, names and messages, as everything shows it to people: one line of valid UTF-8 that does nothing to
/// a terminal. Each control character (C0, DEL, C1), line or paragraph separator, character that turns or hides the
/// text around it (bidirectional controls, tags, annotations) and byte that is not UTF-8 becomes '?'. Text of more than
/// `most` characters ends with "..." in the place of the rest.
[[nodiscard]] std::string one_line(std::string_view text, std::size_t most = kMostCharacters);

/// JSON text with the same characters escaped as \uXXXX, apart from the spaces and line feeds between its parts. The
/// text must be valid JSON in UTF-8; what it means stays the same.
[[nodiscard]] std::string escape_controls(std::string_view json);

/// Code points, bytes that are no UTF-8 counted one by one: the columns that text takes, roughly.
[[nodiscard]] std::size_t character_count(std::string_view text);

}  // namespace sbrdf::internal
