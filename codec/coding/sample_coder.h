#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "codec/coding/crossing_order.h"
#include "codec/coding/rans.h"
#include "codec/material/slice_samples.h"

#ifdef __FAST_MATH__
#error "steps must have the same bits everywhere: no -ffast-math"
#endif

namespace sbrdf::internal {

static_assert(FLT_EVAL_METHOD == 0 && std::numeric_limits<double>::is_iec559,
              "steps must have the same bits everywhere: IEEE 754, each operation rounded to double");

// Prediction of steps (see Quantizer), and the walk over crossings and slices that encoder and decoder share.
// specs/sbrdf.md, sections 6 and 7.

/// With which distribution something is coded. Numbers stand in files.
struct CodingContext {
  static constexpr unsigned kClasses = 16;
  static constexpr unsigned kCrossingBase = 0;
  static constexpr unsigned kCrossingOther = 16;
  static constexpr unsigned kSampleBase = 32;
  static constexpr unsigned kSampleOther = 48;
  static constexpr unsigned kGuideNode = 64;
  static constexpr unsigned kGuideSample = 65;
  static constexpr unsigned kResidualCount = 66;
  static constexpr unsigned kFlagCount = 48;  ///< whether a gap is halved: depth (6), activity (4), the gap before (2)
};

/// What all chunks of a file share.
struct CodingParameters {
  std::uint32_t channel_count = 1;
  std::uint32_t base_channel = 0;    ///< is predicted first; the others from it, too
  std::uint32_t activity_shift = 0;  ///< activities are divided by 2^this before they choose a class
  double slope_prior = 1;            ///< (steps per octave / 12)^2: how strongly channels are taken to move alike
};

/// What is known of samples, a row for each: the steps of all channels (less the guide's, where there is one), then
/// the magnitudes of their residuals. Both are padded with zeros to groups of four channels.
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

namespace coding {

// floor(x + 1/2), without the call that std::floor is where SSE4.1 cannot be assumed.
inline std::int64_t rounded(double value) {
  constexpr double kLimit = std::numeric_limits<std::int32_t>::max();
  const double shifted = std::min(std::max(value, -kLimit), kLimit) + 0.5;
  const auto whole = static_cast<std::int64_t>(shifted);
  return whole - (static_cast<double>(whole) > shifted ? 1 : 0);
}

// Division of sums over the members of a stencil, nearly always four.
inline std::uint64_t over_count(std::uint64_t sum, std::uint32_t count) {
  if (count == 4) return sum >> 2U;
  return count == 0 ? 0 : sum / count;
}

/// Half octaves of an activity: 0 below 8, then 8-11, 12-15, 16-23 ...
inline unsigned class_of(std::uint64_t activity, std::uint32_t shift) {
  const std::uint64_t a = activity >> (shift + 3);
  if (a == 0) return 0;
  const auto octave = static_cast<unsigned>(std::bit_width(a)) - 1;
  const auto half = static_cast<unsigned>(octave == 0 ? 0 : (a >> (octave - 1)) & 1U);
  return std::min(CodingContext::kClasses - 1, 1 + 2 * octave + half);
}

/// Four times the mean distance of the members' steps from their mean; 2^28 for a single one.
inline std::int64_t spread_of(const Stencil& stencil, const StepTable& table, const CodingParameters& coding) {
  constexpr std::int64_t kUnknownSpread = std::int64_t{1} << 28U;
  const std::int64_t n = stencil.count;
  if (n < 2) return kUnknownSpread;
  std::array<std::int64_t, 4> step{};
  std::int64_t sum = 0;
  for (std::uint32_t k = 0; k < stencil.count; ++k) {
    step[k] = table.steps(stencil.member[k])[coding.base_channel];
    sum += step[k];
  }
  std::int64_t away = 0;
  for (std::uint32_t k = 0; k < stencil.count; ++k) away += std::abs(n * step[k] - sum);
  return n == 4 ? away >> 2U : 4 * away / (n * n);
}

/// What the members of a stencil say about four neighbouring channels of a sample.
struct GroupView {
  std::array<double, StepTable::kGroup> prediction{};  ///< by interpolation
  std::array<double, StepTable::kGroup> products{};    ///< of the differences from the mean with the base channel's
  std::array<std::uint64_t, StepTable::kGroup> residual{};  ///< mean magnitude
};

/// `Members`: the stencil's count, or 0 where only run time knows.
template <std::uint32_t Members>
class StencilView {
 public:
  StencilView(const Stencil& stencil, const StepTable& table, const CodingParameters& coding)
      : stencil_(stencil), prior_(coding.slope_prior) {
    double sum = 0;
    for (std::uint32_t k = 0; k < count(); ++k) {
      steps_[k] = table.steps(stencil.member[k]);
      residuals_[k] = table.residuals(stencil.member[k]);
      base_[k] = steps_[k][coding.base_channel];
      sum += base_[k];
    }
    const double mean = mean_of(sum);
    for (std::uint32_t k = 0; k < count(); ++k) base_[k] -= mean;
  }

