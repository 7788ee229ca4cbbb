#include "formats/texture/bc6h/kernel.h"

#include <cassert>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/texture/bc6h/kernel.cpp"  // NOLINT
#include <hwy/foreach_target.h>                               // IWYU pragma: keep
// After it, as every set of instructions has its own:
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sbrdf::internal::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float kFar = std::numeric_limits<float>::max();

template <int kCount>
constexpr std::array<std::int32_t, kCount> kWeights = [] {
  std::array<std::int32_t, kCount> weights{};
  for (std::size_t k = 0; k < kCount; ++k) weights[k] = kCount == 8 ? kBc6hWeights3[k % 8] : kBc6hWeights4[k];
  return weights;
}();

// The same order of additions whatever the length of a vector is.
HWY_INLINE float weighted_sum(const Bc6hRegion& region, const float* HWY_RESTRICT errors) {
  std::array<float, 8> sums{};
  for (std::size_t first = 0; first < region.padded_size; first += sums.size()) {
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += region.weight[first + k] * errors[first + k];
  }
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

using Floats = hn::CappedTag<float, 8>;
using Vector = hn::Vec<Floats>;

HWY_INLINE Vector square(Vector x) { return hn::Mul(x, x); }

// The colours of a channel for each index, on the scale of the metric: mix_bc6h, finish_bc6h and bc6h_metric_value.
template <int kCount>
HWY_INLINE void make_palette(const Bc6hScale& scale, const Bc6hEnds& ends, float* HWY_RESTRICT palette) {
  const Floats f;
  const hn::RebindToSigned<Floats> whole;
  const std::int32_t a = unquantise_bc6h(ends[0], scale.endpoint_bits, scale.is_signed);
  const std::int32_t b = unquantise_bc6h(ends[1], scale.endpoint_bits, scale.is_signed);
  for (std::size_t k = 0; k < kCount; k += hn::Lanes(f)) {
    const auto weights = hn::LoadU(whole, kWeights<kCount>.data() + k);
    const auto mixed = hn::ShiftRight<6>(hn::Add(hn::Mul(hn::Set(whole, b - a), weights), hn::Set(whole, 64 * a + 32)));
    const auto size = hn::Abs(mixed);
    const auto scaled = hn::Sub(hn::ShiftLeft<5>(size), size);
    const auto half = scale.is_signed ? hn::ShiftRight<5>(scaled) : hn::ShiftRight<6>(scaled);
    const Vector value = scale.metric == Bc6hMetric::kLog
                             ? hn::ConvertTo(f, half)
                             : hn::Mul(hn::BitCast(f, hn::ShiftLeft<13>(half)), hn::Set(f, 0x1p112F));
    hn::StoreU(hn::CopySignToAbs(value, hn::BitCast(f, mixed)), f, palette + k);
  }
}

// The nearest colours of some texels so far.
struct Nearest {
  Vector error;
  Vector index;

  HWY_INLINE void add(Vector other, std::size_t other_index) {
    const auto nearer = hn::Lt(other, error);
    error = hn::IfThenElse(nearer, other, error);
    index = hn::IfThenElse(nearer, hn::Set(Floats(), static_cast<float>(other_index)), index);
  }
};

template <int kCount>
void match_of(const Bc6hRegion& region, const Bc6hScale& scale, const std::array<Bc6hEnds, 3>& ends, Bc6hMatch& match) {
  constexpr std::size_t kHalf = kCount / 2;
  const Floats f;
  const hn::RebindToSigned<Floats> whole;
  alignas(64) std::array<std::array<float, kCount>, 3> palette;
  for (std::size_t c = 0; c < 3; ++c) make_palette<kCount>(scale, ends[c], palette[c].data());
  alignas(64) std::array<float, 16> errors;
  for (std::size_t at = 0; at < region.padded_size; at += hn::Lanes(f)) {
    const Vector r = hn::LoadU(f, region.value[0].data() + at);
    const Vector g = hn::LoadU(f, region.value[1].data() + at);
    const Vector b = hn::LoadU(f, region.value[2].data() + at);
    const auto error_of = [&](std::size_t k) HWY_ATTR {
      return hn::Add(
          hn::Add(square(hn::Sub(r, hn::Set(f, palette[0][k]))), square(hn::Sub(g, hn::Set(f, palette[1][k])))),
          square(hn::Sub(b, hn::Set(f, palette[2][k]))));
    };
    Nearest nearest = {hn::Set(f, kFar), hn::Zero(f)};
    for (std::size_t k = 0; k < kHalf; ++k) nearest.add(error_of(k), k);
    const Nearest lower = nearest;
    for (std::size_t k = kHalf; k < kCount; ++k) nearest.add(error_of(k), k);
    hn::StoreU(nearest.error, f, errors.data() + at);
    hn::StoreU(hn::ConvertTo(whole, nearest.index), whole, match.indices.data() + at);
    if (at == 0) {
      errors[0] = hn::GetLane(lower.error);
      match.indices[0] = static_cast<std::int32_t>(hn::GetLane(lower.index));
    }
  }
  match.error = weighted_sum(region, errors.data());
}

template <int kCount>
void others_of(const Bc6hRegion& region, const Bc6hScale& scale, const std::array<Bc6hEnds, 3>& ends,
               std::size_t channel, Bc6hOthers& others) {
  const Floats f;
  const std::array<std::size_t, 2> kept = {(channel + 1) % 3, (channel + 2) % 3};
  alignas(64) std::array<std::array<float, kCount>, 2> palette;
  for (std::size_t c = 0; c < 2; ++c) make_palette<kCount>(scale, ends[kept[c]], palette[c].data());
  for (std::size_t at = 0; at < region.padded_size; at += hn::Lanes(f)) {
    const Vector x = hn::LoadU(f, region.value[kept[0]].data() + at);
    const Vector y = hn::LoadU(f, region.value[kept[1]].data() + at);
    for (std::size_t k = 0; k < kCount; ++k) {
      hn::StoreU(hn::Add(square(hn::Sub(x, hn::Set(f, palette[0][k]))), square(hn::Sub(y, hn::Set(f, palette[1][k])))),
                 f, others[k].data() + at);
    }
  }
}

template <int kCount>
float channel_error_of(const Bc6hRegion& region, const Bc6hScale& scale, const Bc6hOthers& others, std::size_t channel,
                       const Bc6hEnds& ends) {
  constexpr std::size_t kHalf = kCount / 2;
  const Floats f;
  alignas(64) std::array<float, kCount> palette;
  make_palette<kCount>(scale, ends, palette.data());
  alignas(64) std::array<float, 16> errors;
  for (std::size_t at = 0; at < region.padded_size; at += hn::Lanes(f)) {
    const Vector x = hn::LoadU(f, region.value[channel].data() + at);
    const auto error_of = [&](std::size_t k) HWY_ATTR {
      return hn::Add(hn::LoadU(f, others[k].data() + at), square(hn::Sub(x, hn::Set(f, palette[k]))));
    };
    Vector least = error_of(0);
    for (std::size_t k = 1; k < kHalf; ++k) least = hn::Min(least, error_of(k));
    const Vector lower = least;
    for (std::size_t k = kHalf; k < kCount; ++k) least = hn::Min(least, error_of(k));
    hn::StoreU(least, f, errors.data() + at);
    if (at == 0) errors[0] = hn::GetLane(lower);
  }
  return weighted_sum(region, errors.data());
}

void Match(const Bc6hRegion& region, const Bc6hScale& scale, const std::array<Bc6hEnds, 3>& ends, Bc6hMatch& match) {
  scale.index_count == 8 ? match_of<8>(region, scale, ends, match) : match_of<16>(region, scale, ends, match);
}

void Others(const Bc6hRegion& region, const Bc6hScale& scale, const std::array<Bc6hEnds, 3>& ends, std::size_t channel,
            Bc6hOthers& others) {
  scale.index_count == 8 ? others_of<8>(region, scale, ends, channel, others)
                         : others_of<16>(region, scale, ends, channel, others);
}

void ChannelErrors(const Bc6hRegion& region, const Bc6hScale& scale, const Bc6hOthers& others, std::size_t channel,
                   std::span<const Bc6hEnds> ends, std::span<float> errors) {
  for (std::size_t k = 0; k < ends.size(); ++k) {
    errors[k] = scale.index_count == 8 ? channel_error_of<8>(region, scale, others, channel, ends[k])
                                       : channel_error_of<16>(region, scale, others, channel, ends[k]);
  }
}

}  // namespace
}  // namespace sbrdf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sbrdf::internal {

HWY_EXPORT(Match);
HWY_EXPORT(Others);
HWY_EXPORT(ChannelErrors);

Bc6hMatch match_bc6h(const Bc6hRegion& region, const Bc6hScale& scale, const std::array<Bc6hEnds, 3>& ends) {
  Bc6hMatch match;
  HWY_DYNAMIC_DISPATCH(Match)(region, scale, ends, match);
  return match;
}

Bc6hOthers other_channels_bc6h(const Bc6hRegion& region, const Bc6hScale& scale, const std::array<Bc6hEnds, 3>& ends,
                               std::size_t channel) {
  Bc6hOthers others;
  HWY_DYNAMIC_DISPATCH(Others)(region, scale, ends, channel, others);
  return others;
}

void channel_errors_bc6h(const Bc6hRegion& region, const Bc6hScale& scale, const Bc6hOthers& others,
                         std::size_t channel, std::span<const Bc6hEnds> ends, std::span<float> errors) {
  assert(errors.size() >= ends.size());
  HWY_DYNAMIC_DISPATCH(ChannelErrors)(region, scale, others, channel, ends, errors);
}

}  // namespace sbrdf::internal
#endif
