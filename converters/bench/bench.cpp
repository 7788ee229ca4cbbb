#include "converters/bench/bench.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "converters/judge/heap.h"

namespace sbrdf::internal {
namespace {

constexpr double kPrepareShare = 0.9;  // of a row: making the file takes longest
constexpr double kJudgeShare = 0.5;    // of what is left then
constexpr double kGrowthShare = 0.3;   // of a material that has growth tables

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Opening and one evaluation. The contender's end does not count.
TimedWork first_value_work(const Prepared& prepared, const VectorPairs& pairs, std::vector<float>& values) {
  return {[&]() -> std::optional<double> {
            const auto start = std::chrono::steady_clock::now();
            const Result<std::unique_ptr<Contender>> opened = prepared.open();
            if (!opened) return std::nullopt;  // it was opened before: shows as 0
            (*opened)->evaluate(std::span(pairs.i).first(1), std::span(pairs.v).first(1),
                                std::span(values).first((*opened)->channel_count()));
            return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
          },
          Clock::kTold};
}

/// One material.
class Bench {
 public:
  Bench(Workshop& workshop, const BenchSettings& settings, double theta_max_deg)
      : workshop_(workshop),
        settings_(settings),
        quality_{settings.judged_pairs, theta_max_deg},
        pairs_(draw_vector_pairs(settings.timed_pairs, theta_max_deg)),
        values_(pairs_.size() * std::max<std::size_t>(workshop.source().channel_count(), 3)) {}

  [[nodiscard]] const VectorPairs& pairs() const { return pairs_; }

  /// Everything but growth.
  Status run(BenchReport& report, const Progress& progress) {
    std::vector<std::pair<const Method*, Variant>> wanted;
    for (const Method& method : bench_methods()) {
      const std::string_view why = method.left_out(workshop_.source());
      if (!why.empty()) {
        report.left_out.push_back(workshop_.material().name + ": " + std::string(method.name) + ": " +
                                  std::string(why));
        continue;
      }
      for (const Variant& variant : method.variants(settings_.variants)) wanted.emplace_back(&method, variant);
    }
    StepwiseProgress steps(progress);
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      const auto& [method, variant] = wanted[k];
      const Result<BenchRow> row = measure(*method, variant, steps.step(1.0 / static_cast<double>(wanted.size() - k)));
      if (!row) return in_context(row.error(), workshop_.material().name, method->name, variant.name);
      report.rows.push_back(*row);
    }
    return ok_status();
  }

 private:
  Result<BenchRow> measure(const Method& method, const Variant& variant, const Progress& progress) {
    StepwiseProgress steps(progress);
    const Result<Prepared> prepared = method.prepare(workshop_, variant, steps.step(kPrepareShare));
    if (!prepared) return prepared.error();
    const std::uint64_t heap = heap_bytes();
    const Result<std::unique_ptr<Contender>> contender = prepared->open();
    if (!contender) return contender.error();
    if (Status right = verify(**contender, workshop_.source(), pairs_, method.wild_percent); !right) {
      return right.error();
    }
    // What is made when it is first asked for belongs to it.
    (*contender)->evaluate(pairs_.i, pairs_.v, std::span(values_).first(pairs_.size() * (*contender)->channel_count()));
    const std::uint64_t grown = heap_bytes();
    BenchRow row{workshop_.material().name, std::string(method.name), variant.name, variant.samples};
    row.resident_bytes = grown > heap ? grown - heap : 0;
    row.file_bytes = prepared->file_bytes;
    const Result<Quality> quality = measure_quality(**contender, workshop_.source(), quality_, steps.step(kJudgeShare));
    if (!quality) return quality.error();
    row.quality = *quality;
    time(**contender, *prepared, row);
    if (!steps.finish()) return interrupted_error();
    return row;
  }

  void time(const Contender& contender, const Prepared& prepared, BenchRow& row) {
    const std::array works = {evaluation_work(contender, pairs_, 1, values_),
                              evaluation_work(contender, pairs_, pairs_.size(), values_),
                              yardstick_work(pairs_, values_), first_value_work(prepared, pairs_, values_)};
    const std::vector<double> seconds = median_seconds(works, settings_.timing);
    const double each = 1e9 / static_cast<double>(pairs_.size());
    row.single_ns = seconds[0] * each;
    row.batch_ns = seconds[1] * each;
    row.yardstick_ns = seconds[2] * each;
    row.first_value_ms = 1e3 * seconds[3];
  }

