#include "tools/commands/atlas/atlas_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "converters/files/atlas/manifest.h"
#include "converters/files/atlas/paper/paper_manifest.h"
#include "converters/slicing/slicing.h"
#include "formats/os/atomic_file.h"
#include "formats/os/files.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kPaperSampleCount = 8911;

/// The files of the atlas that has this manifest already, which may be replaced: none where it is not one.
std::vector<std::string> files_there(const std::string& manifest) {
  if (!std::filesystem::is_regular_file(manifest)) return {};
  const Result<std::unique_ptr<ByteSource>> file = map_file(manifest);
  if (!file) return {};
  const Result<std::vector<std::byte>> bytes = read_range(**file, 0, (*file)->size());
  if (!bytes) return {};
  const std::string_view text = {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
  std::vector<std::string> names;
  if (const Result<AtlasManifest> engine = parse_manifest(text)) {
    names = {engine->files.texture, engine->files.shader};
  } else if (const Result<PaperManifest> paper = parse_paper_manifest(text)) {
    names.assign(paper->files.names.begin(), paper->files.names.end());
  } else {
    return {};
  }
  names.push_back(file_name_of(manifest));
  return names;
}

}  // namespace

std::string path_of(const AtlasCommand& command, const std::string& ending) { return command.prefix + ending; }

std::string file_name_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

Status check_paths(const AtlasCommand& command, const std::vector<std::string>& paths, const std::string& manifest) {
  const std::vector<std::string> inputs = {command.in};
  const std::vector<std::string> there = files_there(manifest);
  for (const std::string& path : paths) {
    const bool own = std::find(there.begin(), there.end(), file_name_of(path)) != there.end();
    const bool input = is_among(path, paths_read(inputs));
    Status free = input ? Status(usage_error("is an input, which this would replace"))
                  : own ? check_destination(path)
                        : check_output(path, nullptr, inputs);
    if (!free) {
      Error named = free.error();
      named.message = path + ": " + named.message;
      return named;
    }
    // A name that ends like a model's or a table's, though nothing recognises it.
    if (!own && std::filesystem::exists(path) && path == manifest) {
      return usage_error(path + ": there is a file of another kind of that name; remove it first");
    }
  }
  return ok_status();
}

Result<DecodedSliced> slices_of(const BrdfSource& source, const AtlasCommand& command, const Progress& progress) {
  if (const DecodedSliced* sliced = source.sliced()) return *sliced;
  const bool paper = command.layout == AtlasLayoutName::kPaper;
  SliceOptions options;
  options.stop = SampleCount{command.samples.value_or(paper ? kPaperSampleCount : kDefaultSampleCount)};
  if (paper) options.structure = command.placement.value_or(Placement{14, 36});
  Result<Slicing> slicing = slice_source(source, options, progress);
  if (!slicing) return slicing.error();
  DecodedSliced decoded;
  decoded.sliced = std::move(slicing->sliced);
  decoded.lattice = std::move(slicing->lattice);
  return decoded;
}

Status write_together(const std::vector<std::pair<std::string, std::span<const std::byte>>>& contents) {
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
  return ok_status();
}

Json errors_json(const AtlasErrors& errors) {
  return {{"mre_percent", errors.mre_percent},
          {"rel_l1_percent", errors.rel_l1_percent},
          {"directions", errors.directions}};
}

Json facts_json(const AtlasErrors& to_slices, const AtlasErrors& to_source, const AtlasCommand& command,
                const SourceTraits& traits) {
  Json facts;
  facts["errors"] = {{"to_slices", errors_json(to_slices)}, {"to_source", errors_json(to_source)}};
  facts["source"] = {
      {"name", file_name_of(command.in)}, {"format", traits.format}, {"description", traits.description}};
  return facts;
}

std::string errors_text(const AtlasErrors& errors) {
  return fmt::format("MRE {} %, relative L1 {} %", format_number(errors.mre_percent),
                     format_number(errors.rel_l1_percent));
}

}  // namespace sbrdf::internal
