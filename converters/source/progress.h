#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>

#include "formats/core/interrupted.h"  // IWYU pragma: export
#include "formats/core/result.h"

namespace sbrdf::internal {

/// How long work tells how far it is, and learns that it should stop.
struct Progress {
  /// Called with the fraction done, in (0, 1] and growing, at most some hundred times for each step of the work, from
  /// any thread but never from two at once. Returning false asks to stop: the work then ends soon with
  /// interrupted_error(). May be empty.
  std::function<bool(double fraction)> report;
};

/// Counts the finished parts of some work and reports them rarely. Shared between the threads that do the work.
class ProgressCounter {
 public:
  ProgressCounter(Progress progress, std::uint64_t total) : progress_(std::move(progress)), total_(total) {}

  /// `count` more parts are done; more than `total` in all count as all. False once the work should stop.
  bool advance(std::uint64_t count = 1) {
    if (!progress_.report) return true;
    const std::scoped_lock lock(mutex_);
    done_ += count;
    const double fraction = done_ < total_ ? static_cast<double>(done_) / static_cast<double>(total_) : 1.0;
    if (!stopped_ && (fraction >= reported_ + kStep || (fraction == 1 && reported_ < 1))) {
      reported_ = fraction;
      stopped_ = !progress_.report(fraction);
    }
    return !stopped_;
  }
  /// Some report returned false.
  [[nodiscard]] bool stopped() const {
    const std::scoped_lock lock(mutex_);
    return stopped_;
  }

 private:
  static constexpr double kStep = 1.0 / 256;

  Progress progress_;
  std::uint64_t total_;
  mutable std::mutex mutex_;
  std::uint64_t done_ = 0;
  double reported_ = 0;
  bool stopped_ = false;
};

/// Progress of work in steps, of which it is not known beforehand how many there will be: each takes a share of what is
/// left. They run one after the other, and what each reports as its own fraction is passed on as that of the whole.
class StepwiseProgress {
 public:
  explicit StepwiseProgress(Progress whole) : whole_(std::move(whole)) {}
  StepwiseProgress(const StepwiseProgress&) = delete;
  StepwiseProgress& operator=(const StepwiseProgress&) = delete;

  /// The next step; `share` in [0, 1] is its part of what the steps before have left. Of use until the next call.
  [[nodiscard]] Progress step(double share) {
    begin_ = end_;
    end_ += share * (1 - end_);
    if (!whole_.report) return {};
    return {[this](double fraction) { return report(begin_ + (end_ - begin_) * fraction); }};
  }
  /// The last step came to nothing: its part is left again.
  void take_back() { end_ = begin_; }
  /// All is done, whatever the steps have left. False where the work was asked to stop.
  bool finish() { return report(1); }

 private:
  bool report(double fraction) {
    if (stopped_ || !whole_.report) return !stopped_;
    if (fraction <= reported_) return true;
    reported_ = fraction;
    stopped_ = !whole_.report(fraction);
    return !stopped_;
  }

  Progress whole_;
  double begin_ = 0;
  double end_ = 0;
  double reported_ = 0;
  bool stopped_ = false;
};

}  // namespace sbrdf::internal
