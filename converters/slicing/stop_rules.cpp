#include "converters/slicing/stop_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kFewestSamples = 64;

// Shares of what is left of the work, for the steps whose number is not known beforehand.
constexpr double kBisection = 0.06;
constexpr double kFullSearch = 0.9;
constexpr double kRepair = 0.125;

/// More crossings than samples, in any structure: more samples may help.
template <class T>
bool has_too_few(const Result<T>& result) {
  return !result && result.error().code == ErrorCode::kUsage;
}

/// The fewest samples that reach an error. Twice as many each time until they do, then bisection, both by the
/// directions that choices are made by. The full search at that count is then judged on directions that took no part,
/// and repaired with more samples; an open precision is traded against their number.
class FewestSamples {
 public:
  FewestSamples(const Slicer& slicer, double target_percent, const Progress& progress)
      : slicer_(slicer), target_(target_percent), steps_(progress) {}

  Result<Slicing> run() {
    if (slicer_.all_held_back_zero()) {
      return difference_error(
          fmt::format("the source is zero on all {} held-back directions: there is no relative error to hold against a "
                      "target",
                      slicer_.held_back_count()));
    }
    if (Status status = double_until_reached(); !status) return status.error();
    if (Status status = bisect(); !status) return status.error();
    return verified();
  }

 private:
  struct Attempt {
    double error = 0;
    Slicing slicing;
  };

  // Afterwards `few_` samples miss the target, and `enough_` reach it.
  Status double_until_reached() {
    for (int left = kDoublings;; --left) {
      const Result<bool> reached = reaches(enough_, 1.0 / (left + 1));
      if (!reached) return reached.error();
      if (*reached) return ok_status();
      if (enough_ == kMaxSampleCount) return out_of_reach();
      few_ = std::exchange(enough_, std::min(2 * enough_, kMaxSampleCount));
    }
  }

  Status bisect() {
    while (enough_ - few_ > std::max<std::uint64_t>(1, enough_ / 20)) {
      const std::uint64_t middle = (few_ + enough_) / 2;
      const Result<bool> reached = reaches(middle, kBisection);
      if (!reached) return reached.error();
      (*reached ? enough_ : few_) = middle;
    }
    return ok_status();
  }

  Result<bool> reaches(std::uint64_t count, double share) {
    Result<Slicing> slicing = slicer_.slice(count, Effort::kStarts, steps_.step(share));
    if (has_too_few(slicing)) {
      refusal_ = slicing.error();
      return false;
    }
    if (!slicing) return slicing.error();
    // Where the precision is open, a finer one than any may be needed.
    const double error = slicer_.error_on_choice(*slicing, slicer_.options().precision.value_or(0));
    remember(error, *std::move(slicing));
    return error <= target_;
  }

  Result<Slicing> verified() {
    best_.reset();
    const Result<SlicePlan> plan = slicer_.plan(enough_, Effort::kFull, steps_.step(kFullSearch));
    if (!plan) return plan.error();
    if (Status status = try_more(*plan); !status) return status.error();
    if (!slicer_.options().precision) {
      if (Status status = try_fewer(*plan); !status) return status.error();
    }
    return std::move(smallest_->slicing);
  }

  // More samples for as long as fresh directions say that the target is missed. With an open precision, then more still
  // for as long as the coarser samples that they allow take fewer bytes.
  Status try_more(const SlicePlan& plan) {
    int larger = 0;
    for (std::uint64_t count = enough_; larger < kLarger; count += count / 16 + 1) {
      if (count > kMaxSampleCount) break;
      Result<Slicing> slicing = slicer_.sample(plan, count, steps_.step(kRepair));
      if (!slicing) return slicing.error();
      const bool reached = set_precision(*slicing);
      if (!reached) {
        const double error = slicer_.error_on_report(*slicing, slicer_.options().precision.value_or(0));
        remember(error, *std::move(slicing));
        continue;
      }
      larger = offer(*std::move(slicing)) ? 0 : larger + 1;
      if (slicer_.options().precision) break;
    }
    return smallest_ ? ok_status() : Status(out_of_reach());
  }

  // What the full search found may reach the target with fewer than the search for their number did.
  Status try_fewer(const SlicePlan& plan) {
    int larger = 0;
    for (std::uint64_t count = enough_ - enough_ / 16; larger < kLarger && count >= kFewestSamples;
         count -= count / 16) {
      Result<Slicing> slicing = slicer_.sample(plan, count, steps_.step(kRepair));
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
    if (slicer_.options().precision) {
      slicing.precision = slicer_.options().precision;
      return reaches(*slicing.precision);
    }
    slicing.precision = coarsest_precision(reaches);
    return slicing.precision.has_value();
  }

  // Whether its file is the smallest one yet.
  bool offer(Slicing slicing) {
    const std::size_t bytes = slicer_.file_size(slicing);
    if (smallest_ && bytes >= smallest_->bytes) return false;
    smallest_ = Sized{bytes, std::move(slicing)};
    return true;
  }

  void remember(double error, Slicing slicing) {
    if (!best_ || error < best_->error) best_ = Attempt{error, std::move(slicing)};
  }

  [[nodiscard]] Error out_of_reach() const {
    if (!best_) return refusal_;
    return difference_error(fmt::format(
        "no structure of up to 1,000,000 samples reaches the target of {:.4g} %: the least error, {:.4g} %, "
        "was reached with {} samples in {} bytes",
        target_, best_->error, best_->slicing.sliced.sample_count(), slicer_.file_size(best_->slicing)));
  }

  struct Sized {
    std::size_t bytes = 0;
    Slicing slicing;
  };

  static constexpr int kLarger = 2;      // in a row, until no smaller file is looked for
  static constexpr int kDoublings = 15;  // 64, 128, ..., 524,288 and 1,000,000

  const Slicer& slicer_;
  double target_;
  StepwiseProgress steps_;
  std::uint64_t few_ = kFewestSamples / 2;
  std::uint64_t enough_ = kFewestSamples;
  std::optional<Attempt> best_;
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
    if (const std::size_t size = slicer_.file_size(*fitting); size > limit_) {
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
    const Result<SlicePlan> plan = slicer_.plan(few_, Effort::kFull, steps_.step(kFullSearch));
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
