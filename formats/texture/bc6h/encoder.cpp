#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <vector>

#include "formats/texture/bc6h/bc6h.h"
#include "formats/texture/bc6h/line_fit.h"
#include "formats/texture/bc6h/region.h"
#include "formats/texture/bc6h/trial.h"

namespace sbrdf::internal {

namespace {

constexpr std::uint8_t kTwoRegionModes = 10;  // that many come first
static_assert(kTwoRegionModes < kBc6hModeCount);
constexpr std::uint16_t kLargestHalf = 0x7BFF;
constexpr std::uint16_t kInfinity = 0x7C00;

// How far a search goes.
struct Effort {
  std::size_t partitions = 0;      // that are looked at
  std::size_t kept = 0;            // of all trials, to be refitted
  std::size_t lined = 0;           // of these, to try other lines in
  float worth_lines = 0;           // but not where the error is more than so many times that of the best trial
  std::size_t lines = 0;           // so many for each region
  std::size_t polished_lines = 0;  // of these
  std::size_t polished = 0;        // trials, in the end
};
constexpr Effort kFastEffort = {
    .partitions = 3, .kept = 3, .lined = 1, .worth_lines = 1, .lines = 28, .polished_lines = 1, .polished = 2};
constexpr Effort kThoroughEffort = {.partitions = kBc6hPartitionCount,
                                    .kept = 12,
                                    .lined = 12,
                                    .worth_lines = 12,
                                    .lines = 28,
                                    .polished_lines = 4,
                                    .polished = 12};
constexpr int kMostRefits = 4;

bool is_better(const Bc6hTrial& a, const Bc6hTrial& b) { return a.error() < b.error(); }

std::uint16_t representable(std::uint16_t half, bool is_signed) {
  const std::uint16_t size = half & 0x7FFFU;
  if (size > kInfinity) return 0;
  if ((half & 0x8000U) != 0 && !is_signed) return 0;
  return static_cast<std::uint16_t>((half & 0x8000U) | std::min(size, kLargestHalf));
}

// A block, and the best ways to encode it so far.
class Search {
 public:
  Search(const Bc6hTexels& texels, const std::array<float, 16>& weights, const Bc6hOptions& options)
      : options_(options),
        effort_(options.speed == Bc6hSpeed::kFast ? kFastEffort : kThoroughEffort),
        whole_(make_bc6h_region(texels, weights, options)) {}

  Bc6hBytes best() {
    try_one_region();
    if (!done()) try_two_regions();
    if (!done()) improve();
    const Bc6hTrial& best = *std::min_element(trials_.begin(), trials_.end(), is_better);
    return emit_bc6h_trial(regions_of(best), options_, best);
  }

 private:
  [[nodiscard]] bool done() const { return trials_.front().error() == 0; }

  [[nodiscard]] std::span<const Bc6hRegion> regions_of(const Bc6hTrial& trial) const {
    if (kBc6hModes[trial.mode].region_count == 1) return {&whole_, 1};
    return parts_[trial.partition];
  }

  void keep(const Bc6hTrial& trial) {
    const auto at = std::upper_bound(trials_.begin(), trials_.end(), trial, is_better);
    if (at == trials_.end() && trials_.size() == effort_.kept) return;
    trials_.insert(at, trial);
    if (trials_.size() > effort_.kept) trials_.pop_back();
  }

  void try_lines(Bc6hTrial& trial) const {
    const std::span<const Bc6hRegion> regions = regions_of(trial);
    std::vector<Bc6hLine> lines(effort_.lines);
    for (std::size_t k = 0; k < regions.size(); ++k) {
      fit_bc6h_lines(regions[k], kBc6hModes[trial.mode].index_count(), lines);
      try_bc6h_lines(regions, lines, k, options_, effort_.polished_lines, trial);
    }
  }

  void try_one_region() {
    whole_line_ = fit_bc6h_line(whole_, 16);
    for (std::uint8_t mode = kTwoRegionModes; mode < kBc6hModeCount; ++mode) {
      keep(make_bc6h_trial({&whole_, 1}, {&whole_line_, 1}, mode, 0, options_));
    }
  }

  void try_two_regions() {
    const std::array<float, kBc6hPartitionCount> ratings = rate_bc6h_partitions(whole_);
    std::array<std::uint8_t, kBc6hPartitionCount> order{};
    std::iota(order.begin(), order.end(), std::uint8_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint8_t a, std::uint8_t b) { return ratings[a] < ratings[b]; });
    for (std::size_t k = 0; k < effort_.partitions; ++k) try_partition(order[k]);
  }

  void try_partition(std::uint8_t partition) {
    parts_[partition] = split_bc6h_region(whole_, partition);
    std::array<Bc6hLine, 2> lines;
    for (std::size_t k = 0; k < 2; ++k) {
      const Bc6hRegion& part = parts_[partition][k];
      const bool seen = std::any_of(part.weight.begin(), part.weight.end(), [](float weight) { return weight > 0; });
      lines[k] = seen ? fit_bc6h_line(part, 8) : whole_line_;
    }
    const auto stretched = stretched_bc6h_lines(parts_[partition][0], lines[0], 8);
    for (std::uint8_t mode = 0; mode < kTwoRegionModes; ++mode) {
      Bc6hTrial best = make_bc6h_trial(parts_[partition], lines, mode, partition, options_);
      if (best.wants_other_start) {
        for (const Bc6hLine& line : stretched) {
          const std::array<Bc6hLine, 2> others = {line, lines[1]};
          best = std::min(best, make_bc6h_trial(parts_[partition], others, mode, partition, options_), is_better);
        }
      }
      keep(best);
    }
  }

  void improve() {
    for (Bc6hTrial& trial : trials_) refit_bc6h_trial(regions_of(trial), options_, kMostRefits, trial);
    std::stable_sort(trials_.begin(), trials_.end(), is_better);
    const float worth = effort_.worth_lines * trials_.front().error();
    for (std::size_t k = 0; k < std::min(trials_.size(), effort_.lined); ++k) {
      if (trials_[k].error() <= worth) try_lines(trials_[k]);
    }
    for (std::size_t k = 0; k < std::min(trials_.size(), effort_.polished); ++k) {
      polish_bc6h_trial(regions_of(trials_[k]), options_, trials_[k]);
    }
  }

  Bc6hOptions options_;
  Effort effort_;
  Bc6hRegion whole_;
  Bc6hLine whole_line_;
  std::array<std::array<Bc6hRegion, 2>, kBc6hPartitionCount> parts_;
  std::vector<Bc6hTrial> trials_;  // the best first
};

}  // namespace

Bc6hBytes encode_bc6h_block(const Bc6hTexels& texels, const std::array<float, 16>& weights,
                            const Bc6hOptions& options) {
  Bc6hTexels sound = texels;
  for (auto& texel : sound) {
    for (std::uint16_t& half : texel) half = representable(half, options.is_signed);
  }
  return Search(sound, weights, options).best();
}

Bc6hBytes encode_bc6h_block(const Bc6hTexels& texels, const Bc6hOptions& options) {
  std::array<float, 16> weights{};
  weights.fill(1);
  return encode_bc6h_block(texels, weights, options);
}

}  // namespace sbrdf::internal
