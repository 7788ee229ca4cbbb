#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "codec/atlas/shader.h"
#include "codec/atlas/slice_values.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/files/atlas/manifest.h"
#include "converters/files/by_name.h"
#include "converters/files/sliced/slice_options.h"
#include "formats/core/named.h"
#include "formats/sbrdf/container.h"
#include "tools/commands/atlas/atlas_command.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

/// The files of an atlas, by their paths.
struct AtlasPaths {
  std::string manifest, texture, shader;
};

AtlasPaths paths_of(const AtlasCommand& command) {
  const std::string extension(name_of(kAtlasContainerNames, command.options.container));
  return {command.prefix + ".json", command.prefix + "." + extension, command.prefix + ".glsl"};
}

Result<MadeAtlas> make_with_bar(const BrdfSource& source, const Needed& needed, const AtlasCommand& command) {
  ProgressBar bar("atlas " + one_line(command.in, 40));
  StepwiseProgress steps(bar.progress());
  const Result<DecodedSliced> sliced = slices_of(source, command, steps.step(source.sliced() == nullptr ? 0.7 : 0));
  if (!sliced) return sliced.error();
  AtlasOptions options = command.options;
  Result<AtlasCells> cells = needed_cells(needed, sliced->lattice, steps.step(needed.scene ? 0.5 : 0));
  if (!cells) return cells.error();
  options.cells = *std::move(cells);
  Result<MadeAtlas> made = make_atlas(*sliced, source, options, steps.step(1));
  if (made && !steps.finish()) return interrupted_error();
  return made;
}

/// What the manifest says beside how to evaluate.
Json facts_of(const MadeAtlas& made, const AtlasCommand& command, const SourceTraits& traits) {
  Json facts = facts_json(made.errors, made.of_source, command, traits);
  facts["clamped_texels"] = made.counts.clamped;
  return facts;
}

struct Written {
  AtlasFiles files;
  std::uint64_t manifest_bytes = 0, shader_bytes = 0;
};

/// All three files, or none: each is complete before the first gets its name.
Result<Written> write_files(const MadeAtlas& made, const AtlasPaths& paths, const AtlasCommand& command,
                            const SourceTraits& traits) {
  const Result<std::vector<std::byte>> texture = pack_texture(made.texture, command.options);
  if (!texture) return texture.error();
  Written written;
  written.files.texture = file_name_of(paths.texture);
  written.files.shader = file_name_of(paths.shader);
  written.files.texel = made.texture.format;
  written.files.texture_bytes = texture->size();
  written.files.texels_crc32 = checksum(std::as_bytes(std::span(made.texture.bytes)));
  const std::string shader = atlas_shader(made.atlas);
  const std::string manifest = emit_manifest(made.atlas, written.files, facts_of(made, command, traits));
  written.shader_bytes = shader.size();
  written.manifest_bytes = manifest.size();
  const std::vector<std::pair<std::string, std::span<const std::byte>>> contents = {
      {paths.texture, *texture},
      {paths.shader, std::as_bytes(std::span(shader))},
      {paths.manifest, std::as_bytes(std::span(manifest))}};
  if (Status put = write_together(contents); !put) return put.error();
  return written;
}

/// Of a texture with all cells, in percent.
double share_of_texels(const MadeAtlas& made) {
  const AtlasLayout& layout = made.atlas.layout;
  return 100.0 * layout.width * layout.height / static_cast<double>(std::max<std::uint64_t>(made.texels_of_all, 1));
}

void print_atlas(const MadeAtlas& made, const AtlasPaths& paths, const Written& written, const AtlasCommand& command,
                 double seconds) {
  const AtlasLayout& layout = made.atlas.layout;
  Table table;
  table.add({"wrote",
             fmt::format("{}: {} x {} texels {}, {} bytes", paths.texture, layout.width, layout.height,
                         name_of(kTexelFormatNames, made.texture.format), format_count(written.files.texture_bytes))});
  table.add({"", fmt::format("{}: the shader, {} bytes", paths.shader, format_count(written.shader_bytes))});
  table.add({"", fmt::format("{}: the manifest, {} bytes", paths.manifest, format_count(written.manifest_bytes))});
  table.add({"to slices", fmt::format("{} on {} directions, dense around highlights", errors_text(made.errors),
                                      format_count(made.errors.directions))});
  table.add({"to source", errors_text(made.of_source) + " on the same"});
  table.add({"tables", layout.dense_along ? "one, dense along all axes: smaller here than those of all slices"
                                          : fmt::format("{}, of slices", layout.tables.size())});
  if (!made.reached) {
    table.add({"note", fmt::format("--max-error {:g} % is not reached: more texels bring neither error down by a tenth",
                                   command.options.max_error_percent)});
  }
  if (!layout.cells.is_everything()) {
    table.add({"holds", fmt::format("{} of {} cells, {:.1f} % of the texels of all", format_count(layout.cells.size()),
                                    format_count(layout.cells.flags().size()), share_of_texels(made))});
  }
  if (made.counts.clamped > 0) table.add({"note", format_count(made.counts.clamped) + " channels of texels clamped"});
  table.add({"took", format_number(seconds) + " s"});
  table.print();
}

