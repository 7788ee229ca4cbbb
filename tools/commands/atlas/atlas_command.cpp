#include "tools/commands/atlas/atlas_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>

#include "converters/files/atlas/atlas_file.h"
#include "converters/slicing/slicing.h"
#include "formats/os/atomic_file.h"
#include "formats/os/files.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kPaperSampleCount = 8911;

bool is_utf8(const std::string& text) {
  const std::string quoted = Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
  return Json::parse(quoted).get<std::string>() == text;
}

/// What an earlier atlas of this name consists of may be replaced, and nothing else: who names one prefix does not see
/// all names.
Status check_path(const std::string& path, bool own, const std::vector<std::string>& read) {
  if (is_among(path, read)) return usage_error("is an input, or belongs to one, which this would replace");
  if (Status free = check_destination(path); !free) return free;
  std::error_code none;
  if (own || !std::filesystem::exists(path, none)) return ok_status();
  return usage_error("there is a file of that name that is of no atlas here; choose another prefix or remove it first");
}

}  // namespace

std::string path_of(const AtlasCommand& command, const std::string& ending) { return command.prefix + ending; }

std::string file_name_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

Status check_paths(const AtlasCommand& command, const std::vector<std::string>& paths,
                   const std::vector<std::string>& former) {
  const std::string name = file_name_of(command.prefix);
  if (name.empty() || name == "." || name == "..") {
    return usage_error("OUT_PREFIX is a folder; add the beginning of a file name");
  }
  if (name.find('\\') != std::string::npos) {
    return usage_error("OUT_PREFIX has a \\, which a manifest cannot name, as it is no part of a name everywhere");
  }
  if (!is_utf8(name)) return usage_error("OUT_PREFIX is not UTF-8, which is all that a manifest can name");
  const std::vector<std::string> read = paths_read({&command.in, 1});
  for (const std::string& path : paths) {
    const bool own = !former.empty() && (path == paths.back() ||
                                         std::find(former.begin(), former.end(), file_name_of(path)) != former.end());
    if (Status free = check_path(path, own, read); !free) {
      Error named = free.error();
      named.message = path + ": " + named.message;
      return named;
    }
  }
  return ok_status();
}

std::vector<std::string> files_of_former(const std::string& manifest) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(manifest, none)) return {};
  const Result<std::unique_ptr<ByteSource>> file = map_file(manifest);
  return file ? files_of_atlas(**file) : std::vector<std::string>();
}

std::vector<std::string> remove_left_over(const AtlasCommand& command, const std::vector<std::string>& former,
                                          const std::vector<std::string>& paths) {
  std::vector<std::string> removed;
  const std::string prefix = file_name_of(command.prefix);
  const std::vector<std::string> read = paths_read({&command.in, 1});
  for (const std::string& name : former) {
    const std::string path = (std::filesystem::path(command.prefix).parent_path() / name).string();
    // A manifest may have been renamed: what bears another name may be of another atlas.
    if (!name.starts_with(prefix) || is_among(path, paths) || is_among(path, read)) continue;
    std::error_code failed;
    if (std::filesystem::remove(path, failed) && !failed) removed.push_back(path);
  }
  return removed;
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
  const auto of_file = [](const std::string& path, const Error& error) {
    Error named = error;
    named.message = path + ": " + error.message;
    return named;
  };
  std::vector<std::unique_ptr<AtomicFile>> files;
  for (const auto& [path, bytes] : contents) {
    Result<std::unique_ptr<AtomicFile>> file = AtomicFile::create(path);
    if (!file) return of_file(path, file.error());
    if (Status put = (*file)->write(0, bytes); !put) return of_file(path, put.error());
    files.push_back(*std::move(file));
  }
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (Status committed = files[k]->commit(); !committed) return of_file(contents[k].first, committed.error());
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
