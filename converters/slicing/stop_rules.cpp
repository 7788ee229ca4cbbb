#include "converters/slicing/stop_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kFewestSamples = 16;

// Shares of what is left of the work, for the steps whose number is not known beforehand.
constexpr double kOneSearch = 0.25;
constexpr double kBisection = 0.06;
constexpr double kFullSearch = 0.9;
constexpr double kRepair = 0.125;

/// More crossings than samples, in any structure: more samples may help.
template <class T>
bool has_too_few(const Result<T>& result) {
  return !result && result.error().code == ErrorCode::kUsage;
}

/// The fewest samples that reach an error. Searches in full for numbers that the errors so far make likely, first until
/// one reaches the target, then between those that miss and those that reach it; all by the directions that choices are
/// made by. What reaches it with fewest is then judged on directions that took no part, and repaired with more samples;
/// an open precision is traded against their number.
class FewestSamples {
 public:
  FewestSamples(const Slicer& slicer, double target_percent, const Progress& progress)
      : slicer_(slicer), target_(target_percent), steps_(progress) {}

  Result<Slicing> run() {
    if (slicer_.all_held_back_zero()) {
      return difference_error(
          "the source is zero on all held-back directions of a draw: there is no relative error to hold against a "
          "target");
    }
    if (Status status = grow_until_reached(); !status) return status.error();
    if (Status status = narrow(); !status) return status.error();
    return verified();
  }

 private:
  /// A number of samples, and the error that it reaches by the directions that choices are made by [%].
  struct Attempt {
    std::uint64_t count = 0;
    double error = 0;
  };
  struct Tried {
    Attempt attempt;
    SlicePlan plan;
  };
  /// The larger of the errors on both draws of directions [%], with the precision that was asked for, or unrounded.
  struct Least {
    double error = 0;
    Slicing slicing;
  };
  struct Sized {
    std::size_t bytes = 0;
    Slicing slicing;
  };

  // Afterwards `few_` misses the target, unless it is of none, and `enough_` reaches it.
  Status grow_until_reached() {
    std::uint64_t count = kFewestSamples;
    while (true) {
      const Result<double> error = error_with(count);
      if (!error) return error.error();
      if (*error <= target_) {
        enough_ = {count, *error};
        return ok_status();
      }
      if (count == kMaxSampleCount || errors_no_longer_fall()) return out_of_reach();
      few_ = {count, *error};
      const double missing = std::pow(*error / target_, kSamplesPerError);
      count = grown(count, std::isfinite(missing) ? std::clamp(missing, kLeastGrowth, kMostGrowth) : kLeastGrowth);
    }
  }

  static std::uint64_t grown(std::uint64_t count, double factor) {
    const auto more = static_cast<std::uint64_t>(std::ceil(static_cast<double>(count) * factor));
    return std::min(more, count < kMostSearched ? kMostSearched : kMaxSampleCount);
  }

  // Single errors rise by chance, so it is the least one that counts.
  bool errors_no_longer_fall() {
    if (!least_) return false;
    const bool falls = least_->error < kStillFalls * least_before_;
    growths_in_vain_ = falls ? 0 : growths_in_vain_ + 1;
    if (falls) least_before_ = least_->error;
    return growths_in_vain_ == kMostInVain;
  }

  // Where a line through both errors, drawn over the logarithms, meets the target.
  Status narrow() {
    for (int k = 0; k < kNarrowings && few_.count != 0 && enough_.count > few_.count + few_.count / 5 + 1; ++k) {
      const double width = std::log(static_cast<double>(enough_.count) / static_cast<double>(few_.count));
      const double part = std::log(few_.error / target_) / std::log(few_.error / enough_.error);
      const double inside = std::isfinite(part) ? std::clamp(part, 0.2, 0.8) : 0.5;
      const double between = static_cast<double>(few_.count) * std::exp(inside * width);
      const auto count = std::max(few_.count + 1, static_cast<std::uint64_t>(between));
      const Result<double> error = error_with(count);
      if (!error) return error.error();
      (*error <= target_ ? enough_ : few_) = {count, *error};
    }
    return ok_status();
  }

  // What is good by both errors is at times better by one of them than what was searched for by that one alone.
  Result<double> error_with(std::uint64_t count) {
    Result<double> error = error_with(count, slicer_.objective());
    const bool again = error && searches(count) && *error > target_ && *error < kWorthAnother * target_;
    if (!again) return error;
    const Result<double> other = error_with(count, Objective::kBoth);
    return other ? std::min(*error, *other) : other;
  }

