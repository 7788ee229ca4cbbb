#include "tools/audit/audit_journal.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/os/files.h"
#include "formats/sbrdf/container.h"
#include "tools/audit/audit_report.h"
#include "tools/io/notes.h"
#include "tools/io/outputs.h"
#include "tools/io/sha256.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

class MaterialMemory final : public AuditMemory {
 public:
  MaterialMemory(std::string path, std::string work, std::function<void(const Error&)> complain)
      : path_(std::move(path)), work_(std::move(work)), complain_(std::move(complain)) {
    const Json entry = read_note(path_);
    const auto work_then = entry.find("work");
    if (work_then == entry.end() || !work_then->is_string() || !entry.contains("rows")) return;
    if (as_noted(work_) == *work_then) rows_ = audit_rows_of(entry["rows"]).value_or(rows_);
  }

  [[nodiscard]] std::optional<AuditRow> recall(std::string_view method, double target_percent) const override {
    const auto found = std::find_if(rows_.begin(), rows_.end(), [&](const AuditRow& row) {
      return row.method == method && row.target_percent == target_percent;
    });
    return found == rows_.end() ? std::nullopt : std::optional(*found);
  }
  void note(const AuditRow& row) override {
    rows_.push_back(row);
    const std::string text = note_text({{"work", work_}, {"rows", audit_rows_json(rows_)}});
    const Status written =
        write_file_atomically(path_, std::as_bytes(std::span(text.data(), text.size())), AfterSignal::kComplete);
    if (written) return;
    Error error = written.error();
    error.message = path_ + ": " + error.message + "; a later run will do this again";
    complain_(error);
  }

 private:
  std::string path_;
  std::string work_;
  std::function<void(const Error&)> complain_;
  std::vector<AuditRow> rows_;
};

}  // namespace

AuditJournal::AuditJournal(const std::string& folder, const AuditSettings& settings, const Options& given)
    : folder_((fs::path(folder) / kFolder).string()), settings_(fmt::format("{} directions", settings.directions)) {
  for (const auto& [name, text] : given.all()) settings_ += fmt::format("; --{} {}", name, text);
}

Status AuditJournal::start() const {
  std::error_code failed;
  fs::create_directories(folder_, failed);
  if (failed && !fs::is_directory(folder_)) return io_error("the folder cannot be made: " + failed.message());
  return check_destination(fs::path(folder_) / "sbrdf-probe");
}

std::string AuditJournal::work_on(const std::string& material) const {
  std::string work = fmt::format("sbrdf {}; {}; {}", SBRDF_VERSION, material, settings_);
  for (const std::string& path : paths_read(std::span(&material, 1))) work += "; " + sha256_of(path);
  return work;
}

std::string AuditJournal::entry_of(const std::string& material) const {
  std::string name = material.size() > 100 ? material.substr(material.size() - 100) : material;
  for (char& c : name) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-';
    if (!plain) c = '_';
  }
  const std::uint32_t sum = checksum(std::as_bytes(std::span(material.data(), material.size())));
  return (fs::path(folder_) / fmt::format("{}-{:08x}.json", name, sum)).string();
}

std::unique_ptr<AuditMemory> AuditJournal::memory_of(const std::string& material,
                                                     std::function<void(const Error&)> complain) const {
  return std::make_unique<MaterialMemory>(entry_of(material), work_on(material), std::move(complain));
}

}  // namespace sbrdf::internal
