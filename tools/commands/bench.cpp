#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "converters/bench/bench.h"
#include "converters/files/by_name.h"
#include "converters/models/analytic.h"
#include "tools/bench/bench_files.h"
#include "tools/bench/bench_page.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

struct BenchCommand {
  std::vector<std::string> inputs;
  std::string out;
  bool quick = false;
  bool json = false;
  Options given;  ///< of reading
};

/// None of the built-in materials is isotropic.
const AnalyticModel& isotropic_model() {
  static const AnalyticModel kModel = {
      "isotropic gloss", {0.08, 0.05, 0.03}, {{{0.12, 0.11, 0.1}, 0.2, 0.15, 0.15, 0.2}}};
  return kModel;
}

/// They need no files, so that a run without any repeats everywhere.
std::vector<BenchMaterial> default_materials(bool quick) {
  const auto isotropic = []() -> Result<OpenedSource> {
    OpenedSource opened;
    opened.source = make_analytic_source(isotropic_model());
    return opened;
  };
  std::vector<BenchMaterial> materials = {{isotropic_model().name, isotropic}};
  std::vector<std::string> names = {"kurt:fabric112"};
  if (!quick) names.emplace_back("kurt:Brushed alum");
  for (const std::string& name : names) materials.push_back({name, [name] { return open_source(name); }});
  return materials;
}

std::vector<BenchMaterial> materials_of(const BenchCommand& command) {
  if (command.inputs.empty()) return default_materials(command.quick);
  std::vector<BenchMaterial> materials;
  for (const std::string& name : command.inputs) {
    materials.push_back({name, [name, given = command.given] { return open_source(name, given); }});
  }
  return materials;
}

void print_table(const TextRows& rows) {
  Table table;
  for (const std::vector<std::string>& row : rows) table.add(row);
  table.print();
}

void print_as_tables(const BenchReport& report, const BenchRun& run) {
  print(fmt::format("{}\n{}\n", run.machine.line(), yardstick_text(report)));
  for (const std::string& material : run.materials) {
    print("\n" + one_line(material) + "\n");
    print_table(material_table(report, material));
  }
  for (const auto& [name, axis] : kGrowthAxisNames) {
    const TextRows rows = growth_table(report, axis);
    if (rows.size() == 1) continue;
    print(fmt::format("\nagainst {}\n", name));
    print_table(rows);
  }
  if (!report.left_out.empty()) print("\nleft out\n");
  for (const std::string& line : report.left_out) print(one_line(line) + "\n");
  print(fmt::format("\ntook {} s\n", format_number(run.seconds)));
}

Result<BenchReport> run_with_bar(const std::vector<BenchMaterial>& materials, const BenchSettings& settings) {
  ProgressBar bar("bench");
  return run_bench(materials, settings, bar.progress());
}

/// For pages that are kept: of the folder only its name.
std::string told_command(const BenchCommand& command) {
  std::string text = "sbrdf bench";
  for (const std::string& input : command.inputs)
    text += " " + (input.find(' ') == input.npos ? input : "'" + input + "'");
  if (command.quick) text += " --quick";
  if (!command.out.empty()) text += " --out " + whole_path(command.out).filename().string();
  return text;
}

int run_bench_command(const BenchCommand& command) {
  const Stopwatch watch;
  if (!command.inputs.empty()) {
    if (Status used = check_reading_options(command.given, command.inputs); !used) {
      return report_error(command.inputs.front(), used.error());
    }
  }
  const std::vector<BenchMaterial> materials = materials_of(command);
  BenchRun run;
  for (const BenchMaterial& material : materials) {
    if (std::find(run.materials.begin(), run.materials.end(), material.name) != run.materials.end()) {
      return report_error(material.name, usage_error("is given twice"));
    }
    run.materials.push_back(material.name);
  }
  run.machine = this_machine();
  run.settings = command.quick ? quick_settings() : full_settings();
  run.command = told_command(command);
  BenchFolder folder(command.out);
  const auto fail = [&](const std::string& subject, const Error& error) {
    if (!command.out.empty()) folder.take_back();
    return report_error(subject, error);
  };
  if (!command.out.empty()) {
    if (Status free = folder.prepare(run.materials, command.inputs); !free) return fail(command.out, free.error());
  }
  const Result<BenchReport> report = run_with_bar(materials, run.settings);
  if (!report) return fail("", report.error());
  run.seconds = watch.seconds();
  if (!command.out.empty()) {
    if (Status written = folder.write(*report, run); !written) return fail(command.out, written.error());
  }
  if (command.json) {
    print_json(bench_run_json(*report, run));
  } else {
    print_as_tables(*report, run);
  }
  return 0;
}

}  // namespace

void add_bench(CLI::App& program, int& exit_code) {
  auto* app = program.add_subcommand("bench", "Times every way to evaluate a material, beside its error and bytes.");
  const auto command = std::make_shared<BenchCommand>();
  app->add_option("IN", command->inputs,
                  "Files, kurt:NAME or kurt:FILE.json; unless given, three analytic materials, one of them isotropic");
  app->add_flag("--quick", command->quick, "In seconds: few samples, medians of three, structures hardly searched for");
  app->add_option("--out", command->out,
                  "Also write tables (CSV, JSON), a page (Markdown) and charts (SVG) to this folder; made if missing")
      ->type_name("DIR");
  app->add_flag("--json", command->json, "Print JSON");
  add_reading_options(*app, command->given);
  app->footer(
      "Each method is compared with the material before it is timed; exit code 5 where its values are wild, not "
      "finite, "
      "or\nother ones in a batch. Times are medians of nine, ns of one core for one evaluation from two unit vectors; "
      "x is the\nratio to a plain trilinear look-up that runs beside. For quiet figures let nothing else run.\n\n"
      "Examples:\n  sbrdf bench --out charts\n  sbrdf bench material.bsdf kurt:wood01 --quick");
  app->callback([command, &exit_code] { exit_code = run_bench_command(*command); });
}

}  // namespace sbrdf::internal
