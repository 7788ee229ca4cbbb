#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace sbrdf::internal {

/// How values >= 0 are spread, in little memory however many they are: counted in cells of 1/128 of an octave from
/// 2^-34 (6e-11) to 2^30 (1e9), so quantiles are known to 0.4 %. Counts are whole numbers, so the order of adding makes
/// no difference: the same bits on any number of threads.
class LogHistogram {
 public:
  /// `weight` in [0, 4], to the nearest 2^-22; together at most 2^42.
  void add(double value, double weight = 1);
  void add(const LogHistogram& other);

  /// The least value for which `part`, in (0, 1], of the weight lies at it or below (of an unweighted list the value of
  /// rank ceil(part n)); from the middle of its cell, but no less than the least value added and no more than the
  /// largest. Below the cells as 0, above them as the largest. NaN where one was added or nothing was.
  [[nodiscard]] double quantile(double part) const;

 private:
  std::vector<std::uint64_t> cells_;  ///< empty until something is added; the first and the last take the rest
  double least_ = std::numeric_limits<double>::infinity();
  double largest_ = 0;
  bool has_nan_ = false;
};

}  // namespace sbrdf::internal
