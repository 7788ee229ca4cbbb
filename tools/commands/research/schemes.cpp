#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "converters/baselines/schemes.h"
#include "tools/commands/commands.h"
#include "tools/console/plain_text.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

double step_deg(const Ring& ring) { return 360.0 / static_cast<double>(ring.count); }

Json scheme_json(const UniformScheme& scheme) {
  Json rings = Json::array();
  for (const Ring& ring : scheme.rings) {
    rings.push_back({{"theta_deg", ring.theta_deg}, {"azimuth_step_deg", step_deg(ring)}, {"count", ring.count}});
  }
  return {{"name", scheme.name},
          {"directions", scheme.direction_count()},
          {"pairs", scheme.pair_count()},
          {"reciprocal_pairs", scheme.reciprocal_pair_count()},
          {"rings", rings}};
}

void print_schemes(const std::vector<UniformScheme>& schemes) {
  Table table;
  table.add({"scheme", "rings", "directions", "light x view", "reciprocal"});
  for (const UniformScheme& scheme : schemes) {
    table.add({scheme.name, std::to_string(scheme.rings.size()), format_count(scheme.direction_count()),
               format_count(scheme.pair_count()), format_count(scheme.reciprocal_pair_count())});
  }
  table.print();
}

void print_rings(const UniformScheme& scheme) {
  Table table;
  table.add({"theta", "azimuth step", "directions"});
  for (const Ring& ring : scheme.rings) {
    table.add(
        {fmt::format("{:g} deg", ring.theta_deg), fmt::format("{:g} deg", step_deg(ring)), std::to_string(ring.count)});
  }
  print("\n" + one_line(scheme.name) + "\n");
  table.print();
}

int run_schemes(const std::vector<std::string>& names, bool as_json) {
  std::vector<UniformScheme> schemes;
  for (const std::string& name : names) {
    Result<UniformScheme> scheme = scheme_by_name(name);
    if (!scheme) return report_error(name, scheme.error());
    schemes.push_back(*std::move(scheme));
  }
  if (names.empty()) schemes = paper_schemes();
  if (as_json) {
    Json json = Json::array();
    for (const UniformScheme& scheme : schemes) json.push_back(scheme_json(scheme));
    print_json(json);
    return 0;
  }
  print_schemes(schemes);
  if (names.empty()) return 0;
  for (const UniformScheme& scheme : schemes) print_rings(scheme);
  return 0;
}

}  // namespace

void add_schemes(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("schemes", "Lists uniform sampling schemes, and what each has to measure.");
  const auto names = std::make_shared<std::vector<std::string>>();
  const auto json = std::make_shared<bool>(false);
  command->add_option("SCHEME", *names, "1 to 30 of the paper's Table 1, or FILE.json; all thirty unless given");
  command->add_flag("--json", *json, "Print JSON, with the rings of each");
  command->footer(
      "A scheme is a set of directions that light and viewer go through independently: rings about the normal.\n"
      "One of your own is a JSON file:\n"
      "  {\"name\": \"mine\", \"rings\": [{\"theta_deg\": 0, \"count\": 1}, {\"theta_deg\": 40, \"count\": 12}]}\n\n"
      "Example:\n  sbrdf schemes 14 19");
  command->callback([names, json, &exit_code] { exit_code = run_schemes(*names, *json); });
}

}  // namespace sbrdf::internal
