#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// kUsage where a report does not end with .json.
[[nodiscard]] Status check_report_name(const std::string& path);

/// Whether a report may be written to `path`, asked before long work; whether it can be, check_destination tells.
/// kUsage as check_report_name, and where it is by whatever name one of the files that are `read` or will be `written`
/// (paths_read, paths_written), or would replace anything but an earlier report.
[[nodiscard]] Status check_report(const std::string& path, const std::vector<std::string>& read,
                                  const std::vector<std::string>& written);

/// The whole file or none, also after a signal: it tells what was done until then. kIo.
[[nodiscard]] Status write_report_file(const std::string& path, const nlohmann::ordered_json& report);

}  // namespace sbrdf::internal
