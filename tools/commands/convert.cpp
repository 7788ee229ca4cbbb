#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <system_error>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "formats/os/files.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/conversion/conversion.h"
#include "tools/conversion/conversion_report.h"
#include "tools/conversion/convert_folder.h"
#include "tools/conversion/report_file.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

struct ConvertOptions {
  std::string in;
  std::string out;
  std::string to;      ///< a row's name or an extension; empty: the extension of `out` tells
  std::string report;  ///< a file; empty: none
  Options given;       ///< those that rows of the format table declare
  std::optional<Shard> shard;
  bool recursive = false;
  bool json = false;
};

Result<const Format*> writer_of(const ConvertOptions& options) {
  return options.to.empty() ? find_writer(extension_of(options.out)) : find_target(options.to);
}

bool is_folder(const std::string& path) {
  std::error_code failed;
  return std::filesystem::is_directory(path, failed);
}

std::optional<Failure> convert_one(const ConvertOptions& options, ConversionOrder& order, Conversion& done) {
  const Result<const Format*> writer = writer_of(options);
  if (!writer) return Failure{options.out, writer.error()};
  order = {.in = options.in, .out = options.out, .format = *writer, .given = options.given};
  const bool reports = !options.report.empty();
  if (reports) {
    Status free =
        check_report(options.report, paths_read(std::span(&options.in, 1)), paths_written(options.out, **writer));
    if (free) free = check_destination(options.report);
    if (!free) return Failure{options.report, free.error()};
  }
  ProgressBar bar("converting");
  auto failure = convert_file(order, done, bar.progress());
  if (failure || !reports) return failure;
  const Status written = write_report_file(options.report, report_of(order, done));
  return written ? std::nullopt : std::optional(Failure{options.report, written.error()});
}

int run_convert(const ConvertOptions& options) {
  if (is_folder(options.in) && options.to.empty()) {
    return report_error(options.in, io_error("is a directory; '--to FORMAT' converts the files in it"));
  }
  ConversionOrder order;
  Conversion done;
  if (const auto failure = convert_one(options, order, done)) return report_error(failure->subject, failure->error);
  if (options.json) {
    print_json(report_of(order, done));
  } else {
    print_report(order, done);
  }
  return 0;
}

FolderOrder folder_order(const ConvertOptions& options, const Format* format) {
  return {.folder = options.in,
          .out_folder = options.out,
          .format = format,
          .given = options.given,
          .shard = options.shard.value_or(Shard()),
          .recursive = options.recursive,
          .report = options.report};
}

void add_folder_options(CLI::App& command, ConvertOptions& options) {
  command.add_option("--to", options.to, "What to write: a format's name or extension; needed where IN is a folder")
      ->type_name("FORMAT");
  command
      .add_option_function<std::string>(
          "--shard",
          [&options](const std::string& text) {
            const Result<Shard> shard = parse_shard(text);
            if (!shard) throw CLI::ValidationError("--shard", shard.error().message);
            options.shard = *shard;
          },
          "Of a folder, only every N-th file, beginning with the I-th: several runs at once share the work")
      ->type_name("I/N");
  command.add_flag("--recursive", options.recursive, "Of a folder, the files in its subfolders as well");
  command.add_option("--report", options.report, "Write the report as JSON, of a folder as an array with all files")
      ->type_name("FILE.json");
}

// Wrong usage, before anything is looked at.
void check_usage(const ConvertOptions& options) {
  const bool folder = is_folder(options.in) && !options.to.empty();
  if (!folder && options.shard) throw CLI::ValidationError("--shard", "is for a folder and --to");
  if (!folder && options.recursive) throw CLI::ValidationError("--recursive", "is for a folder and --to");
  const Result<const Format*> writer = writer_of(options);
  if (!writer && !options.to.empty()) throw CLI::ValidationError("--to", writer.error().message);
  if (!writer) return;
  const Status allowed = check_save(**writer, options.given.select((*writer)->options, OptionUse::kWrite));
  if (!allowed) throw CLI::ValidationError(allowed.error().message);
}

const char* const kFooter =
    "A sliced IN is copied to a sliced OUT as it is, unless one of the options on slices asks to sample it again;\n"
    "--precision and --chunks only write it another way.\n\n"
    "Of a folder, each file goes to OUT/NAME with another extension. Options have to fit OUT or some format that is\n"
    "read. Files whose names begin with a dot, sidecars (x.npy.json) and documents (README, *.md, *.png) are skipped "
    "and\n"
    "said to be; all others that cannot be converted are named, and the exit code is that of the first. What an "
    "earlier\n"
    "run has done is kept as long as source, options, program and output are the same: after an interruption, run the\n"
    "command again. specs/convert.md tells it all.\n\n"
    "Examples:\n"
    "  sbrdf convert material.bsdf material.sbrdf --samples 4096\n"
    "  sbrdf convert material.sbrdf material.binary\n"
    "  sbrdf convert kurt:fabric112 fabric112.sbrdf --samples 8911 --placement 14/36 --domain linear --refine "
    "measured\n"
    "  sbrdf convert downloads/ sliced/ --to sbrdf --report sliced/report.json";

}  // namespace

void add_convert(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("convert", "Writes a BRDF, or each in a folder, in another format.");
  const auto options = std::make_shared<ConvertOptions>();
  command
      ->add_option("IN", options->in,
                   "A file of any readable format, kurt:NAME or kurt:FILE.json; or a folder of files")
      ->required();
  command
      ->add_option(
          "OUT", options->out,
          "The file to write; its extension chooses the format. Or the folder of the files, which may be missing")
      ->required();
  add_folder_options(*command, *options);
  add_format_options(*command, options->given);
  command->add_flag("--json", options->json, "Print the report as JSON");
  add_memory_limit(*command, options->given.memory);
  command->footer(kFooter);
  command->callback([options, &exit_code] {
    check_usage(*options);
    const Result<const Format*> writer = writer_of(*options);
    const bool folder = is_folder(options->in) && !options->to.empty();
    exit_code = folder ? run_convert_folder(folder_order(*options, *writer), options->json) : run_convert(*options);
  });
}

}  // namespace sbrdf::internal
