#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "converters/merl.h"
#include "converters/slicing.h"
#include "tools/commands.h"
#include "tools/sources.h"
#include "tools/terminal.h"

namespace sbrdf {
namespace {

using Json = nlohmann::ordered_json;

/// Metadata nested deeper than this is shown as text: writing it out recurses.
constexpr int kDeepestMetadata = 64;

Json parse_metadata(const std::string& text) {
  bool too_deep = false;
  const auto watch_depth = [&](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > kDeepestMetadata;
    return !too_deep;
  };
  Json metadata = Json::parse(text, watch_depth, false);
  if (metadata.is_discarded() || too_deep) return text;
  return metadata;
}

/// The spacing of azimuths that divide the whole turn evenly, else null.
Json azimuth_step(const std::vector<double>& nodes_deg) {
  if (nodes_deg.empty()) return nullptr;
  const double step = 360 / static_cast<double>(nodes_deg.size());
  for (std::size_t k = 0; k < nodes_deg.size(); ++k) {
    if (std::abs(nodes_deg[k] - static_cast<double>(k) * step) > 1e-9) return nullptr;
  }
  return step;
}

Json placement_of(const FrameSpec& frame) {
  Json placement = {{"elevation_step_deg", nullptr}, {"azimuth_step_deg", nullptr}, {"elevations_deg", nullptr}};
  if (frame.id == FrameId::kElevation) {
    const std::vector<double>& elevations = frame.axes[kVertical].nodes_deg;
    if (elevations.size() > 1) placement["elevation_step_deg"] = elevations[1];
    placement["azimuth_step_deg"] = azimuth_step(frame.axes[kDiagonal].nodes_deg);
    placement["elevations_deg"] = elevations;
  }
  for (const Axis& axis : frame.axes) placement["nodes_deg"][axis.name] = axis.nodes_deg;
  return placement;
}

void add_sliced(const SlicedSource& source, Json& json) {
  const SlicedBrdf& sliced = source.sliced();
  const std::size_t crossings = sliced.crossing_count();
  json["version"] = source.version();
  json["frame"] = geometry(sliced.frame.id).name();
  json["domain"] = sliced.domain.kind == DomainKind::kLog ? "log" : "linear";
  json["symmetries"] = {{"mirror_x", sliced.frame.symmetries.mirror_x}, {"mirror_y", sliced.frame.symmetries.mirror_y}};
  json["placement"] = placement_of(sliced.frame);
  json["samples"] = {{"crossings", crossings},
                     {"adaptive", sliced.adaptive_count()},
                     {"guide", sliced.guide_count()},
                     {"total", sliced.sample_count()}};
  json["metadata"] = parse_metadata(sliced.metadata);
}

Json describe(const OpenedSource& opened) {
  const SourceTraits& traits = opened.source->traits();
  Json json = {{"format", traits.format},         {"description", traits.description}, {"isotropic", traits.isotropic},
               {"reciprocal", traits.reciprocal}, {"channels", traits.channels},       {"bytes", nullptr},
               {"findings", Json::array()}};
  if (opened.bytes) json["bytes"] = *opened.bytes;
  for (const Finding& finding : traits.findings) {
    json["findings"].push_back({{"what", finding.what}, {"count", finding.count}, {"total", finding.total}});
  }
  if (const auto* merl = dynamic_cast<const MerlSource*>(opened.source.get())) json["shape"] = merl->table().shape;
  if (const auto* sliced = dynamic_cast<const SlicedSource*>(opened.source.get())) add_sliced(*sliced, json);
  return json;
}

/// A value on one line, text without its quotes.
std::string plain(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void add_rows(Table& table, const std::string& name, const Json& value) {
  if (value.is_object()) {
    for (const auto& [key, member] : value.items()) add_rows(table, std::string(name).append(".").append(key), member);
  } else {
    table.add({name, plain(value)});
  }
}

void print_as_table(const OpenedSource& opened, const Json& json) {
  const SourceTraits& traits = opened.source->traits();
  Table table;
  for (const auto& [key, value] : json.items()) {
    if (key == "channels") {
      table.add({key, join(traits.channels)});
    } else if (key == "findings") {
      for (const Finding& finding : traits.findings) {
        table.add({key, format_count(finding.count) + " of " + format_count(finding.total) + " " + finding.what});
      }
    } else {
      add_rows(table, key, value);
    }
  }
  table.print();
}

int run_info(const std::string& file, bool as_json) {
  const Result<OpenedSource> opened = open_source(file);
  if (!opened) return report_error(file, opened.error());
  const Json json = describe(*opened);
  if (as_json) {
    print_json(json);
  } else {
    print_as_table(*opened, json);
  }
  return 0;
}

struct InfoOptions {
  std::string file;
  bool json = false;
};

}  // namespace

void add_info(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("info", "Tells what a file holds: format, channels, placement, samples.");
  const auto options = std::make_shared<InfoOptions>();
  command->add_option("FILE", options->file, "A file of any readable format, kurt:NAME or kurt:FILE.json")->required();
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Angles are in degrees, sizes in bytes.\n\nExample:\n  sbrdf info material.sbrdf --json");
  command->callback([options, &exit_code] { exit_code = run_info(options->file, options->json); });
}

}  // namespace sbrdf
