#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "converters/judge/compare.h"
#include "converters/models/analytic.h"
#include "converters/models/analytic_fit.h"
#include "converters/source/reciprocity.h"
#include "formats/os/files.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kJudgedPairs = 200'000;

struct FitCommand {
  std::string in;
  std::string out;
  AnalyticFitOptions fit;
  std::string model = "kurt";
  std::string metric = "log";
  Options given;  ///< of reading IN
  bool json = false;
};

/// The row of the files that are written.
const Format& format_of(LobeKind kind) {
  const auto rows = formats();
  return *std::find_if(rows.begin(), rows.end(),
                       [&](const Format& row) { return row.name == name_of(kLobeKindNames, kind); });
}

/// How far the model is from the source, on directions that are dense in highlights.
Result<Comparison> judge(const BrdfSource& source, const AnalyticModel& model) {
  CompareOptions options;
  options.directions = CompareDirections::kHighlight;
  options.random_count = kJudgedPairs;
  options.theta_max_deg = source.traits().slice_theta_max_deg;
  options.symmetrise = !source.traits().reciprocal;
  options.false_values = FalseValueSearch::kNone;
  return compare_sources(source, *make_analytic_source(model), options);
}

/// One channel stands for three.
class ThreeChannels final : public BrdfSource {
 public:
  explicit ThreeChannels(const BrdfSource& source) : source_(source), traits_(source.traits()) {
    traits_.channels = {"R", "G", "B"};
  }
  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    std::vector<float> grey(pairs.size());
    source_.evaluate(pairs, grey);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = grey[k / 3];
  }
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
    source_.measured(pairs, flags);
  }
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override { return source_.mask_grid(); }

 private:
  const BrdfSource& source_;
  SourceTraits traits_;
};

std::string three(const std::array<double, 3>& values) {
  return fmt::format("{:.4g}, {:.4g}, {:.4g}", values[0], values[1], values[2]);
}

std::string lobe_text(const AnalyticLobe& lobe, LobeKind kind) {
  std::string text = "k_s " + three(lobe.k_s);
  if (kind != LobeKind::kWard) text += fmt::format("; f_0 {:.4g}", lobe.f_0);
  if (kind != LobeKind::kKurt) return text + fmt::format("; alpha_x {:.4g}, alpha_y {:.4g}", lobe.m_x, lobe.m_y);
  return text + fmt::format("; m_x {:.4g}, m_y {:.4g}; alpha {:.4g}", lobe.m_x, lobe.m_y, lobe.alpha);
}

void print_fit(const FitCommand& command, const AnalyticFit& fit, const Comparison& errors, std::size_t bytes,
               double reciprocity_percent) {
  Table table;
  table.add({"wrote", fmt::format("{}: {} bytes, {} numbers", command.out, format_count(bytes),
                                  3 + (3 + shape_count(fit.model.kind)) * fit.model.lobes.size())});
  table.add(
      {"fitted to", fmt::format("{} pairs of directions, rms {:.4g} of the metric {}; {} of {} starts that were "
                                "followed to their end found this minimum",
                                format_count(fit.pairs), fit.rms, command.metric, fit.same_minimum, fit.finished)});
  if (reciprocity_percent > 0) {
    table.add({"", "f(i,v) and f(v,i) differ by " + percent_text(reciprocity_percent) + "; their mean was fitted"});
  }
  table.add({"error", fmt::format("MRE {:.3f} %, relative L1 {:.3f} %, on {} directions dense in highlights",
                                  errors.mre_percent, errors.rel_l1_percent, format_count(errors.directions))});
  table.add({"", fmt::format("the largest difference is {:.4g} 1/sr", errors.max_abs)});
  table.add({"diffuse", "k_d " + three(fit.model.k_d)});
  for (const AnalyticLobe& lobe : fit.model.lobes) table.add({"lobe", lobe_text(lobe, fit.model.kind)});
  table.print();
}

