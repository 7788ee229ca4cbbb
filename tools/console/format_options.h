#pragma once

#include <CLI/CLI.hpp>
#include <span>
#include <string>

#include "converters/files/options.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// Options that rows of the format table declare, as options of a command. In the help each format has a group; formats
// that share an option mean the same by it.

/// All of them, for reading and for writing.
void add_format_options(CLI::App& command, Options& given);

/// Those for reading, and --memory-limit: for commands whose inputs are of any format. Each is to be checked by
/// check_reading_options().
void add_reading_options(CLI::App& command, Options& given);

/// An option without effect is a misunderstanding: the format of at least one of the inputs, as they were named, must
/// have it. An input whose format cannot be told beforehand (a pipe, or what will turn out to be none) may have any.
/// kUsage naming the first that none has.
[[nodiscard]] Status check_reading_options(const Options& given, std::span<const std::string> inputs);

}  // namespace sbrdf::internal
