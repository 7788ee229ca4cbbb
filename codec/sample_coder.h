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

#include "codec/crossing_plan.h"
#include "codec/entropy.h"
#include "codec/slice_table.h"

#ifdef __FAST_MATH__
#error "levels must have the same bits everywhere: no -ffast-math"
#endif

namespace sbrdf {

static_assert(FLT_EVAL_METHOD == 0 && std::numeric_limits<double>::is_iec559,
              "levels must have the same bits everywhere: IEEE 754, each operation rounded to double");

// Prediction of levels (see LevelScale), and the walk over crossings and slices that encoder and decoder share.
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
  static constexpr unsigned kFlagCount = 48;  ///< whether a gap is halved: level (6), activity (4), the gap before (2)
};

/// What all chunks of a file share.
struct CodingParameters {
  std::uint32_t channel_count = 1;
  std::uint32_t base_channel = 0;    ///< is predicted first; the others from it, too
  std::uint32_t activity_shift = 0;  ///< activities are divided by 2^this before they choose a class
  double slope_prior = 1;            ///< (levels per octave / 12)^2: how strongly channels are taken to move alike
};

/// Levels of `count` samples with what is known of each: channel fastest.
struct LevelTable {
  std::vector<std::int32_t> levels;      ///< less the guide's, where there is one
  std::vector<std::uint32_t> residuals;  ///< |level - prediction|

  void resize(std::size_t values) {
    levels.resize(values);
    residuals.resize(values);
  }
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

/// Four times the mean distance of the members' levels from their mean; 2^28 for a single one.
inline std::int64_t spread_of(const Stencil& stencil, const LevelTable& table, const CodingParameters& coding) {
  constexpr std::int64_t kUnknownSpread = std::int64_t{1} << 28U;
  const std::int64_t n = stencil.count;
  if (n < 2) return kUnknownSpread;
  std::array<std::int64_t, 4> level{};
  std::int64_t sum = 0;
  for (std::uint32_t k = 0; k < stencil.count; ++k) {
    level[k] = table.levels[stencil.member[k] * coding.channel_count + coding.base_channel];
    sum += level[k];
  }
  std::int64_t away = 0;
  for (std::uint32_t k = 0; k < stencil.count; ++k) away += std::abs(n * level[k] - sum);
  return n == 4 ? away >> 2U : 4 * away / (n * n);
}

}  // namespace coding

namespace coding {

/// See code_sample. `Channels` and `Members` are what they are named after, or 0 where only run time knows.
template <std::uint32_t Channels, std::uint32_t Members, class Io>
void code_sample_of(Io& io, const CodingParameters& coding, const Stencil& stencil, std::int64_t spread,
                    LevelTable& table, std::size_t own, unsigned base_context, unsigned other_context, bool classes) {
  const std::uint32_t channels = Channels != 0 ? Channels : coding.channel_count;
  const std::uint32_t count = Members != 0 ? Members : stencil.count;
  std::int32_t* levels = table.levels.data() + own * channels;
  std::uint32_t* residuals = table.residuals.data() + own * channels;
  std::array<std::size_t, 4> at{};
  for (std::uint32_t k = 0; k < count; ++k) at[k] = std::size_t{stencil.member[k]} * channels;
  const auto mean_residual = [&](std::uint32_t c) {
    std::uint64_t sum = 0;
    for (std::uint32_t k = 0; k < count; ++k) sum += table.residuals[at[k] + c];
    return over_count(sum, count);
  };
  // Dividing by 4 and multiplying by 1/4 give the same bits.
  const auto mean_of = [&](double sum) { return count == 4 ? sum * 0.25 : count == 0 ? 0 : sum / count; };
  const auto code = [&](std::uint32_t c, double prediction, std::uint64_t activity, unsigned group) {
    const std::int64_t predicted = rounded(prediction);
    std::int64_t residual = Io::kDecodes ? 0 : levels[c] - predicted;
    io.residual(group + (classes ? class_of(activity, coding.activity_shift) : 0), residual);
    if (Io::kDecodes) levels[c] = io.level(predicted + residual);
    residuals[c] = static_cast<std::uint32_t>(std::min<std::int64_t>(std::abs(residual), 0x7FFFFFFF));
    return residuals[c];
  };
  const std::uint32_t base_channel = coding.base_channel;
  std::array<double, 4> base{};
  double base_prediction = 0;
  double base_sum = 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    base[k] = table.levels[at[k] + base_channel];
    base_prediction += stencil.weight[k] * base[k];
    base_sum += base[k];
  }
  const std::uint64_t base_residual =
      code(base_channel, base_prediction, 16 * mean_residual(base_channel) + static_cast<std::uint64_t>(spread),
           base_context);
  if (channels == 1) return;
  const double base_off = levels[base_channel] - base_prediction;
  // The slope between the channels, by least squares over the members, drawn towards 1.
  const double base_mean = mean_of(base_sum);
  double squares = coding.slope_prior;
  for (std::uint32_t k = 0; k < count; ++k) {
    base[k] -= base_mean;
    squares += base[k] * base[k];
  }
  std::uint64_t last_residual = 0;
  for (std::uint32_t c = 0; c < channels; ++c) {
    if (c == base_channel) continue;
    double prediction = 0;
    double sum = 0;
    std::array<double, 4> level{};
    for (std::uint32_t k = 0; k < count; ++k) {
      level[k] = table.levels[at[k] + c];
      prediction += stencil.weight[k] * level[k];
      sum += level[k];
    }
    const double mean = mean_of(sum);
    double products = coding.slope_prior;
    for (std::uint32_t k = 0; k < count; ++k) products += base[k] * (level[k] - mean);
    prediction += products / squares * base_off;
    const std::uint64_t activity = 16 * mean_residual(c) + base_residual / 2 + 16 * last_residual;
    last_residual = code(c, prediction, activity, other_context);
  }
}

}  // namespace coding

