#include "tools/conversion/folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <system_error>
#include <utility>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "formats/core/numbers.h"
#include "formats/os/files.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostShards = 1'000'000;

// What lies beside measurements in archives and repositories.
constexpr std::array<std::string_view, 10> kDocumentNames = {"readme", "license", "licence",  "copying",   "copyright",
                                                             "notice", "authors", "citation", "changelog", "checksums"};
constexpr std::array<std::string_view, 14> kDocumentExtensions = {
    ".md", ".txt", ".rst", ".html", ".htm", ".pdf", ".bib", ".png", ".jpg", ".jpeg", ".gif", ".svg", ".md5", ".sha256"};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return text;
}

template <class Words>
bool is_among(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool is_extension_of_format(std::string_view extension) {
  return std::any_of(formats().begin(), formats().end(),
                     [&](const Format& format) { return format.extension == extension; });
}

/// By its name: README, README.txt, LICENSE.md, picture.png. Where .txt files are a format, notes.txt is none.
bool has_name_of_document(const fs::path& path) {
  const std::string extension = lower_extension(path.string());
  if (is_extension_of_format(extension)) return is_among(kDocumentNames, lower(path.stem().string()));
  return is_among(kDocumentExtensions, extension) || is_among(kDocumentNames, lower(path.stem().string()));
}

bool is_of_a_format(const fs::path& path) {
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  return file && recognise(**file);
}

bool is_any_of(const fs::path& path, const std::vector<std::string>& others) {
  return std::any_of(others.begin(), others.end(), [&](const std::string& other) {
    std::error_code failed;
    return fs::equivalent(path, other, failed) && !failed;
  });
}

/// Goes through a folder; names are those below `root`.
class Listing {
 public:
  Listing(fs::path root, const FolderRules& rules) : root_(std::move(root)), rules_(rules) {}

  [[nodiscard]] Status enter(const fs::path& below) {
    std::error_code failed;
    for (fs::directory_iterator at(root_ / below, failed), end; !failed && at != end; at.increment(failed)) {
      if (Status looked = look_at(below / at->path().filename()); !looked) return looked;
    }
    if (!failed) return ok_status();
    return io_error((below.empty() ? "" : below.string() + ": ") + "cannot be read: " + failed.message());
  }

  [[nodiscard]] FolderContent finish() && {
    leave_out_sidecars();
    std::sort(content_.skipped.begin(), content_.skipped.end(),
              [](const SkippedFile& a, const SkippedFile& b) { return a.name < b.name; });
    return std::move(content_);
  }

 private:
  [[nodiscard]] Status look_at(const fs::path& name) {
    const fs::path path = root_ / name;
    const auto skip = [&](std::string reason) {
      content_.skipped.push_back({name.string(), std::move(reason)});
      return ok_status();
    };
    std::error_code failed;
    const fs::file_status status = fs::status(path, failed);
    if (name.filename().string().starts_with('.')) return skip("its name begins with a dot");
    if (is_any_of(path, rules_.ignored)) return skip("it is written by this run");
    if (fs::is_directory(status)) {
      // A link to a folder above would never end.
      if (!rules_.recursive || fs::is_symlink(fs::symlink_status(path, failed))) return skip("it is a folder");
      return enter(name);
    }
    // A link to nothing is to be told of, like any file that cannot be read.
    if (fs::exists(status) && !fs::is_regular_file(status)) return skip("it is no ordinary file");
    if (has_name_of_document(name) && !is_of_a_format(path)) return skip("it is a document");
    content_.files.push_back({name.string(), {}, {}});
    return ok_status();
  }

  void leave_out_sidecars() {
    std::vector<FolderFile>& files = content_.files;
    std::sort(files.begin(), files.end(), [](const FolderFile& a, const FolderFile& b) { return a.name < b.name; });
    std::map<std::string, FolderFile*> by_name;
    for (FolderFile& file : files) {
      if (!extension_of(file.name).empty()) by_name.emplace(file.name, &file);
    }
    std::set<std::string> sidecars;
    for (const FolderFile& file : files) {
      if (!file.name.ends_with(kSidecarSuffix)) continue;
      const auto owner = by_name.find(file.name.substr(0, file.name.size() - kSidecarSuffix.size()));
      if (owner == by_name.end()) continue;
      owner->second->sidecar = file.name;
      sidecars.insert(file.name);
      content_.skipped.push_back({file.name, "it belongs to " + owner->first});
    }
    std::erase_if(files, [&](const FolderFile& file) { return sidecars.contains(file.name); });
  }

  fs::path root_;
  const FolderRules& rules_;
  FolderContent content_;
};

// More than one round: a whole name may be the short one of another file. Whole names differ, so it ends.
void name_outputs(std::vector<FolderFile>& files, const std::string& extension) {
  for (FolderFile& file : files) file.out = fs::path(file.name).replace_extension(extension).string();
  for (bool changed = true; changed;) {
    changed = false;
    std::map<std::string, int> uses;
    for (const FolderFile& file : files) ++uses[file.out];
    for (FolderFile& file : files) {
      if (uses[file.out] == 1 || file.out == file.name + extension) continue;
      file.out = file.name + extension;
      changed = true;
    }
  }
}

}  // namespace

Result<Shard> parse_shard(std::string_view text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  const auto number = parse_count(text.substr(0, slash));
  const auto count = slash < text.size() ? parse_count(text.substr(slash + 1)) : std::nullopt;
  if (number && count && *number >= 1 && *number <= *count && *count <= kMostShards) return Shard{*number, *count};
  return usage_error("'" + std::string(text) + "' is not one of several parts, such as 2/3");
}

Result<FolderContent> list_folder(const std::string& folder, const FolderRules& rules) {
  Listing listing(folder, rules);
  if (Status entered = listing.enter({}); !entered) return entered.error();
  FolderContent content = std::move(listing).finish();
  name_outputs(content.files, rules.extension);
  if (content.files.empty()) return usage_error("the folder holds nothing to convert");
  return content;
}

}  // namespace sbrdf::internal
