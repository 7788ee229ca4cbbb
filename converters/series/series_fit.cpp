#include "converters/series/series_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "codec/frame/frame.h"
#include "codec/series/series_file.h"
#include "codec/series/series_table.h"
#include "converters/difference/error_sums.h"
#include "converters/drawing/sampled_source.h"
#include "converters/series/series_problem.h"
#include "converters/slicing/metadata.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kFittedCount = 40'000;
constexpr double kUsualTarget = 2;  // [%]
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Steps of coefficients: 2^(-step / 8).
constexpr int kCoarsestStep = 4;
constexpr int kFinestStep = 76;
constexpr int kFirstStep = 30;
constexpr int kStride = 4;

constexpr std::array<std::uint8_t, 3> kPowers = {3, 5, 7};                    // 1/2, 3/4, 1
constexpr std::array<int, 9> kWidths = {32, 40, 48, 56, 64, 72, 80, 88, 96};  // 1/4 to 64 degrees
constexpr std::array<std::uint8_t, 6> kFineness = {2, 3, 4, 6, 8, 12};
constexpr std::size_t kTermsOfByte = 2;  // more are no use: a coefficient takes a byte, and half of them are 0
constexpr std::size_t kFewTerms = 40;
constexpr double kTableShare = 1.01;  // how much a table may add to the error

/// Shapes that are tried, from the coarsest on. Anisotropic materials need more of them along both azimuths.
std::vector<SeriesShape> ladder(const Symmetries& symmetries) {
  if (symmetries.isotropic) {
    return {{6, 3, 1, 2},   {8, 4, 1, 2},   {10, 5, 1, 3},  {12, 6, 1, 3},  {14, 7, 1, 4},  {16, 8, 1, 4},
            {20, 10, 1, 4}, {24, 12, 1, 4}, {28, 14, 1, 4}, {32, 16, 1, 5}, {36, 20, 1, 5}, {40, 24, 1, 5}};
  }
  const std::uint32_t turn = symmetries.mirror_x && symmetries.mirror_y ? 2 : 1;  // odd orders are left out anyway
  return {{6, 3, 2 * turn, 2},  {8, 4, 3 * turn, 3},  {10, 5, 4 * turn, 4}, {12, 6, 5 * turn, 4},
          {14, 7, 6 * turn, 4}, {16, 8, 7 * turn, 5}, {18, 9, 8 * turn, 5}, {20, 10, 10 * turn, 6}};
}

struct Candidate {
  SeriesBrdf brdf;
  double error = kInfinite;  ///< [%], on the directions that choices are made by
  std::size_t bytes = 0;     ///< without metadata
};

class SeriesSearch {
 public:
  SeriesSearch(const SeriesProblem& problem, const SliceOptions& options, std::size_t metadata_bytes,
               const Progress& progress)
      : problem_(problem), objective_(objective_of(options.stop)), progress_(progress) {
    target_ = target_percent(options.stop);
    if (const auto* most = std::get_if<MaxBytes>(&options.stop)) {
      most_bytes_ = most->count > metadata_bytes ? static_cast<std::size_t>(most->count) - metadata_bytes : 0;
    } else if (!target_) {
      target_ = kUsualTarget;
      objective_ = Objective::kRelL1;
    }
  }

  Result<Candidate> run(const std::vector<SeriesShape>& shapes) {
    const Result<Warp> warp = choose_warp(shapes[std::min<std::size_t>(2, shapes.size() - 1)]);
    if (!warp) return warp.error();
    std::optional<Candidate> best;
    std::size_t at = 0;
    int in_vain = 0;
    for (std::size_t k = 0; k < shapes.size() && in_vain < 2; ++k) {
      if (!go_on(0.85)) return interrupted_error();
      const Result<Candidate> tried = best_of(shapes[k], *warp);
      if (!tried && tried.error().code == ErrorCode::kUnsupported) break;
      if (!tried) return tried.error();
      if (!better(*tried, best)) {
        if (best) ++in_vain;
        continue;
      }
      best = *tried;
      at = k;
      in_vain = 0;
    }
    if (!best) return failure();
    if (Status refined = refine(shapes[at], *best); !refined) return refined.error();
    return *std::move(best);
  }

  [[nodiscard]] Objective objective() const { return objective_; }
  [[nodiscard]] Error failure() const {
    if (target_) {
      return {ErrorCode::kDifference,
              fmt::format("no dense table reaches {:g} %: the best has {:.3g} %", *target_, least_error_),
              std::nullopt};
    }
    return {ErrorCode::kDifference, "no dense table is so small", std::nullopt};
  }

 private:
  bool go_on(double left) {
    share_ = 1 - (1 - share_) * left;
    return !progress_.report || progress_.report(share_);
  }

