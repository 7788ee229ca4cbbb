#include "tools/console/format_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "tools/console/options.h"

namespace sbrdf::internal {
namespace {

const Format* first_that_reads_with(std::string_view name) {
  const auto found =
      std::find_if(formats().begin(), formats().end(), [&](const Format& format) { return reads_with(format, name); });
  return found == formats().end() ? nullptr : &*found;
}

void add_option(CLI::App& command, const OptionSpec& option, const std::string& group, Options& given) {
  const std::string flag = fmt::format("--{}", option.name);
  const auto take = [&option, &given](const std::string& text) {
    if (Status checked = check_value(option, text); !checked) throw CLI::ValidationError(checked.error().message);
    given.set(std::string(option.name), text);
  };
  const std::string meaning(option.meaning);
  if (option.kind == OptionKind::kFlag) {
    command
        .add_flag_callback(
            flag, [take] { take(""); }, meaning)
        ->group(group);
    return;
  }
  const bool chosen = option.kind == OptionKind::kChoice;
  command.add_option_function<std::string>(flag, take, meaning)
      ->type_name(chosen ? fmt::format("{}", fmt::join(option.choices, "|")) : std::string(option.unit))
      ->default_str(std::string(option.fallback))
      ->group(group);
}

}  // namespace

void add_format_options(CLI::App& command, Options& given) {
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      if (find_format_with(option.name) != &format) continue;
      const bool read_only = option.use == OptionUse::kRead;
      add_option(command, option, fmt::format("For {} files{}", format.extension, read_only ? " as IN" : ""), given);
    }
  }
}

void add_reading_options(CLI::App& command, Options& given) {
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      if (first_that_reads_with(option.name) != &format) continue;
      add_option(command, option, fmt::format("Of reading {} files", format.extension), given);
    }
  }
  add_memory_limit(command, given.memory);
}

Status check_reading_options(const Options& given, std::span<const std::string> inputs) {
  if (given.all().empty()) return ok_status();
  std::vector<const Format*> read;
  for (const std::string& input : inputs) {
    const std::optional<const Format*> format = format_of(input, given.memory);
    if (!format) return ok_status();
    if (*format != nullptr) read.push_back(*format);
  }
  for (const auto& option : given.all()) {
    const std::string& name = option.first;
    if (std::any_of(read.begin(), read.end(), [&](const Format* format) { return reads_with(*format, name); }))
      continue;
    const Format* owner = first_that_reads_with(name);
    return usage_error(fmt::format("--{} is an option of reading {} files, {}", name,
                                   owner == nullptr ? "no" : owner->extension,
                                   inputs.size() == 1 ? "which this is not" : "which none of these is"));
  }
  return ok_status();
}

}  // namespace sbrdf::internal
