#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/conversion/conversion.h"

namespace sbrdf::internal {

// What is told of a conversion, one object for each file; specs/convert.md lists the members.

/// Of one that was done: {"result": "converted", "version", "in", "out", "options", "remarks", "seconds"}.
[[nodiscard]] nlohmann::ordered_json report_of(const ConversionOrder& order, const Conversion& done);

/// Of one that failed: {"result": "failed", "in": {"path"}, "error": {"code", "message", "offset"}}.
[[nodiscard]] nlohmann::ordered_json report_of(const std::string& in, const Failure& failure);

/// Of a file that nobody would convert: {"result": "skipped", "in": {"path"}, "reason"}.
[[nodiscard]] nlohmann::ordered_json report_of_skipped(const std::string& in, const std::string& reason);

/// The first mean relative error in a report, for a line of a list: "MRE 0.52 %"; "copied" for a copy; else empty.
[[nodiscard]] std::string main_figure(const nlohmann::ordered_json& report);

/// For people, as a table on standard output.
void print_report(const ConversionOrder& order, const Conversion& done);

}  // namespace sbrdf::internal
