#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "codec/coding/chunk_layout.h"
#include "codec/file/reader.h"
#include "converters/files/by_name.h"
#include "converters/files/sliced/sliced.h"
#include "converters/judge/compare.h"
#include "converters/slicing/metadata_json.h"
#include "converters/slicing/names.h"
#include "formats/os/files.h"
#include "tools/commands/commands.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

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

void add_sliced(const DecodedSliced& content, Json& json) {
  const SlicedBrdf& sliced = content.sliced;
  const std::size_t crossings = sliced.crossing_count();
  json["version"] = content.version;
  json["frame"] = geometry(sliced.frame.id).name();
  json["domain"] = name_of(kDomainNames, sliced.domain.kind);
  json["symmetries"] = {{"mirror_x", sliced.frame.symmetries.mirror_x}, {"mirror_y", sliced.frame.symmetries.mirror_y}};
  json["placement"] = placement_of(sliced.frame);
  json["precision_percent"] = 100 * content.precision;
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
  if (!traits.shape.empty()) json["shape"] = traits.shape;
  if (const DecodedSliced* content = opened.source->sliced()) add_sliced(*content, json);
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

struct InfoOptions {
  std::string file;
  std::string against;
  bool levels = false;
  bool json = false;
};

/// A level of detail: what reading up to it takes, and how far it is from the reference.
struct LevelRow {
  int level = 0;
  std::uint64_t bytes = 0;
  std::uint64_t samples = 0;
  Comparison error;
};

// The deepest level that has samples; levels above give the same.
int deepest_level(const SlicedBrdf& sliced) {
  int deepest = 0;
  for (const SamplePosition& place : sliced.positions) deepest = std::max(deepest, depth_of(place.fraction));
  return deepest;
}

Result<std::vector<LevelRow>> measure_levels(const InfoOptions& options) {
  const Result<std::shared_ptr<const ByteSource>> file = open_sliced_bytes(options.file, "levels of detail");
  if (!file) return file.error();
  const Result<SlicedReader> reader = SlicedReader::open(**file);
  if (!reader) return reader.error();
  Result<SlicedBrdf> whole = reader->load_all();
  if (!whole) return whole.error();
  const int deepest = deepest_level(*whole);
  std::unique_ptr<BrdfSource> reference;
  if (options.against.empty()) {
    reference = std::make_unique<SlicedSource>(DecodedSliced{*std::move(whole), reader->lattice()});
  } else {
    Result<OpenedSource> opened = open_source(options.against);
    if (!opened) {
      Error error = opened.error();
      error.message = options.against + ": " + error.message;
      return error;
    }
    reference = std::move(opened->source);
  }
  CompareOptions compare;
  compare.random_count = 100'000;
  compare.symmetrise = !reference->traits().reciprocal;
  std::vector<LevelRow> rows;
  for (int level = 0; level <= deepest; ++level) {
    Result<SlicedBrdf> part = reader->load_all(level);
    if (!part) return part.error();
    LevelRow row = {level, reader->bytes_up_to(level), part->sample_count(), {}};
    const SlicedSource test({*std::move(part), reader->lattice()});
    const Result<Comparison> error = compare_sources(*reference, test, compare);
    if (!error) return error.error();
    row.error = *error;
    rows.push_back(row);
  }
  return rows;
}

int run_levels(const InfoOptions& options) {
  const Result<std::vector<LevelRow>> rows = measure_levels(options);
  if (!rows) return report_error(options.file, rows.error());
  Json json = Json::array();
  Table table;
  table.add({"level", "samples", "bytes to read", "MRE [%]", "relative L1 [%]"});
  for (const LevelRow& row : *rows) {
    json.push_back({{"level", row.level},
                    {"samples", row.samples},
                    {"bytes", row.bytes},
                    {"mre_percent", row.error.mre_percent},
                    {"rel_l1_percent", row.error.rel_l1_percent}});
    table.add({std::to_string(row.level), format_count(row.samples), format_count(row.bytes),
               format_number(row.error.mre_percent), format_number(row.error.rel_l1_percent)});
  }
  if (options.json) {
    print_json(json);
    return 0;
  }
  table.print();
  print("Errors against " + (options.against.empty() ? "the whole file" : one_line(options.against)) +
        ", over 100,000 random pairs of the 2-degree grid.\n");
  return 0;
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

}  // namespace

void add_info(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("info", "Tells what a file holds: format, channels, placement, samples.");
  const auto options = std::make_shared<InfoOptions>();
  command->add_option("FILE", options->file, "A file of any readable format, kurt:NAME or kurt:FILE.json")->required();
  auto* levels =
      command->add_flag("--levels", options->levels, "Of a sliced file: bytes and error of each level of detail");
  command->add_option("--against", options->against, "With --levels: the source that errors are measured against")
      ->needs(levels)
      ->type_name("SOURCE");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Angles are in degrees, sizes in bytes.\n\nExamples:\n  sbrdf info material.sbrdf --json\n"
      "  sbrdf info fabric112.sbrdf --levels --against kurt:fabric112");
  command->callback([options, &exit_code] {
    exit_code = options->levels ? run_levels(*options) : run_info(options->file, options->json);
  });
}

}  // namespace sbrdf::internal
