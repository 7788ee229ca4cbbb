#include "tools/conversion/folder_conversion.h"

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <system_error>
#include <utility>

#include "converters/files/format_table.h"
#include "formats/os/files.h"
#include "formats/os/interrupt.h"
#include "tools/console/terminal.h"
#include "tools/conversion/conversion_report.h"
#include "tools/conversion/journal.h"
#include "tools/conversion/report_file.h"
#include "tools/io/outputs.h"
#include "tools/io/sha256.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kBetweenReports = 2;  // seconds: what a run that is killed has told may be so old

bool is_same(const fs::path& a, const fs::path& b) {
  std::error_code failed;
  return fs::equivalent(a, b, failed) && !failed;
}

bool lies_in(const fs::path& inner, const fs::path& outer) {
  const fs::path whole = whole_path(inner);
  const fs::path wanted = whole_path(outer);  // it need not be there
  for (fs::path at = whole; at != at.parent_path(); at = at.parent_path()) {
    if (at == wanted || is_same(at, outer)) return true;
  }
  return false;
}

Status check_folders(const FolderOrder& order) {
  if (is_same(order.folder, order.out_folder)) {
    return usage_error("is the folder that is read: outputs would be inputs of the next run; choose another one");
  }
  if (order.recursive && lies_in(order.folder, order.out_folder)) {
    return usage_error("holds the folder that is read, where outputs would be inputs; choose another one");
  }
  return ok_status();
}

class FolderRun {
 public:
  FolderRun(const FolderOrder& order, const FolderWatcher& watcher, std::vector<FileOutcome>& outcomes)
      : order_(order), watcher_(watcher), outcomes_(outcomes), journal_(order.out_folder) {}

  std::optional<Failure> run() {
    if (auto failure = prepare()) return failure;
    for (const FolderFile& file : files_) {
      if (interrupted()) break;
      if (auto report = finished(file)) kept_.emplace(file.name, *std::move(report));
    }
    bool stopped = false;
    for (const FolderFile& file : files_) {
      const auto kept = kept_.find(file.name);
      stopped = stopped || interrupted();
      if (kept != kept_.end()) {
        add(kept_outcome(file, kept->second), !stopped);
      } else if (!stopped) {
        FileOutcome outcome = convert(file);
        stopped = outcome.failure && interrupted();
        if (!stopped) add(std::move(outcome), true);
        done_ += 1;
      }
    }
    if (auto failure = write_report()) return failure;
    return interrupted() ? std::optional(Failure{"", interrupted_error()}) : std::nullopt;
  }

 private:
  [[nodiscard]] std::string in_path(const std::string& name) const { return (fs::path(order_.folder) / name).string(); }
  [[nodiscard]] std::string out_path(const std::string& name) const {
    return (fs::path(order_.out_folder) / name).string();
  }

  std::optional<Failure> prepare() {
    if (Status used = check_effects(order_.given, *order_.format, std::nullopt); !used) {
      return Failure{order_.out_folder, used.error()};
    }
    if (Status apart = check_folders(order_); !apart) return Failure{order_.out_folder, apart.error()};
    const bool reports = !order_.report.empty();
    // The list leaves it out: it is none of the files that are converted.
    if (Status named = reports ? check_report_name(order_.report) : ok_status(); !named) {
      return Failure{order_.report, named.error()};
    }
    const FolderRules rules = {std::string(order_.format->extension),
                               order_.recursive,
                               {order_.out_folder, reports ? order_.report : order_.out_folder}};
    Result<FolderContent> content = list_folder(order_.folder, rules);
    if (!content) return Failure{order_.folder, content.error()};
    if (Status free = reports ? check_report_of(content->files) : ok_status(); !free) {
      return Failure{order_.report, free.error()};
    }
    if (Status ready = journal_.start(); !ready) return Failure{order_.out_folder, ready.error()};
    // Only now: it may lie in the folder of the outputs.
    if (Status free = reports ? check_destination(order_.report) : ok_status(); !free) {
      return Failure{order_.report, free.error()};
    }
    for (std::size_t k = order_.shard.number - 1; k < content->files.size(); k += order_.shard.count) {
      files_.push_back(content->files[k]);
    }
    for (const SkippedFile& file : content->skipped) {
      const std::string in = in_path(file.name);
      add({Fate::kSkipped, in, {}, report_of_skipped(in, file.reason), {}, {}}, true);
    }
    return std::nullopt;
  }

  /// Also against what belongs to the files, and what will be written.
  [[nodiscard]] Status check_report_of(const std::vector<FolderFile>& files) const {
    std::vector<std::string> read;
    std::vector<std::string> written;
    for (const FolderFile& file : files) {
      const std::string in = in_path(file.name);
      for (const std::string& path : paths_read(std::span(&in, 1))) read.push_back(path);
      for (const std::string& path : paths_written(out_path(file.out), *order_.format)) written.push_back(path);
    }
    if (lies_in(order_.report, journal_.folder())) {
      return usage_error("lies in the folder that tells what is done; choose another one");
    }
    return check_report(order_.report, read, written);
  }

