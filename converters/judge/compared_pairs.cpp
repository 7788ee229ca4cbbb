#include "converters/judge/compared_pairs.h"

#include <algorithm>
#include <cmath>

namespace sbrdf::internal {

DirectionGrid::DirectionGrid(double step_deg, double theta_max_deg, bool isotropic) {
  const auto thetas = static_cast<std::uint64_t>(std::floor(theta_max_deg / step_deg + 1e-9)) + 1;
  const auto phis = static_cast<std::uint64_t>(std::floor(360 / step_deg - 1e-9)) + 1;
  for (std::uint64_t k = 0; k < thetas; ++k) {
    thetas_.push_back(direction_from_degrees(static_cast<double>(k) * step_deg, 0).theta);
  }
  for (std::uint64_t k = 0; k < phis; ++k) {
    phis_.push_back(direction_from_degrees(0, static_cast<double>(k) * step_deg).phi);
  }
  // Only where whole steps make a turn does every phi_v see the same azimuth differences.
  const bool closed = std::abs(360 / step_deg - std::round(360 / step_deg)) < 1e-9;
  phi_v_count_ = closed && isotropic ? 1 : phis;
}

DirectionPair DirectionGrid::operator[](std::uint64_t k) const {
  const std::uint64_t phi_v = k % phi_v_count_;
  k /= phi_v_count_;
  const std::uint64_t phi_i = k % phis_.size();
  k /= phis_.size();
  return at(k / thetas_.size(), phi_i, k % thetas_.size(), phi_v);
}

ComparedPairs::ComparedPairs(const PairOptions& options, bool isotropic)
    : options_(options),
      grid_(options.step_deg, options.theta_max_deg, isotropic),
      highlight_(options.theta_max_deg),
      size_(options.random_count > 0 ? options.random_count : grid_.size()) {}

std::uint64_t ComparedPairs::stands_for() const { return options_.random_count > 0 ? size_ : grid_.whole_size(); }

std::vector<WeightedPair> ComparedPairs::block(std::uint64_t number) const {
  std::vector<WeightedPair> pairs(std::min(kBlock, size_ - number * kBlock));
  if (options_.random_count == 0) {
    for (std::uint64_t k = 0; k < pairs.size(); ++k) pairs[k].pair = grid_[number * kBlock + k];
    return pairs;
  }
  // Each block has its own generator, so that the pairs do not depend on which thread draws them.
  std::seed_seq seeds{options_.seed & 0xFFFFFFFFU, options_.seed >> 32U, number};
  std::mt19937_64 random(seeds);
  for (WeightedPair& pair : pairs) pair = draw(random);
  return pairs;
}

WeightedPair ComparedPairs::draw(std::mt19937_64& random) const {
  switch (options_.directions) {
    case CompareDirections::kHighlight:
      return highlight_(random);
    case CompareDirections::kRandom:
      return {draw_pair(random, options_.theta_max_deg)};
    case CompareDirections::kGrid:
      break;
  }
  // Not uniform_int_distribution, which differs between standard libraries. The bias is below 2^-30.
  return {grid_[random() % grid_.size()]};
}

}  // namespace sbrdf::internal
