#include "tools/bench/bench_page.h"

#include <array>

#include <fmt/format.h>

#include "tools/bench/bench_charts.h"
#include "tools/bench/figures.h"

namespace sbrdf::internal {
namespace {

std::string time_text(double ns, double ratio) { return fmt::format("{:.4g} ns, {:.2f} x", ns, ratio); }
std::string percent(double value) {
  constexpr double kRounding = 1e-4;  // nobody is interested in less
  return value >= 0 && value < kRounding ? "< 0.0001 %" : fmt::format("{:.3g} %", value);
}

constexpr std::array<const char*, 3> kGrowthHeads = {"samples", "pairs in one call", "threads"};

/// For a cell of a Markdown table.
std::string in_markdown(const std::string& text) {
  std::string escaped;
  for (const char c : one_line(text)) {
    if (c == '|' || c == '<' || c == '`' || c == '*' || c == '_' || c == '[') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string markdown_table(const TextRows& rows) {
  std::string text;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    text += "|";
    for (const std::string& cell : rows[k]) text += " " + in_markdown(cell) + " |";
    text += "\n";
    if (k > 0) continue;
    text += "|";
    for (std::size_t c = 0; c < rows[k].size(); ++c) text += "---|";
    text += "\n";
  }
  return text + "\n";
}

std::string picture(const NamedChart& chart) {
  return fmt::format("![{}]({})\n\n", in_markdown(chart.chart.title), chart.file);
}

}  // namespace

TextRows material_table(const BenchReport& report, const std::string& material) {
  TextRows rows = {{"method", "size", "one by one", "in a batch", "first value", "in memory", "file", "grid: MRE",
                    "rel L1", "off it: MRE", "rel L1"}};
  for (const BenchRow& row : report.rows) {
    if (row.material != material) continue;
    rows.push_back({row.method, row.variant, time_text(row.single_ns, row.single_ratio()),
                    time_text(row.batch_ns, row.batch_ratio()), fmt::format("{:.3g} ms", row.first_value_ms),
                    bytes_text(row.resident_bytes), bytes_text(row.file_bytes), percent(row.quality.grid_mre_percent),
                    percent(row.quality.grid_rel_l1_percent), percent(row.quality.off_grid_mre_percent),
                    percent(row.quality.off_grid_rel_l1_percent)});
  }
  return rows;
}

TextRows growth_table(const BenchReport& report, GrowthAxis axis) {
  TextRows rows = {{"material", "method", kGrowthHeads.at(static_cast<std::size_t>(axis)), "one evaluation"}};
  if (axis == GrowthAxis::kSamples) rows.front().emplace_back("in memory");
  for (const GrowthRow& row : report.growth) {
    if (row.axis != axis) continue;
    rows.push_back({row.material, row.method, format_count(row.at), time_text(row.ns, row.ratio())});
    if (axis == GrowthAxis::kSamples) rows.back().push_back(bytes_text(row.resident_bytes));
  }
  return rows;
}

std::string yardstick_text(const BenchReport& report) {
  const MemorySpeed& memory = report.memory;
  return fmt::format(
      "plain trilinear look-up {:.4g} ns (median; x: times the one beside each row); memory, one core, arrays of {}: "
      "read {:.3g} GB/s, copied {:.3g} GB/s",
      report.yardstick_ns, bytes_text(memory.array_bytes), memory.read_gb_per_s, memory.copy_gb_per_s);
}

std::string bench_page(const BenchReport& report, const std::vector<std::string>& materials, const std::string& machine,
                       const std::string& command) {
  std::string page = fmt::format(
      "# Run time against error\n\nMade by `{}`; what is measured and how is in specs/bench.md.\n\nMachine: {}.\n\n"
      "Yardsticks of this run: {}.\n\n",
      one_line(command), in_markdown(machine), yardstick_text(report));
  const std::vector<NamedChart> charts = material_charts(report, materials, machine);
  for (std::size_t k = 0; k < materials.size(); ++k) {
    page += fmt::format("## {}\n\n", in_markdown(materials[k]));
    page += markdown_table(material_table(report, materials[k]));
    page += picture(charts[2 * k]) + picture(charts[2 * k + 1]);
  }
  if (!report.growth.empty()) page += "## Growth\n\n";
  const std::vector<NamedChart> growth = growth_charts(report, machine);
  for (std::size_t k = 0; k < growth.size() && !report.growth.empty(); ++k) {
    page += markdown_table(growth_table(report, kGrowthAxisNames.at(k).value)) + picture(growth[k]);
  }
  if (report.left_out.empty()) return page;
  page += "## Left out\n\n";
  for (const std::string& line : report.left_out) page += "- " + in_markdown(line) + "\n";
  return page;
}

}  // namespace sbrdf::internal
