#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>

namespace sbrdf::internal {

/// The whole text as a number that its type can hold; nothing otherwise. No spaces, no hexadecimal digits, and no plus.
template <class T>
[[nodiscard]] std::optional<T> parse_whole(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// The whole text is a number, in form, but too large for its type or too close to 0.
template <class T>
[[nodiscard]] bool is_out_of_range(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc::result_out_of_range && end == text.data() + text.size();
}

/// The whole text as a finite decimal number, such as "-1.5e3" or "+2"; nothing otherwise. No "nan" or "inf".
[[nodiscard]] inline std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  const std::optional<double> value = parse_whole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

/// The whole text as digits; nothing otherwise, or where 64 bits are too few.
[[nodiscard]] inline std::optional<std::uint64_t> parse_count(std::string_view text) {
  return parse_whole<std::uint64_t>(text);
}

}  // namespace sbrdf::internal
