#include "tools/bench/bench_charts.h"

#include <algorithm>
#include <array>
#include <set>

#include <fmt/format.h>

#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

constexpr double kLeastError = 1e-3;  // [%]; what is below is rounding, or exact

/// The same look for a method in every chart: its row in the registry.
std::size_t style_of(const std::string& method) {
  const std::span<const Method> methods = bench_methods();
  const auto found =
      std::find_if(methods.begin(), methods.end(), [&](const Method& row) { return row.name == method; });
  return static_cast<std::size_t>(found - methods.begin());
}

/// Of letters, digits and "-"; the same for a name that differs in nothing else gets a number behind.
std::vector<std::string> stems_of(const std::vector<std::string>& materials) {
  constexpr std::size_t kLongest = 60;
  std::vector<std::string> stems;
  std::set<std::string> taken = {"growth"};
  for (const std::string& material : materials) {
    std::string stem;
    for (const char c : material.substr(material.find_last_of('/') + 1)) {
      const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
      const bool capital = c >= 'A' && c <= 'Z';
      if (plain) stem += c;
      if (capital) stem += static_cast<char>(c - 'A' + 'a');
      if (!plain && !capital && !stem.empty() && stem.back() != '-') stem += '-';
    }
    stem = stem.substr(0, kLongest);
    if (!stem.empty() && stem.back() == '-') stem.pop_back();
    if (stem.empty()) stem = "material";
    std::string name = stem;
    for (int k = 2; !taken.insert(name).second; ++k) name = fmt::format("{}-{}", stem, k);
    stems.push_back(name);
  }
  return stems;
}

/// Samples of slices, nodes of dense tables; nothing for what comes in one size.
std::string label_of(const BenchRow& row) {
  constexpr std::string_view kNodes = " nodes";
  if (row.samples > 0) return format_count(row.samples);
  return row.variant.ends_with(kNodes) ? row.variant.substr(0, row.variant.size() - kNodes.size()) : "";
}

/// One series for each method of a material; points of slices are joined.
template <class PointOf>
std::vector<ChartSeries> series_of(const BenchReport& report, const std::string& material, const PointOf& point_of) {
  std::vector<ChartSeries> all;
  for (const BenchRow& row : report.rows) {
    if (row.material != material) continue;
    if (all.empty() || all.back().name != row.method) all.push_back({row.method, style_of(row.method)});
    all.back().points.push_back(point_of(row));
    all.back().joined = row.samples > 0;
  }
  return all;
}

Chart error_chart(const std::string& machine) {
  Chart chart;
  chart.x_title = "mean relative error off the grid [%]";
  chart.x_least = kLeastError;
  chart.pareto_front = true;
  chart.footnote = machine;
  return chart;
}

Chart time_chart(const BenchReport& report, const std::string& material, const std::string& machine) {
  Chart chart = error_chart(machine);
  chart.title = one_line(material, 80) + ": time against error";
  chart.y_title = "one evaluation on one core [ns]";
  chart.filled_name = "in a batch";
  chart.hollow_name = "one pair at a time";
  chart.series = series_of(report, material, [](const BenchRow& row) {
    return ChartPoint{row.quality.off_grid_mre_percent, row.batch_ns, row.single_ns, label_of(row)};
  });
  chart.levels = {{report.yardstick_ns, "yardstick: the plain look-up"}};
  return chart;
}

Chart bytes_chart(const BenchReport& report, const std::string& material, const std::string& machine) {
  Chart chart = error_chart(machine);
  chart.title = one_line(material, 80) + ": bytes against error";
  chart.y_title = "bytes";
  chart.y_numerals = Numerals::kBytes;
  chart.filled_name = "of the file";
  chart.hollow_name = "in memory";
  chart.series = series_of(report, material, [](const BenchRow& row) {
    const auto resident = static_cast<double>(row.resident_bytes);
    ChartPoint point = {row.quality.off_grid_mre_percent, resident, {}, label_of(row)};
    if (row.file_bytes) {
      point.y = static_cast<double>(*row.file_bytes);
      point.other_y = resident;
    }
    return point;
  });
  std::erase_if(chart.series, [&](const ChartSeries& series) {  // a model has no file
    return std::none_of(series.points.begin(), series.points.end(),
                        [](const ChartPoint& point) { return point.other_y.has_value(); });
  });
  return chart;
}

struct GrowthTitle {
  GrowthAxis axis;
  const char* title;
  const char* x_title;
  const char* y_title;
};
constexpr std::array<GrowthTitle, 3> kGrowthTitles = {
    {{GrowthAxis::kSamples, "Growth with the number of samples", "samples", "one evaluation in a batch, one core [ns]"},
     {GrowthAxis::kBatch, "Growth with the size of batches", "pairs in one call", "one evaluation, one core [ns]"},
     {GrowthAxis::kThreads, "Growth with the number of threads", "threads",
      "time that passes for one evaluation [ns]"}}};

std::string growth_file(GrowthAxis axis) { return fmt::format("growth-{}.svg", name_of(kGrowthAxisNames, axis)); }

}  // namespace

std::vector<NamedChart> material_charts(const BenchReport& report, const std::vector<std::string>& materials,
                                        const std::string& machine) {
  const std::vector<std::string> stems = stems_of(materials);
  std::vector<NamedChart> charts;
  for (std::size_t k = 0; k < materials.size(); ++k) {
    charts.push_back({stems[k] + "-time.svg", time_chart(report, materials[k], machine)});
    charts.push_back({stems[k] + "-bytes.svg", bytes_chart(report, materials[k], machine)});
  }
  return charts;
}

std::vector<NamedChart> growth_charts(const BenchReport& report, const std::string& machine) {
  std::vector<NamedChart> charts;
  for (const GrowthTitle& titles : kGrowthTitles) {
    Chart chart;
    chart.title = titles.title;
    chart.x_title = titles.x_title;
    chart.y_title = titles.y_title;
    chart.footnote = machine;
    chart.x_ticks_at_points = titles.axis != GrowthAxis::kSamples;
    for (const GrowthRow& row : report.growth) {
      if (row.axis != titles.axis) continue;
      const std::string name = row.material + ": " + row.method;
      if (chart.series.empty() || chart.series.back().name != name) {
        chart.series.push_back({name, chart.series.size() + 1, true});  // several of one method: numbered here
      }
      chart.series.back().points.push_back({static_cast<double>(row.at), row.ns});
    }
    if (report.yardstick_ns > 0) chart.levels = {{report.yardstick_ns, "yardstick: the plain look-up"}};
    charts.push_back({growth_file(titles.axis), std::move(chart)});
  }
  return charts;
}

std::vector<std::string> chart_files(const std::vector<std::string>& materials) {
  std::vector<std::string> files;
  for (const std::string& stem : stems_of(materials)) {
    files.push_back(stem + "-time.svg");
    files.push_back(stem + "-bytes.svg");
  }
  for (const auto& [name, axis] : kGrowthAxisNames) files.push_back(growth_file(axis));
  return files;
}

}  // namespace sbrdf::internal
