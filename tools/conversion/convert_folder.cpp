#include "tools/conversion/convert_folder.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <tuple>

#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"
#include "tools/conversion/conversion_report.h"

namespace sbrdf::internal {
namespace {

/// Prints what becomes of each file, and keeps count.
class Teller {
 public:
  Teller(bool json, ProgressBar& bar) : json_(json), bar_(bar) {}

  void tell(const FileOutcome& outcome) {
    ++counts_.at(static_cast<std::size_t>(outcome.fate));
    bar_.wipe();
    if (outcome.failure) {
      const int failed = report_error(outcome.failure->subject, outcome.failure->error);
      if (exit_code_ == 0) exit_code_ = failed;
    } else if (!json_) {
      print(line_of(outcome) + "\n");
      std::ignore = flush_output();
    }
    if (outcome.note) print_note(outcome.out, "a later run will convert it again: " + outcome.note->message);
  }

  void sum_up(double seconds) const {
    const auto count = [&](Fate fate) { return format_count(counts_.at(static_cast<std::size_t>(fate))); };
    print(fmt::format("{} converted, {} kept, {} failed, {} skipped; took {} s\n", count(Fate::kConverted),
                      count(Fate::kKept), count(Fate::kFailed), count(Fate::kSkipped), format_number(seconds)));
  }
  [[nodiscard]] int exit_code() const { return exit_code_; }

 private:
  static std::string line_of(const FileOutcome& outcome) {
    if (outcome.fate == Fate::kSkipped) {
      return fmt::format("skipped {}: {}", one_line(outcome.in), one_line(outcome.report.value("reason", "")));
    }
    const std::string figure = main_figure(outcome.report);
    return fmt::format("{} {} -> {}, {} bytes{}{}", outcome.report.value("result", ""), one_line(outcome.in),
                       one_line(outcome.out), format_count(outcome.report["out"].value("bytes", std::uint64_t{0})),
                       figure.empty() ? "" : ", ", figure);
  }

  bool json_;
  ProgressBar& bar_;
  std::array<std::uint64_t, 4> counts_ = {};  ///< by Fate
  int exit_code_ = 0;
};

}  // namespace

int run_convert_folder(const FolderOrder& order, bool json) {
  const Stopwatch watch;
  std::vector<FileOutcome> outcomes;
  ProgressBar bar("converting");
  Teller teller(json, bar);
  const FolderWatcher watcher = {[&](const FileOutcome& outcome) { teller.tell(outcome); }, bar.progress()};
  const auto failure = convert_folder(order, watcher, outcomes);
  bar.wipe();
  if (json && !outcomes.empty()) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const FileOutcome& outcome : outcomes) all.push_back(outcome.report);
    print_json(all);
  }
  if (!json && !outcomes.empty()) teller.sum_up(watch.seconds());
  if (failure) return report_error(failure->subject, failure->error);
  return teller.exit_code();
}

}  // namespace sbrdf::internal
