#include "tools/sources.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "converters/format_table.h"
#include "converters/kurt.h"
#include "converters/progress.h"
#include "tools/files.h"
#include "tools/interrupt.h"

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

}  // namespace

Result<OpenedSource> open_source(const std::string& text) {
  if (text.starts_with(kKurtPrefix)) return open_kurt(text.substr(kKurtPrefix.size()));
  const Result<std::vector<std::byte>> file = read_file(text);
  if (!file) return file.error();
  Result<std::unique_ptr<BrdfSource>> source = load_source(*file);
  if (!source) return source.error();
  // Reading a large table takes long enough for somebody to change their mind.
  if (interrupted()) return interrupted_error();
  return OpenedSource{*std::move(source), file->size()};
}

}  // namespace sbrdf
