#pragma once

#include <cstdint>
#include <vector>

#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"

namespace sbrdf::internal {

/// Over which directions two sources are compared.
struct CompareOptions {
  double step_deg = 2;  ///< theta in 0, step, ... theta_max; phi in 0, step, ... below 360, for i and for v
  double theta_max_deg = 80;
  std::uint64_t random_count = 0;  ///< 0: the whole grid; else so many random pairs of the grid
  std::uint64_t seed = 1;
  bool symmetrise = false;  ///< the reference is replaced by the mean of f(i,v) and f(v,i)
  double floor = 0;         ///< smallest denominator of the MRE [1/sr]
};

/// Differences of a test r from a reference f, over all directions and channels.
struct Comparison {
  /// 100 x mean of |f - r| / max(|f|, floor), over values whose denominator is not 0; NaN where there is none
  double mre_percent = 0;
  double rel_l1_percent = 0;          ///< 100 x sum |f - r| / sum |f|
  double rmse = 0;                    ///< [1/sr]
  double max_abs = 0;                 ///< [1/sr]
  double psnr_db = 0;                 ///< 20 log10(max |f| / rmse); infinite for equal sources
  std::uint64_t directions = 0;       ///< pairs evaluated
  std::uint64_t grid_directions = 0;  ///< pairs of the grid that these stand for, each as often as any other
  std::uint64_t mre_left_out = 0;     ///< channel values with f = 0 and no floor: no relative error
  std::uint64_t mre_values = 0;       ///< the others, whose mean the MRE is
};

/// What a Comparison is made of, value by value.
class ErrorSums {
 public:
  void add(double f, double r, double floor);
  void add(const ErrorSums& other);
  /// The figures; `directions` and `grid_directions` are the caller's.
  [[nodiscard]] Comparison summary() const;

 private:
  double relative_ = 0;
  double difference_ = 0;
  double reference_ = 0;
  double squares_ = 0;
  double max_difference_ = 0;
  double max_reference_ = 0;
  std::uint64_t relative_count_ = 0;
  std::uint64_t count_ = 0;
};

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

/// Where both sources are isotropic, only pairs with phi_v = 0 are evaluated: the same means. The same bits for any
/// number of threads. kUnsupported where the numbers of channels differ; kUsage for options out of range;
/// interrupted_error().
[[nodiscard]] Result<Comparison> compare_sources(const BrdfSource& reference, const BrdfSource& test,
                                                 const CompareOptions& options, const Progress& progress = {});

}  // namespace sbrdf::internal
