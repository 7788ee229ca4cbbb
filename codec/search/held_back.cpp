#include "codec/search/held_back.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "codec/search/random_pairs.h"

namespace sbrdf::internal {
namespace {

// Strata by theta_h [degrees] and the share of the pairs drawn in each.
constexpr std::array<double, 7> kEdges = {0, 1, 2, 4, 8, 16, 91};
constexpr std::array<double, 6> kShares = {0.12, 0.12, 0.14, 0.16, 0.16, 0.30};
constexpr std::uint64_t kMaxDraws = 4'000'000;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

std::size_t stratum_of(const DirectionPair& pair) {
  const double theta_h = degrees_from_radians(half_difference_from_pair(pair).theta_h);
  std::size_t stratum = 0;
  while (stratum + 1 < kShares.size() && theta_h >= kEdges[stratum + 1]) ++stratum;
  return stratum;
}

// Those that stay weigh 1 together again.
void keep_measured(const HeldBackDraw& draw, HeldBack& held_back) {
  if (!draw.measured) return;
  std::vector<std::uint8_t> flags(held_back.pairs.size());
  draw.measured(held_back.pairs, flags);
  HeldBack kept;
  double total = 0;
  for (std::size_t k = 0; k < flags.size(); ++k) {
    if (flags[k] == 0) continue;
    kept.pairs.push_back(held_back.pairs[k]);
    kept.weights.push_back(held_back.weights[k]);
    total += held_back.weights[k];
  }
  for (double& weight : kept.weights) weight /= total;
  held_back = std::move(kept);
}

// What every draw ends with.
Result<HeldBack> measured_draw(const HeldBackDraw& draw, std::size_t channel_count, const Measure& measure,
                               HeldBack held_back) {
  keep_measured(draw, held_back);
  held_back.values.resize(held_back.pairs.size() * channel_count);
  if (Status status = measure(held_back.pairs, held_back.values); !status) return status.error();
  return held_back;
}

}  // namespace

Result<HeldBack> draw_held_back(const HeldBackDraw& draw, std::size_t channel_count, const Measure& measure) {
  std::mt19937_64 random(draw.seed);
  std::array<std::size_t, kShares.size()> wanted{};
  std::array<std::size_t, kShares.size()> kept{};
  std::array<std::size_t, kShares.size()> seen{};
  std::size_t missing = 0;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    wanted[k] = static_cast<std::size_t>(kShares[k] * static_cast<double>(draw.count));
    missing += wanted[k];
  }
  HeldBack held_back;
  std::vector<std::size_t> strata;
  std::uint64_t draws = 0;
  for (; missing > 0 && draws < kMaxDraws; ++draws) {
    const double theta_i = draw_uniform(random, draw.theta_max_deg);
    const double theta_v = draw_uniform(random, draw.theta_max_deg);
    const double phi_i = draw_uniform(random, 360);
    const DirectionPair pair = {direction_from_degrees(theta_i, phi_i),
                                direction_from_degrees(theta_v, draw.isotropic ? 0 : draw_uniform(random, 360))};
    const std::size_t stratum = stratum_of(pair);
    ++seen[stratum];
    if (kept[stratum] == wanted[stratum]) continue;
    ++kept[stratum];
    --missing;
    held_back.pairs.push_back(pair);
    strata.push_back(stratum);
  }
  for (const std::size_t stratum : strata) {
    held_back.weights.push_back(static_cast<double>(seen[stratum]) / static_cast<double>(draws) /
                                static_cast<double>(kept[stratum]));
  }
  return measured_draw(draw, channel_count, measure, std::move(held_back));
}

Result<HeldBack> draw_for_fit(const HeldBackDraw& draw, std::size_t channel_count, const Measure& measure) {
  std::mt19937_64 random(draw.seed);
  const HighlightDraw highlights(draw.theta_max_deg);
  HeldBack held_back;
  double total = 0;
  for (std::size_t k = 0; k < draw.count; ++k) {
    WeightedPair drawn = highlights(random);
    if (draw.isotropic) {
      drawn.pair.i.phi -= drawn.pair.v.phi;
      drawn.pair.v.phi = 0;
    }
    held_back.pairs.push_back(drawn.pair);
    held_back.weights.push_back(drawn.weight);
    total += drawn.weight;
  }
  for (double& weight : held_back.weights) weight /= total;
  return measured_draw(draw, channel_count, measure, std::move(held_back));
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

HeldBackError judge(const Evaluator& evaluator, const HeldBack& held_back) {
  const std::size_t channels = evaluator.channel_count();
  const double floor = mre_floor(held_back);
  const double total = 100 * floor * static_cast<double>(channels);
  double difference = 0;
  double relative = 0;
  std::vector<float> values(channels);
  for (std::size_t k = 0; k < held_back.pairs.size(); ++k) {
    evaluator.evaluate(held_back.pairs[k], values);
    for (std::size_t c = 0; c < channels; ++c) {
      const double f = held_back.values[k * channels + c];
      const double distance = std::abs(values[c] - f);
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
