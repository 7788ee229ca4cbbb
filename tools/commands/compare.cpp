#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "converters/files/by_name.h"
#include "converters/judge/compare.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kMostPairs = 10'000'000'000;

struct CompareCommand {
  std::string reference;
  std::string test;
  CompareOptions options;
  std::optional<double> max_mre;
  std::optional<double> max_rel_l1;
  MemoryLimit memory;
  bool json = false;
};

/// Written so that a NaN is above every limit.
bool exceeds(double value, const std::optional<double>& limit) { return limit && !(value <= *limit); }

void print_as_json(const CompareCommand& command, const Comparison& result, double seconds) {
  nlohmann::ordered_json json = {{"reference", command.reference},
                                 {"test", command.test},
                                 {"mre_percent", result.mre_percent},
                                 {"rel_l1_percent", result.rel_l1_percent},
                                 {"rmse", result.rmse},
                                 {"max_abs", result.max_abs},
                                 {"psnr_db", nullptr},
                                 {"directions", result.directions},
                                 {"grid_directions", result.grid_directions},
                                 {"mre_left_out", result.mre_left_out},
                                 {"floor", command.options.floor},
                                 {"step_deg", command.options.step_deg},
                                 {"theta_max_deg", command.options.theta_max_deg},
                                 {"symmetrised", command.options.symmetrise},
                                 {"seconds", seconds}};
  if (std::isfinite(result.psnr_db)) json["psnr_db"] = result.psnr_db;
  if (command.options.random_count > 0) json["seed"] = command.options.seed;
  print_json(json);
}

std::string directions_text(const CompareOptions& options, const Comparison& result) {
  std::string text = format_count(result.directions) + " pairs";
  if (options.random_count > 0) {
    text += fmt::format(", drawn with seed {} from", options.seed);
  } else if (result.grid_directions != result.directions) {
    text += ", both isotropic, for the " + format_count(result.grid_directions) + " of";
  } else {
    text += ",";
  }
  return text + fmt::format(" the {:g}-degree grid up to theta {:g} degrees", options.step_deg, options.theta_max_deg);
}

void print_as_table(const CompareCommand& command, const Comparison& result, double seconds) {
  const CompareOptions& options = command.options;
  Table table;
  table.add({"reference f", command.reference + (options.symmetrise ? ", mean of f(i,v) and f(v,i)" : "")});
  table.add({"test r", command.test});
  table.add({"MRE", format_number(result.mre_percent) + " %",
             fmt::format("mean of |f - r| / max(|f|, floor), floor {:g} 1/sr", options.floor)});
  table.add({"rel L1", format_number(result.rel_l1_percent) + " %", "sum |f - r| / sum |f|"});
  table.add({"RMSE", format_number(result.rmse) + " 1/sr"});
  table.add({"largest", format_number(result.max_abs) + " 1/sr", "largest |f - r|"});
  table.add({"PSNR", format_number(result.psnr_db) + " dB", "largest |f| against the RMSE"});
  table.add({"directions", directions_text(options, result)});
  if (result.mre_left_out > 0) {
    table.add(
        {"left out", format_count(result.mre_left_out) + " values with f = 0: no relative error, not in the MRE"});
  }
  table.add({"took", format_number(seconds) + " s"});
  table.print();
}

int check_limits(const CompareCommand& command, const Comparison& result) {
  const auto fail = [&](const char* name, double value, double limit) {
    return report_error(command.test,
                        {ErrorCode::kDifference,
                         fmt::format("{} {} % is above the limit of {:g} %", name, format_number(value), limit),
                         {}});
  };
  if (command.max_mre && result.mre_values == 0) {
    return report_error(command.test, {ErrorCode::kDifference,
                                       "there is no MRE to hold against the limit: f = 0 in all " +
                                           format_count(result.mre_left_out) + " values, and the floor is 0",
                                       {}});
  }
  if (exceeds(result.mre_percent, command.max_mre)) return fail("MRE", result.mre_percent, *command.max_mre);
  if (exceeds(result.rel_l1_percent, command.max_rel_l1)) {
    return fail("rel L1", result.rel_l1_percent, *command.max_rel_l1);
  }
  return 0;
}

Result<Comparison> compare_with_bar(const BrdfSource& reference, const BrdfSource& test,
                                    const CompareOptions& options) {
  ProgressBar bar("comparing");
  return compare_sources(reference, test, options, bar.progress());
}

int run_compare(const CompareCommand& command) {
  const Result<OpenedSource> reference = open_source(command.reference, within(command.memory));
  if (!reference) return report_error(command.reference, reference.error());
  const Result<OpenedSource> test = open_source(command.test, within(command.memory));
  if (!test) return report_error(command.test, test.error());
  const Stopwatch watch;
  const Result<Comparison> result = compare_with_bar(*reference->source, *test->source, command.options);
  if (!result) return report_error(command.test, result.error());
  if (command.json) {
    print_as_json(command, *result, watch.seconds());
  } else {
    print_as_table(command, *result, watch.seconds());
  }
  return check_limits(command, *result);
}

void add_options(CLI::App& app, CompareCommand& command) {
  CompareOptions& options = command.options;
  add_number(app, "--step", options.step_deg, {0.1, 90}, "DEG", "Step of the grid in theta and phi, degrees");
  add_number(app, "--theta-max", options.theta_max_deg, {0, 90}, "DEG", "Largest theta of the grid, degrees");
  auto* random = add_count(app, "--random", options.random_count, {1, kMostPairs},
                           "Random pairs of the grid instead of all of it");
  random->default_str("");
  add_count(app, "--seed", options.seed, {}, "Start of the random numbers")->needs(random);
  app.add_flag("--symmetrise", options.symmetrise, "Replace the reference by the mean of f(i,v) and f(v,i)");
  add_number(app, "--floor", options.floor, {0}, "X", "Smallest denominator of the MRE, 1/sr");
  add_number(app, "--max-mre", command.max_mre, {0}, "PERCENT", "Exit code 5 where the MRE is above");
  add_number(app, "--max-rel-l1", command.max_rel_l1, {0}, "PERCENT", "Exit code 5 where the relative L1 is above");
  app.add_flag("--json", command.json, "Print JSON");
  add_memory_limit(app, command.memory);
}

}  // namespace

void add_compare(CLI::App& program, int& exit_code) {
  auto* app = program.add_subcommand("compare", "Differences of f_r between two BRDFs over a grid of directions.");
  const auto command = std::make_shared<CompareCommand>();
  app->add_option("REFERENCE", command->reference, "A file, kurt:NAME or kurt:FILE.json")->required();
  app->add_option("TEST", command->test, "The one to be judged, likewise")->required();
  add_options(*app, *command);
  app->footer(
      "The grid has theta_i and theta_v in 0, step, ... theta-max and phi_i and phi_v in 0, step, ... below 360 "
      "degrees.\n"
      "Values are f_r in 1/sr, without any cosine; all channels count alike.\n\n"
      "Examples:\n"
      "  sbrdf compare material.bsdf material.sbrdf --symmetrise\n"
      "  sbrdf compare kurt:fabric112 fabric112.sbrdf --random 100000 --seed 1 --max-mre 1.5");
  app->callback([command, &exit_code] { exit_code = run_compare(*command); });
}

}  // namespace sbrdf::internal
