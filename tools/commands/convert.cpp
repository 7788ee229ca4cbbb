#include <fmt/format.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "converters/files/kurt/kurt_file.h"
#include "formats/os/files.h"
#include "tools/commands/commands.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"
#include "tools/io/sha256.h"

namespace sbrdf::internal {
namespace {

struct ConvertOptions {
  std::string in;
  std::string out;
  Options given;  ///< those that rows of the format table declare
  bool json = false;
};

struct Conversion {
  OpenedSource in;
  const Format* format = nullptr;
  Report report;
  double seconds = 0;
};

/// An error and whose it is.
struct Failure {
  std::string subject;
  Error error;
};

Result<const Format*> writer_of(const ConvertOptions& options) {
  return find_writer(std::filesystem::path(options.out).extension().string());
}

/// The format that has an option, for messages.
const Format* owner_of(std::string_view name) {
  for (const Format& format : formats()) {
    if (find_option(format.options, name, OptionUse::kBoth) != nullptr) return &format;
  }
  return nullptr;
}

// An option without effect is a misunderstanding: each must be one for writing OUT or for reading IN. As long as IN is
// not open, it may be one for reading any format.
Status check_uses(const Options& given, const Format& written, std::optional<const Format*> read) {
  for (const auto& [name, text] : given.all()) {
    if (find_option(written.options, name, OptionUse::kWrite) != nullptr) continue;
    const Format* owner = owner_of(name);
    const Format* reader = read.value_or(owner);
    if (reader != nullptr && find_option(reader->options, name, OptionUse::kRead) != nullptr) continue;
    return usage_error(fmt::format("--{} is an option of {} files, not of {} files that are written", name,
                                   owner->extension, written.extension));
  }
  return ok_status();
}

/// The file that is written, which knows whether an error was its own.
class OutputSink final : public ByteSink {
 public:
  explicit OutputSink(AtomicFile& file) : file_(file) {}
  [[nodiscard]] Status write(std::uint64_t offset, std::span<const std::byte> bytes) override {
    Status written = file_.write(offset, bytes);
    if (!written) failed_ = true;
    return written;
  }
  [[nodiscard]] std::string path() const override { return file_.path(); }
  [[nodiscard]] Result<ByteSink*> sibling(std::string_view suffix) override { return file_.sibling(suffix); }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  AtomicFile& file_;
  std::atomic<bool> failed_ = false;
};

std::optional<Failure> save(const ConvertOptions& options, Conversion& done) {
  Options writing = options.given.select(done.format->options, OptionUse::kWrite);
  if (done.format->capabilities.has(Capability::kMetadata)) {
    writing.provenance.source_sha256 = sha256_of(options.in);
  }
  const Result<std::unique_ptr<AtomicFile>> file = AtomicFile::create(options.out);
  if (!file) return Failure{options.out, file.error()};
  OutputSink sink(**file);
  ProgressBar bar("converting");
  if (Status saved = save_source(*done.format, *done.in.source, sink, writing, done.report, bar.progress()); !saved) {
    return Failure{sink.failed() ? options.out : options.in, saved.error()};
  }
  if (Status written = (*file)->commit(); !written) return Failure{options.out, written.error()};
  return std::nullopt;
}

std::optional<Failure> convert(const ConvertOptions& options, Conversion& done) {
  const Stopwatch watch;
  const Result<const Format*> writer = writer_of(options);
  if (!writer) return Failure{options.out, writer.error()};
  done.format = *writer;
  if (Status used = check_uses(options.given, *done.format, std::nullopt); !used) {
    return Failure{options.out, used.error()};
  }
  if (Status free = check_output(options.out, done.format, std::span(&options.in, 1)); !free) {
    return Failure{options.out, free.error()};
  }
  Result<OpenedSource> in = open_source(options.in, options.given);
  if (!in) return Failure{options.in, in.error()};
  done.in = *std::move(in);
  if (Status used = check_uses(options.given, *done.format, done.in.format); !used) {
    return Failure{options.in, used.error()};
  }
  if (auto failure = save(options, done)) return failure;
  done.seconds = watch.seconds();
  return std::nullopt;
}

// What was asked for, for the metadata: names of files without their folders, which say more about a machine than about
// a material; options in the order in which they are declared.
std::string command_text(const ConvertOptions& options) {
  const auto name_of = [](const std::string& path) {
    return is_named(path) && path.find('/') == std::string::npos ? path
                                                                 : std::filesystem::path(path).filename().string();
  };
  std::string text = "sbrdf convert " + name_of(options.in) + " " + name_of(options.out);
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      const std::optional<std::string> value = options.given.text(option.name);
      if (!value || owner_of(option.name) != &format) continue;
      text += fmt::format(" --{}", option.name);
      if (option.kind != OptionKind::kFlag) text += " " + *value;
    }
  }
  return text;
}

