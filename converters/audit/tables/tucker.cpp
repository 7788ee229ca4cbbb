#include "converters/audit/tables/tucker.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/core/directions.h"
#include "formats/core/half.h"

namespace sbrdf::internal {
namespace {

using Shape = std::array<std::size_t, 5>;

std::size_t product(const Shape& shape) {
  std::size_t result = 1;
  for (const std::size_t n : shape) result *= n;
  return result;
}

/// Numbers from one to the next along an axis, in C order.
std::size_t stride_of(const Shape& shape, std::size_t axis) {
  std::size_t stride = 1;
  for (std::size_t k = axis + 1; k < shape.size(); ++k) stride *= shape[k];
  return stride;
}

/// sum over n of tensor[.. n ..] matrix[n][r]: the axis gets `ranks` entries.
std::vector<double> contracted(const std::vector<double>& tensor, Shape& shape, std::size_t axis,
                               const std::vector<double>& matrix, std::size_t columns, std::size_t ranks) {
  const std::size_t stride = stride_of(shape, axis);
  const std::size_t count = shape[axis];
  const std::size_t outer = tensor.size() / (stride * count);
  std::vector<double> result(outer * ranks * stride, 0.0);
  for (std::size_t o = 0; o < outer; ++o) {
    for (std::size_t n = 0; n < count; ++n) {
      const double* from = tensor.data() + (o * count + n) * stride;
      for (std::size_t r = 0; r < ranks; ++r) {
        const double weight = matrix[n * columns + r];
        double* to = result.data() + (o * ranks + r) * stride;
        for (std::size_t s = 0; s < stride; ++s) to[s] += weight * from[s];
      }
    }
  }
  shape[axis] = ranks;
  return result;
}

Eigen::MatrixXd gram_along(const std::vector<double>& tensor, const Shape& shape, std::size_t axis) {
  const std::size_t stride = stride_of(shape, axis);
  const std::size_t count = shape[axis];
  const std::size_t outer = tensor.size() / (stride * count);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(count));
  for (std::size_t o = 0; o < outer; ++o) {
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> block(
        tensor.data() + o * count * stride, static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(stride));
    gram += block * block.transpose();
  }
  return gram;
}

float as_half(double value) { return float_from_half(half_from_float(static_cast<float>(value))); }

class TuckerSource final : public BrdfSource {
 public:
  TuckerSource(const AuditSubject& subject, const LogTable& like, Tucker tucker)
      : grid_(like.grid),
        base_(like.base()),
        scale_(like.scale),
        folded_(like.counts[3] < like.grid.axes[3].size()),
        tucker_(std::move(tucker)) {
    traits_.format = "tucker";
    traits_.description = "Tucker decomposition";
    traits_.channels = subject.original().traits().channels;
    traits_.isotropic = grid_.is_isotropic();
    traits_.reciprocal = true;
  }

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }

  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    const std::size_t channels = traits_.channels.size();
    std::vector<double> logs(channels);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const std::span<float> to = values.subspan(k * channels, channels);
      if (!above_horizon(pairs[k])) {
        std::fill(to.begin(), to.end(), 0.0F);
        continue;
      }
      logarithms(pairs[k], logs);
      for (std::size_t c = 0; c < channels; ++c) {
        const double log = c == base_ ? logs[c] : logs[base_] + logs[c];
        to[c] = static_cast<float>(scale_.value_of(log));
      }
    }
  }

 private:
  /// Of the core, axis after axis; each takes the curves between its two nodes.
  void logarithms(const DirectionPair& pair, std::vector<double>& logs) const {
    const Grid::Place place = grid_.place_of(pair);
    std::vector<double> left(tucker_.core.begin(), tucker_.core.end());
    std::size_t size = left.size();
    for (std::size_t axis = 0; axis < 4; ++axis) {
      const Bracket between = grid_.axes[axis].bracket(place[axis]);
      const std::size_t ranks = tucker_.ranks[axis];
      const float* low = tucker_.factors[axis].data() + row(axis, between.low) * ranks;
      const float* high = tucker_.factors[axis].data() + row(axis, between.high) * ranks;
      const std::size_t stride = size / ranks;
      for (std::size_t s = 0; s < stride; ++s) {
        double sum = 0;
        for (std::size_t r = 0; r < ranks; ++r) {
          sum += (low[r] + between.weight * (high[r] - low[r])) * left[r * stride + s];
        }
        left[s] = sum;
      }
      size = stride;
    }
    const std::size_t ranks = tucker_.ranks[4];
    for (std::size_t c = 0; c < logs.size(); ++c) {
      logs[c] = 0;
      for (std::size_t r = 0; r < ranks; ++r) logs[c] += tucker_.factors[4][c * ranks + r] * left[r];
    }
  }

  [[nodiscard]] std::size_t row(std::size_t axis, std::uint32_t node) const {
    if (axis != 3 || !folded_ || node < tucker_.nodes[3]) return node;
    return grid_.axes[3].size() - node;
  }

  Grid grid_;
  std::size_t base_;
  LogScale scale_;
  bool folded_;
  Tucker tucker_;
  SourceTraits traits_;
};

}  // namespace