/// Codes all channels of one sample. `Io::residual(context, residual&)` writes or reads one number. `own` is the
/// sample's place in `table`, where its levels stand (encoder) or are put (decoder). Without `classes` all residuals
/// have the context of their group.
template <class Io>
void code_sample(Io& io, const CodingParameters& coding, const Stencil& stencil, std::int64_t spread, LevelTable& table,
                 std::size_t own, unsigned base_context, unsigned other_context, bool classes = true) {
  if (coding.channel_count == 3 && stencil.count == 4) {
    coding::code_sample_of<3, 4>(io, coding, stencil, spread, table, own, base_context, other_context, classes);
  } else {
    coding::code_sample_of<0, 0>(io, coding, stencil, spread, table, own, base_context, other_context, classes);
  }
}

/// The crossings of one block.
template <class Io>
void code_crossings(Io& io, const CodingParameters& coding, const CrossingPlan& plan, std::uint32_t block,
                    LevelTable& table) {
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

/// A slice while its samples are coded level by level. Made for one slice after the other: memory is kept.
struct SliceLevels {
  Boundary boundary = Boundary::kBounded;
  double length_deg = 0;  ///< the period of a periodic slice
  std::vector<SamplePosition> places;
  std::vector<double> positions_deg;
  std::vector<std::uint8_t> depths;  ///< refinement level of each sample, 0 for crossings
  LevelTable table;                  ///< of the samples known so far, by rising position
  int deepest = 0;                   ///< the greatest of `depths`

  [[nodiscard]] std::size_t size() const { return places.size(); }

  // Of the level that is being coded: behind which sample, and where.
  struct Found {
    std::size_t left = 0;
    SamplePosition place;
    double position_deg = 0;
  };
  std::vector<Found> found;
  LevelTable fresh;
};

/// Gives the places and levels of samples that are to be written; what a decoder gets instead decides on every flag.
struct SamplesToEncode {
  std::span<const SamplePosition> places;  ///< of one slice, rising, crossings left out
  std::span<const std::int32_t> levels;    ///< channel fastest
};

namespace coding {

/// Puts what was found at a level between the known samples, from the back on, in place.
void merge_found(SliceLevels& slice, std::size_t channels, int level);

/// The stencil of a gap's middle: the samples at -1, 0, 1, 2 from the gap's left end, as far as there are any.
Stencil stencil_around(const SliceLevels& slice, std::size_t known, std::size_t gap, double at);

}  // namespace coding

/// Codes the samples of level `level` on one slice, and merges them into `slice`. `place_deg(place)` gives positions;
/// `samples` is nullptr when reading.
template <class Io, class PlaceDeg>
void code_level(Io& io, const CodingParameters& coding, int level, SliceLevels& slice, const PlaceDeg& place_deg,
                const SamplesToEncode* samples, unsigned base_context, unsigned other_context, bool classes = true) {
  // Only the halves of what was halved before are left to halve.
  if (slice.deepest != level - 1) return;
  const std::size_t known = slice.size();
  const std::uint32_t channels = coding.channel_count;
  const std::size_t gaps = slice.boundary == Boundary::kPeriodic ? known : known - 1;
  const std::uint32_t half = SamplePosition::kOne >> static_cast<unsigned>(level);
  const unsigned level_context = (static_cast<unsigned>(std::min(level, 6)) - 1) * 8;
  slice.found.clear();
  std::size_t next = 0;  // in `samples`
  bool halved = false;
  for (std::size_t gap = 0; gap < gaps; ++gap) {
    const std::size_t right = gap + 1 < known ? gap + 1 : 0;
    if (std::max(slice.depths[gap], slice.depths[right]) != level - 1) continue;
    const SamplePosition middle = {slice.places[gap].interval, slice.places[gap].fraction + half};
    const std::uint64_t nearby =
        std::uint64_t{8} * (std::uint64_t{slice.table.residuals[gap * channels + coding.base_channel]} +
                            slice.table.residuals[right * channels + coding.base_channel]);
    const unsigned activity = (coding::class_of(nearby, coding.activity_shift) + 2) / 4;
    const unsigned context = level_context + std::min(activity, 3U) * 2 + (halved ? 1 : 0);
    if (!Io::kDecodes) {
      while (next < samples->places.size() && samples->places[next] < middle) ++next;
      halved = next < samples->places.size() && samples->places[next] == middle;
    }
    io.flag(context, halved);
    if (!halved) continue;

    const double at = place_deg(middle);
    const Stencil stencil = coding::stencil_around(slice, known, gap, at);
    // The new sample stands behind the known ones for the moment.
    const std::size_t own = known + slice.found.size();
    slice.table.resize((own + 1) * channels);
    if (!Io::kDecodes) {
      std::copy_n(samples->levels.begin() + static_cast<std::ptrdiff_t>(next * channels), channels,
                  slice.table.levels.begin() + static_cast<std::ptrdiff_t>(own * channels));
    }
    code_sample(io, coding, stencil, coding::spread_of(stencil, slice.table, coding), slice.table, own, base_context,
                other_context, classes);
    slice.found.push_back({gap, middle, at});
    if (!io.ok()) break;
  }
  if (!slice.found.empty()) coding::merge_found(slice, channels, level);
}

}  // namespace sbrdf
