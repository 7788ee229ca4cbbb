#include "converters/compare.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "converters/reciprocity.h"

namespace sbrdf {
namespace {

constexpr std::uint64_t kBlock = 4096;  // pairs that one task evaluates
constexpr double kMinStep = 0.1;
constexpr std::uint64_t kMostPairs = 1ULL << 36U;  // a day's work, and the largest table of partial sums that is sane

struct Sums {
  double relative = 0;
  double difference = 0;
  double reference = 0;
  double squares = 0;
  double max_difference = 0;
  double max_reference = 0;
  std::uint64_t relative_count = 0;
  std::uint64_t count = 0;

  void add(double f, double r, double floor) {
    const double d = std::abs(f - r);
    const double denominator = std::max(std::abs(f), floor);
    if (denominator != 0) {  // a NaN is let through, here and below, so that it shows
      relative += d / denominator;
      ++relative_count;
    }
    difference += d;
    reference += std::abs(f);
    squares += d * d;
    if (d > max_difference || std::isnan(d)) max_difference = d;
    max_reference = std::max(max_reference, std::abs(f));
    ++count;
  }
  void add(const Sums& other) {
    relative += other.relative;
    difference += other.difference;
    reference += other.reference;
    squares += other.squares;
    if (other.max_difference > max_difference || std::isnan(other.max_difference))
      max_difference = other.max_difference;
    max_reference = std::max(max_reference, other.max_reference);
    relative_count += other.relative_count;
    count += other.count;
  }
};

/// The pairs of the grid by number: phi_v fastest, then phi_i, theta_v, theta_i.
class Grid {
 public:
  Grid(const CompareOptions& options, bool isotropic) {
    const auto thetas = static_cast<std::uint64_t>(std::floor(options.theta_max_deg / options.step_deg + 1e-9)) + 1;
    const auto phis = static_cast<std::uint64_t>(std::floor(360 / options.step_deg - 1e-9)) + 1;
    theta_count_ = thetas;
    phi_i_count_ = phis;
    phi_v_count_ = isotropic ? 1 : phis;
    grid_size_ = thetas * thetas * phis * phis;
    for (std::uint64_t k = 0; k < thetas; ++k) thetas_.push_back(static_cast<double>(k) * options.step_deg);
    for (std::uint64_t k = 0; k < phis; ++k)
      phis_.push_back(direction_from_degrees(0, static_cast<double>(k) * options.step_deg).phi);
    for (double& theta : thetas_) theta = direction_from_degrees(theta, 0).theta;
  }
  [[nodiscard]] std::uint64_t size() const { return theta_count_ * theta_count_ * phi_i_count_ * phi_v_count_; }
  [[nodiscard]] std::uint64_t grid_size() const { return grid_size_; }
  [[nodiscard]] DirectionPair operator[](std::uint64_t k) const {
    const std::uint64_t phi_v = k % phi_v_count_;
    k /= phi_v_count_;
    const std::uint64_t phi_i = k % phi_i_count_;
    k /= phi_i_count_;
    return {{thetas_[k / theta_count_], phis_[phi_i]}, {thetas_[k % theta_count_], phis_[phi_v]}};
  }

 private:
  std::vector<double> thetas_;
  std::vector<double> phis_;
  std::uint64_t theta_count_ = 0;
  std::uint64_t phi_i_count_ = 0;
  std::uint64_t phi_v_count_ = 0;
  std::uint64_t grid_size_ = 0;
};

// Each block has its own generator, so that the pairs do not depend on which thread draws them.
void fill_block(const Grid& grid, const CompareOptions& options, std::uint64_t block, std::span<DirectionPair> pairs) {
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
  const auto usage = [](const char* what) { return Error{ErrorCode::kUsage, what, {}}; };
  if (!(options.step_deg >= kMinStep && options.step_deg <= 90)) return usage("the step must be in [0.1, 90] degrees");
  if (!(options.theta_max_deg >= 0 && options.theta_max_deg <= 90))
    return usage("theta-max must be in [0, 90] degrees");
  if (!(options.floor >= 0 && std::isfinite(options.floor))) return usage("the floor must be finite and not negative");
  if (reference.channel_count() != test.channel_count()) {
    return Error{ErrorCode::kUnsupported,
                 "the reference has " + std::to_string(reference.channel_count()) + " channels, the test " +
                     std::to_string(test.channel_count()),
                 {}};
  }
  return ok_status();
}

Comparison summarise(const Sums& sums) {
  Comparison result;
  const auto count = static_cast<double>(sums.count);
  result.mre_percent = sums.relative_count > 0 ? 100 * sums.relative / static_cast<double>(sums.relative_count)
                                               : std::numeric_limits<double>::quiet_NaN();
  result.rel_l1_percent = sums.difference == 0 ? 0 : 100 * sums.difference / sums.reference;
  result.rmse = std::sqrt(sums.squares / count);
  result.max_abs = sums.max_difference;
  result.psnr_db =
      result.rmse == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(sums.max_reference / result.rmse);
  result.mre_values = sums.relative_count;
  result.mre_left_out = sums.count - sums.relative_count;
  return result;
}

}  // namespace

Result<Comparison> compare_sources(const BrdfSource& reference, const BrdfSource& test, const CompareOptions& options,
                                   const Progress& progress) {
  if (Status status = check(reference, test, options); !status) return status.error();
  std::optional<SymmetrisedSource> symmetrised;
  if (options.symmetrise) symmetrised.emplace(reference);
  const BrdfSource& judge = symmetrised ? static_cast<const BrdfSource&>(*symmetrised) : reference;
  // Only where whole steps make a turn does every phi_v see the same azimuth differences.
  const bool closed = std::abs(360 / options.step_deg - std::round(360 / options.step_deg)) < 1e-9;
  const Grid grid(options, closed && reference.traits().isotropic && test.traits().isotropic);
  const std::uint64_t total = options.random_count > 0 ? options.random_count : grid.size();
  if (total > kMostPairs) {
    return Error{ErrorCode::kUsage, std::to_string(total) + " direction pairs are too many; take a larger step", {}};
  }
  const std::uint64_t blocks = (total + kBlock - 1) / kBlock;
  std::vector<Sums> sums(blocks);
  ProgressCounter counter(progress, blocks);
  tbb::parallel_for(std::uint64_t{0}, blocks, [&](std::uint64_t block) {
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
  Sums all;
  for (const Sums& block : sums) all.add(block);
  Comparison result = summarise(all);
  result.directions = total;
  result.grid_directions = options.random_count > 0 ? total : grid.grid_size();
  return result;
}

}  // namespace sbrdf
