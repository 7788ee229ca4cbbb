#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "converters/stress/stress.h"
#include "formats/os/interrupt.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

struct StressCommand {
  std::uint64_t seed = 1;
  bool json = false;
};

void print_as_json(const StressCommand& command, const std::vector<StressRow>& rows, double seconds) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const StressRow& row : rows) {
    list.push_back({{"row", row.name},
                    {"tried", row.what},
                    {"cases", row.cases},
                    {"worst", row.worst},
                    {"limit", row.limit},
                    {"pass", row.passed}});
  }
  print_json({{"seed", command.seed}, {"rows", list}, {"seconds", seconds}});
}

void print_as_table(const std::vector<StressRow>& rows, double seconds) {
  Table table;
  table.add({"row", "tried", "cases", "worst", "limit", "pass"});
  for (const StressRow& row : rows) {
    table.add({row.name, row.what, format_count(row.cases), format_number(row.worst), format_number(row.limit),
               row.passed ? "pass" : "FAIL"});
  }
  table.print();
  print(fmt::format("\ntook {} s\n", format_number(seconds)));
}

std::vector<StressRow> run_with_bar(std::uint64_t seed) {
  ProgressBar bar("stress");
  return run_stress(seed, bar.progress());
}

int run_command(const StressCommand& command) {
  const Stopwatch watch;
  const std::vector<StressRow> rows = run_with_bar(command.seed);
  if (interrupted()) return report_error("", interrupted_error());
  if (command.json) {
    print_as_json(command, rows, watch.seconds());
  } else {
    print_as_table(rows, watch.seconds());
  }
  const auto failed = std::count_if(rows.begin(), rows.end(), [](const StressRow& row) { return !row.passed; });
  if (failed == 0) return 0;
  return report_error("", difference_error(fmt::format("{} of {} rows failed", failed, rows.size())));
}

}  // namespace

void add_stress(CLI::App& program, int& exit_code) {
  auto* app = program.add_subcommand("stress", "Tests the numerical stability of evaluation on this machine.");
  const auto command = std::make_shared<StressCommand>();
  add_count(*app, "--seed", command->seed, {}, "Start of the random numbers");
  app->add_flag("--json", command->json, "Print JSON");
  app->footer(
      "Analytic functions are sampled in both frames and both value domains, and evaluated where arithmetic is in "
      "danger.\n"
      "Errors are against the same equations in long double. Exit code 5 where a row fails.\n\n"
      "Example:\n  sbrdf stress --seed 7");
  app->callback([command, &exit_code] { exit_code = run_command(*command); });
}

}  // namespace sbrdf::internal