  // Infinite where there are too few samples.
  Result<double> error_with(std::uint64_t count, Objective objective) {
    const Result<SlicePlan> plan = plan_for(count, objective);
    if (has_too_few(plan)) return refused(plan.error());
    if (!plan) return plan.error();
    Result<Slicing> slicing = slicer_.sample(*plan, count, steps_.step(kOneSearch));
    if (has_too_few(slicing)) return refused(slicing.error());
    if (!slicing) return slicing.error();
    const Tried tried = {{count, slicer_.error_on_choice(*slicing, least_rounding())}, *plan};
    remember(*std::move(slicing), tried.attempt.error);
    if (tried.attempt.error <= target_) reaching_.push_back(tried);
    const bool better = count == largest_.attempt.count && tried.attempt.error < largest_.attempt.error;
    if (count > largest_.attempt.count || better) largest_ = tried;
    return tried.attempt.error;
  }

  // From kMostSearched samples on the structure stays as it is, since a search would take minutes.
  Result<SlicePlan> plan_for(std::uint64_t count, Objective objective) {
    if (searches(count)) return slicer_.plan(count, Effort::kFull, objective, steps_.step(kOneSearch));
    if (largest_.attempt.count != 0) return largest_.plan;
    return slicer_.plan(count, Effort::kFull, objective, steps_.step(0));
  }

  [[nodiscard]] bool searches(std::uint64_t count) const {
    return std::holds_alternative<SearchedStructure>(slicer_.options().structure) && count <= kMostSearched;
  }

  // Where the precision is open, a finer one than any may be needed.
  [[nodiscard]] double least_rounding() const { return slicer_.options().precision.value_or(0); }

  double refused(Error error) {
    steps_.take_back();
    refusal_ = std::move(error);
    return std::numeric_limits<double>::infinity();
  }

  // Where nothing that reached the target by one draw of directions reaches it by the other, more samples follow.
  Result<Slicing> verified() {
    std::uint64_t count = enough_.count;
    while (!smallest_) {
      if (reaching_.empty()) {
        if (count == kMaxSampleCount || errors_no_longer_fall()) return out_of_reach();
        count = grown(count, kLeastGrowth);
        if (const Result<double> error = error_with(count); !error) return error.error();
        continue;
      }
      const auto fewest = std::min_element(reaching_.begin(), reaching_.end(), has_fewer);
      const Tried from = std::move(*fewest);
      reaching_.erase(fewest);
      // Up to where the next one takes over.
      const auto next = std::min_element(reaching_.begin(), reaching_.end(), has_fewer);
      const std::uint64_t most = next == reaching_.end() ? from.attempt.count * 3 / 2 : next->attempt.count;
      if (Status status = try_more(from, std::min(most, kMaxSampleCount)); !status) return status.error();
      if (!smallest_) continue;
      if (Status status = try_fewer(from); !status) return status.error();
    }
    return std::move(smallest_->slicing);
  }

  static bool has_fewer(const Tried& a, const Tried& b) { return a.attempt.count < b.attempt.count; }

  // More samples for as long as fresh directions say that the target is missed. With an open precision, then more still
  // for as long as the coarser samples that they allow take fewer bytes.
  Status try_more(const Tried& from, std::uint64_t most) {
    int larger = 0;
    for (std::uint64_t count = from.attempt.count; larger < kLarger; count += count / 16 + 1) {
      if (count > (smallest_ ? kMaxSampleCount : most)) break;
      Result<Slicing> slicing = slicer_.sample(from.plan, count, steps_.step(kRepair));
      if (!slicing) return slicing.error();
      if (!set_precision(*slicing)) {
        const double on_choice = slicer_.error_on_choice(*slicing, least_rounding());
        remember(*std::move(slicing), on_choice);
        continue;
      }
      larger = offer(*std::move(slicing)) ? 0 : larger + 1;
      if (slicer_.options().precision) break;
    }
    return ok_status();
  }

  // What the full search found may reach the target with fewer than the search for their number did.
  Status try_fewer(const Tried& from) {
    int larger = 0;
    for (std::uint64_t count = from.attempt.count - from.attempt.count / 16;
         larger < kLarger && count >= kFewestSamples; count -= count / 16) {
      Result<Slicing> slicing = slicer_.sample(from.plan, count, steps_.step(kRepair));
      if (has_too_few(slicing)) break;
      if (!slicing) return slicing.error();
      if (!set_precision(*slicing)) break;
      larger = offer(*std::move(slicing)) ? 0 : larger + 1;
    }
    return ok_status();
  }

