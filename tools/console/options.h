#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "converters/files/options.h"
#include "formats/core/numbers.h"  // IWYU pragma: export
#include "formats/sbrdf/memory_limit.h"

namespace sbrdf::internal {

/// Options whose text number_within or count_within reads; whatever else is given, or is out of range, is a usage error
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

/// Gives a command that reads files the option --memory-limit.
CLI::Option* add_memory_limit(CLI::App& app, MemoryLimit& limit);

}  // namespace sbrdf::internal
