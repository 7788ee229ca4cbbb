#include "formats/table/number_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace sbrdf::internal {
namespace {

using Fields = std::vector<std::string_view>;

bool is_comment(std::string_view line) { return line.starts_with('#') || line.starts_with('%'); }

bool is_number(std::string_view field) { return read_field(field).kind != FieldNumber::Kind::kNone; }

bool names_angle(std::string_view field) {
  return field.find("theta") != std::string_view::npos || field.find("Theta") != std::string_view::npos;
}

// Wavelengths may stand beside names.
bool are_names(const Fields& fields) {
  return std::none_of(fields.begin(), fields.end(), is_number) ||
         std::any_of(fields.begin(), fields.end(), names_angle);
}

Error wrong(const TextLine& line, std::string_view what) {
  return invalid_file(fmt::format("line {}: {}", line.number, what), line.offset);
}

/// Walks over the lines that hold something.
class RowReader {
 public:
  explicit RowReader(std::string_view text) : lines_(text) {}

  Result<NumberTable> read() {
    while (const std::optional<TextLine> line = lines_.next()) {
      if (line->text.size() > kLongestLine) return wrong(*line, "longer than 2^20 characters");
      const std::string_view text = trimmed(line->text);
      if (text.empty()) continue;
      if (is_comment(text)) {
        if (table_.lines.empty()) comment_ = text.substr(1);
        continue;
      }
      if (Status taken = take(*line, text); !taken) return taken.error();
    }
    if (table_.lines.empty()) return invalid_file("no line of numbers");
    return std::move(table_);
  }

 private:
  Status take(const TextLine& line, std::string_view text) {
    if (!table_.lines.empty()) return take_row(line, text);
    separator_ = separator_of(text);
    split_fields(text, separator_, fields_);
    if (fields_.size() > kMostNumberColumns)
      return unsupported(fmt::format("more than {} columns", kMostNumberColumns));
    if (!are_names(fields_) || !names_.empty()) return take_first_row(line, text);
    names_ = text;
    return ok_status();
  }

  Status take_first_row(const TextLine& line, std::string_view text) {
    table_.column_count = fields_.size();
    if (!names_.empty()) {
      table_.names = names_of_line(names_);
      if (table_.names.empty()) {
        return wrong(line, fmt::format("{} fields below a line of names that has others", table_.column_count));
      }
    }
    table_.comment_names = names_of_line(comment_);
    return take_row(line, text);
  }

  std::vector<std::string> names_of_line(std::string_view text) {
    Fields names;
    split_fields(trimmed(text), separator_, names);
    if (names.size() != table_.column_count) return {};
    return {names.begin(), names.end()};
  }

  Status take_row(const TextLine& line, std::string_view text) {
    split_fields(text, separator_, fields_);
    if (fields_.size() != table_.column_count) {
      return wrong(line, fmt::format("{} fields instead of {}", fields_.size(), table_.column_count));
    }
    for (std::size_t k = 0; k < fields_.size(); ++k) {
      const FieldNumber number = read_field(fields_[k]);
      if (number.kind != FieldNumber::Kind::kFinite) {
        return wrong(line, fmt::format("column {} is '{}', {}", k + 1, field_text(fields_[k]),
                                       number.kind == FieldNumber::Kind::kNone ? "no number" : "not finite"));
      }
      table_.numbers.push_back(number.value);
    }
    table_.lines.push_back(line.number);
    return ok_status();
  }

  LineWalker lines_;
  NumberTable table_;
  Separator separator_ = Separator::kBlanks;
  std::string_view names_;
  std::string_view comment_;
  Fields fields_;
};

// Of a line that may be cut off, the last field says nothing.
bool is_row(std::string_view text, bool cut) {
  Fields fields;
  split_fields(text, separator_of(text), fields);
  if (cut && !fields.empty()) fields.pop_back();
  return fields.size() >= kFewestNumberColumns && std::all_of(fields.begin(), fields.end(), is_number);
}

bool may_be_names(std::string_view text) {
  if (text.starts_with('{') || text.starts_with('[') || text.starts_with('<')) return false;
  Fields fields;
  split_fields(text, separator_of(text), fields);
  return fields.size() >= kFewestNumberColumns && are_names(fields);
}

}  // namespace

NumberTableLook look_at_number_table(std::string_view head, bool whole) {
  LineWalker lines(head);
  bool names = false;
  bool likely = false;  // comments, or names of angles
  while (const std::optional<TextLine> line = lines.next()) {
    const std::string_view text = trimmed(line->text);
    if (text.empty()) continue;
    if (is_comment(text)) {
      likely = true;
      continue;
    }
    const bool cut = !whole && line->offset + line->text.size() >= head.size();
    if (is_row(text, cut)) return NumberTableLook::kTable;
    const bool second = std::exchange(names, true);
    if (cut && second) break;
    if (second || !may_be_names(text)) return NumberTableLook::kNone;
    likely = names_angle(text);
  }
  return likely && !whole ? NumberTableLook::kComments : NumberTableLook::kNone;
}

Result<NumberTable> parse_number_table(std::string_view text) { return RowReader(text).read(); }

}  // namespace sbrdf::internal