  // By how well the first field can be fitted at all.
  Result<Warp> choose_warp(const SeriesShape& shape) {
    Warp best;
    double least = kInfinite;
    for (const int width : kWidths) {
      for (const std::uint8_t power : kPowers) {
        const Warp warp = {problem_.theta_max_deg(), static_cast<std::uint8_t>(width), power};
        const Result<SeriesStructure> structure = problem_.structure(shape, warp);
        if (!structure) return structure.error();
        const double residual = problem_.residual(*structure);
        if (!(residual < least)) continue;
        least = residual;
        best = warp;
      }
      if (!go_on(0.99)) return interrupted_error();
    }
    return best;
  }

  [[nodiscard]] bool fits(const Candidate& each) const {
    return target_ ? each.error <= *target_ : each.bytes <= most_bytes_;
  }
  [[nodiscard]] bool better(const Candidate& each, const std::optional<Candidate>& than) const {
    if (!fits(each)) return false;
    if (!than) return true;
    return target_ ? each.bytes < than->bytes : each.error < than->error;
  }

  // With a target, the coarsest step that reaches it; else the finest that is small enough.
  Result<Candidate> best_of(const SeriesShape& shape, const Warp& warp) {
    const Result<SeriesStructure> structure = problem_.structure(shape, warp);
    if (!structure) return structure.error();
    if (most_bytes_ > 0 && structure->basis.terms.size() > kTermsOfByte * most_bytes_ + kFewTerms) {
      return unsupported("more terms than bytes can tell of");
    }
    std::map<int, Candidate> tried;
    const auto reaches = [&](int step) {
      const auto [found, is_new] = tried.try_emplace(step);
      if (is_new) found->second = candidate(*structure, step);
      // Finer steps come nearer and take more.
      return fits(found->second) == target_.has_value();
    };
    int low = kCoarsestStep - 1;  // does not reach
    int high = kFinestStep + 1;   // reaches, as far as is known
    for (int step = near_; low + 1 < high;) {
      (reaches(step) ? high : low) = step;
      if (low < kCoarsestStep && high > kCoarsestStep) {
        step = std::max(kCoarsestStep, high - kStride);
      } else if (high > kFinestStep && low < kFinestStep) {
        step = std::min(kFinestStep, low + kStride);
      } else {
        step = (low + high) / 2;
      }
      if (progress_.report && !progress_.report(share_)) return interrupted_error();
      if (high <= kCoarsestStep || low >= kFinestStep) break;
    }
    const int chosen = std::clamp(target_ ? high : low, kCoarsestStep, kFinestStep);
    near_ = chosen;
    static_cast<void>(reaches(chosen));
    return tried.at(chosen);
  }

  Candidate candidate(const SeriesStructure& structure, int step) {
    Candidate made;
    made.brdf = problem_.quantise(structure, static_cast<std::uint8_t>(step));
    made.error = objective_value(judge(problem_.judged_values(structure, made.brdf), problem_.judged()), objective_);
    made.bytes = encode_series(made.brdf).size();
    least_error_ = std::min(least_error_, made.error);
    return made;
  }

  // Other warps, near to that of the best shape.
  Status refine(const SeriesShape& shape, Candidate& best) {
    for (const int width : {-6, 6, -3, 3}) {
      Warp warp = best.brdf.warp;
      warp.width_step = static_cast<std::uint8_t>(std::clamp(warp.width_step + width, 0, 255));
      if (Status status = try_warp(shape, warp, best); !status) return status;
    }
    for (const int power : {-1, 1}) {
      Warp warp = best.brdf.warp;
      warp.power_step = static_cast<std::uint8_t>(std::clamp(warp.power_step + power, 0, 15));
      if (Status status = try_warp(shape, warp, best); !status) return status;
    }
    return ok_status();
  }

  Status try_warp(const SeriesShape& shape, const Warp& warp, Candidate& best) {
    if (!go_on(0.85)) return interrupted_error();
    Result<Candidate> tried = best_of(shape, warp);
    if (!tried) return tried.error();
    if (better(*tried, best)) best = *std::move(tried);
    return ok_status();
  }

  const SeriesProblem& problem_;
  Objective objective_;
  const Progress& progress_;
  std::optional<double> target_;
  std::size_t most_bytes_ = 0;
  int near_ = kFirstStep;
  double share_ = 0;
  double least_error_ = kInfinite;
};

HeldBackError error_of(const VectorEvaluator& table, const HeldBack& held_back) {
  std::vector<float> values(held_back.values.size());
  evaluate_pairs(table, held_back.pairs, values);
  return judge(values, held_back);
}

/// The coarsest table that adds little to the error of the series.
Status choose_table(SeriesBrdf& brdf, double error, Objective objective, const HeldBack& held_back) {
  std::uint8_t chosen = 0;
  for (const std::uint8_t fineness : kFineness) {
    brdf.fineness = fineness;
    if (table_bytes(brdf) > kMostTableBytes) break;
    chosen = fineness;
    const Result<VectorEvaluator> table = make_table(brdf, kMostTableBytes);
    if (!table) return table.error();
    if (objective_value(error_of(*table, held_back), objective) <= kTableShare * error) break;
  }
  if (chosen == 0) return unsupported("the table of this series takes more than 64 MiB");
  brdf.fineness = chosen;
  return ok_status();
}