  /// Without the hash of the content.
  [[nodiscard]] Work work_on(const FolderFile& file, const Options& effective) const {
    return {fs::path(file.name).filename().string(), "", sidecar_sha256(file), options_text(effective),
            std::string(order_.format->name)};
  }

  /// Of a link it may lie in another folder, beside the file that it leads to.
  [[nodiscard]] std::string sidecar_sha256(const FolderFile& file) const {
    if (!file.sidecar.empty()) return sha256_of(in_path(file.sidecar));
    const fs::path in = in_path(file.name);
    std::error_code none;
    if (!fs::is_symlink(fs::symlink_status(in, none))) return "";
    const fs::path beside = sibling_path(in, kSidecarSuffix);
    return is_ordinary_file(beside) ? sha256_of(beside.string()) : std::string();
  }

  [[nodiscard]] std::optional<Json> finished(const FolderFile& file) const {
    if (!journal_.has_entry(file.out)) return std::nullopt;
    const Result<std::unique_ptr<ByteSource>> bytes = map_file(in_path(file.name));
    if (!bytes) return std::nullopt;
    const Result<const Format*> read = recognise(**bytes);
    if (!read) return std::nullopt;
    Work work = work_on(file, effective_options(order_.given, *order_.format, **read));
    work.sha256 = sha256_of(**bytes);
    return journal_.finished_report(file.out, work);
  }

  [[nodiscard]] FileOutcome kept_outcome(const FolderFile& file, Json report) const {
    const std::string in = in_path(file.name);
    const std::string out = out_path(file.out);
    report["result"] = "kept";
    report["in"]["path"] = in;
    report["out"]["path"] = out;
    if (report["out"].contains("with")) {
      for (Json& with : report["out"]["with"]) {
        with["path"] = (fs::path(out).parent_path() / with.value("path", "")).string();
      }
    }
    report["seconds"] = nullptr;
    return {Fate::kKept, in, out, std::move(report), {}, {}};
  }

  [[nodiscard]] FileOutcome convert(const FolderFile& file) {
    FileOutcome outcome = {Fate::kFailed, in_path(file.name), out_path(file.out), {}, {}, {}};
    outcome.failure = convert(file, outcome);
    if (outcome.failure) outcome.report = report_of(outcome.in, *outcome.failure);
    return outcome;
  }

  std::optional<Failure> convert(const FolderFile& file, FileOutcome& outcome) {
    if (is_same(outcome.in, outcome.out)) {
      return Failure{outcome.out, usage_error("is a link to the file that is read, which it would replace")};
    }
    const Result<std::shared_ptr<const ByteSource>> bytes = open_file(outcome.in);
    if (!bytes) return Failure{outcome.in, bytes.error()};
    const Result<const Format*> read = recognise(**bytes);
    if (!read) return Failure{outcome.in, read.error()};
    if (Status made = journal_.make_room(file.out); !made) return Failure{outcome.out, made.error()};
    const Options effective = effective_options(order_.given, *order_.format, **read);
    const ConversionOrder order = {outcome.in, outcome.out, order_.format, effective, *bytes, true};
    Work work = work_on(file, effective);
    Conversion done;
    if (auto failure = convert_file(order, done, progress_of_one())) return failure;
    work.sha256 = done.sha256;
    outcome.fate = Fate::kConverted;
    outcome.report = report_of(order, done);
    if (Status kept = journal_.finish(file.out, work, done.written, outcome.report); !kept) {
      outcome.note = kept.error();
    }
    return std::nullopt;
  }

  [[nodiscard]] Progress progress_of_one() const {
    if (!watcher_.progress.report) return {};
    const auto total = static_cast<double>(files_.size() - kept_.size());
    return {[this, total](double fraction) { return watcher_.progress.report((done_ + fraction) / total); }};
  }

  void add(FileOutcome outcome, bool tell) {
    if (tell && watcher_.tell) watcher_.tell(outcome);
    outcomes_.push_back(std::move(outcome));
    if (since_report_.seconds() < kBetweenReports) return;
    static_cast<void>(write_report());  // the last one tells what is wrong
    since_report_ = {};
  }

  [[nodiscard]] std::optional<Failure> write_report() const {
    if (order_.report.empty()) return std::nullopt;
    Json all = Json::array();
    for (const FileOutcome& outcome : outcomes_) all.push_back(outcome.report);
    if (Status written = write_report_file(order_.report, all); !written) {
      return Failure{order_.report, written.error()};
    }
    return std::nullopt;
  }

  const FolderOrder& order_;
  const FolderWatcher& watcher_;
  std::vector<FileOutcome>& outcomes_;
  Journal journal_;
  std::vector<FolderFile> files_;     ///< of the shard
  std::map<std::string, Json> kept_;  ///< reports, by name
  double done_ = 0;                   ///< files that were not kept
  Stopwatch since_report_;
};

}  // namespace

std::optional<Failure> convert_folder(const FolderOrder& order, const FolderWatcher& watcher,
                                      std::vector<FileOutcome>& outcomes) {
  return FolderRun(order, watcher, outcomes).run();
}

}  // namespace sbrdf::internal
