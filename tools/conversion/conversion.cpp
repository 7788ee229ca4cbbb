#include "tools/conversion/conversion.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <span>
#include <utility>

#include "converters/files/analytic/analytic_file.h"
#include "converters/files/format_table.h"
#include "formats/os/files.h"
#include "tools/console/terminal.h"
#include "tools/io/outputs.h"
#include "tools/io/sha256.h"

namespace sbrdf::internal {
namespace {

bool may_be_read_with(std::optional<const Format*> read, std::string_view name) {
  if (read) return *read != nullptr && reads_with(**read, name);
  return std::any_of(formats().begin(), formats().end(),
                     [&](const Format& format) { return reads_with(format, name); });
}

/// The file that is written, which knows whether an error was its own, and what else is written along with it.
class OutputSink final : public ByteSink {
 public:
  explicit OutputSink(AtomicFile& file) : file_(file) {}
  [[nodiscard]] Status write(std::uint64_t offset, std::span<const std::byte> bytes) override {
    Status written = file_.write(offset, bytes);
    if (!written) failed_ = true;
    return written;
  }
  [[nodiscard]] std::string path() const override {
    opened_ = true;
    return file_.path();
  }
  [[nodiscard]] Result<ByteSink*> sibling(std::string_view suffix) override {
    Result<ByteSink*> made = file_.sibling(suffix);
    if (made) {
      siblings_.push_back({std::string(suffix), *made});
    } else {
      failed_ = true;
    }
    return made;
  }
  /// Whether an error is that of the file that is written: one of its own, or of a library that writes to it.
  [[nodiscard]] bool failed(const Error& error) const { return failed_ || (opened_ && error.code == ErrorCode::kIo); }

  /// To be asked before the files get their names: from then on somebody else may replace them.
  [[nodiscard]] std::vector<WrittenFile> written(const ConversionOrder& order) const {
    std::vector<WrittenFile> files = {look_at(order.out, file_, order.hash_written)};
    for (const auto& [suffix, sink] : siblings_) {
      files.push_back(look_at(sibling_path(order.out, suffix).string(), *sink, order.hash_written));
    }
    return files;
  }

 private:
  static WrittenFile look_at(const std::string& path, const ByteSink& sink, bool hash) {
    const std::string temporary = sink.path();
    std::error_code failed;
    const auto size = std::filesystem::file_size(temporary, failed);
    return {path, failed ? 0 : size, hash ? sha256_of(temporary) : std::string()};
  }

  AtomicFile& file_;
  std::vector<std::pair<std::string, ByteSink*>> siblings_;
  std::atomic<bool> failed_ = false;
  mutable std::atomic<bool> opened_ = false;  ///< somebody was told where the file lies
};

// What was asked for, for the metadata: names of files without their folders, which say more about a machine than about
// a material.
std::string command_text(const ConversionOrder& order) {
  const auto name_of = [](const std::string& path) {
    return is_named(path) && path.find('/') == std::string::npos ? path
                                                                 : std::filesystem::path(path).filename().string();
  };
  const std::string options = options_text(order.given);
  return "sbrdf convert " + name_of(order.in) + " " + name_of(order.out) + (options.empty() ? "" : " ") + options;
}

Result<OpenedSource> open(const ConversionOrder& order, std::string& sha256) {
  if (order.bytes != nullptr) {
    sha256 = sha256_of(*order.bytes);
    return source_in(order.bytes, order.given);
  }
  Result<OpenedSource> in = open_source(order.in, order.given);
  if (in) sha256 = sha256_of(order.in);
  return in;
}

std::optional<Failure> save(const ConversionOrder& order, Conversion& done, const Progress& progress) {
  Options writing = order.given.select(order.format->options, OptionUse::kWrite);
  if (order.format->capabilities.has(Capability::kMetadata)) {
    writing.provenance = {command_text(order), done.sha256};
  }
  const Result<std::unique_ptr<AtomicFile>> file = AtomicFile::create(order.out);
  if (!file) return Failure{order.out, file.error()};
  OutputSink sink(**file);
  if (Status saved = save_source(*order.format, *done.in.source, sink, writing, done.report, progress); !saved) {
    return Failure{sink.failed(saved.error()) ? order.out : order.in, saved.error()};
  }
  done.written = sink.written(order);
  if (Status written = (*file)->commit(); !written) return Failure{order.out, written.error()};
  return std::nullopt;
}

}  // namespace

Result<const Format*> find_target(std::string_view text) {
  std::string wanted(text);
  std::transform(wanted.begin(), wanted.end(), wanted.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  std::string known;
  // Names before extensions: several formats may share one of these.
  for (const bool by_name : {true, false}) {
    for (const Format& format : formats()) {
      if (!format.capabilities.has(Capability::kWrite)) continue;
      const std::string_view key = by_name ? format.name : format.extension;
      if (key == wanted || (!by_name && key == "." + wanted)) return &format;
      if (by_name) known += fmt::format("{}{} ({})", known.empty() ? "" : ", ", format.name, format.extension);
    }
  }
  return usage_error(fmt::format("no format that is written is called '{}'; use one of {}", text, known));
}

Status check_effects(const Options& given, const Format& written, std::optional<const Format*> read) {
  for (const auto& [name, text] : given.all()) {
    if (find_option(written.options, name, OptionUse::kWrite) != nullptr) continue;
    if (may_be_read_with(read, name)) continue;
    const Format* owner = find_format_with(name);
    return usage_error(fmt::format("--{} is an option of {} files, not of {} files that are written", name,
                                   owner == nullptr ? "no" : owner->extension, written.extension));
  }
  return ok_status();
}

Options effective_options(const Options& given, const Format& written, const Format& read) {
  Options effective;
  effective.memory = given.memory;
  for (const auto& [name, text] : given.all()) {
    if (find_option(written.options, name, OptionUse::kWrite) != nullptr || reads_with(read, name)) {
      effective.set(name, text);
    }
  }
  return effective;
}

std::string options_text(const Options& given) {
  std::string words;
  for (const Format& format : formats()) {
    for (const OptionSpec& option : format.options) {
      const std::optional<std::string> value = given.text(option.name);
      if (!value || find_format_with(option.name) != &format) continue;
      words += fmt::format("{}--{}", words.empty() ? "" : " ", option.name);
      if (option.kind != OptionKind::kFlag) words += " " + *value;
    }
  }
  return words;
}

std::optional<Failure> convert_file(const ConversionOrder& order, Conversion& done, const Progress& progress) {
  const Stopwatch watch;
  if (Status used = check_effects(order.given, *order.format, std::nullopt); !used) {
    return Failure{order.out, used.error()};
  }
  if (Status free = check_output(order.out, order.format, std::span(&order.in, 1)); !free) {
    return Failure{order.out, free.error()};
  }
  Result<OpenedSource> in = open(order, done.sha256);
  if (!in) return Failure{order.in, in.error()};
  done.in = *std::move(in);
  if (Status used = check_effects(order.given, *order.format, done.in.format); !used) {
    return Failure{order.in, used.error()};
  }
  if (auto failure = save(order, done, progress)) return failure;
  done.seconds = watch.seconds();
  return std::nullopt;
}

}  // namespace sbrdf::internal
