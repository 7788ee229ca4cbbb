#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "converters/audit/subject.h"
#include "converters/audit/tables/grid_ladder.h"
#include "converters/audit/tables/log_table.h"
#include "converters/files/options.h"
#include "converters/models/analytic_fit.h"
#include "converters/source/progress.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

using FileBytes = std::shared_ptr<const std::vector<std::byte>>;

/// A material kept one way.
struct Kept {
  std::string setting;         ///< for people: "half floats, 1 x 30 x 12 x 18 nodes"
  std::uint64_t bytes = 0;     ///< of all files
  std::uint64_t overhead = 0;  ///< of these, what says nothing of values: heads, metadata, names, checksums
  double percent = 0;          ///< relative L1, off the grid
  /// From the bytes, every time from the start.
  std::function<Result<std::unique_ptr<BrdfSource>>()> open;
};

/// What several ways of keeping one material have in common. The subject must outlive it.
class Workbench {
 public:
  explicit Workbench(const AuditSubject& subject) : subject_(subject), ladder_(subject) {}

  [[nodiscard]] const AuditSubject& subject() const { return subject_; }
  [[nodiscard]] GridLadder& ladder() { return ladder_; }

  /// The table of logarithms on a step of the ladder; the last two stay. The errors of make_log_table.
  [[nodiscard]] Result<std::shared_ptr<const LogTable>> logs(std::size_t step, const Progress& progress);

  /// Opens it and judges it: fills in `percent`.
  [[nodiscard]] Status judge(Kept& kept) const;

  /// What `sbrdf convert` writes of the subject under an extension.
  [[nodiscard]] Result<FileBytes> file(std::string_view extension, const Options& options,
                                       const Progress& progress) const;
  /// A file in memory, read with these options. `overhead` is left at 0.
  [[nodiscard]] Result<Kept> kept(std::string setting, FileBytes bytes, const Options& reading) const;

  /// The fit of a model with so many lobes, made once. The errors of fit_analytic.
  [[nodiscard]] Result<AnalyticModel> fit(LobeKind kind, std::uint64_t lobes, const Progress& progress);

 private:
  const AuditSubject& subject_;
  GridLadder ladder_;
  std::map<std::size_t, std::shared_ptr<const LogTable>> logs_;
  std::map<std::pair<LobeKind, std::uint64_t>, AnalyticModel> fits_;
};

/// What a search for the smallest came to.
struct Found {
  std::optional<Kept> kept;  ///< the smallest that reaches the target; else the nearest that was found
  bool reached = false;
  std::string why;  ///< where nothing was found: for people
};

/// "half floats, 30 x 12 nodes".
[[nodiscard]] std::string on_grid(std::string_view what, const Grid& grid);

/// Keeps the smallest that reaches a target, or the nearest.
class Smallest {
 public:
  explicit Smallest(double percent) : percent_(percent) {}
  /// True where it reaches the target.
  bool take(Kept kept);
  /// Why something was not kept. False where the work was interrupted: the search is to end then.
  [[nodiscard]] bool complain(const Error& error);
  [[nodiscard]] bool reached() const { return found_.reached; }
  [[nodiscard]] Found found() && { return std::move(found_); }

 private:
  double percent_;
  Found found_;
};

}  // namespace sbrdf::internal
