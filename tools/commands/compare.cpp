#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "converters/files/by_name.h"
#include "converters/judge/compare.h"
#include "formats/core/named.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kMostPairs = 10'000'000'000;
constexpr std::uint64_t kDefaultCount = 1'000'000;

constexpr std::array<Named<CompareDirections>, 3> kDirectionNames = {{{"grid", CompareDirections::kGrid},
                                                                      {"random", CompareDirections::kRandom},
                                                                      {"highlight", CompareDirections::kHighlight}}};

struct CompareCommand {
  std::string reference;
  std::string test;
  std::string directions = "grid";
  CompareOptions options;
  std::optional<double> max_mre;
  std::optional<double> max_rel_l1;
  Options given;  ///< of reading, for each of the two that has them
  bool json = false;
};

const std::string& channel_name(const SourceTraits& traits, const ValuePlace& place) {
  return traits.channels[place.channel];
}

Json place_json(const ValuePlace& place, const SourceTraits& traits) {
  const DirectionPair& pair = place.pair;
  return {{"channel", channel_name(traits, place)},
          {"theta_i_deg", degrees_from_radians(pair.i.theta)},
          {"phi_i_deg", degrees_from_radians(pair.i.phi)},
          {"theta_v_deg", degrees_from_radians(pair.v.theta)},
          {"phi_v_deg", degrees_from_radians(pair.v.phi)},
          {"reference", place.reference},
          {"test", place.test}};
}

void add_figures(const ErrorFigures& figures, const SourceTraits& traits, Json& json) {
  json["mre_percent"] = figures.mre_percent;
  json["rel_l1_percent"] = figures.rel_l1_percent;
  json["cosine_rel_l1_percent"] = figures.cosine_rel_l1_percent;
  json["relative_p99_percent"] = figures.relative_p99_percent;
  json["relative_p999_percent"] = figures.relative_p999_percent;
  json["max_relative_percent"] = figures.max_relative_percent;
  if (figures.max_relative_percent > 0) json["max_relative_at"] = place_json(figures.max_relative_at, traits);
  json["rmse"] = figures.rmse;
  json["max_abs"] = figures.max_abs;
  if (figures.max_abs > 0) json["max_abs_at"] = place_json(figures.max_abs_at, traits);
  json["psnr_db"] = figures.psnr_db;
  json["mre_left_out"] = figures.mre_left_out;
}

Json false_values_json(const FalseValues& found, const SourceTraits& traits) {
  Json json = {{"count", found.count}, {"factor", kFalseFactor}, {"within_deg", kNeighbourhoodDeg}};
  if (found.count > 0) {
    json["worst_factor"] = found.worst_factor;
    json["worst_at"] = place_json(found.worst, traits);
  }
  json["strict"] = {{"count", found.strict_count()},
                    {"too_large", found.too_large},
                    {"too_small", found.too_small},
                    {"factor", kStrictFactor}};
  if (found.strict_count() > 0) json["strict"]["worst_at"] = place_json(found.strict_worst_at, traits);
  json["complete"] = found.complete;
  return json;
}

void print_as_json(const CompareCommand& command, const SourceTraits& traits, const Comparison& result,
                   double seconds) {
  const CompareOptions& options = command.options;
  Json json = {{"reference", command.reference}, {"test", command.test}};
  add_figures(result, traits, json);
  json["channels"] = Json::array();
  for (std::size_t c = 0; c < result.channels.size(); ++c) {
    Json channel = {{"name", traits.channels[c]}};
    add_figures(result.channels[c], traits, channel);
    json["channels"].push_back(channel);
  }
  json["false_values"] = false_values_json(result.false_values, traits);
  json["drawn"] = command.directions;
  json["directions"] = result.directions;
  json["grid_directions"] = result.grid_directions;
  json["unmeasured_directions"] = result.unmeasured;
  json["floor"] = result.floor;
  if (options.directions == CompareDirections::kGrid) json["step_deg"] = options.step_deg;
  json["theta_max_deg"] = options.theta_max_deg;
  if (options.random_count > 0) json["seed"] = options.seed;
  json["symmetrised"] = options.symmetrise;
  json["seconds"] = seconds;
  print_json(json);
}

std::string directions_text(const CompareOptions& options, const Comparison& result) {
  std::string text = format_count(result.directions) + " pairs";
  if (options.directions != CompareDirections::kGrid) {
    const bool dense = options.directions == CompareDirections::kHighlight;
    return text + fmt::format(", drawn with seed {} at random{}, theta up to {:g} degrees", options.seed,
                              dense ? ", densely around the mirror direction and weighted in return" : "",
                              options.theta_max_deg);
  }
  if (options.random_count > 0) {
    text += fmt::format(", drawn with seed {} from", options.seed);
  } else if (result.grid_directions != result.directions + result.unmeasured) {
    text += ", both isotropic, for the " + format_count(result.grid_directions) + " of";
  } else {
    text += ",";
  }
  return text + fmt::format(" the {:g}-degree grid up to theta {:g} degrees", options.step_deg, options.theta_max_deg);
}