  /// Of the channels [first, first + 4): the same operations for each, so that they go side by side.
  [[nodiscard]] GroupView group(std::size_t first) const {
    constexpr std::size_t kGroup = StepTable::kGroup;
    GroupView view;
    std::array<std::array<double, kGroup>, 4> step;
    std::array<double, kGroup> mean{};
    for (std::uint32_t k = 0; k < count(); ++k) {
      for (std::size_t c = 0; c < kGroup; ++c) {
        step[k][c] = steps_[k][first + c];
        view.prediction[c] += stencil_.weight[k] * step[k][c];
        mean[c] += step[k][c];
        view.residual[c] += static_cast<std::uint32_t>(residuals_[k][first + c]);
      }
    }
    for (std::size_t c = 0; c < kGroup; ++c) {
      mean[c] = mean_of(mean[c]);
      view.residual[c] = over_count(view.residual[c], count());
      view.products[c] = prior_;
    }
    for (std::uint32_t k = 0; k < count(); ++k) {
      for (std::size_t c = 0; c < kGroup; ++c) view.products[c] += base_[k] * (step[k][c] - mean[c]);
    }
    return view;
  }

 private:
  [[nodiscard]] std::uint32_t count() const { return Members != 0 ? Members : stencil_.count; }
  // Dividing by 4 and multiplying by 1/4 give the same bits.
  [[nodiscard]] double mean_of(double sum) const {
    return count() == 4 ? sum * 0.25 : count() == 0 ? 0 : sum / count();
  }

  const Stencil& stencil_;
  double prior_;
  std::array<const std::int32_t*, 4> steps_{};
  std::array<const std::int32_t*, 4> residuals_{};
  std::array<double, 4> base_{};
};

/// See code_sample.
template <std::uint32_t Members, class Io>
inline void code_sample_of(Io& io, const CodingParameters& coding, const Stencil& stencil, std::int64_t spread,
                           StepTable& table, std::size_t own, unsigned base_context, unsigned other_context,
                           bool classes) {
  constexpr std::size_t kGroup = StepTable::kGroup;
  std::int32_t* steps = table.steps(own);
  std::int32_t* residuals = table.residuals(own);
  const auto code = [&](std::uint32_t c, double prediction, std::uint64_t activity, unsigned group) {
    const std::int64_t predicted = rounded(prediction);
    std::int64_t residual = Io::kDecodes ? 0 : steps[c] - predicted;
    io.residual(group + (classes ? class_of(activity, coding.activity_shift) : 0), residual);
    if (Io::kDecodes) steps[c] = io.step(predicted + residual);
    residuals[c] = static_cast<std::int32_t>(std::min<std::int64_t>(std::abs(residual), 0x7FFFFFFF));
    return static_cast<std::uint64_t>(residuals[c]);
  };
  const StencilView<Members> members(stencil, table, coding);
  const std::uint32_t base = coding.base_channel;
  std::size_t first = base / kGroup * kGroup;
  GroupView view = members.group(first);
  const double base_prediction = view.prediction[base - first];
  const double squares = view.products[base - first];
  const std::uint64_t base_residual =
      code(base, base_prediction, 16 * view.residual[base - first] + static_cast<std::uint64_t>(spread), base_context);
  const double base_off = steps[base] - base_prediction;
  std::uint64_t last_residual = 0;
  for (std::uint32_t c = 0; c < coding.channel_count; ++c) {
    if (c - first >= kGroup) {
      first = c / kGroup * kGroup;
      view = members.group(first);
    }
    if (c == base) continue;
    // The slope between the channels, by least squares over the members, drawn towards 1.
    const double prediction = view.prediction[c - first] + view.products[c - first] / squares * base_off;
    const std::uint64_t activity = 16 * view.residual[c - first] + base_residual / 2 + 16 * last_residual;
    last_residual = code(c, prediction, activity, other_context);
  }
}

}  // namespace coding

/// Codes all channels of one sample. `Io::residual(context, residual&)` writes or reads one number. `own` is the
/// sample's row in `table`, where its steps stand (encoder) or are put (decoder). Without `classes` all residuals
/// have the context of their group.
template <class Io>
void code_sample(Io& io, const CodingParameters& coding, const Stencil& stencil, std::int64_t spread, StepTable& table,
                 std::size_t own, unsigned base_context, unsigned other_context, bool classes = true) {
  if (stencil.count == 4) {
    coding::code_sample_of<4>(io, coding, stencil, spread, table, own, base_context, other_context, classes);
  } else {
    coding::code_sample_of<0>(io, coding, stencil, spread, table, own, base_context, other_context, classes);
  }
}

/// The crossings of one block.
template <class Io>
void code_crossings(Io& io, const CodingParameters& coding, const CrossingPlan& plan, std::uint32_t block,
                    StepTable& table) {
  static constexpr Stencil kNone{};
  for (std::uint32_t s = plan.block_begin[block]; s < plan.block_begin[block + 1]; ++s) {
    const CrossingPlan::Step& step = plan.steps[s];
    const Stencil* best = &kNone;
    std::int64_t least = 0;
    for (std::uint32_t k = 0; k < step.stencil_count; ++k) {
      const Stencil& stencil = plan.stencils[step.first_stencil + k];
      const std::int64_t spread = coding::spread_of(stencil, table, coding);
      if (best == &kNone || spread < least) {
        best = &stencil;
        least = spread;
      }
    }
    code_sample(io, coding, *best, 2 * least, table, step.crossing, CodingContext::kCrossingBase,
                CodingContext::kCrossingOther);
  }
}

/// A slice while its samples are coded depth by depth: crossings by rising position, then the samples of each depth, in
/// a list that is linked by position. Made for one slice after the other: memory is kept.
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

