#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

#include "converters/audit/methods.h"
#include "converters/audit/tables/table_coders.h"
#include "converters/audit/tables/tucker.h"
#include "converters/tables/dense_source.h"

namespace sbrdf::internal {
namespace {

// Compressors of others, on a table of logarithms.

/// The first of so many settings, from the coarsest, that is `good`, as all behind it are; the last where none is.
template <class Good>
std::size_t first_good(std::size_t count, const Good& good) {
  std::size_t low = 0;
  std::size_t high = count;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (good(middle)) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return std::min(low, count - 1);
}

/// The coarsest setting of a coder that is within an error on a table.
std::size_t coarsest_setting(const AuditSubject& subject, const LogTable& table, const TableCoder& coder,
                             double percent) {
  const auto good_enough = [&](std::size_t setting) {
    if (coder.approximate != nullptr) {
      return few_percent_of(subject, dense_table_of(table, coder.approximate(table, setting))) <= percent;
    }
    const Result<Planes> planes = coder.decode(coder.encode(table, setting), table);
    return planes && few_percent_of(subject, dense_table_of(table, *planes)) <= percent;
  };
  return first_good(coder.setting_count, good_enough);
}

Result<Kept> kept_coded(Workbench& bench, std::shared_ptr<const LogTable> table, const TableCoder& coder,
                        double percent) {
  const AuditSubject& subject = bench.subject();
  const std::size_t setting = coarsest_setting(subject, *table, coder, percent);
  const auto bytes = std::make_shared<const std::vector<std::byte>>(coder.encode(*table, setting));
  Kept kept;
  kept.setting = on_grid(coder.setting_text(setting), table->grid);
  kept.bytes = kTableHeadBytes + bytes->size();
  kept.overhead = kTableHeadBytes;
  // What is read takes the numbers from the bytes alone.
  const auto like = std::make_shared<const LogTable>(without_numbers(*table));
  kept.open = [like, bytes, decode = coder.decode,
               channels = subject.original().traits().channels]() -> Result<std::unique_ptr<BrdfSource>> {
    const Result<Planes> planes = decode(*bytes, *like);
    if (!planes) return planes.error();
    DenseDescription description;
    description.format = "table";
    description.channels = channels;
    return DenseSource::make(dense_table_of(*like, *planes), std::move(description));
  };
  if (Status judged = bench.judge(kept); !judged) return judged.error();
  return kept;
}

/// A grid that only just reaches the target leaves nothing for rounding; a finer one takes more nodes, each more
/// coarsely. `kept_on` each of three.
template <class KeptOn>
Result<Found> find_on_logs(Workbench& bench, double percent, const KeptOn& kept_on, const Progress& progress) {
  Smallest smallest(percent);
  StepwiseProgress steps(progress);
  constexpr double kHopeless = 1.2;  // times the target: aiming lower will not help
  std::optional<std::size_t> last;
  for (const double share : {0.9, 0.75, 0.55}) {
    const std::size_t step = std::min(bench.ladder().reach(share * percent), bench.ladder().size() - 1);
    if (last == step) continue;
    last = step;
    const Result<std::shared_ptr<const LogTable>> table = bench.logs(step, steps.step(0.4));
    if (!table) {
      if (!smallest.complain(table.error())) return table.error();
      break;
    }
    // What the few directions say may be a little less than what all say.
    for (const double strictness : {1.0, 0.97, 0.9}) {
      const Progress step_progress = steps.step(0.3);
      Result<Kept> kept = kept_on(*table, strictness * percent);
      if (step_progress.report && !step_progress.report(1)) return interrupted_error();
      if (!kept) {
        std::ignore = smallest.complain(kept.error());
        break;
      }
      const bool hopeless = kept->percent > kHopeless * percent;
      if (smallest.take(*std::move(kept)) || hopeless) break;
    }
  }
  return std::move(smallest).found();
}

Result<Kept> kept_tucker(Workbench& bench, const std::shared_ptr<const LogTable>& table, double percent) {
  const AuditSubject& subject = bench.subject();
  const TuckerFamily family(*table);
  const auto like = std::make_shared<const LogTable>(without_numbers(*table));
  const auto few_percent = [&](const Tucker& tucker) {
    std::vector<float> values(subject.few().values.size());
    evaluate_in_parallel(*make_tucker_source(subject, *like, tucker), subject.few().pairs, values);
    return subject.few_percent(values);
  };
  // Shares of the squares, four to a tenfold: the largest that is good enough, of those that are not too many numbers.
  constexpr std::size_t kShares = 41;
  constexpr std::size_t kMostNumbers = 40'000;  // each is asked for at every evaluation
  const auto keep = [&](std::size_t k) { return family.keep(std::pow(10.0, -2 - 0.25 * static_cast<double>(k))); };
  std::size_t setting = first_good(kShares, [&](std::size_t k) {
    const Tucker tucker = keep(k);
    return tucker.number_count() > kMostNumbers || few_percent(tucker) <= percent;
  });
  while (setting > 0 && keep(setting).number_count() > kMostNumbers) --setting;
  const auto tucker = std::make_shared<const Tucker>(keep(setting));
  Kept kept;
  const auto& r = tucker->ranks;
  kept.setting = on_grid(fmt::format("ranks {}, {}, {}, {}, {}", r[0], r[1], r[2], r[3], r[4]), table->grid);
  kept.bytes = kTableHeadBytes + sizeof(std::uint16_t) * tucker->number_count();
  kept.overhead = kTableHeadBytes;
  kept.open = [&subject, tucker, like]() -> Result<std::unique_ptr<BrdfSource>> {
    return make_tucker_source(subject, *like, *tucker);
  };
  if (Status judged = bench.judge(kept); !judged) return judged.error();
  return kept;
}

}  // namespace

Result<Found> find_coded(Workbench& bench, const TableCoder& coder, double percent, const Progress& progress) {
  return find_on_logs(
      bench, percent,
      [&](const std::shared_ptr<const LogTable>& table, double goal) { return kept_coded(bench, table, coder, goal); },
      progress);
}

Result<Found> find_tucker(Workbench& bench, double percent, const Progress& progress) {
  return find_on_logs(
      bench, percent,
      [&](const std::shared_ptr<const LogTable>& table, double goal) { return kept_tucker(bench, table, goal); },
      progress);
}

}  // namespace sbrdf::internal
