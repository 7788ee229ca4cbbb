#include "tools/io/outputs.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "formats/os/files.h"

namespace sbrdf::internal {
namespace {

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

}  // namespace

Status check_output(const std::string& out, const Format* written, std::span<const std::string> inputs) {
  if (Status free = check_destination(out); !free) return free;
  struct stat status {};
  if (::stat(out.c_str(), &status) != 0) return ok_status();
  const Format* found = format_of_content(out);
  if (found != nullptr && found == written) return ok_status();
  const bool is_input = std::any_of(inputs.begin(), inputs.end(), [&](const std::string& input) {
    const std::optional<std::string> file = file_of(input);
    return file && is_same_file(status, *file);
  });
  const std::string what = written == nullptr ? "a table of figures" : "a " + std::string(written->description);
  if (is_input) return usage_error(fmt::format("is an input, which {} would replace; choose another name", what));
  const Format* kept = found == nullptr && written == nullptr ? format_of_name(out) : found;
  if (kept == nullptr) return ok_status();
  return usage_error(
      fmt::format("there is a {} file of that name, which {} would replace; choose another name or "
                  "remove it first",
                  kept->extension, what));
}

}  // namespace sbrdf::internal