  /// Up to four samples around the middle `at` of the gap behind `left`.
  [[nodiscard]] Stencil stencil_around(std::uint32_t left, double at) const;

  Boundary boundary = Boundary::kBounded;
  double length_deg = 0;  ///< the period of a periodic slice
  std::vector<Sample> samples;
  StepTable table;         ///< a row for each sample
  std::size_t newest = 0;  ///< the first sample of the newest depth
  int depth = 0;           ///< which is this one
};

/// Gives the places and steps of samples that are to be written; what a decoder gets instead decides on every flag.
struct SamplesToEncode {
  std::span<const SamplePosition> places;  ///< of one slice, rising, crossings left out
  std::span<const std::int32_t> steps;     ///< channel fastest
};

/// Codes the samples of depth `depth` on one slice. `place_deg(place)` gives positions; `wanted` is nullptr when
/// reading.
template <class Io, class PlaceDeg>
void code_depth(Io& io, const CodingParameters& coding, int depth, SliceSteps& slice, const PlaceDeg& place_deg,
                const SamplesToEncode* wanted, unsigned base_context, unsigned other_context, bool classes = true) {
  // Only the halves of what was halved before are left to halve.
  if (slice.depth != depth - 1) return;
  const std::size_t known = slice.samples.size();
  const std::uint32_t half = SamplePosition::kOne >> static_cast<unsigned>(depth);
  const unsigned depth_context = (static_cast<unsigned>(std::min(depth, 6)) - 1) * 8;
  std::size_t next = 0;  // in `wanted`
  bool halved = false;
  const auto code_gap = [&](std::uint32_t left) {
    const std::uint32_t right = slice.samples[left].after;
    if (right == SliceSteps::kNone) return;
    const SamplePosition middle = {slice.samples[left].place.interval, slice.samples[left].place.fraction + half};
    const auto residual = [&](std::uint32_t row) {
      return static_cast<std::uint64_t>(slice.table.residuals(row)[coding.base_channel]);
    };
    const unsigned activity = (coding::class_of(8 * (residual(left) + residual(right)), coding.activity_shift) + 2) / 4;
    const unsigned context = depth_context + std::min(activity, 3U) * 2 + (halved ? 1 : 0);
    if (!Io::kDecodes) {
      while (next < wanted->places.size() && wanted->places[next] < middle) ++next;
      halved = next < wanted->places.size() && wanted->places[next] == middle;
    }
    io.flag(context, halved);
    if (!halved) return;
    const double at = place_deg(middle);
    const Stencil stencil = slice.stencil_around(left, at);
    const std::uint32_t own = slice.add({at, middle, left, SliceSteps::kNone});
    if (!Io::kDecodes) {
      std::copy_n(wanted->steps.data() + next * coding.channel_count, coding.channel_count, slice.table.steps(own));
    }
    code_sample(io, coding, stencil, coding::spread_of(stencil, slice.table, coding), slice.table, own, base_context,
                other_context, classes);
  };
  // No two samples of the newest depth are neighbours.
  for (std::size_t k = slice.newest; k < known && io.ok(); ++k) {
    if (depth > 1) code_gap(slice.samples[k].before);
    code_gap(static_cast<std::uint32_t>(k));
  }
  if (slice.samples.size() > known) slice.link(known, depth);
}

}  // namespace sbrdf::internal
