#include "converters/files/rgl/rgl_least_squares.h"

#include <algorithm>
#include <cmath>

#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kWidth = 4;  // channels that are solved for at a time
constexpr int kMostIterations = 60;
constexpr double kEnough = 1e-4;  // of the residual at the start
/// Steps from an equation to the last node that is solved for. What lies farther below the horizon would settle last,
/// and slowly, and nothing reads it.
constexpr int kSteps = 2;
/// Weights of smoothness, of that of the equations at a node.
constexpr double kSecondDifferences = 1e-4;
constexpr double kFirstDifferences = 1e-6;
/// Least part of that weight that a node takes over from the next.
constexpr double kPerStep = 0.1;

/// Numbers [slice, node, channel] of a block of channels.
using Block = std::vector<double>;

class Solver {
 public:
  Solver(std::span<const RglPanel> panels, const RglGrid& grid, std::size_t slice_count, std::size_t channel_count)
      : panels_(panels), grid_(grid), cells_(grid.cell_count()), slices_(slice_count), channels_(channel_count) {
    diagonal_.resize(slices_ * cells_);
    total_.resize(slices_ * cells_);
    for (const RglPanel& panel : panels_) panel.add_diagonal(diagonal_, total_);
    find_solved();
  }

  std::vector<double> run() {
    std::vector<double> solution(slices_ * channels_ * cells_);
    for (std::size_t first = 0; first < channels_; first += kWidth) {
      const std::size_t width = std::min(kWidth, channels_ - first);
      Block x = solve(first, width);
      continue_from(solved_, width, x);
      for (std::size_t n = 0; n < slices_ * cells_; ++n) {
        for (std::size_t c = 0; c < width; ++c) {
          solution[(n / cells_ * channels_ + first + c) * cells_ + n % cells_] = x[n * width + c];
        }
      }
    }
    return solution;
  }

 private:
  /// Which nodes are solved for, and how much smoothness counts there.
  void find_solved() {
    solved_.resize(total_.size());
    std::transform(total_.begin(), total_.end(), solved_.begin(), [](double sum) { return sum > 0 ? 1 : 0; });
    smoothness_ = diagonal_;
    parallel_for(slices_, [&](std::uint64_t slice) {
      const std::span<std::uint8_t> solved = std::span(solved_).subspan(slice * cells_, cells_);
      const std::span<double> smoothness = std::span(smoothness_).subspan(slice * cells_, cells_);
      for (int step = 0; step < kSteps; ++step) {
        const std::vector<std::uint8_t> was_solved(solved.begin(), solved.end());
        const std::vector<double> before(smoothness.begin(), smoothness.end());
        for (std::size_t n = 0; n < cells_; ++n) {
          for_neighbours(n, [&](std::size_t other) {
            solved[n] = std::max(solved[n], was_solved[other]);
            smoothness[n] = std::max(smoothness[n], kPerStep * before[other]);
          });
        }
      }
    });
  }

  template <class Visit>
  void for_neighbours(std::size_t n, const Visit& visit) const {
    const std::size_t x = n % grid_.x_count;
    const std::size_t y = n / grid_.x_count;
    if (x > 0) visit(n - 1);
    if (x + 1 < grid_.x_count) visit(n + 1);
    if (y > 0) visit(n - grid_.x_count);
    if (y + 1 < grid_.y_count) visit(n + grid_.x_count);
  }

  [[nodiscard]] Block right_side(std::size_t first, std::size_t width) const {
    Block b(slices_ * cells_ * width);
    for (const RglPanel& panel : panels_) {
      for (std::size_t n = 0; n < panel.slice_count * cells_ && !panel.right_side().empty(); ++n) {
        const std::size_t target = panel.slices[n / cells_] * cells_ + n % cells_;
        for (std::size_t c = 0; c < width; ++c) {
          b[target * width + c] += panel.right_side()[n * channels_ + first + c];
        }
      }
    }
    return b;
  }

  /// The mean of what the equations ask for around each node; next to it where they ask for nothing.
  [[nodiscard]] Block start(const Block& b, std::size_t width) const {
    Block x(b.size());
    std::vector<std::uint8_t> known(total_.size());
    for (std::size_t n = 0; n < total_.size(); ++n) {
      if (!(total_[n] > 0)) continue;
      known[n] = 1;
      for (std::size_t c = 0; c < width; ++c) x[n * width + c] = b[n * width + c] / total_[n];
    }
    continue_from(known, width, x);
    return x;
  }

