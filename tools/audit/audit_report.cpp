#include "tools/audit/audit_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "tools/charts/log_axis.h"
#include "tools/charts/strips.h"
#include "tools/console/output.h"
#include "tools/console/plain_text.h"
#include "tools/console/terminal.h"
#include "tools/io/columns.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kAuditTable = "audit.csv";
constexpr const char* kAuditJson = "audit.json";
constexpr const char* kAuditPage = "audit.md";

/// A row with the material that it is of, and what its method can do.
struct NamedRow {
  std::string material;
  AuditRow row;
};

const AuditMethod& method_of(const AuditRow& row) {
  const auto methods = audit_methods();
  return *std::find_if(methods.begin(), methods.end(),
                       [&](const AuditMethod& method) { return method.name == row.method; });
}

Figure if_found(const AuditRow& row, const Figure& figure) { return row.found() ? figure : Figure(); }

// What is read back from the journal, under the same keys.
constexpr std::array kColumns = {
    Column<NamedRow>{"material", [](const NamedRow& one) { return Figure(one.material); }},
    Column<NamedRow>{"target_rel_l1_percent", [](const NamedRow& one) { return Figure(one.row.target_percent); }},
    Column<NamedRow>{"method", [](const NamedRow& one) { return Figure(one.row.method); }},
    Column<NamedRow>{"setting", [](const NamedRow& one) { return Figure(one.row.setting); }},
    Column<NamedRow>{"reached", [](const NamedRow& one) { return Figure(one.row.reached); }},
    Column<NamedRow>{"bytes", [](const NamedRow& one) { return if_found(one.row, one.row.bytes); }},
    Column<NamedRow>{"bits", [](const NamedRow& one) { return if_found(one.row, 8 * one.row.bytes); }},
    Column<NamedRow>{"overhead_bytes", [](const NamedRow& one) { return if_found(one.row, one.row.overhead); }},
    Column<NamedRow>{"payload_bytes",
                     [](const NamedRow& one) { return if_found(one.row, one.row.bytes - one.row.overhead); }},
    Column<NamedRow>{"resident_bytes", [](const NamedRow& one) { return if_found(one.row, one.row.resident_bytes); }},
    Column<NamedRow>{"grid_mre_percent",
                     [](const NamedRow& one) { return if_found(one.row, one.row.grid_mre_percent); }},
    Column<NamedRow>{"grid_rel_l1_percent",
                     [](const NamedRow& one) { return if_found(one.row, one.row.grid_rel_l1_percent); }},
    Column<NamedRow>{"off_grid_mre_percent",
                     [](const NamedRow& one) { return if_found(one.row, one.row.off_grid_mre_percent); }},
    Column<NamedRow>{"off_grid_rel_l1_percent",
                     [](const NamedRow& one) { return if_found(one.row, one.row.off_grid_rel_l1_percent); }},
    Column<NamedRow>{"largest_per_sr", [](const NamedRow& one) { return if_found(one.row, one.row.largest); }},
    Column<NamedRow>{"ratio_to_smallest",
                     [](const NamedRow& one) { return one.row.reached ? Figure(one.row.ratio) : Figure(); }},
    Column<NamedRow>{"in_place", [](const NamedRow& one) { return Figure(method_of(one.row).in_place); }},
    Column<NamedRow>{"in_part", [](const NamedRow& one) { return Figure(method_of(one.row).in_part); }},
    Column<NamedRow>{"bound", [](const NamedRow& one) { return Figure(std::string(method_of(one.row).bound)); }},
    Column<NamedRow>{"note", [](const NamedRow& one) { return Figure(one.row.note); }},
};

std::vector<std::vector<AuditRow>> rows_of(const std::vector<AuditedMaterial>& materials) {
  std::vector<std::vector<AuditRow>> rows;
  for (const AuditedMaterial& material : materials) {
    if (!material.failure) rows.push_back(material.rows);
  }
  return rows;
}