  Workshop& workshop_;
  const BenchSettings& settings_;
  QualityOptions quality_;
  VectorPairs pairs_;
  std::vector<float> values_;
};

/// As far as the source is good for anything, but no farther than the paper looks.
double theta_max_of(const BrdfSource& source) { return std::min(80.0, source.traits().slice_theta_max_deg); }

/// Of each kind the first has growth tables.
std::vector<bool> growing(std::span<const OpenedSource> opened) {
  std::vector<bool> grows(opened.size(), false);
  for (const bool isotropic : {true, false}) {
    const auto first = std::find_if(opened.begin(), opened.end(), [&](const OpenedSource& one) {
      return one.source->traits().isotropic == isotropic;
    });
    if (first != opened.end()) grows[static_cast<std::size_t>(first - opened.begin())] = true;
  }
  return grows;
}

}  // namespace

Error in_context(const Error& error, const std::string& material, std::string_view method, std::string_view variant) {
  Error placed = error;
  std::string where = material + ": " + std::string(method);
  if (!variant.empty()) where += ", " + std::string(variant);
  placed.message = where + ": " + error.message;
  return placed;
}

TimedWork evaluation_work(const Contender& contender, const VectorPairs& pairs, std::size_t batch,
                          std::vector<float>& values) {
  return {[&contender, &pairs, batch, &values]() -> std::optional<double> {
            const std::size_t channels = contender.channel_count();
            for (std::size_t first = 0; first < pairs.size(); first += batch) {
              const std::size_t count = std::min(batch, pairs.size() - first);
              contender.evaluate(std::span(pairs.i).subspan(first, count), std::span(pairs.v).subspan(first, count),
                                 std::span(values).subspan(first * channels, count * channels));
            }
            return std::nullopt;
          },
          Clock::kProcessor};
}

TimedWork yardstick_work(const VectorPairs& pairs, std::vector<float>& values) {
  static const TrilinearTable<double> kTable = make_yardstick();
  return {[&pairs, &values]() -> std::optional<double> {
            for (std::size_t k = 0; k < pairs.size(); ++k) {
              const glm::vec3 value = kTable.look_up(pairs.i[k], pairs.v[k]);
              for (int c = 0; c < 3; ++c) values[3 * k + static_cast<std::size_t>(c)] = value[c];
            }
            return std::nullopt;
          },
          Clock::kProcessor};
}

BenchSettings full_settings() { return {}; }

BenchSettings quick_settings() {
  BenchSettings settings;
  settings.timing = {3, 0.002};
  settings.timed_pairs = 4096;
  settings.judged_pairs = 10'000;
  settings.variants = {
      {500, 1500},
      {"utia", "half-difference/30:3:5:10"},
      Options().set("rgl-size", "16").set("rgl-warp-size", "32").set("rgl-theta", "8").set("rgl-phi", "9")};
  settings.growth_samples = {1000, 3000, 8911};
  settings.batches = {1, 16, 4096};
  settings.growth_batch_samples = 1000;
  settings.search_evaluations = 1;
  settings.least_array_bytes = std::uint64_t{1} << 26U;
  return settings;
}

Result<BenchReport> run_bench(std::span<const BenchMaterial> materials, const BenchSettings& settings,
                              const Progress& progress) {
  std::vector<OpenedSource> opened;
  for (const BenchMaterial& material : materials) {
    Result<OpenedSource> source = material.open();
    if (!source) {
      Error error = source.error();
      error.message = material.name + ": " + error.message;
      return error;
    }
    opened.push_back(*std::move(source));
  }
  const std::vector<bool> grows = growing(opened);
  BenchReport report;
  report.memory = measure_memory_speed(settings.least_array_bytes, settings.timing);
  StepwiseProgress steps(progress);
  for (std::size_t k = 0; k < materials.size(); ++k) {
    Workshop workshop(materials[k], *opened[k].source, settings.search_evaluations);
    Bench bench(workshop, settings, theta_max_of(*opened[k].source));
    StepwiseProgress own(steps.step(1.0 / static_cast<double>(materials.size() - k)));
    if (Status done = bench.run(report, own.step(grows[k] ? 1 - kGrowthShare : 1)); !done) return done.error();
    if (!grows[k]) continue;
    Result<std::vector<GrowthRow>> growth = measure_growth(workshop, settings, bench.pairs(), own.step(1));
    if (!growth) return growth.error();
    report.growth.insert(report.growth.end(), growth->begin(), growth->end());
  }
  std::vector<double> yardsticks;
  for (const BenchRow& row : report.rows) yardsticks.push_back(row.yardstick_ns);
  report.yardstick_ns = median(yardsticks);
  if (!steps.finish()) return interrupted_error();
  return report;
}

}  // namespace sbrdf::internal
