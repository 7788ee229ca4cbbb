#include "tools/io/sources.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "converters/files/format_table.h"
#include "converters/models/kurt.h"
#include "converters/source/progress.h"
#include "formats/sbrdf/bundle.h"
#include "tools/console/interrupt.h"
#include "tools/io/files.h"

namespace sbrdf {
namespace {

bool names_json(const std::string& name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension == ".json";
}

Result<OpenedSource> open_kurt(const std::string& name) {
  OpenedSource opened;
  Result<KurtModel> model = KurtModel{};
  if (names_json(name)) {
    const Result<std::vector<std::byte>> file = read_file(name);
    if (!file) return file.error();
    opened.bytes = file->size();
    model = parse_kurt_json({reinterpret_cast<const char*>(file->data()), file->size()});
  } else {
    model = kurt_material(name);
  }
  if (!model) return model.error();
  opened.source = make_kurt_source(*model);
  return opened;
}

bool exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

/// Where the ':' between a bundle, or else any file, and the name of a material in it stands; nothing without a file.
/// Both may hold others.
std::optional<std::size_t> find_separator(const std::string& text) {
  std::optional<std::size_t> other;
  for (std::size_t at = text.find(':'); at != std::string::npos; at = text.find(':', at + 1)) {
    const std::string path = text.substr(0, at);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) continue;
    const Result<std::unique_ptr<ByteSource>> file = map_file(path);
    if (!file) return at;
    const auto start = read_range(**file, 0, std::min<std::uint64_t>(kBundleMagic.size(), (*file)->size()));
    if (start && is_bundle(*start)) return at;
    if (!other) other = at;
  }
  return other;
}

Result<std::vector<std::byte>> read_material(const std::string& bundle, const std::string& name) {
  const Result<std::unique_ptr<ByteSource>> file = map_file(bundle);
  if (!file) return file.error();
  const Result<BundleReader> reader = BundleReader::open(**file);
  if (!reader) return reader.error();
  const Result<std::unique_ptr<ByteSource>> material = reader->material(name);
  if (!material) return material.error();
  return read_range(**material, 0, (*material)->size());
}

/// The bytes of what `text` names: a file first, else a material of a bundle.
Result<std::vector<std::byte>> read_named(const std::string& text) {
  const auto separator = exists(text) ? std::nullopt : find_separator(text);
  if (separator) return read_material(text.substr(0, *separator), text.substr(*separator + 1));
  Result<std::vector<std::byte>> file = read_file(text);
  if (!file || !is_bundle(*file)) return file;
  const MemorySource source(*file);
  const Result<BundleReader> reader = BundleReader::open(source);
  return reader ? reader->find("").error() : reader.error();
}

}  // namespace

Result<OpenedSource> open_source(const std::string& text) {
  if (text.starts_with(kKurtPrefix)) return open_kurt(text.substr(kKurtPrefix.size()));
  const Result<std::vector<std::byte>> file = read_named(text);
  if (!file) return file.error();
  Result<std::unique_ptr<BrdfSource>> source = load_source(*file);
  if (!source) return source.error();
  // Reading a large table takes long enough for somebody to change their mind.
  if (interrupted()) return interrupted_error();
  return OpenedSource{*std::move(source), file->size()};
}

}  // namespace sbrdf
