#include "tools/io/report_folder.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <span>
#include <system_error>

#include "formats/os/files.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

Error naming(const std::string& file, const Error& error) {
  Error named = error;
  named.message = file + ": " + error.message;
  return named;
}

/// By its name a JSON file could be parameters of a material: nothing is replaced but what such a run wrote before.
Status check_json(const std::string& path, std::string_view first_member, const std::vector<std::string>& inputs) {
  constexpr std::size_t kBeginning = 64;
  if (Status free = check_destination(path); !free) return free;
  if (is_among(path, paths_read(inputs))) return usage_error("is an input, which this would replace");
  if (!exists(path)) return ok_status();
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  if (!file) return file.error();
  const Result<std::vector<std::byte>> head = read_start(**file, kBeginning);
  if (!head) return head.error();
  const std::string_view text(reinterpret_cast<const char*>(head->data()), head->size());
  const std::string_view first = text.substr(std::min(text.find_first_not_of("{ \n"), text.size()));
  if (text.empty() || first.starts_with("\"" + std::string(first_member) + "\":")) return ok_status();
  return usage_error("there is a file of another kind of that name; choose another folder or remove it first");
}

}  // namespace

std::string ReportFolder::path_of(const std::string& file) const { return (fs::path(path_) / file).string(); }

Status ReportFolder::prepare(const std::vector<std::string>& files, const std::vector<std::string>& inputs) {
  std::error_code failed;
  made_ = fs::create_directory(path_, failed);
  if (failed && !fs::is_directory(path_)) return io_error("the folder cannot be made: " + failed.message());
  for (const std::string& file : files) {
    const bool is_json = file.ends_with(".json");
    const Status free =
        is_json ? check_json(path_of(file), first_member_, inputs) : check_output(path_of(file), nullptr, inputs);
    if (!free) return naming(file, free.error());
  }
  return ok_status();
}

Status ReportFolder::write(const std::vector<std::pair<std::string, std::string>>& files) const {
  for (const auto& [file, text] : files) {
    const Status written = write_file_atomically(path_of(file), std::as_bytes(std::span(text.data(), text.size())));
    if (!written) return naming(file, written.error());
  }
  return ok_status();
}

void ReportFolder::take_back() const {
  std::error_code none;
  if (made_) fs::remove(path_, none);  // an empty folder, or nothing
}

}  // namespace sbrdf::internal
