#include "converters/files/options.h"

#include <fmt/format.h>

#include <algorithm>

#include "formats/core/numbers.h"

namespace sbrdf::internal {
namespace {

std::string describe(const Range& range) {
  if (range.open) {
    const std::string least = fmt::format("greater than {:g}", range.least);
    return range.most == Range().most ? least : least + fmt::format(" and at most {:g}", range.most);
  }
  if (range.most == Range().most) return fmt::format("at least {:g}", range.least);
  return fmt::format("{:g} to {:g}", range.least, range.most);
}

template <class T>
Status without_value(const Result<T>& result) {
  return result ? ok_status() : Status(result.error());
}

Status check_choice(const OptionSpec& option, std::string_view text) {
  if (std::find(option.choices.begin(), option.choices.end(), text) != option.choices.end()) return ok_status();
  return usage_error(fmt::format("'{}' is none of {}", text, fmt::join(option.choices, ", ")));
}

Status check_text(const OptionSpec& option, std::string_view text) {
  switch (option.kind) {
    case OptionKind::kNumber:
      return without_value(number_within(text, option.range));
    case OptionKind::kCount:
      return without_value(count_within(text, option.counts));
    case OptionKind::kChoice:
      return check_choice(option, text);
    case OptionKind::kFlag:
      return text.empty() ? ok_status() : Status(usage_error(fmt::format("takes no value, such as '{}'", text)));
    case OptionKind::kText:
      break;
  }
  return option.check == nullptr ? ok_status() : option.check(text);
}

bool has_use(const OptionSpec& option, OptionUse use) {
  return option.use == use || option.use == OptionUse::kBoth || use == OptionUse::kBoth;
}

}  // namespace

Result<double> number_within(std::string_view text, const Range& range) {
  const std::optional<double> number = parse_number(text);
  if (!number && is_out_of_range<double>(text)) {
    return usage_error(fmt::format("{} is too large for a number, or too close to 0", text));
  }
  if (!number) return usage_error(fmt::format("'{}' is not a decimal number", text));
  const bool enough = range.open ? *number > range.least : *number >= range.least;
  if (enough && *number <= range.most) return *number + 0.0;  // -0 becomes 0
  return usage_error(fmt::format("{} is out of range; it must be {}", text, describe(range)));
}

Result<std::uint64_t> count_within(std::string_view text, const CountRange& range) {
  const std::optional<std::uint64_t> count = parse_count(text);
  if (!count && !is_out_of_range<std::uint64_t>(text)) {
    return usage_error(fmt::format("'{}' is not a whole number of 0 or more in decimal digits", text));
  }
  if (count && *count >= range.least && *count <= range.most) return *count;
  return usage_error(fmt::format("{} is out of range; it must be {} to {}", text, range.least, range.most));
}

Status check_value(const OptionSpec& option, std::string_view text) {
  Status checked = check_text(option, text);
  if (checked) return checked;
  return usage_error(fmt::format("--{}: {}", option.name, checked.error().message));
}

Options& Options::set(std::string name, std::string text) {
  const auto same = [&](const auto& given) { return given.first == name; };
  const auto at = std::find_if(given_.begin(), given_.end(), same);
  if (at != given_.end()) {
    at->second = std::move(text);
  } else {
    given_.emplace_back(std::move(name), std::move(text));
  }
  return *this;
}

std::optional<std::string> Options::text(std::string_view name) const {
  for (const auto& [given, text] : given_) {
    if (given == name) return text;
  }
  return std::nullopt;
}

std::optional<double> Options::number(std::string_view name) const {
  const std::optional<std::string> given = text(name);
  return given ? parse_number(*given) : std::nullopt;
}

std::optional<std::uint64_t> Options::count(std::string_view name) const {
  const std::optional<std::string> given = text(name);
  return given ? parse_count(*given) : std::nullopt;
}

Options Options::select(std::span<const OptionSpec> declared, OptionUse use) const {
  Options selected;
  selected.provenance = provenance;
  selected.memory = memory;
  for (const auto& [name, text] : given_) {
    if (find_option(declared, name, use) != nullptr) selected.set(name, text);
  }
  return selected;
}

const OptionSpec* find_option(std::span<const OptionSpec> declared, std::string_view name, OptionUse use) {
  const auto found = std::find_if(declared.begin(), declared.end(), [&](const OptionSpec& option) {
    return option.name == name && has_use(option, use);
  });
  return found == declared.end() ? nullptr : &*found;
}

Status check_options(const Options& options, std::span<const OptionSpec> declared, OptionUse use,
                     std::string_view whose) {
  for (const auto& [name, text] : options.all()) {
    const OptionSpec* option = find_option(declared, name, use);
    if (option == nullptr) return usage_error(fmt::format("--{} is no option of {}", name, whose));
    if (Status checked = check_value(*option, text); !checked) return checked;
  }
  return ok_status();
}

}  // namespace sbrdf::internal
