#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "codec/coding/crossing_order.h"
#include "codec/coding/prediction.h"
#include "codec/coding/slice_steps.h"

namespace sbrdf::internal {

// The walk over crossings and slices that encoder and decoder share: the order in which samples are coded, and what
// each is predicted from. Both directions run through the same lines, so that they cannot drift apart; what differs is
// the Io, which writes or reads a number, and who knows which gaps are halved. specs/sbrdf.md, sections 6 and 7.

/// The crossings of one block. Of the stencils that the plan has for a crossing, the one whose members differ least is
/// used: where the material is smooth, the prediction is good.
template <class Io>
void code_crossings(Io& io, const CodingParameters& coding, const CrossingPlan& plan, std::uint32_t block,
                    StepTable& table) {
  static constexpr Stencil kNone{};
  for (std::uint32_t s = plan.block_begin[block]; s < plan.block_begin[block + 1]; ++s) {
    const CrossingPlan::Step& step = plan.steps[s];
    const Stencil* best = &kNone;
    std::int64_t least = coding::kUnknownSpread;
    for (std::uint32_t k = 0; k < step.stencil_count; ++k) {
      const Stencil& stencil = plan.stencils[step.first_stencil + k];
      const std::int64_t spread = coding::spread_of(stencil, table, coding);
      if (best == &kNone || spread < least) {
        best = &stencil;
        least = spread;
      }
    }
    code_sample(io, coding, {*best, 2 * least}, kCrossingContexts, table, step.crossing);
  }
}

/// The encoder's knowledge of which gaps are halved: the samples that there are on a slice, but for its crossings. A
/// copy for each depth, since the walk goes over them once a depth.
class SamplesToWrite {
 public:
  /// `places` rise; `steps` have the channel fastest. Both must outlive this.
  SamplesToWrite(std::span<const SamplePosition> places, std::span<const std::int32_t> steps)
      : places_(places), steps_(steps) {}

  /// Whether a sample lies at the middle of a gap. Middles are asked for in rising order.
  [[nodiscard]] bool has(const SamplePosition& middle) {
    while (next_ < places_.size() && places_[next_] < middle) ++next_;
    return next_ < places_.size() && places_[next_] == middle;
  }
  /// The steps of the sample that `has` found.
  void give(std::int32_t* target, std::uint32_t channels) const {
    std::copy_n(steps_.data() + next_ * channels, channels, target);
  }

 private:
  std::span<const SamplePosition> places_;
  std::span<const std::int32_t> steps_;
  std::size_t next_ = 0;
};

/// The decoder's: nothing. Every flag and every step comes out of the stream.
class SamplesToRead {
 public:
  [[nodiscard]] static bool has(const SamplePosition& /*middle*/) { return false; }
  static void give(std::int32_t* /*target*/, std::uint32_t /*channels*/) {}
};

/// What one slice, or the guide, is coded with.
template <class PlaceDeg>
struct SliceCoding {
  const CodingParameters& parameters;
  SampleContexts contexts;
  PlaceDeg place_deg;  ///< place_deg(SamplePosition) gives the position in degrees
};
template <class PlaceDeg>
SliceCoding(const CodingParameters&, SampleContexts, PlaceDeg) -> SliceCoding<PlaceDeg>;

namespace coding {

/// The samples of one depth on one slice, gap by gap.
template <class Io, class PlaceDeg, class Samples>
class DepthCoder {
 public:
  DepthCoder(Io& io, const SliceCoding<PlaceDeg>& coding, int depth, SliceSteps& slice, const Samples& samples)
      : io_(io),
        coding_(coding),
        slice_(slice),
        samples_(samples),
        half_(SamplePosition::kOne >> static_cast<unsigned>(depth)),
        depth_context_((static_cast<unsigned>(std::min(depth, kDepths)) - 1) * kPerDepth) {}

  /// The gap behind `left`: a flag, and where it is halved the sample in its middle.
  [[gnu::always_inline]] void code_gap(std::uint32_t left) {
    const std::uint32_t right = slice_.samples[left].after;
    if (right == SliceSteps::kNone) return;
    const SamplePosition middle = {slice_.samples[left].place.interval, slice_.samples[left].place.fraction + half_};
    const unsigned context = flag_context(left, right);
    halved_ = samples_.has(middle);
    io_.flag(context, halved_);
    if (halved_) code_middle(left, middle);
  }

 private:
  static constexpr int kDepths = 6;  // deeper ones have the contexts of the last
  static constexpr unsigned kPerDepth = 8;
  static constexpr unsigned kActivities = 4;

  // By depth, by how badly the ends were predicted, and by whether the gap before was halved.
  [[nodiscard]] unsigned flag_context(std::uint32_t left, std::uint32_t right) const {
    const CodingParameters& parameters = coding_.parameters;
    const auto residual = [&](std::uint32_t row) {
      return static_cast<std::uint64_t>(slice_.table.residuals(row)[parameters.base_channel]);
    };
    const unsigned activity = (class_of(8 * (residual(left) + residual(right)), parameters.activity_shift) + 2) / 4;
    return depth_context_ + std::min(activity, kActivities - 1) * 2 + (halved_ ? 1 : 0);
  }

  [[gnu::always_inline]] void code_middle(std::uint32_t left, const SamplePosition& middle) {
    const double at = coding_.place_deg(middle);
    const Stencil stencil = slice_.stencil_around(left, at);
    const std::uint32_t own = slice_.add({at, middle, left, SliceSteps::kNone});
    samples_.give(slice_.table.steps(own), coding_.parameters.channel_count);
    const Neighbours from = {stencil, spread_of(stencil, slice_.table, coding_.parameters)};
    code_sample(io_, coding_.parameters, from, coding_.contexts, slice_.table, own);
  }

  Io& io_;
  const SliceCoding<PlaceDeg>& coding_;
  SliceSteps& slice_;
  Samples samples_;
  std::uint32_t half_;
  unsigned depth_context_;
  bool halved_ = false;  // the gap before
};

}  // namespace coding

/// Codes the samples of depth `depth` on one slice, whose samples of all lower depths are there. `samples` is
/// SamplesToWrite or SamplesToRead.
template <class Io, class PlaceDeg, class Samples>
void code_depth(Io& io, const SliceCoding<PlaceDeg>& coding, int depth, SliceSteps& slice, const Samples& samples) {
  // Only the halves of what was halved before are left to halve.
  if (slice.depth != depth - 1) return;
  const std::size_t known = slice.samples.size();
  coding::DepthCoder<Io, PlaceDeg, Samples> gaps(io, coding, depth, slice, samples);
  // No two samples of the newest depth are neighbours.
  for (std::size_t k = slice.newest; k < known && io.ok(); ++k) {
    if (depth > 1) gaps.code_gap(slice.samples[k].before);
    gaps.code_gap(static_cast<std::uint32_t>(k));
  }
  if (slice.samples.size() > known) slice.link(known, depth);
}

}  // namespace sbrdf::internal
