#include "codec/search/held_back.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "codec/search/random_pairs.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// So many pairs are looked at for each that is kept.
constexpr std::size_t kSeenPerKept = 4;
// Which are kept: by what they weigh times how large the source is there, by what they weigh, and evenly. The first is
// best for the relative L1 error and the second for the mean relative one, where relative errors are alike everywhere;
// since they are not, the third keeps pairs near all highlights, however faint.
constexpr double kByValue = 0.4;
constexpr double kByWeight = 0.3;
constexpr std::size_t kBlock = 1024;  // pairs that one task makes or asks for

void keep(const std::vector<std::uint8_t>& flags, std::size_t channel_count, HeldBack& held_back) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < flags.size(); ++k) {
    if (flags[k] == 0) continue;
    held_back.pairs[kept] = held_back.pairs[k];
    held_back.weights[kept] = held_back.weights[k];
    if (!held_back.values.empty()) {
      std::copy_n(held_back.values.begin() + static_cast<std::ptrdiff_t>(k * channel_count), channel_count,
                  held_back.values.begin() + static_cast<std::ptrdiff_t>(kept * channel_count));
    }
    ++kept;
  }
  held_back.pairs.resize(kept);
  held_back.weights.resize(kept);
  if (!held_back.values.empty()) held_back.values.resize(kept * channel_count);
}

// Before any is thinned out, without values.
HeldBack draw_pairs(const HeldBackDraw& draw, std::mt19937_64& random) {
  const HighlightDraw highlights(draw.theta_max_deg);
  std::vector<HighlightDraw::Numbers> numbers(kSeenPerKept * draw.count);
  for (HighlightDraw::Numbers& each : numbers) each = HighlightDraw::draw_numbers(random);
  HeldBack drawn;
  drawn.pairs.resize(numbers.size());
  drawn.weights.resize(numbers.size());
  for_all(numbers.size(), kBlock, [&](std::size_t k) {
    WeightedPair weighted = highlights(numbers[k]);
    if (draw.isotropic) {
      weighted.pair.i.phi -= weighted.pair.v.phi;
      weighted.pair.v.phi = 0;
    }
    drawn.pairs[k] = weighted.pair;
    drawn.weights[k] = weighted.weight;
  });
  return drawn;
}

void keep_measured(const HeldBackDraw& draw, HeldBack& held_back) {
  if (!draw.measured) return;
  std::vector<std::uint8_t> flags(held_back.pairs.size());
  draw.measured(held_back.pairs, flags);
  keep(flags, 0, held_back);
}

// The mean of |f| over the channels of each pair.
std::vector<double> magnitudes(const HeldBack& held_back, std::size_t channel_count) {
  std::vector<double> sizes(held_back.pairs.size());
  for (std::size_t k = 0; k < held_back.values.size(); ++k) {
    sizes[k / channel_count] += std::abs(static_cast<double>(held_back.values[k])) / static_cast<double>(channel_count);
  }
  return sizes;
}

// How likely each is kept, adding up to `count` where none is certain; what is certain stands at 1.
std::vector<double> chances(const HeldBack& held_back, std::size_t channel_count, double count) {
  const std::vector<double> sizes = magnitudes(held_back, channel_count);
  const double weight = std::accumulate(held_back.weights.begin(), held_back.weights.end(), 0.0);
  const double value = std::inner_product(held_back.weights.begin(), held_back.weights.end(), sizes.begin(), 0.0);
  const double by_value = value > 0 ? kByValue / value : 0;
  const double by_weight = (value > 0 ? kByWeight : kByWeight + kByValue) / weight;
  const double evenly = (1 - kByValue - kByWeight) / static_cast<double>(sizes.size());
  std::vector<double> result(sizes.size());
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    result[k] = std::min(1.0, count * (held_back.weights[k] * (by_value * sizes[k] + by_weight) + evenly));
  }
  return result;
}

