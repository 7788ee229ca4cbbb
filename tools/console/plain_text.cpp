#include "tools/console/plain_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace sbrdf::internal {
namespace {

struct CodePoint {
  std::optional<char32_t> value;  ///< none: a byte that begins no character
  std::size_t size = 1;           ///< [bytes]
};

constexpr char32_t kSurrogates = 0xD800;
constexpr char32_t kPastSurrogates = 0xE000;
constexpr char32_t kLargest = 0x10FFFF;

/// The first character of text that is not empty. Longer codes than needed and halves of surrogate pairs are none: what
/// reads them may take them for something else than was checked.
CodePoint first_code_point(std::string_view text) {
  const auto byte = [text](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  constexpr std::array<char32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};  // by size
  if (lead < 0xC0 || lead >= 0xF8 || text.size() < size) return {};
  char32_t value = lead & (0x7FU >> size);
  for (std::size_t k = 1; k < size; ++k) {
    if ((byte(k) & 0xC0U) != 0x80) return {};
    value = (value << 6U) | (byte(k) & 0x3FU);
  }
  const bool half = value >= kSurrogates && value < kPastSurrogates;
  if (value < kLeast.at(size) || value > kLargest || half) return {};
  return {value, size};
}

struct Span {
  char32_t first, last;
};

/// Rising.
constexpr std::array<Span, 10> kControls = {{
    {0x00, 0x1F},        // C0
    {0x7F, 0x9F},        // DEL and C1
    {0x61C, 0x61C},      // Arabic letter mark
    {0x200E, 0x200F},    // left-to-right and right-to-left marks
    {0x2028, 0x202E},    // line and paragraph separators; bidirectional embeddings and overrides
    {0x2066, 0x206F},    // bidirectional isolates; deprecated format characters
    {0xFEFF, 0xFEFF},    // byte order mark
    {0xFFF9, 0xFFFB},    // interlinear annotations
    {0x1D173, 0x1D17A},  // musical beams and slurs, which have no shape of their own
    {0xE0000, 0xE0FFF},  // tags and variation selectors
}};

bool controls(char32_t value) {
  return std::any_of(kControls.begin(), kControls.end(),
                     [value](const Span& span) { return value >= span.first && value <= span.last; });
}

/// Calls `take` with each code point and its bytes until it returns false.
template <class Take>
void walk(std::string_view text, const Take& take) {
  while (!text.empty()) {
    const CodePoint point = first_code_point(text);
    if (!take(point, text.substr(0, point.size))) return;
    text.remove_prefix(point.size);
  }
}

std::string escaped(char32_t value) {
  if (value < 0x10000) return fmt::format("\\u{:04x}", static_cast<std::uint32_t>(value));
  const auto offset = static_cast<std::uint32_t>(value) - 0x10000U;
  return fmt::format("\\u{:04x}\\u{:04x}", 0xD800U + (offset >> 10U), 0xDC00U + (offset & 0x3FFU));
}

}  // namespace

std::string one_line(std::string_view text, std::size_t most) {
  std::string clean;
  std::size_t count = 0;
  std::size_t size_if_cut = 0;
  walk(text, [&](const CodePoint& point, std::string_view bytes) {
    if (count + 3 == most) size_if_cut = clean.size();
    if (count == most) {
      clean.resize(size_if_cut);
      clean += "...";
      return false;
    }
    ++count;
    clean += point.value && !controls(*point.value) ? bytes : "?";
    return true;
  });
  return clean;
}

std::string escape_controls(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  walk(json, [&](const CodePoint& point, std::string_view bytes) {
    if (point.value && *point.value > 0x1F && controls(*point.value)) {
      text += escaped(*point.value);
    } else {
      text += bytes;
    }
    return true;
  });
  return text;
}

std::size_t character_count(std::string_view text) {
  std::size_t count = 0;
  walk(text, [&](const CodePoint&, std::string_view) {
    ++count;
    return true;
  });
  return count;
}

}  // namespace sbrdf::internal
