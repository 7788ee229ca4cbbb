#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "codec/file/reader.h"
#include "codec/series/series_file.h"
#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "formats/os/files.h"
#include "formats/sbrdf/bundle.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

struct PackOptions {
  std::string folder;
  std::string out;
  std::string list;
  MemoryLimit memory;
  bool json = false;
};

/// An error and whose it is.
struct Failure {
  std::string subject;
  Error error;
};

struct Material {
  fs::path path;
  std::vector<std::byte> file;
};

/// What a folder holds, by the names alone.
struct Folder {
  std::vector<Material> materials;   ///< rising by path
  std::vector<std::string> skipped;  ///< names of hidden files, such as those that some systems put beside each file
};

const Format& bundle_format() {
  return *std::find_if(formats().begin(), formats().end(),
                       [](const Format& format) { return format.capabilities.has(Capability::kManyMaterials); });
}

bool has_name_of_material(const fs::path& path) {
  const std::string extension = lower_extension(path.string());
  return std::any_of(formats().begin(), formats().end(), [&](const Format& format) {
    return format.capabilities.has(Capability::kBundled) && format.extension == extension;
  });
}

Result<Folder> look_into(const fs::path& path) {
  std::error_code failed;
  Folder folder;
  for (fs::directory_iterator at(path, failed), end; !failed && at != end; at.increment(failed)) {
    if (!has_name_of_material(at->path())) continue;
    if (at->path().filename().string().starts_with('.')) {
      folder.skipped.push_back(at->path().filename().string());
    } else {
      folder.materials.push_back({at->path(), {}});
    }
  }
  if (failed) return io_error("cannot be read: " + failed.message());
  if (folder.materials.empty()) return usage_error("the folder holds no .sbrdf files");
  std::sort(folder.skipped.begin(), folder.skipped.end());
  std::sort(folder.materials.begin(), folder.materials.end(),
            [](const Material& a, const Material& b) { return a.path < b.path; });
  return folder;
}

// Only what can be read to its end goes into a bundle.
Status load(Material& material, const MemoryLimit& limit) {
  if (Status allowed = check_material_name(material.path.stem().string()); !allowed) return allowed;
  const Result<std::unique_ptr<ByteSource>> mapped = map_file(material.path);  // a named pipe would never end
  if (!mapped) return mapped.error();
  const Result<const Format*> format = recognise(**mapped);
  if (!format) return format.error();
  if (!(*format)->capabilities.has(Capability::kBundled)) {
    return unsupported("is of another kind, " + std::string((*format)->description) +
                       "; a bundle holds sliced files, see 'sbrdf convert --help'");
  }
  Result<std::vector<std::byte>> file = read_range(**mapped, 0, (*mapped)->size());
  if (!file) return file.error();
  const MemorySource source(*file);
  if (is_series_file(source)) return unsupported("is a dense file, which is smaller than what a bundle would save");
  const Result<SlicedReader> reader = SlicedReader::open(source, limit);
  if (!reader) return reader.error();
  const Result<SlicedBrdf> all = reader->load_all();
  if (!all) return all.error();
  material.file = *std::move(file);
  return ok_status();
}

/// All that is wrong, so that a folder is mended in one go.
std::vector<Failure> load_all(std::vector<Material>& materials, const MemoryLimit& limit) {
  std::vector<Failure> failures;
  ProgressBar bar("pack");
  ProgressCounter counter(bar.progress(), materials.size());
  std::map<std::string, fs::path> names;
  for (Material& material : materials) {
    const auto [other, is_new] = names.emplace(material.path.stem().string(), material.path);
    if (!is_new) {
      failures.push_back({material.path.string(),
                          usage_error("has the same name in the bundle as " + other->second.filename().string())});
    } else if (Status loaded = load(material, limit); !loaded) {
      failures.push_back({material.path.string(), loaded.error()});
    }
    if (!counter.advance()) return {{"", interrupted_error()}};
  }
  return failures;
}

/// An error of the whole, in the form of those of files.
std::vector<Failure> one(const std::string& subject, const Error& error) { return {{subject, error}}; }

std::vector<Failure> pack(const PackOptions& options, std::vector<std::string>& skipped,
                          std::vector<std::byte>& bundle) {
  if (lower_extension(options.out) != bundle_format().extension) {
    return one(options.out, usage_error("the name of a bundle must end with .sbrdfz"));
  }
  Result<Folder> folder = look_into(options.folder);
  if (!folder) return one(options.folder, folder.error());
  std::vector<Material>& materials = folder->materials;
  skipped = std::move(folder->skipped);
  std::vector<std::string> files;
  for (const Material& material : materials) files.push_back(material.path.string());
  if (Status free = check_output(options.out, &bundle_format(), files); !free) return one(options.out, free.error());
  if (auto failures = load_all(materials, options.memory); !failures.empty()) return failures;
  std::vector<BundleInput> inputs;
  for (const Material& material : materials) {
    inputs.push_back({material.path.stem().string(), material.file});
  }
  Result<std::vector<std::byte>> bytes = emit_bundle(inputs);
  if (!bytes) return one(options.folder, bytes.error());
  if (Status written = write_file_atomically(options.out, *bytes); !written) return one(options.out, written.error());
  bundle = *std::move(bytes);
  return {};
}

