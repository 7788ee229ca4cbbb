#include "codec/crossing_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

namespace sbrdf {
namespace {

using Point = std::array<std::uint32_t, kAxisCount>;

// A weight above this belongs to an extrapolation, which is worse than another axis or the last value.
constexpr double kLargestWeight = 2.5;
constexpr std::uint32_t kUnknown = 0xFFFFFFFFU;

class Planner {
 public:
  Planner(const Lattice& lattice, const LatticeBlocks& blocks)
      : lattice_(lattice), blocks_(blocks), first_(first_points(lattice)), known_in_(first_.size(), kUnknown) {
    std::size_t longest = 1;
    for (const std::vector<double>& nodes : lattice.nodes) longest = std::max(longest, nodes.size());
    coarsest_ = longest < 3 ? 1 : std::bit_floor(longest - 1);
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      periodic_[axis] = geometry(lattice.spec.id).node_period(axis) > 0 && lattice.nodes[axis].size() > 1;
    }
  }

  CrossingPlan plan() {
    for (std::uint32_t block = 0; block < blocks_.crossings.size(); ++block) {
      plan_.block_begin.push_back(static_cast<std::uint32_t>(plan_.steps.size()));
      add_block(block);
    }
    plan_.block_begin.push_back(static_cast<std::uint32_t>(plan_.steps.size()));
    return std::move(plan_);
  }

 private:
  /// The coarsest regular part of the lattice that a point is in.
  [[nodiscard]] std::uint32_t stride(const Point& p) const {
    const std::uint32_t any = p[0] | p[1] | p[2] | p[3];
    if (any == 0) return static_cast<std::uint32_t>(coarsest_);
    return std::min(static_cast<std::uint32_t>(coarsest_), any & (~any + 1));
  }
  [[nodiscard]] bool between(const Point& p, std::size_t axis) const { return (p[axis] / stride(p)) % 2 == 1; }
  [[nodiscard]] unsigned between_count(const Point& p) const {
    unsigned count = 0;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) count += between(p, axis) ? 1 : 0;
    return count;
  }

  void add_block(std::uint32_t block) {
    std::vector<std::uint32_t> order = blocks_.crossings[block];
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::tuple(-static_cast<std::int64_t>(stride(first_[a])), between_count(first_[a]), a) <
             std::tuple(-static_cast<std::int64_t>(stride(first_[b])), between_count(first_[b]), b);
    });
    std::uint32_t last = kUnknown;
    for (const std::uint32_t crossing : order) {
      const auto first_stencil = static_cast<std::uint32_t>(plan_.stencils.size());
      const Point& p = first_[crossing];
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        if (between(p, axis)) add_stencil(p, axis, block);
      }
      if (plan_.stencils.size() == first_stencil && last != kUnknown) {
        plan_.stencils.push_back({{last}, {1.0}, 1});
      }
      plan_.steps.push_back(
          {crossing, first_stencil, static_cast<std::uint32_t>(plan_.stencils.size()) - first_stencil});
      known_in_[crossing] = block;
      last = crossing;
    }
  }

  void add_stencil(const Point& p, std::size_t axis, std::uint32_t block) {
    Stencil stencil;
    std::array<double, 4> positions{};
    const std::vector<double>& nodes = lattice_.nodes[axis];
    const auto end = static_cast<std::int64_t>(nodes.size()) - 1;
    for (const std::int64_t steps : {-3, -1, 1, 3}) {
      std::int64_t index = p[axis] + steps * stride(p);
      double turns = 0;
      if (periodic_[axis]) {
        const std::int64_t wrapped = (index % end + end) % end;
        turns = static_cast<double>((index - wrapped) / end);
        index = wrapped;
      }
      if (index < 0 || index > end) continue;
      std::uint32_t corner = 0;
      for (std::size_t a = 0; a < kAxisCount; ++a) {
        corner += (a == axis ? static_cast<std::uint32_t>(index) : p[a]) * lattice_.corner_strides[a];
      }
      const std::uint32_t crossing = lattice_.corners[corner];
      if (known_in_[crossing] != block) continue;
      positions[stencil.count] = nodes[static_cast<std::size_t>(index)] + turns * nodes.back();
      stencil.member[stencil.count++] = crossing;
    }
    if (stencil.count == 0) return;
    set_weights(stencil, std::span(positions).first(stencil.count), nodes[p[axis]]);
    const auto too_large = [](double w) { return std::abs(w) > kLargestWeight; };
    if (std::any_of(stencil.weight.begin(), stencil.weight.begin() + stencil.count, too_large)) return;
    plan_.stencils.push_back(stencil);
  }

  const Lattice& lattice_;
  const LatticeBlocks& blocks_;
  std::vector<Point> first_;
  std::vector<std::uint32_t> known_in_;
  std::size_t coarsest_ = 1;
  std::array<bool, kAxisCount> periodic_{};
  CrossingPlan plan_;
};

}  // namespace

template <std::size_t Count>
void set_weights_of(Stencil& stencil, const double* positions, double at) {
  for (std::size_t k = 0; k < Count; ++k) {
    double weight = 1;
    for (std::size_t j = 0; j < Count; ++j) {
      if (j != k) weight *= (at - positions[j]) / (positions[k] - positions[j]);
    }
    stencil.weight[k] = weight;
  }
}

void set_weights(Stencil& stencil, std::span<const double> positions, double at) {
  switch (positions.size()) {
    case 1:
      return set_weights_of<1>(stencil, positions.data(), at);
    case 2:
      return set_weights_of<2>(stencil, positions.data(), at);
    case 3:
      return set_weights_of<3>(stencil, positions.data(), at);
    default:
      return set_weights_of<4>(stencil, positions.data(), at);
  }
}

CrossingPlan plan_crossings(const Lattice& lattice, const LatticeBlocks& blocks) {
  return Planner(lattice, blocks).plan();
}

}  // namespace sbrdf
