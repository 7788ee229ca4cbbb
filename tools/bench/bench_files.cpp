#include "tools/bench/bench_files.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "formats/os/files.h"
#include "tools/bench/bench_charts.h"
#include "tools/bench/bench_page.h"
#include "tools/bench/figures.h"
#include "tools/console/output.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kTable = "bench.csv";
constexpr const char* kGrowth = "growth.csv";
constexpr const char* kJson = "bench.json";
constexpr const char* kPage = "bench.md";

Error naming(const std::string& file, const Error& error) {
  Error named = error;
  named.message = file + ": " + error.message;
  return named;
}

/// By its name a JSON file could be parameters of a material: nothing is replaced but what a benchmark wrote before.
Status check_json(const std::string& path, const std::vector<std::string>& inputs) {
  constexpr std::size_t kBeginning = 64;
  if (Status free = check_destination(path); !free) return free;
  if (is_among(path, paths_read(inputs))) return usage_error("is an input, which this would replace");
  if (!exists(path)) return ok_status();
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  if (!file) return file.error();
  const Result<std::vector<std::byte>> head = read_start(**file, kBeginning);
  if (!head) return head.error();
  const std::string_view text(reinterpret_cast<const char*>(head->data()), head->size());
  const std::string_view first = text.substr(std::min(text.find_first_not_of("{ \n"), text.size()));
  if (text.empty() || first.starts_with("\"machine\":")) return ok_status();
  return usage_error("there is a file of another kind of that name; choose another folder or remove it first");
}

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
  std::error_code failed;
  made_ = fs::create_directory(path_, failed);
  if (failed && !fs::is_directory(path_)) return io_error("the folder cannot be made: " + failed.message());
  std::vector<std::string> files = {kTable, kGrowth, kJson, kPage};
  for (std::string& file : chart_files(materials)) files.push_back(std::move(file));
  for (const std::string& file : files) {
    const std::string path = (fs::path(path_) / file).string();
    const Status free = file == kJson ? check_json(path, inputs) : check_output(path, nullptr, inputs);
    if (!free) return naming(file, free.error());
  }
  return ok_status();
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
  for (const auto& [file, text] : files) {
    const Status written =
        write_file_atomically(fs::path(path_) / file, std::as_bytes(std::span(text.data(), text.size())));
    if (!written) return naming(file, written.error());
  }
  return ok_status();
}

void BenchFolder::take_back() const {
  std::error_code none;
  if (made_) fs::remove(path_, none);  // an empty folder, or nothing
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
