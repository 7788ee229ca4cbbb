#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "converters/audit/audit.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// One material of an audit: its rows, or why there are none.
struct AuditedMaterial {
  std::string name;
  std::vector<AuditRow> rows;
  std::optional<Error> failure = {};
};

/// What was asked for, for reports.
struct AuditRun {
  AuditSettings settings;
  std::string command;
  std::string version;  ///< of this program
};

[[nodiscard]] nlohmann::ordered_json audit_rows_json(const std::vector<AuditRow>& rows);
/// The inverse; nothing for what it did not write.
[[nodiscard]] std::optional<std::vector<AuditRow>> audit_rows_of(const nlohmann::ordered_json& json);

/// All of it: what audit.json holds and `--json` prints.
[[nodiscard]] nlohmann::ordered_json audit_json(const std::vector<AuditedMaterial>& materials, const AuditRun& run);

/// Cells of tables for people, the head first.
using TextRows = std::vector<std::vector<std::string>>;
[[nodiscard]] TextRows material_table(const AuditedMaterial& material, double target_percent);
/// The smallest first.
[[nodiscard]] TextRows totals_table(const std::vector<AuditedMaterial>& materials, double target_percent);
/// "89 B dense representation at 5 %, ..."
[[nodiscard]] std::string smallest_text(const AuditedMaterial& material, const AuditSettings& settings);

/// Names of all files of a report, before anything is measured.
[[nodiscard]] std::vector<std::string> audit_files(const AuditSettings& settings);
/// The same with their texts: audit.csv, audit.json, audit.md, and a chart for each target.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> audit_report(
    const std::vector<AuditedMaterial>& materials, const AuditRun& run);

}  // namespace sbrdf::internal