void print_as_json(const ConvertOptions& options, const Conversion& done) {
  const SourceTraits& traits = done.in.source->traits();
  nlohmann::ordered_json json;
  json["in"] = {{"path", options.in}, {"format", traits.format}, {"description", traits.description}};
  json["in"]["bytes"] = done.in.bytes ? nlohmann::ordered_json(*done.in.bytes) : nlohmann::ordered_json();
  json["in"]["findings"] = nlohmann::ordered_json::array();
  for (const Finding& finding : done.report.findings) {
    json["in"]["findings"].push_back({{"what", finding.what}, {"count", finding.count}, {"total", finding.total}});
  }
  json["out"] = {{"path", options.out}, {"format", done.format->name}, {"bytes", done.report.bytes}};
  json["remarks"] = nlohmann::ordered_json::array();
  for (const Remark& remark : done.report.remarks) {
    json["remarks"].push_back({{"key", remark.key}, {"value", remark.value}, {"text", remark.text}});
  }
  json["seconds"] = done.seconds;
  print_json(json);
}

void print_as_table(const ConvertOptions& options, const Conversion& done) {
  const SourceTraits& traits = done.in.source->traits();
  Table table;
  table.add({"read", options.in + ": " + traits.description +
                         (done.in.bytes ? ", " + format_count(*done.in.bytes) + " bytes" : "")});
  for (const Finding& finding : done.report.findings) {
    table.add({"found", format_count(finding.count) + " of " + format_count(finding.total) + " " + finding.what});
  }
  table.add({"wrote", options.out + ": " + std::string(done.format->description) + ", " +
                          format_count(done.report.bytes) + " bytes"});
  for (const Remark& remark : done.report.remarks) table.add({"", remark.text});
  table.add({"took", format_number(done.seconds) + " s"});
  table.print();
}

int run_convert(const ConvertOptions& options) {
  Conversion done;
  if (const auto failure = convert(options, done)) return report_error(failure->subject, failure->error);
  if (options.json) {
    print_as_json(options, done);
  } else {
    print_as_table(options, done);
  }
  return 0;
}

void add_option(CLI::App& command, const OptionSpec& option, const std::string& group, Options& given) {
  const std::string flag = fmt::format("--{}", option.name);
  const auto take = [&option, &given](const std::string& text) {
    if (Status checked = check_value(option, text); !checked) throw CLI::ValidationError(checked.error().message);
    given.set(std::string(option.name), text);
  };
  const std::string meaning(option.meaning);
  if (option.kind == OptionKind::kFlag) {
    command
        .add_flag_callback(
            flag, [take] { take(""); }, meaning)
        ->group(group);
    return;
  }
  const bool chosen = option.kind == OptionKind::kChoice;
  command.add_option_function<std::string>(flag, take, meaning)
      ->type_name(chosen ? fmt::format("{}", fmt::join(option.choices, "|")) : std::string(option.unit))
      ->default_str(std::string(option.fallback))
      ->group(group);
}

// One group in the help for each format. Formats that share an option mean the same by it.
void add_format_options(CLI::App& command, Options& given) {
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      if (owner_of(option.name) != &format) continue;
      const bool read_only = option.use == OptionUse::kRead;
      add_option(command, option, fmt::format("For {} files{}", format.extension, read_only ? " as IN" : ""), given);
    }
  }
}

}  // namespace

void add_convert(CLI::App& program, int& exit_code) {
  auto* command = program.add_subcommand("convert", "Writes a BRDF in another format.");
  const auto options = std::make_shared<ConvertOptions>();
  command->add_option("IN", options->in, "A file of any readable format, kurt:NAME or kurt:FILE.json")->required();
  command->add_option("OUT", options->out, "The file to write; its extension chooses the format")->required();
  add_format_options(*command, options->given);
  command->add_flag("--json", options->json, "Print the report as JSON");
  add_memory_limit(*command, options->given.memory);
  command->footer(
      "A sliced IN is copied to a sliced OUT as it is, unless one of the options on slices asks to sample it again;\n"
      "--precision and --chunks only write it another way.\n\n"
      "Examples:\n"
      "  sbrdf convert material.bsdf material.sbrdf --samples 4096\n"
      "  sbrdf convert material.sbrdf material.binary\n"
      "  sbrdf convert kurt:fabric112 fabric112.sbrdf --samples 8911 --placement 14/36 --domain linear --refine "
      "measured");
  command->callback([options, &exit_code] {
    if (const Result<const Format*> writer = writer_of(*options)) {
      const Status allowed = check_save(**writer, options->given.select((*writer)->options, OptionUse::kWrite));
      if (!allowed) throw CLI::ValidationError(allowed.error().message);
    }
    options->given.provenance.command = command_text(*options);
    exit_code = run_convert(*options);
  });
}

}  // namespace sbrdf::internal
