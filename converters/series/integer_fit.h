#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sbrdf::internal {

/// Whole numbers x for which `1/2 x' gram x - right' x + bit_price (bits that x takes)` is small. A number that is not
/// 0 takes about `first_bits` and 2 log2(1 + |x|).
struct IntegerProblem {
  Eigen::MatrixXd gram;
  Eigen::VectorXd right;
  double bit_price = 0;
  std::vector<double> first_bits;
};

/// Three ways, of which the best one is taken. The first rounds the numbers one by one from the last to the first, each
/// time with all before it where they are best then (Babai's nearest plane, with prices); the second rounds them all at
/// once; the third goes on from `start`. All end with numbers of which none can be bettered alone.
[[nodiscard]] std::vector<std::int32_t> solve_integers(const IntegerProblem& problem,
                                                       const std::vector<std::int32_t>& start);

}  // namespace sbrdf::internal
