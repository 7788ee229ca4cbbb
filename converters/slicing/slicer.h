#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "converters/drawing/sampled_source.h"
#include "converters/slicing/slicing.h"

namespace sbrdf::internal {

/// Precisions that are tried, six to a tenfold, from the coarsest to the finest that a file can have.
[[nodiscard]] const std::vector<double>& tried_precisions();

/// The coarsest of them that is `good_enough`, which finer ones then are, too; nothing where none is.
template <class GoodEnough>
std::optional<double> coarsest_precision(const GoodEnough& good_enough) {
  const std::vector<double>& tried = tried_precisions();
  const auto found = std::partition_point(tried.begin(), tried.end(), [&](double p) { return !good_enough(p); });
  return found == tried.end() ? std::nullopt : std::optional(*found);
}

/// How far a search for a structure goes: its regular starts suffice to tell how many samples a target will take.
enum class Effort : std::uint8_t { kStarts, kFull };

/// Where slices lie and how they are sampled, for any number of samples.
struct SlicePlan {
  FrameSpec frame;
  SamplingOptions sampling;          ///< `sample_count` is not set
  std::vector<std::string> reasons;  ///< for people: why these, where they were searched for
  bool fits = false;                 ///< values are fitted, as far as options and number of samples allow
};

/// One source and what slicings of it have in common: the source made reciprocal, its symmetries, the directions that
/// choices are made by, and those that results are judged on. Source and options must outlive it.
class Slicer {
 public:
  /// kUsage for options that cannot be; kInvalidFile where the source gives a value that is not finite.
  [[nodiscard]] static Result<Slicer> make(const BrdfSource& source, const SliceOptions& options);

  [[nodiscard]] const SliceOptions& options() const { return options_; }
  [[nodiscard]] double theta_max_deg() const { return sampled_.theta_max_deg(); }
  /// The error that the stop rule names, or both.
  [[nodiscard]] Objective objective() const { return objective_of(options_.stop); }

  /// The placement that was asked for, or the best structure for so many samples that a search by the objective finds.
  /// The errors of search_structure() and elevation_frame().
  [[nodiscard]] Result<SlicePlan> plan(std::uint64_t sample_count, Effort effort, Objective objective,
                                       const Progress& progress) const;
  /// Samples by a plan, which may have been made for another number. kUsage where there are more crossings than
  /// samples.
  [[nodiscard]] Result<Slicing> sample(const SlicePlan& plan, std::uint64_t sample_count,
                                       const Progress& progress) const;
  /// Both.
  [[nodiscard]] Result<Slicing> slice(std::uint64_t sample_count, Effort effort, const Progress& progress) const;

  /// The error of what a file of that precision would give back [%], by the measure of the stop rule: on the directions
  /// that choices are made by, and on those that took no part in any.
  [[nodiscard]] double error_on_choice(const Slicing& slicing, double precision) const;
  [[nodiscard]] double error_on_report(const Slicing& slicing, double precision) const;
  /// The precision that was asked for. Open: the coarsest at which rounding adds no more than a tenth to either error
  /// on the directions that choices are made by, or 0.0015 percentage points.
  [[nodiscard]] double precision_for(const Slicing& slicing) const;
  /// The source is zero on one of the two: no relative error can be stated.
  [[nodiscard]] bool all_held_back_zero() const { return all_zero(choice_) || all_zero(report_); }

  /// Rounds the samples to the precision, which it chooses where it is open, and fills report and metadata.
  /// Gives its values on the directions that results are judged on.
  std::vector<float> finish(Slicing& slicing) const;
  /// Fills what people are told of the error, but not the metadata, of a slicing that is finished; `values` as of
  /// finish.
  void look_closer(std::span<const float> values, Slicing& slicing) const;
  /// Bytes of the file, with the metadata that it will have. Takes a slicing that is not finished.
  [[nodiscard]] std::size_t file_size(Slicing slicing) const;

 private:
  Slicer(const BrdfSource& source, const SliceOptions& options);

  [[nodiscard]] Result<SlicePlan> search(const SearchedStructure& rule, std::uint64_t sample_count, Effort effort,
                                         Objective objective, const Progress& progress) const;
  /// Replaces the values by fitted ones where that is better on the directions that choices are made by.
  [[nodiscard]] Status fit(Slicing& slicing) const;
  [[nodiscard]] std::uint64_t count_filled(const Slicing& slicing) const;

  const BrdfSource& source_;
  const SliceOptions& options_;
  SampledSource sampled_;
  GreyShares grey_shares_;  ///< none where values are placed as the paper does, or no channel changes its sign
  HeldBack choice_;         ///< empty where nothing is chosen by it
  HeldBack report_;
};

}  // namespace sbrdf::internal