/// Those of a target: who reaches it most often first, then the smallest.
std::vector<AuditTotal> ranked(const std::vector<AuditedMaterial>& materials, double target_percent) {
  std::vector<AuditTotal> totals = total(rows_of(materials));
  std::erase_if(totals, [&](const AuditTotal& one) { return one.target_percent != target_percent; });
  std::stable_sort(totals.begin(), totals.end(), [](const AuditTotal& a, const AuditTotal& b) {
    return a.reached != b.reached ? a.reached > b.reached : a.mean_ratio < b.mean_ratio;
  });
  return totals;
}

std::string with_percent(double value) { return format_number(value) + " %"; }

std::string flags_of(const AuditMethod& method) {
  return fmt::format("{}{}", method.in_place ? "place" : "-", method.in_part ? ", part" : "");
}

std::string chart_file(double target_percent) { return fmt::format("bytes-{:g}-percent.svg", target_percent); }

StripChart chart_of(const std::vector<AuditedMaterial>& materials, double target_percent, const AuditRun& run) {
  StripChart chart;
  chart.title = fmt::format("Bytes for {:g} % relative L1 off the grid", target_percent);
  chart.x_title = "bytes of all files of a material";
  chart.numerals = Numerals::kBytes;
  chart.value_name = "a material";
  chart.mean_name = "geometric mean of those that reach it";
  chart.remark_name = "reached";
  for (const AuditTotal& one : ranked(materials, target_percent)) {
    Strip strip;
    strip.name = one.method;
    strip.stands_out = one.method == "sliced" || one.method == "dense representation";
    strip.remark = fmt::format("{} of {}", one.reached, one.materials);
    if (one.reached > 0) strip.mean = one.mean_bytes;
    for (const AuditedMaterial& material : materials) {
      for (const AuditRow& row : material.rows) {
        const bool same = row.method == one.method && row.target_percent == target_percent;
        if (same && row.reached) strip.values.push_back(static_cast<double>(row.bytes));
      }
    }
    chart.strips.push_back(std::move(strip));
  }
  constexpr std::size_t kCommandCharacters = 110;
  chart.footnote = fmt::format("{} materials; sbrdf {}; {}", rows_of(materials).size(), run.version,
                               one_line(run.command, kCommandCharacters));
  return chart;
}

std::string markdown(const TextRows& rows) {
  std::string text;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::string line = "|";
    for (const std::string& cell : rows[k]) {
      line += " ";
      for (const char c : one_line(cell)) line += c == '|' ? "\\|" : std::string(1, c);
      line += " |";
    }
    text += line + "\n";
    if (k > 0) continue;
    text += "|";
    for (std::size_t n = 0; n < rows[k].size(); ++n) text += "---|";
    text += "\n";
  }
  return text;
}

std::string page_of(const std::vector<AuditedMaterial>& materials, const AuditRun& run) {
  std::string page = fmt::format(
      "# Storage audit\n\n`{}`, sbrdf {}. Errors are measured on {} directions. What the columns mean: "
      "specs/audit.md.\n",
      one_line(run.command), run.version, format_count(run.settings.directions));
  for (const double target : run.settings.targets) {
    page +=
        fmt::format("\n## {:g} % relative L1 off the grid\n\n![Bytes of each way]({})\n\n", target, chart_file(target));
    page += markdown(totals_table(materials, target));
  }
  for (const AuditedMaterial& material : materials) {
    page += "\n## " + one_line(material.name) + "\n";
    if (material.failure) page += "\nNot audited: " + one_line(material.failure->message) + "\n";
    for (const double target : run.settings.targets) {
      if (material.failure) break;
      page += fmt::format("\n{:g} %:\n\n", target) + markdown(material_table(material, target));
    }
  }
  return page;
}

/// Takes rows from JSON that anybody may have changed.
class RowReader {
 public:
  explicit RowReader(const Json& json) : json_(json) {}

  [[nodiscard]] bool is_good() const { return good_; }