Status report_on(SeriesFit& fit, const SampledSource& sampled, const SliceOptions& options) {
  const Result<HeldBack> held_back = sampled.draw(kReportSeed);
  if (!held_back) return held_back.error();
  const Result<VectorEvaluator> table = make_table(fit.brdf, kMostTableBytes);
  if (!table) return table.error();
  std::vector<float> values(held_back->values.size());
  evaluate_pairs(*table, held_back->pairs, values);
  SliceReport& report = fit.report;
  report.reciprocity_difference_percent = sampled.reciprocity_difference_percent();
  report.error = judge(values, *held_back);
  report.error_directions = held_back->pairs.size();
  report.error_values_all_zero = all_zero(*held_back);
  report.theta_max_deg = sampled.theta_max_deg();
  report.figures = figures_of(*held_back, values);
  fit.brdf.metadata = metadata_of_slicing(sampled.source().reported_traits(), options, report);
  fit.table_bytes = table_bytes(fit.brdf);
  return ok_status();
}

// Of a file whose metadata have usual numbers in them.
std::size_t metadata_bytes(const SampledSource& sampled, const SliceOptions& options) {
  SliceReport report;
  report.error = {12.34, 12.34};
  report.reciprocity_difference_percent = sampled.reciprocity_difference_percent();
  SeriesBrdf some;
  some.channels = {"Y"};
  some.mean_colour = {static_cast<std::int32_t>(kColourUnit)};
  some.symmetries.isotropic = true;
  some.shape = {2, 2, 1, 2};
  some.coefficients = {{}};
  const std::size_t without = encode_series(some).size();
  some.metadata = metadata_of_slicing(sampled.source().reported_traits(), options, report);
  return encode_series(some).size() - without;
}

/// With so many bytes for metadata.
Result<SeriesFit> fit_with(const SeriesProblem& problem, const SampledSource& sampled, const SliceOptions& options,
                           std::size_t reserved, const Progress& progress) {
  SeriesSearch search(problem, options, reserved, progress);
  Result<Candidate> found = search.run(ladder(sampled.symmetries()));
  if (!found) return found.error();
  SeriesFit fit{std::move(found->brdf), {}, 0};
  if (Status status = choose_table(fit.brdf, found->error, search.objective(), problem.judged()); !status) {
    return status.error();
  }
  if (Status status = report_on(fit, sampled, options); !status) return status.error();
  return fit;
}

}  // namespace

void evaluate_pairs(const VectorEvaluator& table, std::span<const DirectionPair> pairs, std::span<float> values) {
  const FrameGeometry& frame = geometry(FrameId::kHalfDifference);
  const std::size_t channels = table.channel_count();
  for_all(pairs.size(), 256, [&](std::size_t k) {
    const std::span<float> f = values.subspan(k * channels, channels);
    if (above_horizon(pairs[k])) {
      table.evaluate_at(frame.coordinates(pairs[k]), f);
    } else {
      std::fill(f.begin(), f.end(), 0.0F);
    }
  });
}

Result<SeriesFit> fit_series(const BrdfSource& source, const SliceOptions& options, const Progress& progress) {
  if (Status status = check_options(options); !status) return status.error();
  const auto* rule = std::get_if<SearchedStructure>(&options.structure);
  const SampledSource sampled(source, options.theta_max_deg.value_or(source.traits().slice_theta_max_deg),
                              rule == nullptr || rule->use_mirrors ? SymmetryUse::kAll : SymmetryUse::kIsotropy);
  Result<HeldBack> fitted = sampled.draw(kFitSeed, kFittedCount);
  if (!fitted) return fitted.error();
  Result<HeldBack> judged = sampled.draw(kChoiceSeed);
  if (!judged) return judged.error();
  const Result<SeriesProblem> problem =
      SeriesProblem::make(*std::move(fitted), *std::move(judged), source.traits().channels, sampled.symmetries(),
                          sampled.theta_max_deg(), objective_of(options.stop));
  if (!problem) return problem.error();
  const auto* most = std::get_if<MaxBytes>(&options.stop);
  // Metadata tell of the error that is reached, so that their size is known at the end only.
  for (std::size_t reserved = metadata_bytes(sampled, options);;) {
    Result<SeriesFit> fit = fit_with(*problem, sampled, options, reserved, progress);
    if (!fit) return fit.error();
    const std::size_t size = encode_series(fit->brdf).size();
    if (most == nullptr || size <= most->count) {
      if (progress.report && !progress.report(1)) return interrupted_error();
      return fit;
    }
    reserved += size - static_cast<std::size_t>(most->count);
  }
}

}  // namespace sbrdf::internal
