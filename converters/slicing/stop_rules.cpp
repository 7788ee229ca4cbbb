#include "converters/slicing/stop_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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
/// and repaired with more samples.
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
    const double error = slicer_.error_on_choice(*slicing);
    remember(error, *std::move(slicing));
    return error <= target_;
  }

  // More samples for as long as fresh directions say that the target is missed.
  Result<Slicing> verified() {
    best_.reset();
    std::uint64_t count = enough_;
    const Result<SlicePlan> plan = slicer_.plan(count, Effort::kFull, steps_.step(kFullSearch));
    if (!plan) return plan.error();
    for (;; count += count / 16 + 1) {
      if (count > kMaxSampleCount) return out_of_reach();
      Result<Slicing> slicing = slicer_.sample(*plan, count, steps_.step(kRepair));
      if (!slicing) return slicing.error();
      const double error = slicer_.error_on_report(*slicing);
      if (error <= target_) return slicing;
      remember(error, *std::move(slicing));
    }
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

  static constexpr int kDoublings = 15;  // 64, 128, ..., 524,288 and 1,000,000

  const Slicer& slicer_;
  double target_;
  StepwiseProgress steps_;
  std::uint64_t few_ = kFewestSamples / 2;
  std::uint64_t enough_ = kFewestSamples;
  std::optional<Attempt> best_;
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
      if (!slicing || slicer_.file_size(*slicing) <= limit_) return slicing;
    }
    return fitting;
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
