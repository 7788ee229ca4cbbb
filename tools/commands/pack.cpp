#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "codec/file/reader.h"
#include "formats/os/files.h"
#include "formats/sbrdf/bundle.h"
#include "tools/commands/commands.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"

namespace sbrdf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMaterialExtension = ".sbrdf";
constexpr const char* kBundleExtension = ".sbrdfz";

struct PackOptions {
  std::string folder;
  std::string out;
  std::string list;
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
  std::uint32_t first_chunk_size = 0;
};

Result<std::vector<Material>> find_materials(const fs::path& folder) {
  std::error_code failed;
  std::vector<Material> found;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    if (at->path().extension() == kMaterialExtension) found.push_back({at->path(), {}, 0});
  }
  if (failed) return io_error("cannot be read: " + failed.message());
  if (found.empty()) return usage_error("the folder holds no .sbrdf files");
  std::sort(found.begin(), found.end(), [](const Material& a, const Material& b) { return a.path < b.path; });
  return found;
}

// Only what can be read to its end goes into a bundle.
Status load(Material& material) {
  if (Status allowed = check_material_name(material.path.stem().string()); !allowed) return allowed;
  const Result<std::unique_ptr<ByteSource>> mapped = map_file(material.path);  // a named pipe would never end
  if (!mapped) return mapped.error();
  Result<std::vector<std::byte>> file = read_range(**mapped, 0, (*mapped)->size());
  if (!file) return file.error();
  const MemorySource source(*file);
  const Result<SlicedReader> reader = SlicedReader::open(source);
  if (!reader) return reader.error();
  const Result<SlicedBrdf> all = reader->load_all();
  if (!all) return all.error();
  material.first_chunk_size = reader->index().chunk_sizes[ChunkOrder::kMetadata];
  material.file = *std::move(file);
  return ok_status();
}

std::optional<Failure> load_all(std::vector<Material>& materials) {
  ProgressBar bar("pack");
  ProgressCounter counter(bar.progress(), materials.size());
  for (Material& material : materials) {
    if (Status loaded = load(material); !loaded) return Failure{material.path.string(), loaded.error()};
    if (!counter.advance()) return Failure{"", interrupted_error()};
  }
  return {};
}

std::optional<Failure> pack(const PackOptions& options, std::vector<std::byte>& bundle) {
  if (fs::path(options.out).extension() != kBundleExtension) {
    return Failure{options.out, usage_error("the name of a bundle must end with .sbrdfz")};
  }
  if (Status free = check_destination(options.out); !free) return Failure{options.out, free.error()};
  Result<std::vector<Material>> materials = find_materials(options.folder);
  if (!materials) return Failure{options.folder, materials.error()};
  if (auto failure = load_all(*materials)) return failure;
  std::vector<BundleInput> inputs;
  for (const Material& material : *materials) {
    inputs.push_back({material.path.stem().string(), material.file, material.first_chunk_size});
  }
  Result<std::vector<std::byte>> bytes = emit_bundle(inputs);
  if (!bytes) return Failure{options.folder, bytes.error()};
  if (Status written = write_file_atomically(options.out, *bytes); !written) {
    return Failure{options.out, written.error()};
  }
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

void print_as_json(const std::string& path, const BundleReader& reader, std::uint64_t bundle_size) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const BundleEntry& entry : reader.entries()) {
    rows.push_back({{"name", entry.name}, {"file_bytes", entry.file_size()}, {"bundled_bytes", entry.bundled_size()}});
  }
  print_json({{"bundle", path},
              {"version", reader.version()},
              {"materials", rows},
              {"dictionary_bytes", reader.dictionary_size()},
              {"shared_bytes", shared_size(reader, bundle_size)},
              {"file_bytes", size_of_files(reader)},
              {"bundled_bytes", bundle_size}});
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

int report(const std::string& path, const ByteSource& bundle, bool json) {
  const Result<BundleReader> reader = BundleReader::open(bundle);
  if (!reader) return report_error(path, reader.error());
  if (json) {
    print_as_json(path, *reader, bundle.size());
  } else {
    print_as_table(*reader, bundle.size());
  }
  return 0;
}

int run_pack(const PackOptions& options) {
  if (!options.list.empty()) {
    const Result<std::unique_ptr<ByteSource>> bundle = map_file(options.list);
    if (!bundle) return report_error(options.list, bundle.error());
    return report(options.list, **bundle, options.json);
  }
  std::vector<std::byte> bundle;
  if (const auto failure = pack(options, bundle)) return report_error(failure->subject, failure->error);
  return report(options.out, MemorySource(bundle), options.json);
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
  command->footer(
      "A material is named as its file without the extension, and read as BUNDLE.sbrdfz:NAME wherever a file is read.\n"
      "Nothing is written unless every file is valid.\n\n"
      "Examples:\n"
      "  sbrdf pack materials/ materials.sbrdfz\n"
      "  sbrdf pack --list materials.sbrdfz\n"
      "  sbrdf info materials.sbrdfz:fabric112");
  command->callback([options, &exit_code] {
    if (options->list.empty() && options->folder.empty()) throw CLI::RequiredError("DIR");
    if (options->list.empty() && options->out.empty()) throw CLI::RequiredError("OUT");
    exit_code = run_pack(*options);
  });
}

}  // namespace sbrdf
