#include "converters/series/integer_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace sbrdf::internal {
namespace {

double cost_of(const IntegerProblem& problem, const std::vector<std::int32_t>& numbers) {
  Eigen::VectorXd x(static_cast<Eigen::Index>(numbers.size()));
  double bits = 0;
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    x[static_cast<Eigen::Index>(n)] = numbers[n];
    if (numbers[n] != 0) bits += problem.first_bits[n] + 2 * std::log2(1 + std::abs(numbers[n]));
  }
  return 0.5 * x.dot(problem.gram * x) - problem.right.dot(x) + problem.bit_price * bits;
}

// All of them, from -3 to 3.
double least_of_all(const IntegerProblem& problem, std::size_t count) {
  double least = std::numeric_limits<double>::infinity();
  std::vector<std::int32_t> numbers(count, -3);
  while (true) {
    least = std::min(least, cost_of(problem, numbers));
    std::size_t n = 0;
    while (n < count && numbers[n] == 3) numbers[n++] = -3;
    if (n == count) return least;
    ++numbers[n];
  }
}

IntegerProblem drawn(std::mt19937& random, int count, double alike) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd rows(12, count);
  for (int r = 0; r < rows.rows(); ++r) {
    const double common = normal(random);
    for (int c = 0; c < count; ++c) rows(r, c) = alike * common + normal(random);
  }
  Eigen::VectorXd wanted(count);
  for (int c = 0; c < count; ++c) wanted[c] = 0.9 * normal(random);
  IntegerProblem problem;
  problem.gram = rows.transpose() * rows;
  problem.right = problem.gram * wanted;
  problem.bit_price = 0.3;
  problem.first_bits.assign(static_cast<std::size_t>(count), 2);
  return problem;
}

TEST(IntegerFit, IsNearToTheBestOfAllAndBetterThanRounding) {
  std::mt19937 random(9);
  int best = 0;
  double sum_found = 0;
  double sum_least = 0;
  constexpr int kProblems = 60;
  for (int k = 0; k < kProblems; ++k) {
    const IntegerProblem problem = drawn(random, 5, k % 2 == 0 ? 0.3 : 3);
    const double found = cost_of(problem, solve_integers(problem, std::vector<std::int32_t>(5)));
    const double least = least_of_all(problem, 5);
    EXPECT_LE(found, 1e-9);  // no worse than nothing
    sum_found += found;
    sum_least += least;
    if (found <= least + 1e-9) ++best;
    const Eigen::VectorXd exact = problem.gram.llt().solve(problem.right);
    std::vector<std::int32_t> rounded;
    for (const double x : exact) rounded.push_back(static_cast<std::int32_t>(std::lround(x)));
    EXPECT_LE(found, cost_of(problem, rounded) + 1e-9);
  }
  EXPECT_GE(best, kProblems * 2 / 3);
  EXPECT_LE(sum_found, 0.99 * sum_least);  // both are below 0
}

TEST(IntegerFit, PricesKeepNumbersAtZero) {
  std::mt19937 random(1);
  IntegerProblem problem = drawn(random, 5, 0.3);
  problem.bit_price = 1e9;
  EXPECT_EQ(solve_integers(problem, {5, 4, 3, 2, 1}), std::vector<std::int32_t>(5));
}

TEST(IntegerFit, FunctionsThatAreNothingStayOut) {
  IntegerProblem problem;
  problem.gram = Eigen::MatrixXd::Zero(3, 3);
  problem.gram(0, 0) = 4;
  problem.right = Eigen::VectorXd::Zero(3);
  problem.right[0] = 8;
  problem.bit_price = 1e-3;
  problem.first_bits.assign(3, 1);
  EXPECT_EQ(solve_integers(problem, {0, 0, 0}), (std::vector<std::int32_t>{2, 0, 0}));
}

}  // namespace
}  // namespace sbrdf::internal