  /// Gives each other node the value of a known one next to it, and so on.
  void continue_from(const std::vector<std::uint8_t>& of, std::size_t width, Block& x) const {
    parallel_for(slices_, [&](std::uint64_t slice) {
      const std::size_t base = slice * cells_;
      std::vector<std::uint8_t> known(of.data() + base, of.data() + base + cells_);
      for (bool more = true; more;) {
        more = false;
        const std::vector<std::uint8_t> before = known;
        for (std::size_t k = 0; k < cells_; ++k) {
          for_neighbours(k, [&](std::size_t other) {
            if (before[other] == 0 || known[k] != 0) return;
            known[k] = 1;
            more = true;
            std::copy_n(x.begin() + (base + other) * width, width, x.begin() + (base + k) * width);
          });
        }
      }
    });
  }

  /// Adds what smoothness asks for, times `x`. It counts for as much as at the node where it counts least: next to the
  /// horizon equations weigh a thousand times more than a few nodes on.
  void smooth(const Block& x, std::size_t width, Block& result) const {
    parallel_for(slices_, [&](std::uint64_t slice) {
      const std::size_t base = slice * cells_;
      const auto along = [&](std::size_t n, std::size_t step, bool inner) {
        const double* weight = smoothness_.data() + base + n;
        const double of_two = solved_[base + n] * solved_[base + n + step] * std::min(weight[0], weight[step]);
        const double of_three = inner ? solved_[base + n - step] * std::min(of_two, *(weight - step)) : 0;
        for (std::size_t c = 0; c < width; ++c) {
          const auto at = [&](std::size_t k) { return (base + k) * width + c; };
          const double slope = kFirstDifferences * of_two * (x[at(n + step)] - x[at(n)]);
          result[at(n + step)] += slope;
          result[at(n)] -= slope;
          if (!inner) continue;
          const double bend = kSecondDifferences * of_three * (x[at(n - step)] - 2 * x[at(n)] + x[at(n + step)]);
          result[at(n - step)] += bend;
          result[at(n)] -= 2 * bend;
          result[at(n + step)] += bend;
        }
      };
      for (std::size_t n = 0; n < cells_; ++n) {
        const std::size_t i = n % grid_.x_count;
        const std::size_t j = n / grid_.x_count;
        if (i + 1 < grid_.x_count) along(n, 1, i > 0);
        if (j + 1 < grid_.y_count) along(n, grid_.x_count, j > 0);
      }
    });
  }

  void multiply(const Block& x, std::size_t width, Block& result) {
    parts_.resize(panels_.size());
    parallel_for(panels_.size(), [&](std::uint64_t k) {
      parts_[k].assign(panels_[k].slice_count * cells_ * width, 0.0);
      panels_[k].multiply(x, width, parts_[k]);
    });
    std::fill(result.begin(), result.end(), 0.0);
    for (std::size_t k = 0; k < panels_.size(); ++k) {
      for (std::size_t s = 0; s < panels_[k].slice_count; ++s) {
        const double* from = parts_[k].data() + s * cells_ * width;
        double* to = result.data() + panels_[k].slices[s] * cells_ * width;
        for (std::size_t n = 0; n < cells_ * width; ++n) to[n] += from[n];
      }
    }
    smooth(x, width, result);
  }

  [[nodiscard]] static std::array<double, kWidth> dots(const Block& a, const Block& b, std::size_t width) {
    std::array<double, kWidth> sums = {};
    for (std::size_t n = 0; n < a.size(); ++n) sums[n % width] += a[n] * b[n];
    return sums;
  }

  /// Conjugate gradients, each channel by itself, with the diagonal as preconditioner.
  Block solve(std::size_t first, std::size_t width) {
    Block residual = right_side(first, width);
    Block x = start(residual, width);
    Block product(x.size());
    multiply(x, width, product);
    for (std::size_t n = 0; n < x.size(); ++n) residual[n] -= product[n];
    const auto scaled = [&](std::size_t n) {
      const double diagonal = diagonal_[n / width] + 12 * kSecondDifferences * smoothness_[n / width];
      return diagonal > 0 ? residual[n] / diagonal : 0;
    };
    Block z(x.size());
    for (std::size_t n = 0; n < x.size(); ++n) z[n] = scaled(n);
    Block direction = z;
    std::array<double, kWidth> energy = dots(residual, z, width);
    const std::array<double, kWidth> begun = energy;
    for (int iteration = 0; iteration < kMostIterations; ++iteration) {
      bool enough = true;
      for (std::size_t c = 0; c < width; ++c) enough = enough && energy[c] <= kEnough * kEnough * begun[c];
      if (enough) break;
      multiply(direction, width, product);
      const std::array<double, kWidth> curvature = dots(direction, product, width);
      for (std::size_t n = 0; n < x.size(); ++n) {
        const double step = curvature[n % width] > 0 ? energy[n % width] / curvature[n % width] : 0;
        x[n] += step * direction[n];
        residual[n] -= step * product[n];
        z[n] = scaled(n);
      }
      const std::array<double, kWidth> next = dots(residual, z, width);
      for (std::size_t n = 0; n < x.size(); ++n) {
        direction[n] = z[n] + (energy[n % width] > 0 ? next[n % width] / energy[n % width] : 0) * direction[n];
      }
      energy = next;
    }
    return x;
  }

