#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <limits>

#include "codec/coding/slice_steps.h"
#include "codec/entropy/contexts.h"

#ifdef __FAST_MATH__
#error "steps must have the same bits everywhere: no -ffast-math"
#endif

namespace sbrdf::internal {

static_assert(FLT_EVAL_METHOD == 0 && std::numeric_limits<double>::is_iec559,
              "steps must have the same bits everywhere: IEEE 754, each operation rounded to double");

// Prediction of steps (see Quantizer) from those of up to four neighbours, and what is left of it. specs/sbrdf.md,
// section 6. With neighbours k at positions x_k, steps b_k in the base channel and c_k in another:
//
//   base channel    P_b = sum w_k b_k,   w_k = product over j != k of (x - x_j) / (x_k - x_j)
//                   The polynomial through the neighbours (Lagrange), cubic where there are four of them.
//
//   other channels  P_c = sum w_k c_k + m (b - P_b)
//                   By how much the base channel, which is known by now, missed its prediction, this one is likely to
//                   miss it too: colours of one material move together. m is the slope of the line that is nearest to
//                   the points (b_k, c_k), drawn towards slope 1 by a prior of weight h. It minimises
//                     sum ((c_k - mean c) - m (b_k - mean b))^2 + h (1 - m)^2,
//                   so that its normal equation, of one unknown, gives
//                     m = (h + sum (b_k - mean b)(c_k - mean c)) / (h + sum (b_k - mean b)^2).
//                   Steps are logarithms: slope 1 is a change of both by the same factor. h is the square of a twelfth
//                   of an octave; smaller differences than that between neighbours say little about a slope.
//
// The residual is the step less the rounded prediction. Its context is the class of an activity, how far off the
// neighbours' predictions were: classes are half octaves, as widths of distributions are.

/// What all chunks of a file share.
struct CodingParameters {
  std::uint32_t channel_count = 1;
  std::uint32_t base_channel = 0;    ///< is predicted first; the others from it, too
  std::uint32_t activity_shift = 0;  ///< activities are divided by 2^this before they choose a class
  double slope_prior = 1;            ///< h above, (steps per octave / 12)^2
};

/// What a sample is predicted from.
struct Neighbours {
  const Stencil& stencil;
  std::int64_t spread = 0;  ///< how far apart their steps are, see spread_of; a part of the activity
};

/// The contexts of a sample's residuals: those of a group from its first on, one for each class of activity.
struct SampleContexts {
  unsigned base = 0;     ///< first one for the base channel
  unsigned other = 0;    ///< first one for the others; may be the same
  unsigned classes = 1;  ///< of which the last one takes all greater activities
};
inline constexpr SampleContexts kCrossingContexts = {CodingContext::kCrossingBase, CodingContext::kCrossingOther,
                                                     CodingContext::kClasses};
inline constexpr SampleContexts kSampleContexts = {CodingContext::kSampleBase, CodingContext::kSampleOther,
                                                   CodingContext::kClasses};
inline constexpr SampleContexts kGuideNodeContexts = {CodingContext::kGuideNode, CodingContext::kGuideNode, 1};
inline constexpr SampleContexts kGuideSampleContexts = {CodingContext::kGuideSample, CodingContext::kGuideSample, 1};

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

/// The spread of fewer than two members.
inline constexpr std::int64_t kUnknownSpread = std::int64_t{1} << 28U;

/// Four times the mean distance of the members' steps from their mean.
inline std::int64_t spread_of(const Stencil& stencil, const StepTable& table, const CodingParameters& coding) {
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
  [[gnu::always_inline]] StencilView(const Stencil& stencil, const StepTable& table, const CodingParameters& coding)
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
  [[nodiscard]] [[gnu::always_inline]] GroupView group(std::size_t first) const {
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

/// Codes the channels of one sample, the base channel first. What it is made of is always compiled in place: a call for
/// each channel takes a tenth of the time of the whole.
template <std::uint32_t Members, class Io>
class SampleCoder {
 public:
  SampleCoder(Io& io, const CodingParameters& coding, const SampleContexts& contexts, StepTable& table, std::size_t own)
      : io_(io), coding_(coding), contexts_(contexts), steps_(table.steps(own)), residuals_(table.residuals(own)) {}

  [[gnu::always_inline]] void code(const Neighbours& from, const StepTable& table) {
    constexpr std::size_t kGroup = StepTable::kGroup;
    const StencilView<Members> members(from.stencil, table, coding_);
    const std::uint32_t base = coding_.base_channel;
    std::size_t first = base / kGroup * kGroup;
    GroupView view = members.group(first);
    const double predicted = view.prediction[base - first];
    const double squares = view.products[base - first];
    const std::uint64_t missed = code_channel(
        base, predicted, 16 * view.residual[base - first] + static_cast<std::uint64_t>(from.spread), contexts_.base);
    const double base_off = steps_[base] - predicted;
    std::uint64_t missed_last = 0;
    for (std::uint32_t c = 0; c < coding_.channel_count; ++c) {
      if (c - first >= kGroup) {
        first = c / kGroup * kGroup;
        view = members.group(first);
      }
      if (c == base) continue;
      const double with_slope = view.prediction[c - first] + view.products[c - first] / squares * base_off;
      const std::uint64_t activity = 16 * view.residual[c - first] + missed / 2 + 16 * missed_last;
      missed_last = code_channel(c, with_slope, activity, contexts_.other);
    }
  }

 private:
  // The residual's magnitude.
  [[gnu::always_inline]] std::uint64_t code_channel(std::uint32_t c, double prediction, std::uint64_t activity,
                                                    unsigned group) {
    const std::int64_t predicted = rounded(prediction);
    std::int64_t residual = Io::kDecodes ? 0 : steps_[c] - predicted;
    io_.residual(group + std::min(class_of(activity, coding_.activity_shift), contexts_.classes - 1), residual);
    if (Io::kDecodes) steps_[c] = io_.step(predicted + residual);
    residuals_[c] = static_cast<std::int32_t>(std::min<std::int64_t>(std::abs(residual), 0x7FFFFFFF));
    return static_cast<std::uint64_t>(residuals_[c]);
  }

  Io& io_;
  const CodingParameters& coding_;
  const SampleContexts& contexts_;
  std::int32_t* steps_;
  std::int32_t* residuals_;
};

}  // namespace coding

/// Codes all channels of one sample. `own` is its row in `table`, where its steps stand (encoder) or are put (decoder);
/// the rows of its neighbours are known. For Io see codec/entropy/event_stream.h.
template <class Io>
[[gnu::always_inline]] inline void code_sample(Io& io, const CodingParameters& coding, const Neighbours& from,
                                               const SampleContexts& contexts, StepTable& table, std::size_t own) {
  if (from.stencil.count == 4) {
    coding::SampleCoder<4, Io>(io, coding, contexts, table, own).code(from, table);
  } else {
    coding::SampleCoder<0, Io>(io, coding, contexts, table, own).code(from, table);
  }
}

}  // namespace sbrdf::internal
