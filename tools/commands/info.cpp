#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "codec/coding/chunk_layout.h"
#include "codec/coding/quantizer.h"
#include "codec/file/reader.h"
#include "codec/series/series_file.h"
#include "codec/series/series_table.h"
#include "converters/files/analytic/analytic_file.h"
#include "converters/files/by_name.h"
#include "converters/files/sliced/series_source.h"
#include "converters/files/sliced/sliced.h"
#include "converters/judge/compare.h"
#include "converters/slicing/metadata_json.h"
#include "converters/slicing/names.h"
#include "converters/source/findings_json.h"
#include "formats/os/files.h"
#include "formats/sbrdf/container.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
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

// Out of the index and the metadata: samples are not read.
void add_sliced(const SlicedReader& reader, const std::string& metadata, Json& json) {
  const SlicedIndex& index = reader.index();
  const std::size_t crossings = reader.lattice().crossings.size();
  json["version"] = reader.version();
  json["frame"] = geometry(index.frame.id).name();
  json["domain"] = name_of(kDomainNames, index.domain);
  json["symmetries"] = {{"mirror_x", index.frame.symmetries.mirror_x}, {"mirror_y", index.frame.symmetries.mirror_y}};
  json["placement"] = placement_of(index.frame);
  json["precision_percent"] = index.scale.lossless() ? 0 : millionths_of(index.scale.bound()) / 1e4;
  json["samples"] = {{"crossings", crossings},
                     {"adaptive", index.adaptive_count},
                     {"guide", index.guide_count},
                     {"total", crossings + index.adaptive_count + index.guide_count}};
  if (const auto& mask = index.mask) {
    const bool angles = mask->frame == MaskFrame::kAngles;
    json["mask"] = {{"frame", angles ? "angles" : "half-difference"}, {"cells", mask->counts}};
  }
  json["metadata"] = parse_metadata(metadata);
}

Json describe(const SourceTraits& traits, std::optional<std::uint64_t> bytes) {
  Json json = {{"format", traits.format},
               {"description", traits.description},
               {"isotropic", traits.isotropic},
               {"reciprocal", traits.reciprocal},
               {"channels", traits.channels},
               {"bytes", nullptr},
               {"findings", Json()},
               {"theta_max_deg", traits.theta_max_deg}};
  if (bytes) json["bytes"] = *bytes;
  json["findings"] = findings_json(traits.findings);
  if (!traits.shape.empty()) json["shape"] = traits.shape;
  return json;
}

// Coefficients are read, the table is not made.
void add_dense(const SeriesBrdf& brdf, Json& json) {
  const auto nodes = table_nodes(brdf);
  json["representation"] = "dense";
  json["symmetries"] = {{"mirror_x", brdf.symmetries.mirror_x}, {"mirror_y", brdf.symmetries.mirror_y}};
  json["functions"] = {{"theta_h", brdf.shape.theta_h},
                       {"theta_d", brdf.shape.theta_d},
                       {"phi_d", brdf.shape.phi_d},
                       {"phi_h", brdf.shape.phi_h}};
  json["warp"] = {{"width_deg", brdf.warp.width_deg()}, {"power", brdf.warp.power()}};
  json["fields"] = brdf.field_count();
  json["coefficients"] = brdf.coefficient_count();
  json["table"] = {{"nodes", {nodes[0].size(), nodes[1].size(), nodes[2].size(), nodes[3].size()}},
                   {"bytes", table_bytes(brdf)}};
  json["metadata"] = parse_metadata(brdf.metadata);
}

/// What a file is, and all that info has to say of it.
struct Description {
  SourceTraits traits;
  Json json;
};

Result<Description> describe_dense(const ByteSource& file, const MemoryLimit& limit) {
  const Result<SeriesBrdf> brdf = decode_series(file);
  if (!brdf) return brdf.error();
  const Status fits = check_memory(static_cast<double>(table_bytes(*brdf)), limit.of(file.size()));
  if (!fits) return fits.error();
  const SourceTraits traits = series_traits(*brdf);
  Json json = describe(traits, file.size());
  add_dense(*brdf, json);
  return Description{traits, std::move(json)};
}

Result<Description> describe_sliced(const ByteSource& file, const MemoryLimit& limit) {
  const Result<SlicedReader> reader = SlicedReader::open(file, limit);
  if (!reader) return reader.error();
  const Result<std::string> metadata = reader->metadata();
  if (!metadata) return metadata.error();
  const SourceTraits traits = sliced_traits(reader->index().frame, reader->index().channels);
  Json json = describe(traits, file.size());
  add_sliced(*reader, *metadata, json);
  return Description{traits, std::move(json)};
}

Result<Description> describe(const std::string& text, const Options& given) {
  const auto described = [](const Result<OpenedSource>& opened) -> Result<Description> {
    if (!opened) return opened.error();
    const SourceTraits traits = opened->source->reported_traits();
    return Description{traits, describe(traits, opened->bytes)};
  };
  if (is_named(text) || file_in_name(text)) return described(open_source(text, given));
  const Result<std::shared_ptr<const ByteSource>> file = open_named_bytes(text, given.memory);
  if (!file) return file.error();
  if (is_series_file(**file)) return describe_dense(**file, given.memory);
  const Result<std::vector<std::byte>> start = read_start(**file, kContainerMagic.size());
  return start && is_container(*start) ? describe_sliced(**file, given.memory) : described(source_in(*file, given));
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

void print_as_table(const SourceTraits& traits, const Json& json) {
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
  Options given;  ///< of reading
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
  const Result<std::shared_ptr<const ByteSource>> file =
      open_sliced_bytes(options.file, "levels of detail", options.given.memory);
  if (!file) return file.error();
  const Result<SlicedReader> reader = SlicedReader::open(**file, options.given.memory);
  if (!reader) return reader.error();
  Result<SlicedBrdf> whole = reader->load_all();
  if (!whole) return whole.error();
  const int deepest = deepest_level(*whole);
  std::unique_ptr<BrdfSource> reference;
  if (options.against.empty()) {
    reference = std::make_unique<SlicedSource>(DecodedSliced{*std::move(whole), reader->lattice()});
  } else {
    Result<OpenedSource> opened = open_source(options.against, options.given);
    if (!opened) {
      Error error = opened.error();
      error.message = options.against + ": " + error.message;
      return error;
    }
    reference = std::move(opened->source);
  }
  CompareOptions compare;
  compare.random_count = 20'000;
  compare.false_values = FalseValueSearch::kNone;
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
  if (options.given.has("material")) {
    return report_error(options.file,
                        usage_error("--levels takes the name of a material behind a ':', as in BUNDLE:NAME"));
  }
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
        ", over 20,000 random pairs of the 2-degree grid.\n");
  return 0;
}

int run_info(const InfoOptions& options) {
  const Result<Description> description = describe(options.file, options.given);
  if (!description) return report_error(options.file, description.error());
  if (options.json) {
    print_json(description->json);
  } else {
    print_as_table(description->traits, description->json);
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
  add_reading_options(*command, options->given);
  command->footer(
      "Angles are in degrees, sizes in bytes.\n\nExamples:\n  sbrdf info material.sbrdf --json\n"
      "  sbrdf info fabric112.sbrdf --levels --against kurt:fabric112");
  command->callback([options, &exit_code] {
    std::vector<std::string> inputs = {options->file};
    if (!options->against.empty()) inputs.push_back(options->against);
    const Status used = check_reading_options(options->given, inputs);
    exit_code = !used             ? report_error(options->file, used.error())
                : options->levels ? run_levels(*options)
                                  : run_info(*options);
  });
}

}  // namespace sbrdf::internal
