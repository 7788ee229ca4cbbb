#pragma once

#include <cstdint>
#include <vector>

#include "codec/search/random_pairs.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {

/// The pairs of the grid by number: phi_v fastest, then phi_i, theta_v, theta_i. Isotropic: phi_v = 0 only.
class DirectionGrid {
 public:
  DirectionGrid(double step_deg, double theta_max_deg, bool isotropic);

  [[nodiscard]] std::uint64_t theta_count() const { return thetas_.size(); }
  [[nodiscard]] std::uint64_t phi_count() const { return phis_.size(); }
  [[nodiscard]] std::uint64_t size() const { return whole_size() / phis_.size() * phi_v_count_; }
  /// With every phi_v, isotropic or not.
  [[nodiscard]] std::uint64_t whole_size() const { return theta_count() * theta_count() * phi_count() * phi_count(); }
  [[nodiscard]] DirectionPair operator[](std::uint64_t k) const;
  /// By the number of each angle.
  [[nodiscard]] DirectionPair at(std::uint64_t theta_i, std::uint64_t phi_i, std::uint64_t theta_v,
                                 std::uint64_t phi_v) const {
    return {{thetas_[theta_i], phis_[phi_i]}, {thetas_[theta_v], phis_[phi_v]}};
  }

 private:
  std::vector<double> thetas_;
  std::vector<double> phis_;
  std::uint64_t phi_v_count_ = 0;
};

/// Which pairs a comparison goes over.
enum class CompareDirections : std::uint8_t {
  kGrid,       ///< theta in 0, step, ... theta_max; phi in 0, step, ... below 360, for i and for v
  kRandom,     ///< the uniform draw: between the nodes of the grid
  kHighlight,  ///< drawn densely around the mirror direction (HighlightDraw): the same means
};

struct PairOptions {
  CompareDirections directions = CompareDirections::kGrid;
  double step_deg = 2;  ///< of the grid
  double theta_max_deg = 80;
  std::uint64_t random_count = 0;  ///< of the grid: 0 for all of it, else random pairs of it; else how many are drawn
  std::uint64_t seed = 1;          ///< of whatever is drawn
};

/// The pairs of a comparison, in blocks that any thread may make: a block's pairs depend on its number and the options.
class ComparedPairs {
 public:
  static constexpr std::uint64_t kBlock = 4096;

  ComparedPairs(const PairOptions& options, bool isotropic);

  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Pairs of the grid that these stand for, each as often as any other; `size` where they are drawn.
  [[nodiscard]] std::uint64_t stands_for() const;
  [[nodiscard]] std::uint64_t block_count() const { return (size_ + kBlock - 1) / kBlock; }
  [[nodiscard]] std::vector<WeightedPair> block(std::uint64_t number) const;

 private:
  [[nodiscard]] WeightedPair draw(std::mt19937_64& random) const;

  PairOptions options_;
  DirectionGrid grid_;
  HighlightDraw highlight_;
  std::uint64_t size_;
};

}  // namespace sbrdf::internal