  // The one that was asked for, or the coarsest, with which all held-back directions reach the target; false where
  // there is none.
  bool set_precision(Slicing& slicing) const {
    const auto reaches = [&](double precision) {
      return slicer_.error_on_report(slicing, precision) <= target_ &&
             (slicer_.options().precision || slicer_.error_on_choice(slicing, precision) <= target_);
    };
    if (!slicer_.options().precision) {
      slicing.precision = coarsest_precision(reaches);
      if (slicing.precision) return true;
    }
    slicing.precision = least_rounding();
    return reaches(*slicing.precision);
  }

  // Whether its file is the smallest one yet.
  bool offer(Slicing slicing) {
    const std::size_t bytes = slicer_.file_size(slicing);
    if (smallest_ && bytes >= smallest_->bytes) return false;
    smallest_ = Sized{bytes, std::move(slicing)};
    return true;
  }

  void remember(Slicing slicing, double error_on_choice) {
    slicing.precision = least_rounding();
    const double error = std::max(error_on_choice, slicer_.error_on_report(slicing, least_rounding()));
    if (!least_ || error < least_->error) least_ = Least{error, std::move(slicing)};
  }

  [[nodiscard]] Error out_of_reach() const {
    if (!least_) return refusal_;
    return difference_error(fmt::format(
        "no structure of up to 1,000,000 samples reaches the target of {:.4g} %: the least error, {:.4g} %, "
        "was reached with {} samples in {} bytes",
        target_, least_->error, least_->slicing.sliced.sample_count(), slicer_.file_size(least_->slicing)));
  }

  static constexpr int kLarger = 2;  // in a row, until no smaller file is looked for
  static constexpr int kNarrowings = 3;
  static constexpr int kMostInVain = 4;  // growths in a row without less error
  static constexpr double kStillFalls = 0.98;
  static constexpr std::uint64_t kMostSearched = 65'536;
  static constexpr double kWorthAnother = 1.5;     // so much above the target
  static constexpr double kSamplesPerError = 1.5;  // exponent: half the error takes 2.8 times the samples, as a rule
  static constexpr double kLeastGrowth = 1.5;
  static constexpr double kMostGrowth = 8;

  const Slicer& slicer_;
  double target_;
  StepwiseProgress steps_;
  Attempt few_;
  Attempt enough_;
  std::vector<Tried> reaching_;  ///< what reached the target, by the directions that choices are made by
  Tried largest_;                ///< the better one of those with most samples
  std::optional<Least> least_;
  double least_before_ = std::numeric_limits<double>::infinity();
  int growths_in_vain_ = 0;
  std::optional<Sized> smallest_;  ///< of those that reach the target
  Error refusal_;
};

/// The most samples, one to a byte at most, whose file is not larger than a limit: by bisection, then the full search
/// at that count, with fewer samples until the file of its structure fits, too.
class MostSamples {
 public:
  MostSamples(const Slicer& slicer, std::uint64_t limit, const Progress& progress)
      : slicer_(slicer), limit_(limit), steps_(progress) {}

  Result<Slicing> run() {
    Result<Slicing> fitting = smallest();
    if (!fitting) return fitting.error();
    std::size_t size = slicer_.file_size(*fitting);
    if (size > limit_ && !slicer_.options().precision) {
      fitting->precision = tried_precisions().front();  // the coarsest
      size = slicer_.file_size(*fitting);
    }
    if (size > limit_) {
      return difference_error(fmt::format("no file fits into {} bytes: the smallest takes {}, with {} samples", limit_,
                                          size, fitting->sliced.sample_count()));
    }
    if (Status status = bisect(*fitting); !status) return status.error();
    return improved(*std::move(fitting));
  }

 private:
  // With as few samples as there may be; `few_` is their number.
  Result<Slicing> smallest() {
    Result<Slicing> found = starts_at(few_);
    if (!has_too_few(found)) return found;
    std::uint64_t short_of = few_;
    while (has_too_few(found) && few_ < kMaxSampleCount) {
      short_of = std::exchange(few_, std::min(2 * few_, kMaxSampleCount));
      found = starts_at(few_);
    }
    while (found && few_ - short_of > 1) {
      const std::uint64_t middle = (short_of + few_) / 2;
      Result<Slicing> fewer = starts_at(middle);
      if (!fewer && !has_too_few(fewer)) return fewer;
      (fewer ? few_ : short_of) = middle;
      if (fewer) found = std::move(fewer);
    }
    return found;
  }