std::string at_least(const FalseValues& found, std::uint64_t count) {
  return (found.complete ? "" : "at least ") + format_count(count);
}

/// A row with a figure of all channels together and of each.
class FigureRows {
 public:
  FigureRows(const Comparison& result, const SourceTraits& traits) : result_(result) {
    const std::size_t columns = result.channels.size();
    if (columns > 1 && columns <= kMostChannelColumns) shown_ = traits.channels;
    std::vector<std::string> heads = {"", "all"};
    heads.insert(heads.end(), shown_.begin(), shown_.end());
    if (!shown_.empty()) table_.add(heads);
  }
  void add(const std::string& name, double ErrorFigures::*figure, const std::string& unit, const std::string& meaning) {
    std::vector<std::string> row = {name, format_number(result_.*figure)};
    for (std::size_t c = 0; c < shown_.size(); ++c) row.push_back(format_number(result_.channels[c].*figure));
    row.push_back(unit);
    row.push_back(meaning);
    table_.add(row);
  }
  void print() const { table_.print(); }

 private:
  const Comparison& result_;
  std::vector<std::string> shown_;
  Table table_;
};

void print_figures(const Comparison& result, const SourceTraits& traits) {
  FigureRows rows(result, traits);
  rows.add("MRE", &ErrorFigures::mre_percent, "%",
           fmt::format("mean of |f - r| / max(|f|, floor), floor {:.4g} 1/sr", result.floor));
  rows.add("99 %", &ErrorFigures::relative_p99_percent, "%", "of these relative errors are at most so large");
  rows.add("99.9 %", &ErrorFigures::relative_p999_percent, "%", "likewise");
  rows.add("largest", &ErrorFigures::max_relative_percent, "%", "of these relative errors");
  rows.add("rel L1", &ErrorFigures::rel_l1_percent, "%", "sum |f - r| / sum |f|");
  rows.add("rel L1, cosines", &ErrorFigures::cosine_rel_l1_percent, "%", "with cos theta_i cos theta_v before both");
  rows.add("RMSE", &ErrorFigures::rmse, "1/sr", "");
  rows.add("largest", &ErrorFigures::max_abs, "1/sr", "|f - r|");
  rows.add("PSNR", &ErrorFigures::psnr_db, "dB", "largest |f| against the RMSE");
  rows.print();
}

void print_as_table(const CompareCommand& command, const SourceTraits& traits, const Comparison& result,
                    double seconds) {
  const CompareOptions& options = command.options;
  Table table;
  table.add({"reference f", command.reference + (options.symmetrise ? ", mean of f(i,v) and f(v,i)" : "")});
  table.add({"test r", command.test});
  table.add({"directions", directions_text(options, result)});
  if (result.unmeasured > 0) {
    table.add({"", format_count(result.unmeasured) + " more are left out, which one of the two did not measure"});
  }
  if (result.max_relative_percent > 0) table.add({"largest %", place_text(result.max_relative_at, traits.channels)});
  if (result.max_abs > 0) table.add({"largest |f - r|", place_text(result.max_abs_at, traits.channels)});
  const FalseValues& found = result.false_values;
  table.add({"false values",
             at_least(found, found.count) + fmt::format(" above {:g} times the largest |f| within {:g} degrees",
                                                        kFalseFactor, kNeighbourhoodDeg)});
  table.add({"strictly", at_least(found, found.strict_count()) +
                             fmt::format(" beyond {:g} times the largest |f| or the least f of their channel there",
                                         kStrictFactor)});
  if (found.strict_count() > 0) table.add({"worst of these", place_text(found.strict_worst_at, traits.channels)});
  if (result.mre_left_out > 0) {
    table.add(
        {"left out", format_count(result.mre_left_out) + " values with f = 0: no relative error, not in the MRE"});
  }
  table.add({"took", format_number(seconds) + " s"});
  print_figures(result, traits);
  print("\n");
  table.print();
}

void warn_of_false_values(const CompareCommand& command, const SourceTraits& traits, const FalseValues& found) {
  if (found.count == 0) return;
  print_note(
      command.test,
      fmt::format("warning: false values: {} above {:g} times all that the reference has within {:g} degrees; worst, "
                  "{} times, {}",
                  at_least(found, found.count), kFalseFactor, kNeighbourhoodDeg, format_number(found.worst_factor),
                  place_text(found.worst, traits.channels)));
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
  const std::array inputs = {command.reference, command.test};
  if (Status used = check_reading_options(command.given, inputs); !used) {
    return report_error(command.reference, used.error());
  }
  const Result<OpenedSource> reference = open_source(command.reference, command.given);
  if (!reference) return report_error(command.reference, reference.error());
  const Result<OpenedSource> test = open_source(command.test, command.given);
  if (!test) return report_error(command.test, test.error());
  const Stopwatch watch;
  const Result<Comparison> result = compare_with_bar(*reference->source, *test->source, command.options);
  if (!result) return report_error(command.test, result.error());
  const SourceTraits& traits = reference->source->traits();
  if (command.json) {
    print_as_json(command, traits, *result, watch.seconds());
  } else {
    print_as_table(command, traits, *result, watch.seconds());
  }
  const int exit_code = check_limits(command, *result);
  if (exit_code == 0) warn_of_false_values(command, traits, result->false_values);  // one line is enough
  return exit_code;
}

