#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "codec/atlas/shader.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/files/atlas/manifest.h"
#include "converters/files/by_name.h"
#include "converters/slicing/slicing.h"
#include "formats/core/named.h"
#include "formats/os/atomic_file.h"
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

struct AtlasCommand {
  std::string in;
  std::string prefix;
  AtlasOptions options;
  std::uint64_t samples = kDefaultSampleCount;
  bool json = false;
  Options given;  ///< of reading
};

/// The files of an atlas, by their paths.
struct AtlasPaths {
  std::string manifest, texture, shader;
};

AtlasPaths paths_of(const AtlasCommand& command) {
  const std::string extension(name_of(kAtlasContainerNames, command.options.container));
  return {command.prefix + ".json", command.prefix + "." + extension, command.prefix + ".glsl"};
}

/// Whether an atlas has this name already.
bool is_manifest(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) return false;
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  if (!file || (*file)->size() > kLongestManifest) return false;
  const Result<std::vector<std::byte>> text = read_range(**file, 0, (*file)->size());
  return text && parse_manifest({reinterpret_cast<const char*>(text->data()), text->size()}).ok();
}

bool is_utf8(const std::string& text) {
  const std::string quoted = Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
  return Json::parse(quoted).get<std::string>() == text;
}

/// What an earlier atlas of this name consists of may be replaced, and nothing else: who names one prefix does not see
/// three names.
Status check_path(const std::string& path, bool own, std::span<const std::string> inputs) {
  if (is_among(path, paths_read(inputs))) return usage_error("is an input, which this would replace");
  if (Status free = check_destination(path); !free) return free;
  if (own || !std::filesystem::exists(path)) return ok_status();
  return usage_error("there is a file of that name that is of no atlas here; choose another prefix or remove it first");
}

Status check_paths(const AtlasCommand& command, const AtlasPaths& paths) {
  const std::string name = std::filesystem::path(command.prefix).filename().string();
  if (name.empty()) return usage_error("OUT_PREFIX is a folder; add the beginning of a file name");
  if (!is_utf8(name)) return usage_error("OUT_PREFIX is not UTF-8, which is all that a manifest can name");
  const std::vector<std::string> inputs = {command.in};
  const bool own = is_manifest(paths.manifest);
  for (const std::string& path : {paths.manifest, paths.texture, paths.shader}) {
    if (Status free = check_path(path, own, inputs); !free) {
      Error named = free.error();
      named.message = path + ": " + named.message;
      return named;
    }
  }
  return ok_status();
}

/// The slices that a source has, or that it is sampled into.
Result<DecodedSliced> slices_of(const BrdfSource& source, const AtlasCommand& command, const Progress& progress) {
  if (const DecodedSliced* sliced = source.sliced()) return *sliced;
  SliceOptions options;
  options.stop = SampleCount{command.samples};
  Result<Slicing> slicing = slice_source(source, options, progress);
  if (!slicing) return slicing.error();
  DecodedSliced decoded;
  decoded.sliced = std::move(slicing->sliced);
  decoded.lattice = std::move(slicing->lattice);
  return decoded;
}

Json errors_json(const AtlasErrors& errors) {
  return {{"mre_percent", errors.mre_percent},
          {"rel_l1_percent", errors.rel_l1_percent},
          {"directions", errors.directions}};
}

Result<MadeAtlas> make_with_bar(const BrdfSource& source, const AtlasCommand& command) {
  ProgressBar bar("atlas " + one_line(command.in, 40));
  StepwiseProgress steps(bar.progress());
  const Result<DecodedSliced> sliced = slices_of(source, command, steps.step(source.sliced() == nullptr ? 0.7 : 0));
  if (!sliced) return sliced.error();
  Result<MadeAtlas> made = make_atlas(*sliced, source, command.options, steps.step(1));
  if (made && !steps.finish()) return interrupted_error();
  return made;
}

/// What the manifest says beside how to evaluate.
Json facts_of(const MadeAtlas& made, const AtlasCommand& command, const SourceTraits& traits) {
  Json facts;
  facts["errors"] = {{"to_slices", errors_json(made.errors)}, {"to_source", errors_json(made.of_source)}};
  facts["clamped_texels"] = made.counts.clamped;
  facts["source"] = {{"name", std::filesystem::path(command.in).filename().string()},
                     {"format", traits.format},
                     {"description", traits.description}};
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
  written.files.texture = std::filesystem::path(paths.texture).filename().string();
  written.files.shader = std::filesystem::path(paths.shader).filename().string();
  written.files.texel = made.texture.format;
  written.files.texture_bytes = texture->size();
  const std::string shader = atlas_shader(made.atlas);
  const std::string manifest = emit_manifest(made.atlas, written.files, facts_of(made, command, traits));
  written.shader_bytes = shader.size();
  written.manifest_bytes = manifest.size();
  const std::vector<std::pair<std::string, std::span<const std::byte>>> contents = {
      {paths.texture, *texture},
      {paths.shader, std::as_bytes(std::span(shader))},
      {paths.manifest, std::as_bytes(std::span(manifest))}};
  std::vector<std::unique_ptr<AtomicFile>> files;
  for (const auto& [path, bytes] : contents) {
    Result<std::unique_ptr<AtomicFile>> file = AtomicFile::create(path);
    if (!file) return file.error();
    if (Status put = (*file)->write(0, bytes); !put) return put.error();
    files.push_back(*std::move(file));
  }
  for (const auto& file : files) {
    if (Status committed = file->commit(); !committed) return committed.error();
  }
  return written;
}

