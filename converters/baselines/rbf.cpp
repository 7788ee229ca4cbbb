#include "converters/baselines/rbf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>
#include <glm/vec3.hpp>

namespace sbrdf::internal {
namespace {

using Eigen::Index;

/// The interpolant must meet its samples as nearly as this, relative to the largest of them.
constexpr double kLargestMiss = 1e-6;
constexpr std::uint64_t kMostCoefficients = std::uint64_t{1} << 25U;  // 256 MB
constexpr double kGreatest = std::numeric_limits<float>::max();

Index index_of(std::size_t k) { return static_cast<Index>(k); }

class RbfSource final : public SchemeSource {
 public:
  RbfSource(SchemeSamples samples, RbfKernel kernel);
  /// Before it is used.
  [[nodiscard]] Status solve();

 private:
  using Matrix = Eigen::MatrixXd;

  [[nodiscard]] Matrix basis(std::span<const glm::dvec3> w) const;
  void interpolate(std::span<const glm::dvec3> w_i, std::span<const glm::dvec3> w_v,
                   std::span<float> values) const override;

  [[nodiscard]] Index polynomial_terms() const;

  Matrix nodes_;         // directions x 3
  Matrix coefficients_;  // C of each channel, one below the other
};

RbfSource::RbfSource(SchemeSamples samples, RbfKernel kernel)
    : SchemeSource(std::move(samples), {Interpolation::Kind::kRbf, kernel}, "extrapolated") {
  const std::vector<glm::dvec3> directions = scheme_directions(this->samples().scheme);
  nodes_.resize(index_of(directions.size()), 3);
  for (std::size_t k = 0; k < directions.size(); ++k) {
    nodes_.row(index_of(k)) << directions[k].x, directions[k].y, directions[k].z;
  }
}

// One column for each direction that is asked for: the kernel's values, and the polynomial's.
RbfSource::Matrix RbfSource::basis(std::span<const glm::dvec3> w) const {
  Matrix asked(3, index_of(w.size()));
  for (std::size_t k = 0; k < w.size(); ++k) asked.col(index_of(k)) << w[k].x, w[k].y, w[k].z;
  Matrix values(nodes_.rows() + polynomial_terms(), asked.cols());
  auto radial = values.topRows(nodes_.rows());
  radial = (2 - 2 * nodes_.lazyProduct(asked).array()).max(0).matrix();  // r^2
  switch (interpolation().kernel) {
    case RbfKernel::kLinear:
      radial = radial.array().sqrt().matrix();
      break;
    case RbfKernel::kCubic:
      radial = (radial.array() * radial.array().sqrt()).matrix();
      break;
    case RbfKernel::kThinPlate:
      radial = radial.unaryExpr([](double r2) { return r2 > 0 ? 0.5 * r2 * std::log(r2) : 0.0; });
      break;
    case RbfKernel::kInverseMultiquadric:
      radial = (radial.array() + kRbfWidth * kRbfWidth).rsqrt().matrix();
      break;
  }
  if (polynomial_terms() > 0) values.row(nodes_.rows()).setOnes();
  if (polynomial_terms() > 1) values.bottomRows(3) = asked;
  return values;
}

// As many as make the solution unique: none, 1, or 1, x, y and z.
Index RbfSource::polynomial_terms() const {
  switch (interpolation().kernel) {
    case RbfKernel::kInverseMultiquadric:
      return 0;
    case RbfKernel::kLinear:
      return 1;
    case RbfKernel::kCubic:
    case RbfKernel::kThinPlate:
      break;
  }
  return 4;
}

Status RbfSource::solve() {
  const std::size_t count = samples().scheme.direction_count();
  const std::size_t channels = samples().channels.size();
  const Index size = nodes_.rows() + polynomial_terms();
  Matrix interpolation = Matrix::Zero(size, size);
  interpolation.leftCols(nodes_.rows()) = basis(scheme_directions(samples().scheme));
  interpolation.topRightCorner(nodes_.rows(), polynomial_terms()) =
      interpolation.bottomLeftCorner(polynomial_terms(), nodes_.rows()).transpose();
  const Eigen::PartialPivLU<Matrix> solver(interpolation);
  coefficients_.resize(index_of(channels) * size, size);
  for (std::size_t c = 0; c < channels; ++c) {
    Matrix values = Matrix::Zero(size, size);
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = 0; b < count; ++b) {
        values(index_of(a), index_of(b)) = samples().values[pair_number(a, b) * channels + c];
      }
    }
    const Matrix half = solver.solve(values);
    const Matrix found = solver.solve(Matrix(half.transpose()));
    const double largest = values.cwiseAbs().maxCoeff();
    const double miss = (interpolation * found * interpolation - values).cwiseAbs().maxCoeff();
    if (!(miss <= kLargestMiss * largest)) {
      return unsupported(fmt::format("the equations of the RBF have no solution: it misses samples by {:.2g} of {:.2g}",
                                     miss, largest));
    }
    coefficients_.middleRows(index_of(c) * size, size) = found;
  }
  return ok_status();
}

/// Directions without those that come again, in any order, and where each of the given ones is among them.
struct Distinct {
  explicit Distinct(std::span<const glm::dvec3> given) : directions(given.begin(), given.end()) {
    const auto before = [](const glm::dvec3& a, const glm::dvec3& b) {
      return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::sort(directions.begin(), directions.end(), before);
    directions.erase(std::unique(directions.begin(), directions.end()), directions.end());
    for (const glm::dvec3& w : given) {
      place.push_back(std::lower_bound(directions.begin(), directions.end(), w, before) - directions.begin());
    }
  }

  std::vector<glm::dvec3> directions;
  std::vector<Index> place;
};

// Grids come with the same directions again and again. Each is worked out by itself, so that it has the same bits in
// any company.
void RbfSource::interpolate(std::span<const glm::dvec3> w_i, std::span<const glm::dvec3> w_v,
                            std::span<float> values) const {
  const Distinct lights(w_i);
  const Distinct viewers(w_v);
  const Index size = coefficients_.cols();
  const Matrix bases = basis(lights.directions);
  Matrix lit(coefficients_.rows(), bases.cols());  // of each channel, one below the other
  for (Index k = 0; k < bases.cols(); ++k) lit.col(k).noalias() = coefficients_ * bases.col(k);
  const Matrix seen = basis(viewers.directions);
  const std::size_t channels = channel_count();
  for (std::size_t k = 0; k < w_v.size(); ++k) {
    const auto viewer = seen.col(viewers.place[k]);
    for (std::size_t c = 0; c < channels; ++c) {
      const double value = lit.col(lights.place[k]).segment(index_of(c) * size, size).dot(viewer);
      values[k * channels + c] = static_cast<float>(std::clamp(value, -kGreatest, kGreatest));
    }
  }
}

}  // namespace

Result<std::unique_ptr<SchemeSource>> make_rbf(SchemeSamples samples, RbfKernel kernel) {
  const std::uint64_t pairs = samples.scheme.pair_count();
  if (pairs * samples.channels.size() > kMostCoefficients) {
    return unsupported(
        fmt::format("radial basis functions of {} pairs of directions and {} channels: more than 2^25 "
                    "coefficients",
                    pairs, samples.channels.size()));
  }
  auto source = std::make_unique<RbfSource>(std::move(samples), kernel);
  if (Status solved = source->solve(); !solved) return solved.error();
  return std::unique_ptr<SchemeSource>(std::move(source));
}

}  // namespace sbrdf::internal
