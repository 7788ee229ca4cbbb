#include "converters/audit/workbench.h"

#include <fmt/format.h>

#include <utility>

#include "converters/files/format_table.h"
#include "formats/core/byte_sink.h"
#include "formats/core/byte_source.h"

namespace sbrdf::internal {

Result<std::shared_ptr<const LogTable>> Workbench::logs(std::size_t step, const Progress& progress) {
  const auto known = logs_.find(step);
  if (known != logs_.end()) return known->second;
  Result<LogTable> made = make_log_table(subject_, ladder_.step(step).grid, progress);
  if (!made) return made.error();
  while (logs_.size() > 1) logs_.erase(logs_.begin());
  auto table = std::make_shared<const LogTable>(*std::move(made));
  logs_.emplace(step, table);
  return std::shared_ptr<const LogTable>(std::move(table));
}

Status Workbench::judge(Kept& kept) const {
  const Result<std::unique_ptr<BrdfSource>> source = kept.open();
  if (!source) return source.error();
  kept.percent = subject_.error_percent(**source);
  return ok_status();
}

Result<FileBytes> Workbench::file(std::string_view extension, const Options& options, const Progress& progress) const {
  const Result<const Format*> format = find_writer(extension);
  if (!format) return format.error();
  MemorySink sink;
  Report report;
  if (Status done = save_source(**format, subject_.source(), sink, options, report, progress); !done) {
    return done.error();
  }
  return FileBytes(std::make_shared<const std::vector<std::byte>>(std::move(sink).take()));
}

Result<Kept> Workbench::kept(std::string setting, FileBytes bytes, const Options& reading) const {
  Kept kept;
  kept.setting = std::move(setting);
  kept.bytes = bytes->size();
  kept.open = [bytes = std::move(bytes), reading] {
    return open_source(std::make_shared<OwnedMemorySource>(*bytes), reading);
  };
  if (Status judged = judge(kept); !judged) return judged.error();
  return kept;
}

Result<AnalyticModel> Workbench::fit(LobeKind kind, std::uint64_t lobes, const Progress& progress) {
  const auto known = fits_.find({kind, lobes});
  if (known != fits_.end()) return known->second;
  AnalyticFitOptions options;
  options.kind = kind;
  options.lobes = lobes;
  const Result<AnalyticFit> fit = fit_analytic(subject_.source(), options, progress);
  if (!fit) return fit.error();
  fits_.emplace(std::pair(kind, lobes), fit->model);
  return fit->model;
}

std::string on_grid(std::string_view what, const Grid& grid) { return fmt::format("{}, {}", what, grid.size_text()); }

bool Smallest::complain(const Error& error) {
  found_.why = error.message;
  return error.code != interrupted_error().code;
}

bool Smallest::take(Kept kept) {
  const bool reaches = kept.percent <= percent_;
  const auto& best = found_.kept;
  const bool better = !best || (reaches && (!found_.reached || kept.bytes < best->bytes)) ||
                      (!reaches && !found_.reached && kept.percent < best->percent);
  if (better) {
    found_.kept = std::move(kept);
    found_.reached = reaches;
  }
  return reaches;
}

}  // namespace sbrdf::internal
