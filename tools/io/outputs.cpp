#include "tools/io/outputs.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "formats/os/files.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kLongestBeside = std::size_t{8} << 20U;  // bytes; what is longer belongs to no file

bool is_same_file(const struct stat& status, const std::string& path) {
  struct stat other {};
  return ::stat(path.c_str(), &other) == 0 && other.st_dev == status.st_dev && other.st_ino == status.st_ino;
}

/// nullptr for what is no BRDF, or cannot be read.
const Format* format_of_content(const std::string& path) {
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  if (!file) return nullptr;
  const Result<const Format*> format = recognise(**file);
  return format ? *format : nullptr;
}

// Tables of figures are called .csv, too: of such a file the content alone tells.
const Format* format_of_name(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".csv") return nullptr;
  const auto found = std::find_if(formats().begin(), formats().end(),
                                  [&](const Format& format) { return format.extension == extension; });
  return found == formats().end() ? nullptr : &*found;
}

/// The files that one consists of beside itself.
std::vector<std::string> named_by(const std::string& path, const Format& format) {
  if (format.consists_of == nullptr) return {};
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  return file ? format.consists_of(**file) : std::vector<std::string>();
}

/// Of a file that is not there.
std::filesystem::path place_of(const std::string& path) {
  const Result<std::filesystem::path> target = write_target(path);
  return whole_path(target ? *target : std::filesystem::path(path));
}

/// Where the file beside one is looked for, and where it is written: behind a link it may be either of two places.
std::vector<std::string> places_beside(const std::string& path, std::string_view suffix) {
  std::vector<std::string> places = {path + std::string(suffix)};
  if (const Result<std::filesystem::path> target = write_target(path)) {
    std::string behind = target->string() + std::string(suffix);
    if (behind != places.front()) places.push_back(std::move(behind));
  }
  return places;
}

bool is_input(const std::string& path, std::span<const std::string> inputs) {
  return std::any_of(inputs.begin(), inputs.end(), [&](const std::string& input) {
    const std::optional<std::string> file = file_of(input);
    return file && is_same_place(path, *file);
  });
}

/// What lies where the file beside `out` goes is another one of its kind, or empty.
Status check_beside(const std::string& out, const Format& written, std::span<const std::string> inputs) {
  const std::string beside = sibling_path(out, written.beside).string();
  if (Status free = check_destination(beside); !free) {
    return io_error(fmt::format("{}, which belongs to it, {}", beside, free.error().message));
  }
  const auto refuse = [&](std::string_view why) {
    return usage_error(
        fmt::format("{} {}, which what is written along with this file would replace; choose another "
                    "name or remove it first",
                    beside, why));
  };
  if (is_same_place(beside, out)) return refuse("is a link to it");
  if (!exists(beside)) return ok_status();
  if (is_input(beside, inputs)) return refuse("is an input");
  const Result<std::unique_ptr<ByteSource>> file = map_file(beside);
  if (!file) return file.error();
  if ((*file)->size() == 0) return ok_status();
  const Result<std::vector<std::byte>> bytes = read_start(**file, kLongestBeside);
  if (!bytes) return bytes.error();
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const bool replaced = (*file)->size() <= kLongestBeside && written.is_beside(text);
  return replaced ? ok_status() : Status(refuse("is a file of another kind"));
}

}  // namespace

std::filesystem::path whole_path(const std::filesystem::path& path) {
  std::error_code failed;
  std::filesystem::path whole = std::filesystem::absolute(path, failed);
  if (failed) return path;
  std::filesystem::path place = std::filesystem::weakly_canonical(whole, failed);
  return failed ? whole : place;
}

bool is_same_place(const std::string& a, const std::string& b) {
  struct stat status {};
  if (::stat(a.c_str(), &status) == 0) return is_same_file(status, b);
  // Of two that are not there, different names may still be one where they are links.
  std::error_code none;
  const auto is_link = [&](const std::string& path) {
    return std::filesystem::is_symlink(std::filesystem::symlink_status(path, none));
  };
  if (std::filesystem::path(a).filename() != std::filesystem::path(b).filename() && !is_link(a) && !is_link(b)) {
    return false;
  }
  return ::stat(b.c_str(), &status) != 0 && place_of(a) == place_of(b);
}

bool is_among(const std::string& path, const std::vector<std::string>& others) {
  return std::any_of(others.begin(), others.end(),
                     [&](const std::string& other) { return is_same_place(path, other); });
}

std::vector<std::string> paths_written(const std::string& out, const Format& written) {
  std::vector<std::string> paths = {out};
  if (written.beside.empty()) return paths;
  const std::vector<std::string> beside = places_beside(out, written.beside);
  paths.insert(paths.end(), beside.begin(), beside.end());
  return paths;
}

std::vector<std::string> paths_read(std::span<const std::string> inputs) {
  std::vector<std::string> paths;
  for (const std::string& input : inputs) {
    const std::optional<std::string> file = file_of(input);
    if (!file) continue;
    paths.push_back(*file);
    const Format* format = format_of_content(*file);
    if (format == nullptr) continue;
    if (!format->beside.empty()) {
      const std::vector<std::string> beside = places_beside(*file, format->beside);
      paths.insert(paths.end(), beside.begin(), beside.end());
    }
    for (const std::string& name : named_by(*file, *format)) {
      paths.push_back((std::filesystem::path(*file).parent_path() / name).string());
    }
  }
  return paths;
}

Status check_output(const std::string& out, const Format* written, std::span<const std::string> inputs) {
  if (Status free = check_destination(out); !free) return free;
  if (written != nullptr && !written->beside.empty()) {
    if (Status free = check_beside(out, *written, inputs); !free) return free;
  }
  const std::string what = written == nullptr ? "a table of figures" : "a " + std::string(written->description);
  const bool is_read = is_among(out, paths_read(inputs));
  if (is_read && !is_input(out, inputs)) {  // there or not
    return usage_error(fmt::format("belongs to an input; {} would replace it; choose another name", what));
  }
  if (!exists(out)) return ok_status();
  const Format* found = format_of_content(out);
  if (found != nullptr && found == written) return ok_status();
  if (is_read) return usage_error(fmt::format("is an input, which {} would replace; choose another name", what));
  const Format* kept = found == nullptr && written == nullptr ? format_of_name(out) : found;
  if (kept == nullptr) return ok_status();
  return usage_error(
      fmt::format("there is a {} file of that name, which {} would replace; choose another name or "
                  "remove it first",
                  kept->extension, what));
}

}  // namespace sbrdf::internal
