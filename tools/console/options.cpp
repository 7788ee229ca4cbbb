#include "tools/console/options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace sbrdf {
namespace {

template <class T>
std::optional<T> parse(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string describe(const Range& range) {
  if (range.open) {
    const std::string least = fmt::format("greater than {:g}", range.least);
    return range.most == Range().most ? least : least + fmt::format(" and at most {:g}", range.most);
  }
  if (range.most == Range().most) return fmt::format("at least {:g}", range.least);
  return fmt::format("{:g} to {:g}", range.least, range.most);
}

// CLI11's own reading of numbers takes -1 for a large count and 010 for eight.
template <class Variable>
CLI::Option* add_number_to(CLI::App& app, const std::string& flag, Variable& value, Range range,
                           const std::string& unit, const std::string& help) {
  return app
      .add_option_function<std::string>(
          flag,
          [flag, &value, range](const std::string& text) {
            const std::optional<double> number = parse_number(text);
            if (!number) throw CLI::ValidationError(flag, "'" + text + "' is not a number");
            const bool enough = range.open ? *number > range.least : *number >= range.least;
            if (!enough || *number > range.most) {
              throw CLI::ValidationError(flag, text + " is out of range; it must be " + describe(range));
            }
            value = *number;
          },
          help)
      ->type_name(unit);
}

template <class Variable>
CLI::Option* add_count_to(CLI::App& app, const std::string& flag, Variable& value, CountRange range,
                          const std::string& help) {
  return app
      .add_option_function<std::string>(
          flag,
          [flag, &value, range](const std::string& text) {
            const std::optional<std::uint64_t> count = parse_count(text);
            if (!count) throw CLI::ValidationError(flag, "'" + text + "' is not a whole number of 0 or more");
            if (*count < range.least || *count > range.most) {
              throw CLI::ValidationError(flag, fmt::format("must be {} to {}", range.least, range.most));
            }
            value = *count;
          },
          help)
      ->type_name("N");
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  const std::optional<double> value = parse<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::uint64_t> parse_count(std::string_view text) { return parse<std::uint64_t>(text); }

CLI::Option* add_number(CLI::App& app, const std::string& flag, double& value, Range range, const std::string& unit,
                        const std::string& help) {
  return add_number_to(app, flag, value, range, unit, help)->default_str(fmt::format("{:g}", value));
}

CLI::Option* add_number(CLI::App& app, const std::string& flag, std::optional<double>& value, Range range,
                        const std::string& unit, const std::string& help) {
  return add_number_to(app, flag, value, range, unit, help);
}

CLI::Option* add_count(CLI::App& app, const std::string& flag, std::uint64_t& value, CountRange range,
                       const std::string& help) {
  return add_count_to(app, flag, value, range, help)->default_str(std::to_string(value));
}

CLI::Option* add_count(CLI::App& app, const std::string& flag, std::optional<std::uint64_t>& value, CountRange range,
                       const std::string& help) {
  return add_count_to(app, flag, value, range, help);
}

}  // namespace sbrdf
