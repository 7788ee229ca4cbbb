#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/coding/crossing_order.h"
#include "codec/material/slice_samples.h"

namespace sbrdf::internal {

/// What is known of samples, a row for each: the steps of all channels (less the guide's, where there is one), then
/// the magnitudes of their residuals. Both are padded with zeros to groups of four channels, which prediction works on
/// side by side.
class StepTable {
 public:
  static constexpr std::size_t kGroup = 4;

  explicit StepTable(std::size_t channels = 1) : width_((channels + kGroup - 1) / kGroup * kGroup) {}

  /// At least so many rows. The padding of all is zero, steps and residuals are what was put there last.
  void hold(std::size_t rows) {
    if (numbers_.size() < rows * 2 * width_) numbers_.resize(rows * 2 * width_);
  }
  [[nodiscard]] std::int32_t* steps(std::size_t row) { return numbers_.data() + row * 2 * width_; }
  [[nodiscard]] const std::int32_t* steps(std::size_t row) const { return numbers_.data() + row * 2 * width_; }
  [[nodiscard]] std::int32_t* residuals(std::size_t row) { return steps(row) + width_; }
  [[nodiscard]] const std::int32_t* residuals(std::size_t row) const { return steps(row) + width_; }
  /// Makes row `to` what row `from` of a table of as many channels is.
  void copy(std::size_t to, const StepTable& other, std::size_t from) {
    std::copy_n(other.steps(from), 2 * width_, steps(to));
  }

 private:
  std::size_t width_;
  std::vector<std::int32_t> numbers_;
};

/// A slice while its samples are coded depth by depth: crossings by rising position, then the samples of each depth, in
/// a list that is linked by position. Made for one slice after the other: memory is kept.
///
///   depth 0   o-------------------------------o----        crossings
///         1   o---------------x---------------o----        halves the gap between two of depth 0
///         2   o-------x-------o---------------o----        halves a gap that one of depth 1 bounds
///         3   o---x---o-------o---------------o----
///
/// Only the gaps beside samples of the newest depth can still be halved at the next, so no others are looked at.
class SliceSteps {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  struct Sample {
    double position_deg = 0;
    SamplePosition place;
    std::uint32_t before = kNone;  ///< the neighbours; those of the ends are kNone, or each other if periodic
    std::uint32_t after = kNone;
  };

  explicit SliceSteps(std::size_t channels) : table(channels) {}

  /// So many crossings, 1 or more, linked; their positions and steps are for the caller to set.
  void begin(Boundary boundary, double length_deg, std::size_t crossings);
  /// A sample behind the last one; returns its row. It has no neighbours before link().
  std::uint32_t add(const Sample& sample) {
    samples.push_back(sample);
    table.hold(samples.size());
    return static_cast<std::uint32_t>(samples.size() - 1);
  }
  /// Puts the samples from `first` on behind their neighbours `before`, and makes them the newest depth.
  void link(std::size_t first, int depth);

  /// Up to four samples around the middle `at` of the gap behind `left`: one beyond each end of it, where the slice
  /// goes on there, by its period or as its own mirror image.
  [[nodiscard]] Stencil stencil_around(std::uint32_t left, double at) const;

  Boundary boundary = Boundary::kBounded;
  double length_deg = 0;  ///< the period of a periodic slice
  std::vector<Sample> samples;
  StepTable table;         ///< a row for each sample
  std::size_t newest = 0;  ///< the first sample of the newest depth
  int depth = 0;           ///< which is this one

 private:
  struct Members;
  void take_periodic(std::uint32_t left, Members& members) const;
  void take_ended(std::uint32_t left, Members& members) const;
};

}  // namespace sbrdf::internal