/// What belongs to no material by itself.
std::uint64_t shared_size(const BundleReader& reader, std::uint64_t bundle_size) {
  for (const BundleEntry& entry : reader.entries()) bundle_size -= entry.bundled_size();
  return bundle_size;
}

std::uint64_t size_of_files(const BundleReader& reader) {
  std::uint64_t size = 0;
  for (const BundleEntry& entry : reader.entries()) size += entry.file_size();
  return size;
}

void print_as_json(const std::string& path, const BundleReader& reader, std::uint64_t bundle_size,
                   const std::vector<std::string>& skipped) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const BundleEntry& entry : reader.entries()) {
    rows.push_back({{"name", entry.name}, {"file_bytes", entry.file_size()}, {"bundled_bytes", entry.bundled_size()}});
  }
  nlohmann::ordered_json json = {{"bundle", path},
                                 {"version", reader.version()},
                                 {"materials", rows},
                                 {"dictionary_bytes", reader.dictionary_size()},
                                 {"shared_bytes", shared_size(reader, bundle_size)},
                                 {"file_bytes", size_of_files(reader)},
                                 {"bundled_bytes", bundle_size}};
  if (!skipped.empty()) json["skipped"] = skipped;
  print_json(json);
}

void print_as_table(const BundleReader& reader, std::uint64_t bundle_size) {
  Table table;
  table.add({"material", "bytes of the file", "in the bundle"});
  for (const BundleEntry& entry : reader.entries()) {
    table.add({entry.name, format_count(entry.file_size()), format_count(entry.bundled_size())});
  }
  table.add({"(index, dictionary)", "", format_count(shared_size(reader, bundle_size))});
  table.add({"(total)", format_count(size_of_files(reader)), format_count(bundle_size)});
  table.print();
}

int report(const std::string& path, const ByteSource& bundle, bool json, const std::vector<std::string>& skipped) {
  const Result<BundleReader> reader = BundleReader::open(bundle);
  if (!reader) return report_error(path, reader.error());
  if (json) {
    print_as_json(path, *reader, bundle.size(), skipped);
  } else {
    print_as_table(*reader, bundle.size());
  }
  return 0;
}

int list(const PackOptions& options) {
  const Result<std::unique_ptr<ByteSource>> bundle = map_file(options.list);
  if (!bundle) return report_error(options.list, bundle.error());
  return report(options.list, **bundle, options.json, {});
}

int run_pack(const PackOptions& options) {
  std::vector<std::byte> bundle;
  std::vector<std::string> skipped;
  const std::vector<Failure> failures = pack(options, skipped, bundle);
  // Told also where packing fails: it may be why.
  for (const std::string& name : skipped) {
    if (!options.json) print("skipped " + one_line(name) + ": the name begins with a dot\n");
  }
  int exit_code = 0;
  for (const Failure& failure : failures) {
    const int failed = report_error(failure.subject, failure.error);
    if (exit_code == 0) exit_code = failed;
  }
  return failures.empty() ? report(options.out, MemorySource(bundle), options.json, skipped) : exit_code;
}

}  // namespace

void add_pack(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("pack", "Puts many sliced files into one bundle, each found by its name.");
  const auto options = std::make_shared<PackOptions>();
  auto* folder = command->add_option("DIR", options->folder, "The folder whose .sbrdf files are packed");
  auto* out = command->add_option("OUT", options->out, "The bundle to write, a name that ends with .sbrdfz");
  command->add_option("--list", options->list, "Tell instead what this bundle holds")
      ->type_name("BUNDLE")
      ->excludes(folder)
      ->excludes(out);
  command->add_flag("--json", options->json, "Print JSON");
  add_memory_limit(*command, options->memory);
  command->footer(
      "A material is named as its file without the extension, and read as BUNDLE.sbrdfz:NAME wherever a file is read.\n"
      "Names that begin with a dot are skipped, and said to be. Nothing is written unless every file is valid: the bad "
      "ones\n"
      "are all named, and the exit code is that of the first.\n\n"
      "Examples:\n"
      "  sbrdf pack materials/ materials.sbrdfz\n"
      "  sbrdf pack --list materials.sbrdfz\n"
      "  sbrdf info materials.sbrdfz:fabric112");
  command->callback([options, &exit_code] {
    if (options->list.empty() && options->folder.empty()) throw CLI::RequiredError("DIR");
    if (options->list.empty() && options->out.empty()) throw CLI::RequiredError("OUT");
    exit_code = options->list.empty() ? run_pack(*options) : list(*options);
  });
}

}  // namespace sbrdf::internal
