#include "converters/tables/resampling_error.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "codec/frame/frame.h"
#include "codec/search/random_pairs.h"
#include "converters/tables/dense_table.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kMost = 20000;
constexpr std::size_t kBlock = 256;

std::vector<WeightedPair> draw_pairs(const BrdfSource& source) {
  std::mt19937_64 random(7);
  std::vector<WeightedPair> pairs;
  if (const DenseTable* table = source.table()) {
    const auto total = static_cast<double>(table->grid.node_count());
    for (std::size_t k = 0; k < kMost; ++k) {
      const auto index = static_cast<std::uint64_t>(draw_uniform(random, total));
      const DirectionPair pair = table->grid.pair_of(table->grid.node(index));
      if (above_horizon(pair)) pairs.push_back({pair, 1});
    }
    return pairs;
  }
  const HighlightDraw draw(source.traits().slice_theta_max_deg);
  for (std::size_t k = 0; k < kMost; ++k) pairs.push_back(draw(random));
  return pairs;
}

void drop_unmeasured(const BrdfSource& source, std::vector<WeightedPair>& pairs) {
  if (!source.mask_grid()) return;
  std::vector<DirectionPair> plain(pairs.size());
  std::transform(pairs.begin(), pairs.end(), plain.begin(), [](const WeightedPair& p) { return p.pair; });
  std::vector<std::uint8_t> flags(plain.size());
  source.measured(plain, flags);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (flags[k] != 0) pairs[kept++] = pairs[k];
  }
  pairs.resize(kept);
}

std::vector<float> values_at(std::span<const DirectionPair> pairs, std::size_t channels,
                             const EvaluatePairs& evaluate) {
  std::vector<float> values(pairs.size() * channels);
  parallel_blocks(pairs.size(), kBlock, [&](std::size_t first, std::size_t size) {
    evaluate(pairs.subspan(first, size), std::span(values).subspan(first * channels, size * channels));
  });
  return values;
}

}  // namespace

ResamplingError resampling_error(const BrdfSource& source, const EvaluatePairs& evaluate) {
  std::vector<WeightedPair> drawn = draw_pairs(source);
  drop_unmeasured(source, drawn);
  ResamplingError result;
  result.at_nodes = source.table() != nullptr;
  result.directions = drawn.size();
  if (drawn.empty()) return result;
  std::vector<DirectionPair> pairs(drawn.size());
  std::transform(drawn.begin(), drawn.end(), pairs.begin(), [](const WeightedPair& p) { return p.pair; });
  const std::size_t channels = source.channel_count();
  const std::vector<float> f = values_at(pairs, channels, [&](auto p, auto v) { source.evaluate(p, v); });
  const std::vector<float> r = values_at(pairs, channels, evaluate);
  double mean = 0;
  double weights = 0;
  for (std::size_t n = 0; n < f.size(); ++n) {
    mean += drawn[n / channels].weight * std::abs(static_cast<double>(f[n]));
    weights += drawn[n / channels].weight;
  }
  ErrorSums sums(0.01 * mean / weights);
  for (std::size_t n = 0; n < f.size(); ++n) {
    const WeightedPair& at = drawn[n / channels];
    sums.add({at.pair, n % channels, f[n], r[n]}, at.weight, std::cos(at.pair.i.theta) * std::cos(at.pair.v.theta));
  }
  static_cast<ErrorFigures&>(result) = sums.figures();
  return result;
}

}  // namespace sbrdf::internal