  std::span<const RglPanel> panels_;
  RglGrid grid_;
  std::size_t cells_;
  std::size_t slices_;
  std::size_t channels_;
  std::vector<double> diagonal_;
  std::vector<double> total_;
  std::vector<double> smoothness_;
  std::vector<std::uint8_t> solved_;
  std::vector<Block> parts_;
};

/// Weights of the four nodes around the place of an equation.
std::array<double, 4> shares_of(const RglEquation& equation) {
  const double x = equation.x;
  const double y = equation.y;
  return {(1 - y) * (1 - x), (1 - y) * x, y * (1 - x), y * x};
}

}  // namespace

void RglPanel::add(const RglEquation& equation, std::span<const double> target) {
  equations_.push_back(equation);
  if (right_side_.empty()) right_side_.resize(slice_count * cells_ * channels_);
  const std::array<std::size_t, 4> nodes = nodes_of(equation);
  const std::array<double, 4> shares = shares_of(equation);
  for (std::size_t s = 0; s < slice_count; ++s) {
    for (std::size_t tap = 0; tap < 4; ++tap) {
      const double weight = double{equation.weight} * equation.slice[s] * shares[tap];
      double* sums = right_side_.data() + (s * cells_ + nodes[tap]) * channels_;
      for (std::size_t c = 0; c < channels_; ++c) sums[c] += weight * target[c];
    }
  }
}

void RglPanel::add_diagonal(std::span<double> diagonal, std::span<double> total) const {
  for (const RglEquation& equation : equations_) {
    const std::array<std::size_t, 4> nodes = nodes_of(equation);
    const std::array<double, 4> shares = shares_of(equation);
    for (std::size_t s = 0; s < slice_count; ++s) {
      for (std::size_t tap = 0; tap < 4; ++tap) {
        const double share = equation.slice[s] * shares[tap];
        diagonal[slices[s] * cells_ + nodes[tap]] += equation.weight * share * share;
        total[slices[s] * cells_ + nodes[tap]] += equation.weight * share;
      }
    }
  }
}

void RglPanel::lift(std::span<double> unknowns) const {
  for (const RglEquation& equation : equations_) {
    const std::array<std::size_t, 4> nodes = nodes_of(equation);
    const std::array<double, 4> shares = shares_of(equation);
    for (std::size_t c = 0; c < channels_; ++c) {
      double value = 0;
      const auto visit = [&](const auto& take) {
        for (std::size_t k = 0; k < 4 * slice_count; ++k) {
          const double share = equation.slice[k / 4] * shares[k % 4];
          if (share > 0) take(share, unknowns[(slices[k / 4] * channels_ + c) * cells_ + nodes[k % 4]]);
        }
      };
      visit([&](double share, double node) { value += share * node; });
      if (value < 0) visit([](double, double& node) { node = std::max(node, 0.0); });
    }
  }
}

void RglPanel::multiply(std::span<const double> x, std::size_t width, std::span<double> result) const {
  for (const RglEquation& equation : equations_) {
    const std::array<std::size_t, 4> nodes = nodes_of(equation);
    const std::array<double, 4> shares = shares_of(equation);
    std::array<double, kWidth> value = {};
    for (std::size_t s = 0; s < slice_count; ++s) {
      if (equation.slice[s] == 0) continue;
      for (std::size_t tap = 0; tap < 4; ++tap) {
        const double share = equation.slice[s] * shares[tap];
        const double* from = x.data() + (slices[s] * cells_ + nodes[tap]) * width;
        for (std::size_t c = 0; c < width; ++c) value[c] += share * from[c];
      }
    }
    for (double& v : value) v *= equation.weight;
    for (std::size_t s = 0; s < slice_count; ++s) {
      if (equation.slice[s] == 0) continue;
      for (std::size_t tap = 0; tap < 4; ++tap) {
        const double share = equation.slice[s] * shares[tap];
        double* to = result.data() + (s * cells_ + nodes[tap]) * width;
        for (std::size_t c = 0; c < width; ++c) to[c] += share * value[c];
      }
    }
  }
}

std::vector<double> solve_least_squares(std::span<const RglPanel> panels, const RglGrid& grid, std::size_t slice_count,
                                        std::size_t channel_count) {
  return Solver(panels, grid, slice_count, channel_count).run();
}

}  // namespace sbrdf::internal
