#include "tools/bench/bench_files.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "tools/bench/bench_charts.h"
#include "tools/bench/bench_page.h"
#include "tools/bench/figures.h"
#include "tools/console/output.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kTable = "bench.csv";
constexpr const char* kGrowth = "growth.csv";
constexpr const char* kJson = "bench.json";
constexpr const char* kPage = "bench.md";

Json machine_json(const Machine& machine) {
  return {{"line", machine.line()},          {"processor", machine.processor}, {"cores", machine.cores},
          {"compiler", machine.compiler},    {"build", machine.build},         {"highway_target", machine.vectors},
          {"sbrdf_version", machine.version}};
}

Json yardstick_json(const BenchReport& report) {
  return {{"look_up_ns", figure_json(report.yardstick_ns)},
          {"memory_array_bytes", report.memory.array_bytes},
          {"memory_read_gb_per_s", figure_json(report.memory.read_gb_per_s)},
          {"memory_copy_gb_per_s", figure_json(report.memory.copy_gb_per_s)}};
}

}  // namespace

Status BenchFolder::prepare(const std::vector<std::string>& materials, const std::vector<std::string>& inputs) {
  std::vector<std::string> files = {kTable, kGrowth, kJson, kPage};
  for (std::string& file : chart_files(materials)) files.push_back(std::move(file));
  return folder_.prepare(files, inputs);
}

Status BenchFolder::write(const BenchReport& report, const BenchRun& run) const {
  const std::string machine = run.machine.line();
  std::vector<std::pair<std::string, std::string>> files = {
      {kTable, bench_csv(report.rows, machine)},
      {kGrowth, growth_csv(report.growth, machine)},
      {kJson, json_text(bench_run_json(report, run))},
      {kPage, bench_page(report, run.materials, machine, run.command)}};
  for (const auto& charts : {material_charts(report, run.materials, machine), growth_charts(report, machine)}) {
    for (const NamedChart& chart : charts) files.emplace_back(chart.file, draw_chart(chart.chart));
  }
  return folder_.write(files);
}

Json bench_run_json(const BenchReport& report, const BenchRun& run) {
  const BenchSettings& settings = run.settings;
  return {{"machine", machine_json(run.machine)},
          {"command", run.command},
          {"repetitions", settings.timing.repetitions},
          {"timed_pairs", settings.timed_pairs},
          {"judged_pairs", settings.judged_pairs},
          {"yardstick", yardstick_json(report)},
          {"rows", bench_json(report.rows)},
          {"growth", growth_json(report.growth)},
          {"left_out", report.left_out},
          {"seconds", figure_json(run.seconds)}};
}

}  // namespace sbrdf::internal