  std::string text(const char* key) {
    const Json* value = find(key);
    if (value == nullptr || !value->is_string()) return fail<std::string>();
    return value->get<std::string>();
  }
  bool answer(const char* key) {
    const Json* value = find(key);
    return value != nullptr && value->is_boolean() ? value->get<bool>() : fail<bool>();
  }
  /// Null is 0, as of a row for which nothing was found.
  std::uint64_t count(const char* key) {
    const Json* value = find(key);
    if (value == nullptr || value->is_null()) return 0;
    constexpr std::uint64_t kMost = std::uint64_t{1} << 53U;
    if (!value->is_number_unsigned() || value->get<std::uint64_t>() > kMost) return fail<std::uint64_t>();
    return value->get<std::uint64_t>();
  }
  double number(const char* key) {
    const Json* value = find(key);
    if (value == nullptr || value->is_null()) return 0;
    return value->is_number() && value->get<double>() >= 0 ? value->get<double>() : fail<double>();
  }

 private:
  const Json* find(const char* key) {
    if (!json_.is_object()) return nullptr;
    const auto at = json_.find(key);
    return at == json_.end() ? nullptr : &*at;
  }
  template <class T>
  T fail() {
    good_ = false;
    return {};
  }

  const Json& json_;
  bool good_ = true;
};

/// Nothing for what audit_rows_json did not write.
std::optional<AuditRow> row_of(const Json& json) {
  RowReader reader(json);
  AuditRow row;
  row.method = reader.text("method");
  row.setting = reader.text("setting");
  row.note = reader.text("note");
  row.reached = reader.answer("reached");
  row.target_percent = reader.number("target_rel_l1_percent");
  row.bytes = reader.count("bytes");
  row.overhead = reader.count("overhead_bytes");
  row.resident_bytes = reader.count("resident_bytes");
  row.grid_mre_percent = reader.number("grid_mre_percent");
  row.grid_rel_l1_percent = reader.number("grid_rel_l1_percent");
  row.off_grid_mre_percent = reader.number("off_grid_mre_percent");
  row.off_grid_rel_l1_percent = reader.number("off_grid_rel_l1_percent");
  row.largest = reader.number("largest_per_sr");
  row.ratio = reader.number("ratio_to_smallest");
  const bool sensible = row.overhead <= row.bytes && (row.bytes > 0) == row.found() && (row.found() || !row.reached);
  if (!reader.is_good() || !sensible || !check_methods(std::span(&row.method, 1))) return std::nullopt;
  return row;
}

}  // namespace

Json audit_rows_json(const std::vector<AuditRow>& rows) {
  std::vector<NamedRow> named;
  for (const AuditRow& row : rows) named.push_back({"", row});
  Json json = json_of(std::span<const NamedRow>(named), std::span<const Column<NamedRow>>(kColumns));
  for (Json& row : json) row.erase("material");
  return json;
}

std::optional<std::vector<AuditRow>> audit_rows_of(const Json& json) {
  if (!json.is_array()) return std::nullopt;
  std::vector<AuditRow> rows;
  for (const Json& one : json) {
    std::optional<AuditRow> row = row_of(one);
    if (!row) return std::nullopt;
    rows.push_back(*std::move(row));
  }
  return rows;
}

Json audit_json(const std::vector<AuditedMaterial>& materials, const AuditRun& run) {
  Json json = {{"audit",
                {{"command", run.command},
                 {"sbrdf_version", run.version},
                 {"target_rel_l1_percent", run.settings.targets},
                 {"directions", run.settings.directions}}}};
  json["materials"] = Json::array();
  for (const AuditedMaterial& material : materials) {
    Json one = {{"name", material.name}};
    if (material.failure) {
      one["error"] = material.failure->message;
    } else {
      one["rows"] = audit_rows_json(material.rows);
    }
    json["materials"].push_back(std::move(one));
  }
  json["totals"] = Json::array();
  for (const double target : run.settings.targets) {
    for (const AuditTotal& one : ranked(materials, target)) {
      json["totals"].push_back({{"method", one.method},
                                {"target_rel_l1_percent", one.target_percent},
                                {"materials", one.materials},
                                {"reached", one.reached},
                                {"bytes", one.bytes},
                                {"mean_bytes", figure_json(one.mean_bytes)},
                                {"mean_ratio_to_smallest", figure_json(one.mean_ratio)}});
    }
  }
  return json;
}

