#include "converters/audit/audit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "converters/judge/compare.h"
#include "converters/judge/heap.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kTouched = 4096;  // pairs that are evaluated before memory is measured
constexpr double kGridShare = 0.2;      // of the time of a row

/// What differs from run to run goes.
std::uint64_t two_digits(std::uint64_t value) {
  if (value < 100) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(static_cast<double>(value))) - 1);
  return static_cast<std::uint64_t>(std::llround(std::round(static_cast<double>(value) / unit) * unit));
}

/// The least of three, each by a thread of its own: what a thread keeps ready for its next allocations hides some.
std::uint64_t resident_bytes(const Kept& kept, const AuditSubject& subject) {
  const auto pairs = std::span(subject.judged().pairs).first(std::min(kTouched, subject.judged().pairs.size()));
  std::vector<float> values(pairs.size() * subject.channel_count());
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  const auto measure = [&] {
    const std::uint64_t before = heap_bytes();
    const Result<std::unique_ptr<BrdfSource>> source = kept.open();
    if (source) (*source)->evaluate(pairs, values);
    const std::uint64_t after = heap_bytes();
    least = std::min(least, after > before ? after - before : 0);
  };
  for (int k = 0; k < 3; ++k) std::thread([&] { with_threads(1, measure); }).join();
  return two_digits(least);
}

Status fill_in(AuditRow& row, const Kept& kept, const AuditSubject& subject, const AuditSettings& settings,
               const Progress& progress) {
  const Result<std::unique_ptr<BrdfSource>> source = kept.open();
  if (!source) return source.error();
  std::vector<float> values(subject.judged().values.size());
  evaluate_in_parallel(**source, subject.judged().pairs, values);
  const ErrorFigures off = figures_of(subject.judged(), values);
  CompareOptions grid;
  grid.theta_max_deg = subject.theta_max_deg();
  grid.random_count = settings.directions;
  grid.false_values = FalseValueSearch::kNone;
  const Result<Comparison> on = compare_sources(subject.source(), **source, grid, progress);
  if (!on) return on.error();
  row.setting = kept.setting;
  row.bytes = kept.bytes;
  row.overhead = kept.overhead;
  row.resident_bytes = resident_bytes(kept, subject);
  row.grid_mre_percent = on->mre_percent;
  row.grid_rel_l1_percent = on->rel_l1_percent;
  row.off_grid_mre_percent = off.mre_percent;
  row.off_grid_rel_l1_percent = off.rel_l1_percent;
  row.largest = off.max_abs;
  return ok_status();
}

/// What there is to begin with is made when the first row asks for it.
class MaterialAudit {
 public:
  MaterialAudit(const BrdfSource& source, const AuditSettings& settings) : source_(source), settings_(settings) {}

  Result<AuditRow> row(const AuditMethod& method, double target, const Progress& progress) {
    if (!bench_) {
      Result<AuditSubject> subject = AuditSubject::make(source_, settings_.directions);
      if (!subject) return subject.error();
      subject_ = std::make_unique<const AuditSubject>(*std::move(subject));
      bench_ = std::make_unique<Workbench>(*subject_);
    }
    AuditRow row;
    row.method = method.name;
    row.target_percent = target;
    row.note = method.left_out(*subject_);
    if (!row.note.empty()) return row;
    StepwiseProgress steps(progress);
    const Result<Found> found = method.find(*bench_, target, steps.step(1 - kGridShare));
    if (!found) {
      if (found.error().code == interrupted_error().code) return found.error();
      row.note = found.error().message;
      return row;
    }
    if (!found->reached) row.note = found->why;
    if (found->kept) {
      const Status filled = fill_in(row, *found->kept, *subject_, settings_, steps.step(1));
      if (!filled && filled.error().code == interrupted_error().code) return filled.error();
      if (!filled) row.note = filled.error().message;
      row.reached = filled.ok() && found->reached;
    }
    if (!steps.finish()) return interrupted_error();
    return row;
  }

 private:
  const BrdfSource& source_;
  const AuditSettings& settings_;
  std::unique_ptr<const AuditSubject> subject_;
  std::unique_ptr<Workbench> bench_;
};

void add_ratios(std::vector<AuditRow>& rows) {
  for (AuditRow& row : rows) {
    if (!row.reached) continue;
    std::uint64_t least = row.bytes;
    for (const AuditRow& other : rows) {
      if (other.reached && other.target_percent == row.target_percent) least = std::min(least, other.bytes);
    }
    row.ratio = static_cast<double>(row.bytes) / static_cast<double>(least);
  }
}

bool is_wanted(const AuditMethod& method, const AuditSettings& settings) {
  const auto& names = settings.methods;
  return names.empty() || std::find(names.begin(), names.end(), method.name) != names.end();
}

}  // namespace

Status check_methods(std::span<const std::string> names) {
  std::vector<std::string_view> known;
  for (const AuditMethod& method : audit_methods()) known.push_back(method.name);
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      return usage_error(fmt::format("there is no method \"{}\"; there are: \"{}\"", name, fmt::join(known, "\", \"")));
    }
  }
  return ok_status();
}

Result<std::vector<AuditRow>> audit_material(const BrdfSource& source, const AuditSettings& settings,
                                             AuditMemory* memory, const Progress& progress) {
  MaterialAudit audit(source, settings);
  std::vector<const AuditMethod*> wanted;
  for (const AuditMethod& method : audit_methods()) {
    if (is_wanted(method, settings)) wanted.push_back(&method);
  }
  StepwiseProgress steps(progress);
  std::vector<AuditRow> rows;
  std::size_t left = settings.targets.size() * wanted.size();
  for (const double target : settings.targets) {
    for (const AuditMethod* method : wanted) {
      const Progress step = steps.step(1.0 / static_cast<double>(left--));
      if (memory != nullptr) {
        if (std::optional<AuditRow> known = memory->recall(method->name, target)) {
          rows.push_back(*std::move(known));
          continue;
        }
      }
      Result<AuditRow> row = audit.row(*method, target, step);
      if (!row) return row.error();
      if (memory != nullptr) memory->note(*row);
      rows.push_back(*std::move(row));
    }
  }
  if (!steps.finish()) return interrupted_error();
  add_ratios(rows);
  return rows;
}

std::vector<AuditTotal> total(std::span<const std::vector<AuditRow>> materials) {
  std::vector<AuditTotal> totals;
  for (const std::vector<AuditRow>& rows : materials) {
    for (const AuditRow& row : rows) {
      auto at = std::find_if(totals.begin(), totals.end(), [&](const AuditTotal& one) {
        return one.method == row.method && one.target_percent == row.target_percent;
      });
      if (at == totals.end()) {
        totals.push_back({row.method, row.target_percent});
        at = totals.end() - 1;
      }
      ++at->materials;
      if (!row.reached) continue;
      ++at->reached;
      at->bytes += row.bytes;
      at->mean_bytes += std::log(static_cast<double>(row.bytes));
      at->mean_ratio += std::log(row.ratio);
    }
  }
  for (AuditTotal& one : totals) {
    if (one.reached == 0) continue;
    one.mean_bytes = std::exp(one.mean_bytes / static_cast<double>(one.reached));
    one.mean_ratio = std::exp(one.mean_ratio / static_cast<double>(one.reached));
  }
  return totals;
}

}  // namespace sbrdf::internal