Json fit_json(const FitCommand& command, const AnalyticFit& fit, const Comparison& errors, std::size_t bytes,
              double reciprocity_percent) {
  return {{"in", command.in},
          {"out", command.out},
          {"bytes", bytes},
          {"model", command.model},
          {"parameters", Json::parse(emit_analytic_json(fit.model))},
          {"metric", command.metric},
          {"rms", fit.rms},
          {"pairs", fit.pairs},
          {"starts", command.fit.starts},
          {"finished", fit.finished},
          {"same_minimum", fit.same_minimum},
          {"reciprocity_difference_percent", reciprocity_percent},
          {"mre_percent", errors.mre_percent},
          {"rel_l1_percent", errors.rel_l1_percent},
          {"largest", errors.max_abs},
          {"directions", errors.directions}};
}

int run_fit(FitCommand command) {
  command.fit.kind = value_of(kLobeKindNames, command.model).value_or(command.fit.kind);
  command.fit.metric = value_of(kFitMetricNames, command.metric).value_or(command.fit.metric);
  if (lower_extension(command.out) != ".json") {
    return report_error(command.out, usage_error("parameters are written as JSON: the name must end with .json"));
  }
  const std::span inputs(&command.in, 1);
  if (Status free = check_output(command.out, &format_of(command.fit.kind), inputs); !free) {
    return report_error(command.out, free.error());
  }
  if (Status used = check_reading_options(command.given, inputs); !used) return report_error(command.in, used.error());
  const Result<OpenedSource> opened = open_source(command.in, command.given);
  if (!opened) return report_error(command.in, opened.error());
  const BrdfSource& source = *opened->source;
  Result<AnalyticFit> fit = [&] {
    ProgressBar bar("fitting");
    return fit_analytic(source, command.fit, bar.progress());
  }();
  if (!fit) return report_error(command.in, fit.error());
  fit->model.name = std::filesystem::path(command.out).stem().string();
  const ThreeChannels grey(source);
  const Result<Comparison> errors = judge(source.channel_count() == 1 ? grey : source, fit->model);
  if (!errors) return report_error(command.in, errors.error());
  const std::string text = emit_analytic_json(fit->model);
  if (Status written = write_file_atomically(command.out, std::as_bytes(std::span(text))); !written) {
    return report_error(command.out, written.error());
  }
  const double reciprocity = reciprocity_difference_percent(source);
  if (command.json) {
    print_json(fit_json(command, *fit, *errors, text.size(), reciprocity));
  } else {
    print_fit(command, *fit, *errors, text.size(), reciprocity);
  }
  return 0;
}

}  // namespace

void add_fit(CLI::App& program, int& exit_code) {
  auto* app = program.add_subcommand("fit", "Fits an analytic model: is a formula enough for this material?");
  const auto command = std::make_shared<FitCommand>();
  app->add_option("IN", command->in, "A file of any readable format, kurt:NAME or BUNDLE.sbrdfz:NAME")->required();
  app->add_option("OUT", command->out, "The file of parameters to write, NAME.json; every command reads it")
      ->required();
  const auto models = names_of(kLobeKindNames);
  app->add_option("--model", command->model, "The formula, see specs/models.md")
      ->check(CLI::IsMember(std::vector<std::string>(models.begin(), models.end())))
      ->capture_default_str();
  add_count(*app, "--lobes", command->fit.lobes, {1, kMostFitLobes}, "Specular lobes");
  const auto metrics = names_of(kFitMetricNames);
  app->add_option("--metric", command->metric,
                  "Squares are of differences of logarithms, where all values count alike, or of cube roots, where "
                  "bright ones count more")
      ->check(CLI::IsMember(std::vector<std::string>(metrics.begin(), metrics.end())))
      ->capture_default_str();
  add_count(*app, "--starts", command->fit.starts, {1, kMostFitStarts}, "Sets of roughness that are begun with");
  app->add_flag("--json", command->json, "Print JSON");
  add_reading_options(*app, command->given);
  app->footer(
      "Every parameter is found from a cold start, the same on any number of threads. Errors are measured off the "
      "grid,\n"
      "on directions that are dense in highlights; sbrdf compare IN OUT.json measures them elsewhere.\n\n"
      "Examples:\n"
      "  sbrdf fit material.binary material.json --lobes 2\n"
      "  sbrdf fit material.binary material.json --model ggx\n"
      "  sbrdf compare material.binary material.json --symmetrise");
  app->callback([command, &exit_code] { exit_code = run_fit(*command); });
}

}  // namespace sbrdf::internal