TextRows material_table(const AuditedMaterial& material, double target_percent) {
  TextRows table = {{"method", "bytes", "overhead", "ratio", "resident", "off grid: rel. L1", "MRE", "on grid: rel. L1",
                     "MRE", "in", "bound", "setting"}};
  std::vector<AuditRow> rows = material.rows;
  std::erase_if(rows, [&](const AuditRow& row) { return row.target_percent != target_percent; });
  std::stable_sort(rows.begin(), rows.end(), [](const AuditRow& a, const AuditRow& b) {
    const auto rank = [](const AuditRow& row) { return row.reached ? 0 : row.found() ? 1 : 2; };
    if (rank(a) != rank(b)) return rank(a) < rank(b);
    return a.reached ? a.bytes < b.bytes : a.off_grid_rel_l1_percent < b.off_grid_rel_l1_percent;
  });
  for (const AuditRow& row : rows) {
    if (!row.found()) {
      table.push_back({row.method, "-", "-", "-", "-", "-", "-", "-", "-", "-", "-", row.note});
      continue;
    }
    const AuditMethod& method = method_of(row);
    table.push_back({row.method, format_count(row.bytes), format_count(row.overhead),
                     row.reached ? fmt::format("{:.2f} x", row.ratio) : "not reached",
                     numeral(static_cast<double>(row.resident_bytes), Numerals::kBytes),
                     with_percent(row.off_grid_rel_l1_percent), with_percent(row.off_grid_mre_percent),
                     with_percent(row.grid_rel_l1_percent), with_percent(row.grid_mre_percent), flags_of(method),
                     std::string(method.bound), row.setting + (row.note.empty() ? "" : "; " + row.note)});
  }
  return table;
}

TextRows totals_table(const std::vector<AuditedMaterial>& materials, double target_percent) {
  TextRows table = {{"method", "reached", "total bytes", "mean bytes", "mean ratio to the smallest"}};
  for (const AuditTotal& one : ranked(materials, target_percent)) {
    const bool some = one.reached > 0;
    table.push_back({one.method, fmt::format("{} of {}", one.reached, one.materials),
                     some ? format_count(one.bytes) : "-", some ? format_count(std::llround(one.mean_bytes)) : "-",
                     some ? fmt::format("{:.2f} x", one.mean_ratio) : "-"});
  }
  return table;
}

std::string smallest_text(const AuditedMaterial& material, const AuditSettings& settings) {
  std::vector<std::string> parts;
  for (const double target : settings.targets) {
    const AuditRow* best = nullptr;
    for (const AuditRow& row : material.rows) {
      if (row.target_percent != target || !row.reached) continue;
      if (best == nullptr || row.bytes < best->bytes) best = &row;
    }
    parts.push_back(best == nullptr
                        ? fmt::format("{:g} % is not reached", target)
                        : fmt::format("{:g} %: {} bytes, {}", target, format_count(best->bytes), best->method));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::vector<std::string> audit_files(const AuditSettings& settings) {
  std::vector<std::string> files = {kAuditTable, kAuditJson, kAuditPage};
  for (const double target : settings.targets) files.push_back(chart_file(target));
  return files;
}

std::vector<std::pair<std::string, std::string>> audit_report(const std::vector<AuditedMaterial>& materials,
                                                              const AuditRun& run) {
  std::vector<NamedRow> rows;
  for (const AuditedMaterial& material : materials) {
    for (const AuditRow& row : material.rows) rows.push_back({material.name, row});
  }
  std::vector<std::pair<std::string, std::string>> files = {
      {kAuditTable,
       csv_of(std::span<const NamedRow>(rows), std::span<const Column<NamedRow>>(kColumns), "sbrdf", run.version)},
      {kAuditJson, json_text(audit_json(materials, run))},
      {kAuditPage, page_of(materials, run)}};
  for (const double target : run.settings.targets) {
    files.emplace_back(chart_file(target), draw_strips(chart_of(materials, target, run)));
  }
  return files;
}

}  // namespace sbrdf::internal
