#include "formats/texture/bc6h/region.h"

#include <algorithm>
#include <cmath>

namespace sbrdf::internal {

namespace {

// The middle of what becomes this half.
float mixed_from_half(std::uint16_t half, bool is_signed) {
  const auto size = static_cast<float>(half & 0x7FFFU);
  if (!is_signed) return (size + 0.5F) * (64.0F / 31) - 0.5F;
  if (size == 0) return 0;
  const float mixed = (size + 0.5F) * (32.0F / 31) - 0.5F;
  return (half & 0x8000U) != 0 ? -mixed : mixed;
}

void pad(Bc6hRegion& region) { region.padded_size = (region.size + 7) / 8 * 8; }

void append(Bc6hRegion& region, const Bc6hRegion& whole, std::size_t texel) {
  const std::size_t at = region.size++;
  region.texels[at] = static_cast<std::uint8_t>(texel);
  region.weight[at] = whole.weight[texel];
  for (std::size_t channel = 0; channel < 3; ++channel) {
    region.value[channel][at] = whole.value[channel][texel];
    region.mixed[channel][at] = whole.mixed[channel][texel];
    region.fit_weight[channel][at] = whole.fit_weight[channel][texel];
  }
}

}  // namespace

float bc6h_metric_slope(Bc6hMetric metric, std::uint16_t half) {
  if (metric == Bc6hMetric::kLog) return 1;
  const int exponent = std::max((half & 0x7FFF) >> 10, 1);
  return std::ldexp(1.0F, exponent - 25);
}

Bc6hRegion make_bc6h_region(const Bc6hTexels& texels, const std::array<float, 16>& weights,
                            const Bc6hOptions& options) {
  Bc6hRegion region;
  region.size = region.padded_size = 16;
  region.weight = weights;
  // Dark texels beside bright ones will be off by more than their own slope tells.
  constexpr float kLeastShare = 0.25F;
  std::array<float, 3> least_slope{};
  for (const auto& texel : texels) {
    for (std::size_t c = 0; c < 3; ++c) {
      least_slope[c] = std::max(least_slope[c], kLeastShare * bc6h_metric_slope(options.metric, texel[c]));
    }
  }
  for (std::size_t texel = 0; texel < 16; ++texel) {
    region.texels[texel] = static_cast<std::uint8_t>(texel);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const std::uint16_t half = texels[texel][channel];
      region.value[channel][texel] = bc6h_metric_value(options.metric, half);
      region.mixed[channel][texel] = mixed_from_half(half, options.is_signed);
      const float slope = std::max(bc6h_metric_slope(options.metric, half), least_slope[channel]);
      region.fit_weight[channel][texel] = weights[texel] * slope * slope;
    }
  }
  return region;
}

std::array<Bc6hRegion, 2> split_bc6h_region(const Bc6hRegion& whole, std::size_t partition) {
  const std::array<std::size_t, 2> anchors = {0, kBc6hAnchors[partition]};
  std::array<Bc6hRegion, 2> regions;
  for (std::size_t k = 0; k < 2; ++k) append(regions[k], whole, anchors[k]);
  for (std::size_t texel = 1; texel < 16; ++texel) {
    if (texel != anchors[1]) append(regions[kBc6hPartitions[partition] >> texel & 1U], whole, texel);
  }
  for (Bc6hRegion& region : regions) pad(region);
  return regions;
}

}  // namespace sbrdf::internal
