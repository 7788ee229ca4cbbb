#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

// Measurements written as text: lines, and fields of a line. Nothing is copied.

/// One line of a text, without its end.
struct TextLine {
  std::string_view text;
  std::uint64_t number = 0;  ///< from 1
  std::uint64_t offset = 0;  ///< of its first character [bytes]
};

/// Longest line that is read [bytes]: 31 wavelengths take some 700.
inline constexpr std::size_t kLongestLine = std::size_t{1} << 20U;

/// Walks over the lines of a text: "\n" and "\r\n" end one, and so does the end of the text. A byte order mark at the
/// beginning is left out.
class LineWalker {
 public:
  explicit LineWalker(std::string_view text);

  /// The next line; nothing behind the last.
  [[nodiscard]] std::optional<TextLine> next();

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::uint64_t number_ = 0;
};

/// Without blanks and tabs at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// How fields are kept apart: by ';', by ',' or by blanks and tabs, whichever of these a line holds first in this
/// order.
enum class Separator : char { kSemicolon = ';', kComma = ',', kBlanks = ' ' };
[[nodiscard]] Separator separator_of(std::string_view line);

/// The fields of a line, trimmed: `fields` is emptied before. A separator that is no blank makes a field on each side,
/// which may be empty.
void split_fields(std::string_view line, Separator separator, std::vector<std::string_view>& fields);

/// What a field of a table holds: a number in decimal notation, finite or not.
struct FieldNumber {
  enum class Kind : std::uint8_t {
    kFinite,
    kNan,       ///< "nan", in any letter case
    kInfinite,  ///< "inf" and the like, or a number that is too large for its type
    kNone       ///< no number
  };
  Kind kind = Kind::kNone;
  double value = 0;  ///< of kFinite. What is closer to 0 than any number of the type becomes 0.
};
[[nodiscard]] FieldNumber read_field(std::string_view field);
/// The same as a 32-bit float, rounded once.
[[nodiscard]] FieldNumber read_float_field(std::string_view field);

/// For messages: at most 40 characters of a field, those that are not printable as '?'.
[[nodiscard]] std::string field_text(std::string_view field);

}  // namespace sbrdf::internal
