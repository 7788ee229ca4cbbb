#include "formats/core/text_lines.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace sbrdf::internal {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kBlanks = " \t";
/// What is shown of a field in a message.
constexpr std::size_t kShown = 40;

// A number that is out of the range of its type is 0 or infinite; which of them, its exponent tells.
bool is_tiny(std::string_view text) {
  const std::size_t at = text.find_first_of("eE");
  return at == std::string_view::npos ? text.find_first_of("123456789") > text.find('.')
                                      : at + 1 < text.size() && text[at + 1] == '-';
}

template <class T>
FieldNumber read(std::string_view text) {
  using Kind = FieldNumber::Kind;
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = !text.empty() && end == text.data() + text.size();
  if (whole && error == std::errc::result_out_of_range) {
    return is_tiny(text) ? FieldNumber{Kind::kFinite, 0} : FieldNumber{Kind::kInfinite, 0};
  }
  if (!whole || error != std::errc()) return {};
  if (std::isfinite(value)) return {Kind::kFinite, value};
  return {std::isnan(value) ? Kind::kNan : Kind::kInfinite, 0};
}

}  // namespace

LineWalker::LineWalker(std::string_view text) : text_(text) {
  if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
}

std::optional<TextLine> LineWalker::next() {
  if (at_ >= text_.size()) return std::nullopt;
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  TextLine line = {text_.substr(at_, end - at_), ++number_, at_};
  if (line.text.ends_with('\r')) line.text.remove_suffix(1);
  at_ = end + 1;
  return line;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

Separator separator_of(std::string_view line) {
  if (line.find(';') != std::string_view::npos) return Separator::kSemicolon;
  return line.find(',') != std::string_view::npos ? Separator::kComma : Separator::kBlanks;
}

void split_fields(std::string_view line, Separator separator, std::vector<std::string_view>& fields) {
  fields.clear();
  if (separator != Separator::kBlanks) {
    while (true) {
      const std::size_t end = std::min(line.find(static_cast<char>(separator)), line.size());
      fields.push_back(trimmed(line.substr(0, end)));
      if (end == line.size()) return;
      line.remove_prefix(end + 1);
    }
  }
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    if (line.empty()) return;
    const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
    fields.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

FieldNumber read_field(std::string_view field) { return read<double>(field); }
FieldNumber read_float_field(std::string_view field) { return read<float>(field); }

std::string field_text(std::string_view field) {
  std::string text(field.substr(0, kShown));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return field.size() > kShown ? text + "..." : text;
}

}  // namespace sbrdf::internal
