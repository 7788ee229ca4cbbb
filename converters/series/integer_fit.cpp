#include "converters/series/integer_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

namespace sbrdf::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRidge = 1e-6;  // of the diagonal: directions that hardly matter stay small
constexpr int kMostSweeps = 8;
constexpr double kMostNumber = 1 << 22;

class IntegerSearch {
 public:
  explicit IntegerSearch(const IntegerProblem& problem) : problem_(problem) {
    MatrixXd matrix = problem.gram;
    matrix.diagonal() *= 1 + kRidge;
    matrix.diagonal().array() += std::numeric_limits<double>::min() + 1e-12 * matrix.diagonal().maxCoeff();
    const Eigen::LLT<MatrixXd> factors(matrix);
    best_ = VectorXd::Zero(matrix.rows());
    if (factors.info() != Eigen::Success) return;
    best_ = factors.solve(problem.right);
    lower_ = factors.matrixL();
  }

  [[nodiscard]] VectorXd round_one_by_one() const {
    VectorXd x = VectorXd::Zero(best_.size());
    if (lower_.size() == 0) return x;
    // What the numbers that are settled ask of those before them.
    VectorXd pull = x;
    for (Index n = x.size(); n-- > 0;) {
      const double size = lower_(n, n);
      x[n] = cheapest(size * size, best_[n] - pull[n] / size, n);
      pull.head(n) += lower_.row(n).head(n).transpose() * (x[n] - best_[n]);
    }
    return x;
  }

  [[nodiscard]] VectorXd round_at_once() const {
    return best_.unaryExpr([](double x) { return std::round(std::clamp(x, -kMostNumber, kMostNumber)); });
  }

  void improve(VectorXd& x) const {
    VectorXd slope = problem_.right - problem_.gram * x;
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      bool changed = false;
      for (Index n = 0; n < x.size(); ++n) {
        const double curvature = problem_.gram(n, n);
        if (!(curvature > 0)) continue;
        const double wanted = cheapest(curvature, x[n] + slope[n] / curvature, n);
        if (wanted == x[n]) continue;
        slope -= problem_.gram.col(n) * (wanted - x[n]);
        x[n] = wanted;
        changed = true;
      }
      if (!changed) break;
    }
  }

  [[nodiscard]] double cost(const VectorXd& x) const {
    double sum = 0.5 * x.dot(problem_.gram * x) - problem_.right.dot(x);
    for (Index n = 0; n < x.size(); ++n) sum += problem_.bit_price * bits(x[n], n);
    return sum;
  }

 private:
  [[nodiscard]] double bits(double number, Index n) const {
    return number == 0 ? 0 : problem_.first_bits[static_cast<std::size_t>(n)] + 2 * std::log2(1 + std::abs(number));
  }

  // Of a parabola around `centre`.
  [[nodiscard]] double cheapest(double curvature, double centre, Index n) const {
    const double kept = std::clamp(centre, -kMostNumber, kMostNumber);
    double least = std::numeric_limits<double>::infinity();
    double number = 0;
    for (const double candidate : {0.0, std::floor(kept), std::ceil(kept)}) {
      const double off = candidate - kept;
      const double each = 0.5 * curvature * off * off + problem_.bit_price * bits(candidate, n);
      if (each < least) {
        least = each;
        number = candidate;
      }
    }
    return number;
  }

  const IntegerProblem& problem_;
  VectorXd best_;   ///< without rounding
  MatrixXd lower_;  ///< gram = lower lower'; empty where there is none
};

}  // namespace

std::vector<std::int32_t> solve_integers(const IntegerProblem& problem, const std::vector<std::int32_t>& start) {
  const IntegerSearch search(problem);
  VectorXd further(static_cast<Index>(start.size()));
  for (std::size_t n = 0; n < start.size(); ++n) further[static_cast<Index>(n)] = start[n];
  std::array<VectorXd, 3> ways = {search.round_one_by_one(), search.round_at_once(), std::move(further)};
  std::array<double, 3> costs{};
  for (std::size_t k = 0; k < ways.size(); ++k) {
    search.improve(ways[k]);
    costs[k] = search.cost(ways[k]);
  }
  const VectorXd& better = ways[static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin())];
  std::vector<std::int32_t> numbers(start.size());
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    numbers[n] = static_cast<std::int32_t>(better[static_cast<Index>(n)]);
  }
  return numbers;
}

}  // namespace sbrdf::internal
