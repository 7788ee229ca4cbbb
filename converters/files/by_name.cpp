#include "converters/files/by_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "converters/files/analytic/analytic_file.h"
#include "converters/files/format_table.h"
#include "converters/source/progress.h"
#include "formats/os/files.h"
#include "formats/os/interrupt.h"
#include "formats/os/trial.h"

namespace sbrdf::internal {
namespace {

using Bytes = std::shared_ptr<const ByteSource>;

bool holds_many(const ByteSource& bytes) {
  const Result<const Format*> format = recognise(bytes);
  return format && (*format)->capabilities.has(Capability::kManyMaterials);
}

/// Where the ':' between a file of many materials, or else any file, and the name of one of them stands; nothing
/// without a file. Both may hold others.
std::optional<std::size_t> find_separator(const std::string& text) {
  std::optional<std::size_t> other;
  for (std::size_t at = text.find(':'); at != std::string::npos; at = text.find(':', at + 1)) {
    const std::string path = text.substr(0, at);
    if (!is_ordinary_file(path)) continue;
    const Result<std::unique_ptr<ByteSource>> file = map_file(path);
    if (!file || holds_many(**file)) return at;
    if (!other) other = at;
  }
  return other;
}

Result<Bytes> open_material(const std::string& path, std::string_view name, const MemoryLimit& limit) {
  Result<std::unique_ptr<ByteSource>> mapped = map_file(path);  // a bundle is read in part
  if (!mapped) return mapped.error();
  Bytes file = *std::move(mapped);
  const Result<const Format*> format = recognise(*file);
  if (!format) return format.error();
  if (!(*format)->capabilities.has(Capability::kManyMaterials)) {
    return usage_error("holds one material, so that no name can stand behind a ':'");
  }
  return (*format)->material(std::move(file), name, limit);
}

Result<OpenedSource> open_kurt(const std::string& path) {
  const Result<Bytes> file = open_file(path);
  if (!file) return file.error();
  Result<std::unique_ptr<BrdfSource>> source = open_analytic_file(**file);
  if (!source) return source.error();
  return OpenedSource{*std::move(source), (*file)->size()};
}

Status survive_trial(const Format& format, const ByteSource& bytes, const Options& options) {
  std::vector<std::string> arguments;
  for (const auto& [name, text] : options.all()) arguments.push_back(fmt::format("{}={}", name, text));
  const Result<TrialEnd> end = try_apart(bytes, arguments);
  if (!end) return end.error();
  if (*end == TrialEnd::kFell) {
    return invalid_file(fmt::format("damaged: the library that reads {} files falls over it", format.extension));
  }
  if (*end == TrialEnd::kEndless) {
    return invalid_file(
        fmt::format("damaged: the library that reads {} files comes to no end with it", format.extension));
  }
  return ok_status();
}

}  // namespace

bool open_in_trial(std::span<char* const> arguments) {
  Options options;
  for (const std::string_view argument : arguments) {
    const std::size_t equals = argument.find('=');
    if (equals == std::string_view::npos) continue;
    options.set(std::string(argument.substr(0, equals)), std::string(argument.substr(equals + 1)));
  }
  const Result<Bytes> bytes = open_file(kTrialFile);
  if (!bytes) return false;
  std::ignore = source_in(*bytes, options);
  return true;
}

Result<std::shared_ptr<const ByteSource>> open_named_bytes(const std::string& text, const MemoryLimit& limit) {
  const auto separator = exists(text) ? std::nullopt : find_separator(text);
  return separator ? open_material(text.substr(0, *separator), text.substr(*separator + 1), limit) : open_file(text);
}

Result<OpenedSource> source_in(const std::shared_ptr<const ByteSource>& bytes, const Options& options) {
  const Result<const Format*> format = recognise(*bytes);
  if (!format) return format.error();
  const Options reading = options.select((*format)->options, OptionUse::kRead);
  if ((*format)->fragile) {
    if (Status survived = survive_trial(**format, *bytes, reading); !survived) return survived.error();
  }
  Result<std::unique_ptr<BrdfSource>> source = open_source(bytes, reading);
  if (!source) return source.error();
  // Reading a large table takes long enough for somebody to change their mind.
  if (interrupted()) return interrupted_error();
  return OpenedSource{*std::move(source), bytes->size(), *format};
}

Result<std::shared_ptr<const ByteSource>> open_sliced_bytes(const std::string& text, std::string_view what,
                                                            const MemoryLimit& limit) {
  if (is_named(text)) return unsupported(fmt::format("is a model; {} are those of sliced files", what));
  Result<Bytes> bytes = open_named_bytes(text, limit);
  if (!bytes) return bytes;
  const Result<const Format*> format = recognise(**bytes);
  if (!format) return format.error();
  if ((*format)->capabilities.has(Capability::kManyMaterials)) return (*format)->material(*bytes, "", limit);
  if ((*format)->capabilities.has(Capability::kBundled)) return bytes;
  return unsupported(fmt::format("is of another kind, {}; {} are those of sliced files, see 'sbrdf convert --help'",
                                 (*format)->description, what));
}

std::optional<std::string> file_of(const std::string& text) {
  if (const auto path = file_in_name(text)) return std::string(*path);
  if (is_named(text)) return std::nullopt;
  const auto separator = exists(text) ? std::nullopt : find_separator(text);
  return text.substr(0, separator.value_or(text.size()));
}

std::optional<const Format*> format_of(const std::string& text, const MemoryLimit& limit) {
  if (is_named(text)) return nullptr;
  const std::optional<std::string> path = file_of(text);
  if (!path || !is_ordinary_file(*path)) return std::nullopt;
  const Result<Bytes> bytes = open_named_bytes(text, limit);
  if (!bytes) return std::nullopt;
  const Result<const Format*> format = recognise(**bytes);
  return format ? std::optional(*format) : std::nullopt;
}

std::string lower_extension(const std::string& path) {
  std::string extension = extension_of(path);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

Result<OpenedSource> open_source(const std::string& text, const Options& options) {
  if (const auto path = file_in_name(text)) return open_kurt(std::string(*path));
  OpenedSource opened;
  if (is_named(text)) {
    Result<std::unique_ptr<BrdfSource>> source = open_named(text);
    if (!source) return source.error();
    opened.source = *std::move(source);
    return opened;
  }
  const Result<Bytes> bytes = open_named_bytes(text, options.memory);
  if (!bytes) return bytes.error();
  return source_in(*bytes, options);
}

}  // namespace sbrdf::internal
