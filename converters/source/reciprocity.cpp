#include "converters/source/reciprocity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sbrdf::internal {
namespace {

constexpr std::size_t kBlock = 256;  // pairs that are turned round at a time, on the stack

// Calls `visit(exchanged, first)` for blocks of pairs, turned round, the first of which is pair `first`.
template <class Visit>
void for_exchanged(std::span<const DirectionPair> pairs, const Visit& visit) {
  std::array<DirectionPair, kBlock> exchanged;
  for (std::size_t first = 0; first < pairs.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, pairs.size() - first);
    for (std::size_t k = 0; k < count; ++k) exchanged[k] = {pairs[first + k].v, pairs[first + k].i};
    visit(std::span<const DirectionPair>(exchanged).first(count), first);
  }
}

void evaluate_exchanged(const BrdfSource& source, std::span<const DirectionPair> pairs, std::span<float> values) {
  const std::size_t channels = source.channel_count();
  for_exchanged(pairs, [&](std::span<const DirectionPair> exchanged, std::size_t first) {
    source.evaluate(exchanged, values.subspan(first * channels, exchanged.size() * channels));
  });
}

std::vector<std::uint8_t> measured_exchanged(const BrdfSource& source, std::span<const DirectionPair> pairs) {
  std::vector<std::uint8_t> flags(pairs.size());
  for_exchanged(pairs, [&](std::span<const DirectionPair> exchanged, std::size_t first) {
    source.measured(exchanged, std::span(flags).subspan(first, exchanged.size()));
  });
  return flags;
}

}  // namespace

SymmetrisedSource::SymmetrisedSource(const BrdfSource& source) : source_(source), traits_(source.traits()) {
  traits_.reciprocal = true;
}

void SymmetrisedSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  source_.evaluate(pairs, values);
  std::vector<float> exchanged(values.size());
  evaluate_exchanged(source_, pairs, exchanged);
  if (!source_.mask_grid()) {
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = 0.5F * (values[k] + exchanged[k]);
    return;
  }
  std::vector<std::uint8_t> there(pairs.size());
  source_.measured(pairs, there);
  const std::vector<std::uint8_t> back = measured_exchanged(source_, pairs);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::size_t pair = k / channel_count();
    if (there[pair] == back[pair]) {
      values[k] = 0.5F * (values[k] + exchanged[k]);
    } else if (back[pair] == 1) {
      values[k] = exchanged[k];
    }
  }
}

void SymmetrisedSource::measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const {
  source_.measured(pairs, flags);
  const std::vector<std::uint8_t> back = measured_exchanged(source_, pairs);
  for (std::size_t k = 0; k < flags.size(); ++k) flags[k] = std::max(flags[k], back[k]);
}

double reciprocity_difference_percent(const BrdfSource& source) {
  if (source.traits().reciprocal) return 0;
  constexpr int kThetaStep = 5;
  constexpr int kPhiStep = 10;
  std::vector<DirectionPair> pairs;
  for (int theta_i = 0; theta_i <= 80; theta_i += kThetaStep) {
    for (int theta_v = 0; theta_v <= theta_i; theta_v += kThetaStep) {
      for (int phi_i = 0; phi_i < (source.traits().isotropic ? kPhiStep : 360); phi_i += kPhiStep) {
        for (int phi_v = 0; phi_v < 360; phi_v += kPhiStep) {
          pairs.push_back({direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)});
        }
      }
    }
  }
  std::vector<float> there(pairs.size() * source.channel_count());
  std::vector<float> back(there.size());
  source.evaluate(pairs, there);
  evaluate_exchanged(source, pairs, back);
  double difference = 0;
  double sum = 0;
  for (std::size_t k = 0; k < there.size(); ++k) {
    difference += std::abs(static_cast<double>(there[k]) - back[k]);
    sum += 0.5 * (std::abs(static_cast<double>(there[k])) + std::abs(static_cast<double>(back[k])));
  }
  return sum > 0 ? 100 * difference / sum : 0;
}

}  // namespace sbrdf::internal
