#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace sbrdf {

/// The whole text as a finite decimal number, such as "-1.5e3"; nothing otherwise. No spaces, no hexadecimal digits, no
/// "nan" or "inf".
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// The whole text as digits; nothing otherwise, or where 64 bits are too few.
[[nodiscard]] std::optional<std::uint64_t> parse_count(std::string_view text);

struct Range {
  double least = 0;
  double most = std::numeric_limits<double>::max();
  bool open = false;  ///< `least` itself is out of range
};
struct CountRange {
  std::uint64_t least = 0;
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
};

/// Options whose text parse_number or parse_count reads; whatever else is given, or is out of range, is a usage error
/// that names the option. `unit` stands in the help. The value in the variable is the default, shown in the help, or is
/// absent.
CLI::Option* add_number(CLI::App& app, const std::string& flag, double& value, Range range, const std::string& unit,
                        const std::string& help);
CLI::Option* add_number(CLI::App& app, const std::string& flag, std::optional<double>& value, Range range,
                        const std::string& unit, const std::string& help);
CLI::Option* add_count(CLI::App& app, const std::string& flag, std::uint64_t& value, CountRange range,
                       const std::string& help);
CLI::Option* add_count(CLI::App& app, const std::string& flag, std::optional<std::uint64_t>& value, CountRange range,
                       const std::string& help);

}  // namespace sbrdf
