#include "tools/conversion/journal.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <span>
#include <system_error>

#include "formats/os/files.h"
#include "tools/io/notes.h"
#include "tools/io/sha256.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kFolder = ".sbrdf-convert";

Json json_of(const Work& work) {
  Json source = {{"name", work.source}, {"sha256", work.sha256}};
  if (!work.sidecar_sha256.empty()) source["sidecar_sha256"] = work.sidecar_sha256;
  return {{"version", SBRDF_VERSION}, {"source", source}, {"options", work.options}, {"to", work.target}};
}

bool is_as_written(const std::string& path_without_suffix, const Json& output) {
  const auto has = [&](const char* key, auto type_fits) { return output.contains(key) && type_fits(output[key]); };
  const auto is_text = [](const Json& json) { return json.is_string() && !json.get_ref<const std::string&>().empty(); };
  if (!output.is_object() || !has("sha256", is_text)) return false;
  if (!has("suffix", [](const Json& json) { return json.is_string(); })) return false;
  if (!has("bytes", [](const Json& json) { return json.is_number_unsigned(); })) return false;
  const std::string path = path_without_suffix + output["suffix"].get<std::string>();
  std::error_code failed;
  const auto size = fs::file_size(path, failed);
  return !failed && size == output["bytes"].get<std::uint64_t>() &&
         sha256_of(path) == output["sha256"].get_ref<const std::string&>();
}

/// A report without what differs between runs that do the same.
Json without_place_and_time(Json report) {
  const auto name_only = [](Json& path) { path = fs::path(path.get<std::string>()).filename().string(); };
  name_only(report["in"]["path"]);
  name_only(report["out"]["path"]);
  if (report["out"].contains("with")) {
    for (Json& file : report["out"]["with"]) name_only(file["path"]);
  }
  report.erase("seconds");
  return report;
}

Status make_folders(const fs::path& path) {
  std::error_code failed;
  fs::create_directories(path, failed);
  // Another run may have been faster.
  if (!failed || fs::is_directory(path)) return ok_status();
  return io_error("the folder cannot be made: " + failed.message());
}

}  // namespace

std::string Journal::folder() const { return (fs::path(folder_) / kFolder).string(); }

std::string Journal::entry_of(const std::string& out) const { return (fs::path(folder()) / (out + ".json")).string(); }

Status Journal::start() const {
  if (Status made = make_folders(fs::path(folder_)); !made) return made;
  if (Status free = check_destination(fs::path(folder_) / "sbrdf-probe"); !free) return free;
  if (Status made = make_folders(fs::path(folder_) / kFolder); !made) return made;
  return check_destination(fs::path(folder_) / kFolder / "sbrdf-probe");
}

Status Journal::make_room(const std::string& out) const {
  if (Status made = make_folders((fs::path(folder_) / out).parent_path()); !made) return made;
  return make_folders(fs::path(entry_of(out)).parent_path());
}

bool Journal::has_entry(const std::string& out) const { return is_ordinary_file(entry_of(out)); }

std::optional<Json> Journal::finished_report(const std::string& out, const Work& work) const {
  Json entry = read_note(entry_of(out));
  if (entry.is_null() || !entry.contains("work") || entry["work"] != as_noted(json_of(work))) return std::nullopt;
  if (!entry.contains("outputs") || !entry["outputs"].is_array() || entry["outputs"].empty()) return std::nullopt;
  const auto& outputs = entry["outputs"];
  const std::string path = (fs::path(folder_) / out).string();
  const bool whole =
      std::all_of(outputs.begin(), outputs.end(), [&](const Json& output) { return is_as_written(path, output); });
  if (!whole || !entry.contains("report") || !entry["report"].is_object()) return std::nullopt;
  return std::move(entry["report"]);
}

Status Journal::finish(const std::string& out, const Work& work, const std::vector<WrittenFile>& written,
                       const Json& report) const {
  Json entry = {{"work", json_of(work)}};
  for (const WrittenFile& file : written) {
    const std::string suffix = file.path.substr(written.front().path.size());
    entry["outputs"].push_back({{"suffix", suffix}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  }
  entry["report"] = without_place_and_time(report);
  const std::string text = note_text(entry);
  return write_file_atomically(entry_of(out), std::as_bytes(std::span(text.data(), text.size())),
                               AfterSignal::kComplete);
}

}  // namespace sbrdf::internal