  Result<Slicing> starts_at(std::uint64_t count) {
    return slicer_.slice(count, Effort::kStarts, steps_.step(kBisection));
  }

  // Afterwards `few_` samples fit, `fitting` among them.
  Status bisect(Slicing& fitting) {
    std::uint64_t many = std::max(few_, std::min(kMaxSampleCount, limit_));
    while (many - few_ > std::max<std::uint64_t>(1, few_ / 50)) {
      const std::uint64_t middle = (few_ + many) / 2;
      Result<Slicing> slicing = starts_at(middle);
      if (!slicing) return slicing.error();
      const bool fits = slicer_.file_size(*slicing) <= limit_;
      (fits ? few_ : many) = middle;
      if (fits) fitting = *std::move(slicing);
    }
    return ok_status();
  }

  // `fitting` is what remains where the structure of the full search takes more bytes even with few samples.
  Result<Slicing> improved(Slicing fitting) {
    const Result<SlicePlan> plan = slicer_.plan(few_, Effort::kFull, slicer_.objective(), steps_.step(kFullSearch));
    if (!plan) return plan.error();
    for (std::uint64_t count = few_; count >= kFewestSamples; count -= count / 50 + 1) {
      Result<Slicing> slicing = slicer_.sample(*plan, count, steps_.step(kRepair));
      if (has_too_few(slicing)) break;
      if (!slicing) return slicing;
      if (slicer_.file_size(*slicing) > limit_) continue;
      return slicer_.options().precision ? std::move(slicing) : traded(*plan, *std::move(slicing));
    }
    return fitting;
  }

  // Coarser samples leave room for more of them, for as long as that makes the error less.
  Result<Slicing> traded(const SlicePlan& plan, Slicing best) {
    best.precision = slicer_.precision_for(best);
    double least = slicer_.error_on_choice(best, *best.precision);
    std::uint64_t count = best.sliced.sample_count();
    for (const double precision : tried_precisions_from(*best.precision)) {
      Result<Slicing> slicing = filled(plan, precision, count);
      if (!slicing && slicing.error().code == ErrorCode::kDifference) break;
      if (!slicing) return slicing;
      const double error = slicer_.error_on_choice(*slicing, precision);
      if (!(error < least)) break;
      least = error;
      count = slicing->sliced.sample_count();
      best = *std::move(slicing);
    }
    return best;
  }

  // As many samples, from `count` on, as fit with a precision.
  Result<Slicing> filled(const SlicePlan& plan, double precision, std::uint64_t count) {
    constexpr int kSteps = 4;
    std::optional<Slicing> fitting;
    for (int k = 0; k < kSteps; ++k) {
      Result<Slicing> slicing = slicer_.sample(plan, count, steps_.step(kRepair));
      if (!slicing) return slicing;
      slicing->precision = precision;
      const std::size_t bytes = slicer_.file_size(*slicing);
      const bool fits = bytes <= limit_;
      if (fits) fitting = *std::move(slicing);
      if (fitting && (!fits || bytes > limit_ - limit_ / 50)) break;
      const double share = static_cast<double>(limit_) / static_cast<double>(bytes);
      const auto next = static_cast<std::uint64_t>(static_cast<double>(count) * (fits ? share : share * 0.98));
      if (next == count || next < kFewestSamples || next > kMaxSampleCount) break;
      count = next;
    }
    if (fitting) return *std::move(fitting);
    return difference_error("no number of samples fits");
  }

  // Coarser ones than `precision`, the finest first.
  static std::vector<double> tried_precisions_from(double precision) {
    std::vector<double> coarser;
    for (const double p : tried_precisions()) {
      if (p > precision) coarser.insert(coarser.begin(), p);
    }
    return coarser;
  }

  const Slicer& slicer_;
  std::uint64_t limit_;
  StepwiseProgress steps_;
  std::uint64_t few_ = kFewestSamples;
};

}  // namespace

Result<Slicing> slice_by_rule(const Slicer& slicer, const Progress& progress) {
  const StopRule& rule = slicer.options().stop;
  if (const auto* fixed = std::get_if<SampleCount>(&rule)) return slicer.slice(fixed->count, Effort::kFull, progress);
  if (const auto* size = std::get_if<MaxBytes>(&rule)) return MostSamples(slicer, size->count, progress).run();
  return FewestSamples(slicer, *target_percent(rule), progress).run();
}

}  // namespace sbrdf::internal