/// The options that choose directions, of which not all go together.
struct DirectionOptions {
  CLI::Option* step;
  CLI::Option* random;
  CLI::Option* count;
  CLI::Option* seed;
};

// Each has an effect or is refused.
void settle_directions(const DirectionOptions& given, std::uint64_t count, CompareCommand& command) {
  const CompareDirections directions = *value_of(kDirectionNames, command.directions);
  command.options.directions = directions;
  const auto refuse = [](const CLI::Option* option, const char* why) {
    if (option->count() > 0) throw CLI::ValidationError(option->get_name() + " " + why);
  };
  if (directions == CompareDirections::kGrid) {
    refuse(given.count, "needs --directions random or highlight; of the grid, --random N takes N pairs");
    if (given.random->count() == 0) refuse(given.seed, "has no effect on the whole grid, where nothing is drawn");
    return;
  }
  refuse(given.random, "takes pairs of the grid; with --directions random or highlight say --count");
  refuse(given.step, "is the step of the grid; random directions have none");
  if (command.options.theta_max_deg == 0) {
    throw CLI::ValidationError("--theta-max must be above 0 degrees for random directions");
  }
  command.options.random_count = count;
}

DirectionOptions add_direction_options(CLI::App& app, CompareCommand& command, std::uint64_t& count) {
  CompareOptions& options = command.options;
  const auto names = names_of(kDirectionNames);
  app.add_option("--directions", command.directions,
                 "The grid; random pairs between its nodes; or such pairs drawn densely around the mirror direction "
                 "and weighted in return")
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->capture_default_str();
  DirectionOptions added{};
  added.count = add_count(app, "--count", count, {1, kMostPairs}, "Pairs of --directions random and highlight");
  added.step =
      add_number(app, "--step", options.step_deg, {0.1, 90}, "DEG", "Step of the grid in theta and phi, degrees");
  added.random = add_count(app, "--random", options.random_count, {1, kMostPairs},
                           "Random pairs of the grid instead of all of it");
  added.random->default_str("");
  added.seed = add_count(app, "--seed", options.seed, {}, "Start of the random numbers");
  add_number(app, "--theta-max", options.theta_max_deg, {0, 90}, "DEG", "Largest theta, degrees");
  return added;
}

void add_other_options(CLI::App& app, CompareCommand& command) {
  app.add_flag("--symmetrise", command.options.symmetrise, "Replace the reference by the mean of f(i,v) and f(v,i)");
  add_number(app, "--floor", command.options.floor, {0}, "X",
             "Smallest denominator of relative errors, 1/sr; unless given 0 on the grid, else a hundredth of the mean "
             "|f|");
  add_number(app, "--max-mre", command.max_mre, {0}, "PERCENT", "Exit code 5 where the MRE is above");
  add_number(app, "--max-rel-l1", command.max_rel_l1, {0}, "PERCENT", "Exit code 5 where the relative L1 is above");
  app.add_flag("--json", command.json, "Print JSON");
  add_reading_options(app, command.given);
}

}  // namespace

void add_compare(CLI::App& program, int& exit_code) {
  auto* app =
      program.add_subcommand("compare", "Differences of f_r between two BRDFs, on a grid or between its nodes.");
  const auto command = std::make_shared<CompareCommand>();
  const auto count = std::make_shared<std::uint64_t>(kDefaultCount);
  app->add_option("REFERENCE", command->reference, "A file, kurt:NAME or kurt:FILE.json")->required();
  app->add_option("TEST", command->test, "The one to be judged, likewise")->required();
  const DirectionOptions given = add_direction_options(*app, *command, *count);
  add_other_options(*app, *command);
  app->footer(
      "The grid has theta_i and theta_v in 0, step, ... theta-max and phi_i and phi_v in 0, step, ... below 360 "
      "degrees.\n"
      "Random directions have theta uniform in [0, theta-max] and phi uniform. Narrow highlights lie on the grid or\n"
      "between its nodes: what a file is worth there, random and highlight tell.\n"
      "Values are f_r in 1/sr, without any cosine; all channels count alike.\n"
      "A value is false where the reference has none nearly as large within 3 degrees.\n\n"
      "Examples:\n"
      "  sbrdf compare material.bsdf material.sbrdf --symmetrise\n"
      "  sbrdf compare material.bsdf material.sbrdf --symmetrise --directions highlight\n"
      "  sbrdf compare kurt:fabric112 fabric112.sbrdf --random 100000 --seed 1 --max-mre 1.5");
  app->callback([command, count, given, &exit_code] {
    settle_directions(given, *count, *command);
    exit_code = run_compare(*command);
  });
}

}  // namespace sbrdf::internal
