#include "codec/atlas/slice_values.h"

#include <algorithm>
#include <span>
#include <string>

#include "codec/material/value_map.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kChannels = 3;

}  // namespace

SliceValues::SliceValues(const SlicedBrdf& sliced, const Lattice& lattice)
    : evaluator_(sliced, lattice), shares_(sliced.grey_shares), channels_(sliced.channel_count()) {
  for (std::size_t c = 0; c < channels_; ++c) maps_.emplace_back(sliced.domain, c);
}

SliceValues::Value SliceValues::at(const Coordinates& x) const {
  std::array<float, kChannels> f{};
  const auto row = std::span(f).first(channels_);
  evaluator_.evaluate_at(x, row);
  shares_.add(row);
  Value v;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const std::size_t from = std::min(c, channels_ - 1);
    v[c] = maps_[from].forward(static_cast<double>(f[from]));
  }
  return v;
}

AtlasDomain domain_of(const SlicedBrdf& sliced, const Lattice& lattice) {
  AtlasDomain domain;
  const std::size_t channels = sliced.channel_count();
  const ValueMap<float> map(sliced, lattice);
  domain.log = sliced.domain.kind == DomainKind::kLog;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const std::size_t from = std::min(c, channels - 1);
    domain.least[c] = map.least(from);
    domain.most[c] = map.most(from);
    if (sliced.grey_shares.active()) domain.grey_shares[c] = sliced.grey_shares.shares()[from];
    if (!domain.log) continue;
    const DomainMap<float> values(sliced.domain, from);
    domain.reference[c] = sliced.domain.reference[from];
    domain.floor[c] = sliced.domain.floor(from);
    domain.at_floor[c] = values.forward(domain.floor[c]);
    domain.at_zero[c] = values.forward(0);
  }
  if (sliced.grey_shares.active()) {
    domain.grey_divisor = kChannels;
    for (const float share : domain.grey_shares) domain.grey_divisor += share;
  }
  return domain;
}

Status check_atlas_channels(std::size_t channels) {
  if (channels == 1 || channels == 3) return ok_status();
  return unsupported("textures hold three channels, and this material has " + std::to_string(channels));
}

}  // namespace sbrdf::internal
