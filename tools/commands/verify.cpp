#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "codec/file/reader.h"
#include "codec/series/series_file.h"
#include "codec/series/series_table.h"
#include "converters/files/analytic/analytic_file.h"
#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "converters/source/progress.h"
#include "formats/os/files.h"
#include "formats/os/interrupt.h"
#include "formats/sbrdf/bundle.h"
#include "formats/sbrdf/container.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

struct VerifyOptions {
  std::vector<std::string> files;
  MemoryLimit memory;
  bool json = false;
};

struct Verdict {
  std::uint64_t bytes = 0;
  std::size_t materials = 1;
  std::size_t chunks = 0;
  std::size_t samples = 0;
  std::string version;
};

// Everything that a reader could ever look at.
Status verify_sliced(const ByteSource& source, const MemoryLimit& limit, Verdict& verdict) {
  if (is_series_file(source)) {
    const Result<SeriesBrdf> brdf = decode_series(source);
    if (!brdf) return brdf.error();
    const Result<VectorEvaluator> table = make_table(*brdf, limit.of(source.size()));
    if (!table) return table.error();
    const Result<ContainerHead> head = read_head(source);
    if (!head) return head.error();
    verdict.version = head->version();
    return ok_status();
  }
  const Result<SlicedReader> reader = SlicedReader::open(source, limit);
  if (!reader) return reader.error();
  const Result<SlicedBrdf> all = reader->load_all();
  if (!all) return all.error();
  verdict.version = reader->version();
  verdict.samples += all->sample_count();
  for (const std::uint32_t size : reader->index().chunk_sizes) verdict.chunks += size != 0 ? 1 : 0;
  return ok_status();
}

Status verify_bundle(const ByteSource& source, const MemoryLimit& limit, Verdict& verdict) {
  const Result<BundleReader> bundle = BundleReader::open(source, limit);
  if (!bundle) return bundle.error();
  for (const BundleEntry& entry : bundle->entries()) {
    const Result<std::unique_ptr<ByteSource>> material = bundle->material(entry);
    const Status status = material ? verify_sliced(**material, limit, verdict) : Status(material.error());
    if (status) continue;
    Error error = status.error();
    error.message = one_line(entry.name) + ": " + error.message;
    error.offset.reset();  // it counts from the start of the material
    return error;
  }
  verdict.materials = bundle->entries().size();
  verdict.version = bundle->version();
  return ok_status();
}

Result<Verdict> verify(const std::string& text, const MemoryLimit& limit) {
  if (is_named(text)) return unsupported("is a model; only sliced files and bundles have checksums");
  const Result<std::shared_ptr<const ByteSource>> file = open_named_bytes(text, limit);
  if (!file) return file.error();
  const Result<const Format*> format = recognise(**file);
  if (!format) return format.error();
  const Capabilities& can = (*format)->capabilities;
  if (!can.has(Capability::kManyMaterials) && !can.has(Capability::kBundled)) {
    return unsupported("is of another kind, " + std::string((*format)->description) +
                       "; only sliced files and bundles have checksums");
  }
  Verdict verdict;
  verdict.bytes = (*file)->size();
  const Status status = can.has(Capability::kManyMaterials) ? verify_bundle(**file, limit, verdict)
                                                            : verify_sliced(**file, limit, verdict);
  if (!status) return status.error();
  return verdict;
}

int run_verify(const VerifyOptions& options) {
  int exit_code = 0;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  Table table;
  for (const std::string& file : options.files) {
    if (interrupted()) return report_error("", interrupted_error());
    const Result<Verdict> verdict = verify(file, options.memory);
    if (!verdict) {
      json.push_back({{"file", file}, {"ok", false}, {"error", verdict.error().message}});
      const int failed = report_error(file, verdict.error());
      if (exit_code == 0) exit_code = failed;
      continue;
    }
    json.push_back({{"file", file},
                    {"ok", true},
                    {"version", verdict->version},
                    {"bytes", verdict->bytes},
                    {"materials", verdict->materials},
                    {"chunks", verdict->chunks},
                    {"samples", verdict->samples}});
    table.add({"ok", file, "version " + verdict->version, format_count(verdict->bytes) + " bytes",
               format_count(verdict->materials) + " materials", format_count(verdict->chunks) + " chunks",
               format_count(verdict->samples) + " samples"});
  }
  if (options.json) {
    print_json(json);
  } else {
    table.print();
  }
  return exit_code;
}

}  // namespace

void add_verify(CLI::App& program, int& exit_code) {
  auto* command =
      program.add_subcommand("verify", "Checks every byte of sliced files and bundles: checksums, sizes, content.");
  const auto options = std::make_shared<VerifyOptions>();
  command->add_option("FILE", options->files, "Sliced files, bundles, or BUNDLE.sbrdfz:NAME")->required();
  command->add_flag("--json", options->json, "Print JSON");
  add_memory_limit(*command, options->memory);
  command->footer(
      "All files are checked; the exit code is that of the first bad one, 3 for a damaged file.\n\n"
      "Example:\n  sbrdf verify materials/*.sbrdf");
  command->callback([options, &exit_code] { exit_code = run_verify(*options); });
}

}  // namespace sbrdf::internal