void add_part(Json& json, const MadeAtlas& made) {
  const AtlasCells& cells = made.atlas.layout.cells;
  if (cells.is_everything()) return;
  json["cells"] = cells.flags().size();
  json["cells_held"] = cells.size();
  json["texels_of_all"] = made.texels_of_all;
}

int run_engine(const AtlasCommand& command, const BrdfSource& source) {
  const Stopwatch watch;
  const AtlasPaths paths = paths_of(command);
  if (command.samples && source.sliced() != nullptr) {
    return report_error(command.in, usage_error("--samples: it has slices already, which are taken as they are"));
  }
  const Result<Needed> needed = read_needed(command);
  if (!needed) return report_error(command.scene.empty() ? command.directions : command.scene, needed.error());
  const Result<MadeAtlas> made = make_with_bar(source, *needed, command);
  if (!made) return report_error(command.in, made.error());
  const Result<Written> written = write_files(*made, paths, command, source.traits());
  if (!written) return report_error("", written.error());
  if (!command.json) {
    print_atlas(*made, paths, *written, command, watch.seconds());
    return 0;
  }
  const AtlasLayout& layout = made->atlas.layout;
  Json json = {{"in", command.in},
               {"layout", "engine"},
               {"texel", name_of(kTexelFormatNames, made->texture.format)},
               {"container", name_of(kAtlasContainerNames, command.options.container)},
               {"tables", layout.dense_along ? "dense" : "slices"},
               {"width", layout.width},
               {"height", layout.height},
               {"texels", std::uint64_t{layout.width} * layout.height},
               {"bytes", written->files.texture_bytes},
               {"texel_bytes", made->texture.bytes.size()},
               {"files", {paths.texture, paths.shader, paths.manifest}},
               {"mre_percent", made->of_source.mre_percent},
               {"rel_l1_percent", made->of_source.rel_l1_percent},
               {"errors", {{"to_slices", errors_json(made->errors)}, {"to_source", errors_json(made->of_source)}}},
               {"max_error_percent", command.options.max_error_percent},
               {"reached", made->reached},
               {"clamped_texels", made->counts.clamped},
               {"seconds", watch.seconds()}};
  add_part(json, *made);
  print_json(json);
  return 0;
}

/// All files that a command writes, the manifest last.
Result<std::vector<std::string>> files_written(const AtlasCommand& command) {
  if (command.layout == AtlasLayoutName::kPaper) return paper_paths(command);
  if (Status allowed = check_atlas_options(command.options); !allowed) return allowed.error();
  const AtlasPaths paths = paths_of(command);
  return std::vector<std::string>{paths.texture, paths.shader, paths.manifest};
}

int run_atlas(const AtlasCommand& command) {
  if (Status used = check_reading_options(command.given, {&command.in, 1}); !used) {
    return report_error(command.in, used.error());
  }
  if (Status allowed = check_needed(command); !allowed) return report_error("", allowed.error());
  const Result<std::vector<std::string>> paths = files_written(command);
  if (!paths) return report_error("", paths.error());
  const std::vector<std::string> former = files_of_former(paths->back());
  if (Status free = check_paths(command, *paths, former); !free) return report_error("", free.error());
  const Result<OpenedSource> opened = open_source(command.in, command.given);
  if (!opened) return report_error(command.in, opened.error());
  if (Status held = check_atlas_channels(opened->source->channel_count()); !held) {
    return report_error(command.in, held.error());
  }
  const int exit_code = command.layout == AtlasLayoutName::kPaper ? run_paper(command, *opened->source)
                                                                  : run_engine(command, *opened->source);
  if (exit_code != 0) return exit_code;
  for (const std::string& removed : remove_left_over(command, former, *paths)) {
    print_note(removed, "removed: a file of the atlas that this one replaced");
  }
  if (opened->source->mask_grid()) {
    print_note(command.in, "not everything was measured, which an atlas cannot tell: what it has there is made up");
  }
  return 0;
}

constexpr std::array kTexelChoices = {Named{"rgb32f", TexelFormat::kRgb32f}, Named{"rgba16f", TexelFormat::kRgba16f},
                                      Named{"e5b9g9r9", TexelFormat::kE5b9g9r9},
                                      Named{"bc6h", TexelFormat::kBc6hUnsigned}};

/// An option with one of the names of a table; `otherwise` stands in the help for the default.
template <class T, std::size_t N>
void add_choice(CLI::App& app, const char* flag, const char* help, const std::array<Named<T>, N>& table,
                std::optional<T>& value, const char* otherwise) {
  const auto names = names_of(table);
  app.add_option_function<std::string>(
         flag, [&value, &table](const std::string& name) { value = value_of(table, name); }, help)
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->default_str(otherwise);
}

