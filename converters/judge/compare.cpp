#include "converters/judge/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "converters/source/reciprocity.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kBlock = 4096;  // pairs that one task evaluates
constexpr double kMinStep = 0.1;
constexpr std::uint64_t kMostPairs = 1ULL << 36U;  // a day's work, and the largest table of partial sums that is sane

// Each block has its own generator, so that the pairs do not depend on which thread draws them.
void fill_block(const DirectionGrid& grid, const CompareOptions& options, std::uint64_t block,
                std::span<DirectionPair> pairs) {
  if (options.random_count == 0) {
    for (std::uint64_t k = 0; k < pairs.size(); ++k) pairs[k] = grid[block * kBlock + k];
    return;
  }
  std::seed_seq seeds{options.seed & 0xFFFFFFFFU, options.seed >> 32U, block};
  std::mt19937_64 random(seeds);
  // Not uniform_int_distribution, which differs between standard libraries. The bias is below 2^-30.
  for (DirectionPair& pair : pairs) pair = grid[random() % grid.size()];
}

Status check(const BrdfSource& reference, const BrdfSource& test, const CompareOptions& options) {
  const auto usage = [](const char* what) { return usage_error(what); };
  if (!(options.step_deg >= kMinStep && options.step_deg <= 90)) return usage("the step must be in [0.1, 90] degrees");
  if (!(options.theta_max_deg >= 0 && options.theta_max_deg <= 90))
    return usage("theta-max must be in [0, 90] degrees");
  if (!(options.floor >= 0 && std::isfinite(options.floor))) return usage("the floor must be finite and not negative");
  if (reference.channel_count() != test.channel_count()) {
    return unsupported("the reference has " + std::to_string(reference.channel_count()) + " channels, the test " +
                       std::to_string(test.channel_count()));
  }
  return ok_status();
}

}  // namespace

void ErrorSums::add(double f, double r, double floor) {
  const double d = std::abs(f - r);
  const double denominator = std::max(std::abs(f), floor);
  if (denominator != 0) {  // a NaN is let through, here and below, so that it shows
    relative_ += d / denominator;
    ++relative_count_;
  }
  difference_ += d;
  reference_ += std::abs(f);
  squares_ += d * d;
  if (d > max_difference_ || std::isnan(d)) max_difference_ = d;
  max_reference_ = std::max(max_reference_, std::abs(f));
  ++count_;
}

void ErrorSums::add(const ErrorSums& other) {
  relative_ += other.relative_;
  difference_ += other.difference_;
  reference_ += other.reference_;
  squares_ += other.squares_;
  if (other.max_difference_ > max_difference_ || std::isnan(other.max_difference_)) {
    max_difference_ = other.max_difference_;
  }
  max_reference_ = std::max(max_reference_, other.max_reference_);
  relative_count_ += other.relative_count_;
  count_ += other.count_;
}

Comparison ErrorSums::summary() const {
  Comparison result;
  const auto count = static_cast<double>(count_);
  result.mre_percent = relative_count_ > 0 ? 100 * relative_ / static_cast<double>(relative_count_)
                                           : std::numeric_limits<double>::quiet_NaN();
  result.rel_l1_percent = difference_ == 0 ? 0 : 100 * difference_ / reference_;
  result.rmse = std::sqrt(squares_ / count);
  result.max_abs = max_difference_;
  result.psnr_db =
      result.rmse == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(max_reference_ / result.rmse);
  result.mre_values = relative_count_;
  result.mre_left_out = count_ - relative_count_;
  return result;
}

DirectionGrid::DirectionGrid(double step_deg, double theta_max_deg, bool isotropic) {
  const auto thetas = static_cast<std::uint64_t>(std::floor(theta_max_deg / step_deg + 1e-9)) + 1;
  const auto phis = static_cast<std::uint64_t>(std::floor(360 / step_deg - 1e-9)) + 1;
  for (std::uint64_t k = 0; k < thetas; ++k) {
    thetas_.push_back(direction_from_degrees(static_cast<double>(k) * step_deg, 0).theta);
  }
  for (std::uint64_t k = 0; k < phis; ++k) {
    phis_.push_back(direction_from_degrees(0, static_cast<double>(k) * step_deg).phi);
  }
  phi_v_count_ = isotropic ? 1 : phis;
}

DirectionPair DirectionGrid::operator[](std::uint64_t k) const {
  const std::uint64_t phi_v = k % phi_v_count_;
  k /= phi_v_count_;
  const std::uint64_t phi_i = k % phis_.size();
  k /= phis_.size();
  return at(k / thetas_.size(), phi_i, k % thetas_.size(), phi_v);
}

Result<Comparison> compare_sources(const BrdfSource& reference, const BrdfSource& test, const CompareOptions& options,
                                   const Progress& progress) {
  if (Status status = check(reference, test, options); !status) return status.error();
  std::optional<SymmetrisedSource> symmetrised;
  if (options.symmetrise) symmetrised.emplace(reference);
  const BrdfSource& judge = symmetrised ? static_cast<const BrdfSource&>(*symmetrised) : reference;
  // Only where whole steps make a turn does every phi_v see the same azimuth differences.
  const bool closed = std::abs(360 / options.step_deg - std::round(360 / options.step_deg)) < 1e-9;
  const DirectionGrid grid(options.step_deg, options.theta_max_deg,
                           closed && reference.traits().isotropic && test.traits().isotropic);
  const std::uint64_t total = options.random_count > 0 ? options.random_count : grid.size();
  if (total > kMostPairs) {
    return usage_error(std::to_string(total) + " direction pairs are too many; take a larger step");
  }
  const std::uint64_t blocks = (total + kBlock - 1) / kBlock;
  std::vector<ErrorSums> sums(blocks);
  ProgressCounter counter(progress, blocks);
  parallel_for(blocks, [&](std::uint64_t block) {
    if (counter.stopped()) return;
    std::vector<DirectionPair> pairs(std::min(kBlock, total - block * kBlock));
    fill_block(grid, options, block, pairs);
    std::vector<float> f(pairs.size() * judge.channel_count());
    std::vector<float> r(f.size());
    judge.evaluate(pairs, f);
    test.evaluate(pairs, r);
    for (std::size_t k = 0; k < f.size(); ++k) sums[block].add(f[k], r[k], options.floor);
    counter.advance();
  });
  if (counter.stopped()) return interrupted_error();
  ErrorSums all;
  for (const ErrorSums& block : sums) all.add(block);
  Comparison result = all.summary();
  result.directions = total;
  result.grid_directions = options.random_count > 0 ? total : grid.whole_size();
  return result;
}

}  // namespace sbrdf::internal