void print_atlas(const MadeAtlas& made, const AtlasPaths& paths, const Written& written, const AtlasCommand& command,
                 double seconds) {
  const AtlasLayout& layout = made.atlas.layout;
  const auto percent = [](double value) { return format_number(value) + " %"; };
  Table table;
  table.add({"wrote",
             fmt::format("{}: {} x {} texels {}, {} bytes", paths.texture, layout.width, layout.height,
                         name_of(kTexelFormatNames, made.texture.format), format_count(written.files.texture_bytes))});
  table.add({"", fmt::format("{}: the shader, {} bytes", paths.shader, format_count(written.shader_bytes))});
  table.add({"", fmt::format("{}: the manifest, {} bytes", paths.manifest, format_count(written.manifest_bytes))});
  table.add({"to slices", fmt::format("MRE {}, relative L1 {} on {} directions, dense around highlights",
                                      percent(made.errors.mre_percent), percent(made.errors.rel_l1_percent),
                                      format_count(made.errors.directions))});
  table.add({"to source", fmt::format("MRE {}, relative L1 {} on the same", percent(made.of_source.mre_percent),
                                      percent(made.of_source.rel_l1_percent))});
  if (!made.reached) {
    table.add({"note", fmt::format("--max-error {:g} % is not reached: more texels bring no smaller error",
                                   command.options.max_error_percent)});
  }
  if (made.counts.clamped > 0) table.add({"note", format_count(made.counts.clamped) + " channels of texels clamped"});
  table.add({"took", format_number(seconds) + " s"});
  table.print();
}

int run_atlas(const AtlasCommand& command) {
  const Stopwatch watch;
  const AtlasPaths paths = paths_of(command);
  if (Status used = check_reading_options(command.given, {&command.in, 1}); !used) {
    return report_error(command.in, used.error());
  }
  if (Status allowed = check_atlas_options(command.options); !allowed) return report_error("", allowed.error());
  if (Status free = check_paths(command, paths); !free) return report_error("", free.error());
  const Result<OpenedSource> opened = open_source(command.in, command.given);
  if (!opened) return report_error(command.in, opened.error());
  const BrdfSource& source = *opened->source;
  if (Status held = check_atlas_channels(source.channel_count()); !held) return report_error(command.in, held.error());
  const Result<MadeAtlas> made = make_with_bar(source, command);
  if (!made) return report_error(command.in, made.error());
  const Result<Written> written = write_files(*made, paths, command, source.traits());
  if (!written) return report_error(command.prefix, written.error());
  if (!command.json) {
    print_atlas(*made, paths, *written, command, watch.seconds());
    return 0;
  }
  const AtlasLayout& layout = made->atlas.layout;
  Json json = {{"in", command.in},
               {"layout", "engine"},
               {"texel", name_of(kTexelFormatNames, made->texture.format)},
               {"container", name_of(kAtlasContainerNames, command.options.container)},
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
  print_json(json);
  return 0;
}

constexpr std::array kTexelChoices = {Named{"rgb32f", TexelFormat::kRgb32f}, Named{"rgba16f", TexelFormat::kRgba16f},
                                      Named{"e5b9g9r9", TexelFormat::kE5b9g9r9},
                                      Named{"bc6h", TexelFormat::kBc6hUnsigned}};

/// An option with one of the names of a table; the value in the variable is the default.
template <class T, std::size_t N>
void add_choice(CLI::App& app, const char* flag, const char* help, const std::array<Named<T>, N>& table, T& value) {
  const auto names = names_of(table);
  app.add_option_function<std::string>(
         flag, [&value, &table](const std::string& name) { value = value_of(table, name).value_or(value); }, help)
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->default_str(std::string(name_of(table, value)));
}

}  // namespace

void add_atlas(CLI::App& program, int& exit_code) {
  auto* app = program.add_subcommand("atlas", "Writes a texture for engines, with the shader that evaluates it.");
  const auto command = std::make_shared<AtlasCommand>();
  app->add_option("IN", command->in, "A file of any readable format, kurt:NAME or BUNDLE.sbrdfz:NAME")->required();
  app->add_option("OUT_PREFIX", command->prefix,
                  "Files are OUT_PREFIX.json (the manifest), OUT_PREFIX.glsl (the shader) and OUT_PREFIX.ktx2, .exr "
                  "or .dds")
      ->required();
  add_choice(*app, "--texel", "How texels are stored", kTexelChoices, command->options.texel);
  add_choice(*app, "--container", "File of the texture", kAtlasContainerNames, command->options.container);
  app->add_flag("--zstd", command->options.zstd, "Pack a KTX2 file with zstd; not every engine unpacks it");
  app->add_flag("--fast", command->options.fast, "Search less for blocks of bc6h");
  add_number(*app, "--max-error", command->options.max_error_percent, {0.001, 100}, "PERCENT",
             "As few texels as stay within this MRE and relative L1 error of the slices");
  add_count(*app, "--samples", command->samples, {1, kMaxSampleCount}, "Directions sampled where IN has no slices yet");
  app->add_flag("--json", command->json, "Print the report as JSON");
  add_reading_options(*app, command->given);
  app->footer(
      "OUT_PREFIX.json is a BRDF like any other: sbrdf compare, eval and convert evaluate it as the shader does.\n"
      "specs/atlas.md tells what stands where, and how to use it in an engine.\n\n"
      "Examples:\n"
      "  sbrdf atlas leather.sbrdf leather --texel e5b9g9r9\n"
      "  sbrdf atlas material.bsdf material --texel rgba16f --container exr --max-error 1");
  app->callback([command, &exit_code] { exit_code = run_atlas(*command); });
}

}  // namespace sbrdf::internal