/// What was given, before the layout decides the rest.
struct AtlasArguments {
  AtlasCommand command;
  std::optional<AtlasLayoutName> layout;
  std::optional<TexelFormat> texel;
  std::optional<AtlasContainer> container;
  std::optional<double> max_error_percent;
  std::string placement;
};

int run_arguments(AtlasArguments& arguments) {
  AtlasCommand& command = arguments.command;
  command.layout = arguments.layout.value_or(AtlasLayoutName::kEngine);
  const bool paper = command.layout == AtlasLayoutName::kPaper;
  AtlasOptions& options = command.options;
  options.texel = arguments.texel.value_or(paper ? TexelFormat::kRgb32f : options.texel);
  options.container = arguments.container.value_or(paper ? AtlasContainer::kExr : options.container);
  options.max_error_percent = arguments.max_error_percent.value_or(options.max_error_percent);
  if (paper && arguments.max_error_percent) {
    return report_error("", usage_error("--max-error: the texels of --layout paper follow from the placement"));
  }
  if (!arguments.placement.empty()) {
    command.placement = parse_steps(arguments.placement);
    if (!paper) return report_error("", usage_error("--placement is for --layout paper"));
    if (!command.placement) {
      return report_error("", usage_error("--placement: not two positive numbers of degrees such as 14/36"));
    }
  }
  return run_atlas(command);
}

}  // namespace

void add_atlas(CLI::App& program, int& exit_code) {
  // An empty variable of a shell means a file that is missing, not that everything is packed.
  const auto is_not_empty = [](const std::string& name) { return name.empty() ? "no file is named" : std::string(); };
  auto* app = program.add_subcommand("atlas", "Writes a texture for engines, with the shader that evaluates it.");
  const auto given = std::make_shared<AtlasArguments>();
  AtlasCommand& command = given->command;
  app->add_option("IN", command.in, "A file of any readable format, kurt:NAME or BUNDLE.sbrdfz:NAME")->required();
  app->add_option("OUT_PREFIX", command.prefix,
                  "Files are OUT_PREFIX.json (the manifest), OUT_PREFIX.glsl (the shader) and OUT_PREFIX.ktx2, .exr "
                  "or .dds; with --layout paper the manifest and OUT_PREFIX_crossings, _axial, _diagonal, _horizontal")
      ->required();
  add_choice(*app, "--layout", "One texture and its shader, or the paper's four textures (section 8)",
             kAtlasLayoutNames, given->layout, "engine");
  add_choice(*app, "--texel", "How texels are stored", kTexelChoices, given->texel, "rgba16f, paper: rgb32f");
  add_choice(*app, "--container", "File of a texture", kAtlasContainerNames, given->container, "ktx2, paper: exr");
  app->add_flag("--fast", command.options.fast, "Search less for blocks of bc6h");
  app->add_flag("--zstd", command.options.zstd, "Pack a KTX2 file with zstd; not every engine unpacks it");
  add_number(*app, "--max-error", given->max_error_percent, {0.001, 100}, "PERCENT",
             "As few texels as stay within this MRE and relative L1 error of the slices; 0.5 unless given. Not with "
             "--layout paper");
  add_count(*app, "--samples", command.samples, {1, kMaxSampleCount},
            "Directions sampled where IN has no slices yet; 4,096 unless given, with --layout paper 8,911");
  app->add_option("--placement", given->placement,
                  "With --layout paper, where IN has no slices yet: degrees between elevations and azimuths, such as "
                  "10/36")
      ->default_str("14/36");
  add_number(*app, "--theta-max", command.theta_max_deg, {0.1, 90}, "DEGREES",
             "Pack only what pairs with both thetas up to here need");
  app->add_option("--directions", command.directions,
                  "Pack only what these pairs need: a CSV file as sbrdf eval reads it")
      ->check(is_not_empty);
  app->add_option("--used-by", command.scene,
                  "Pack only what a scene needs: a JSON file of cameras, lights and objects (specs/atlas.md)")
      ->check(is_not_empty);
  app->add_flag("--json", command.json, "Print the report as JSON");
  add_reading_options(*app, command.given);
  app->footer(
      "OUT_PREFIX.json is a BRDF like any other: sbrdf compare, eval and convert evaluate it as the shader does.\n"
      "specs/atlas.md tells what stands where, and how to use it in an engine.\n\n"
      "Examples:\n"
      "  sbrdf atlas leather.sbrdf leather --texel e5b9g9r9\n"
      "  sbrdf atlas material.bsdf material --texel rgba16f --container exr --max-error 1\n"
      "  sbrdf atlas leather.sbrdf floor --used-by hall.json\n"
      "  sbrdf atlas leather.sbrdf leather --layout paper");
  app->callback([given, &exit_code] { exit_code = run_arguments(*given); });
}

}  // namespace sbrdf::internal