// Systematic sampling: a pair is kept where the sum of the chances passes another whole number.
void thin(std::size_t count, std::size_t channel_count, std::mt19937_64& random, HeldBack& held_back) {
  if (held_back.pairs.size() <= count) return;
  const std::vector<double> chance = chances(held_back, channel_count, static_cast<double>(count));
  std::vector<std::uint8_t> flags(chance.size());
  double sum = draw_uniform(random, 1);
  for (std::size_t k = 0; k < chance.size(); ++k) {
    const double before = std::floor(sum);
    sum += chance[k];
    if (std::floor(sum) == before) continue;
    flags[k] = 1;
    held_back.weights[k] /= chance[k];
  }
  keep(flags, channel_count, held_back);
}

void normalise(HeldBack& held_back) {
  const double total = std::accumulate(held_back.weights.begin(), held_back.weights.end(), 0.0);
  for (double& weight : held_back.weights) weight /= total;
}

}  // namespace

Result<HeldBack> draw_held_back(const HeldBackDraw& draw, std::size_t channel_count, const Measure& measure) {
  std::mt19937_64 random(draw.seed);
  HeldBack held_back = draw_pairs(draw, random);
  keep_measured(draw, held_back);
  held_back.values.resize(held_back.pairs.size() * channel_count);
  if (Status status = measure(held_back.pairs, held_back.values); !status) return status.error();
  thin(draw.count, channel_count, random, held_back);
  normalise(held_back);
  return held_back;
}

HeldBack first_of(const HeldBack& held_back, std::size_t count) {
  if (count >= held_back.pairs.size()) return held_back;
  const std::size_t channels = held_back.values.size() / held_back.pairs.size();
  HeldBack first = held_back;
  first.pairs.resize(count);
  first.weights.resize(count);
  first.values.resize(count * channels);
  normalise(first);
  return first;
}

bool all_zero(const HeldBack& held_back) {
  return std::all_of(held_back.values.begin(), held_back.values.end(), [](float f) { return f == 0; });
}

double mre_floor(const HeldBack& held_back) {
  const std::size_t channels = held_back.values.size() / std::max<std::size_t>(1, held_back.pairs.size());
  double total = 0;
  for (std::size_t k = 0; k < held_back.values.size(); ++k) {
    total += held_back.weights[k / channels] * std::abs(static_cast<double>(held_back.values[k]));
  }
  return 0.01 * total / static_cast<double>(channels);
}

std::vector<float> evaluate(const Evaluator& evaluator, std::span<const DirectionPair> pairs) {
  const std::size_t channels = evaluator.channel_count();
  std::vector<float> values(pairs.size() * channels);
  for_all(pairs.size(), kBlock,
          [&](std::size_t k) { evaluator.evaluate(pairs[k], std::span(values).subspan(k * channels, channels)); });
  return values;
}

HeldBackError judge(const Evaluator& evaluator, const HeldBack& held_back) {
  return judge(evaluate(evaluator, held_back.pairs), held_back);
}

HeldBackError judge(std::span<const float> values, const HeldBack& held_back) {
  const std::size_t channels = values.size() / std::max<std::size_t>(1, held_back.pairs.size());
  const double floor = mre_floor(held_back);
  const double total = 100 * floor * static_cast<double>(channels);
  double difference = 0;
  double relative = 0;
  for (std::size_t k = 0; k < held_back.pairs.size(); ++k) {
    for (std::size_t c = 0; c < channels; ++c) {
      const double f = held_back.values[k * channels + c];
      const double distance = std::abs(values[k * channels + c] - f);
      const double error = held_back.weights[k] * (std::isnan(distance) ? kInfinite : distance);
      difference += error;
      if (error > 0) relative += error / std::max(std::abs(f), floor);
    }
  }
  HeldBackError result;
  result.mre_percent = 100 * relative / static_cast<double>(channels);
  result.rel_l1_percent = difference > 0 ? 100 * difference / total : 0;
  return result;
}

}  // namespace sbrdf::internal