std::size_t Tucker::number_count() const {
  std::size_t count = core.size();
  for (const std::vector<float>& factor : factors) count += factor.size();
  return count;
}

TuckerFamily::TuckerFamily(const LogTable& table) {
  nodes_ = {table.counts[0], table.counts[1], table.counts[2], table.counts[3], table.planes.size()};
  tensor_.resize(product(nodes_));
  for (std::size_t c = 0; c < table.planes.size(); ++c) {
    for (std::size_t k = 0; k < table.planes[c].size(); ++k) {
      tensor_[k * table.planes.size() + c] = static_cast<double>(table.planes[c][k]);
    }
  }
  for (const double value : tensor_) squares_ += value * value;
  for (std::size_t axis = 0; axis < nodes_.size(); ++axis) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram_along(tensor_, nodes_, axis));
    const auto n = static_cast<Eigen::Index>(nodes_[axis]);
    values_[axis].resize(nodes_[axis]);
    vectors_[axis].resize(nodes_[axis] * nodes_[axis]);
    for (Eigen::Index k = 0; k < n; ++k) {  // rising, turned round
      values_[axis][static_cast<std::size_t>(k)] = solver.eigenvalues()[n - 1 - k];
      for (Eigen::Index r = 0; r < n; ++r) {
        vectors_[axis][static_cast<std::size_t>(r * n + k)] = solver.eigenvectors()(r, n - 1 - k);
      }
    }
  }
}

Tucker TuckerFamily::keep(double share) const {
  Tucker tucker;
  tucker.nodes = nodes_;
  Shape shape = nodes_;
  std::vector<double> core = tensor_;
  for (std::size_t axis = 0; axis < nodes_.size(); ++axis) {
    const auto& values = values_[axis];
    const auto kept = std::count_if(values.begin(), values.end(), [&](double v) { return v > share * squares_; });
    const std::size_t ranks = std::max<std::size_t>(static_cast<std::size_t>(kept), 1);
    tucker.ranks[axis] = ranks;
    core = contracted(core, shape, axis, vectors_[axis], nodes_[axis], ranks);
    for (std::size_t n = 0; n < nodes_[axis]; ++n) {
      for (std::size_t r = 0; r < ranks; ++r) {
        tucker.factors[axis].push_back(as_half(vectors_[axis][n * nodes_[axis] + r]));
      }
    }
  }
  for (const double value : core) tucker.core.push_back(as_half(value));
  return tucker;
}

std::unique_ptr<BrdfSource> make_tucker_source(const AuditSubject& subject, const LogTable& like, Tucker tucker) {
  return std::make_unique<TuckerSource>(subject, like, std::move(tucker));
}

}  // namespace sbrdf::internal
