#include "codec/coding/crossing_order.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "codec/frame/lattice_walk.h"

namespace sbrdf::internal {
namespace {

using Point = LatticePoint;

// A weight above this belongs to an extrapolation, which is worse than another axis or the last value.
constexpr double kLargestWeight = 2.5;
constexpr std::uint32_t kUnknown = 0xFFFFFFFFU;
constexpr std::size_t kMostMembers = 4;
constexpr std::size_t kMostRanks = 32 * (kAxisCount + 1);

std::uint32_t lowest_bit(std::uint32_t value) { return value & (~value + 1); }

class Planner {
 public:
  Planner(const Lattice& lattice, const LatticeBlocks& blocks)
      : lattice_(lattice), blocks_(blocks), first_(first_points(lattice)), known_in_(first_.size(), kUnknown) {
    std::size_t longest = 1;
    for (const std::vector<double>& nodes : lattice.nodes) longest = std::max(longest, nodes.size());
    coarsest_ = static_cast<std::uint32_t>(longest < 3 ? 1 : std::bit_floor(longest - 1));
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) find_reaches(axis);
    rank_.reserve(first_.size());
    std::size_t most_stencils = 0;
    for (const Point& p : first_) {
      rank_.push_back(rank(p));
      most_stencils += std::max(1U, between_count(p));
    }
    plan_.steps.reserve(first_.size());
    plan_.stencils.reserve(most_stencils);
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
  enum class Fitness : std::uint8_t { kUntried, kUsable, kUnusable };
  struct Weights {
    Fitness fitness = Fitness::kUntried;
    std::array<double, kMostMembers> weight{};
  };

  /// What lies around an odd multiple of a stride, one and three strides away on its axis: the same for all points.
  struct Reach {
    double at_deg = 0;
    std::array<double, kMostMembers> position{};  ///< rising
    std::array<std::int32_t, kMostMembers> corner_step{};
    std::uint32_t count = 0;
    std::array<Weights, 1U << kMostMembers> weights;  ///< by which of them are known
  };

  /// The coarsest regular part of the lattice that a point is in.
  [[nodiscard]] std::uint32_t stride(const Point& p) const {
    const std::uint32_t any = p[0] | p[1] | p[2] | p[3];
    return any == 0 ? coarsest_ : std::min(coarsest_, lowest_bit(any));
  }

  /// The axes on which a point lies between coarser ones.
  [[nodiscard]] unsigned between_count(const Point& p) const {
    const std::uint32_t step = stride(p);
    unsigned count = 0;
    for (const std::uint32_t index : p) count += (index & step) != 0 ? 1 : 0;
    return count;
  }

  // Coarse parts first, then what lies between along few axes.
  [[nodiscard]] std::uint8_t rank(const Point& p) const {
    const auto fineness = static_cast<unsigned>(std::countr_zero(coarsest_) - std::countr_zero(stride(p)));
    return static_cast<std::uint8_t>(fineness * (kAxisCount + 1) + between_count(p));
  }

  void find_reaches(std::size_t axis) {
    const std::vector<double>& nodes = lattice_.nodes[axis];
    const bool periodic = geometry(lattice_.spec.id).node_period(axis) > 0 && nodes.size() > 1;
    const auto end = static_cast<std::int64_t>(nodes.size()) - 1;
    reaches_[axis].resize(nodes.size());
    for (std::int64_t at = 1; at <= end; ++at) {
      Reach& reach = reaches_[axis][static_cast<std::size_t>(at)];
      reach.at_deg = nodes[static_cast<std::size_t>(at)];
      const std::int64_t step = std::min(coarsest_, lowest_bit(static_cast<std::uint32_t>(at)));
      for (const std::int64_t steps : {-3, -1, 1, 3}) {
        std::int64_t index = at + steps * step;
        double turns = 0;
        if (periodic) {
          const std::int64_t wrapped = (index % end + end) % end;
          turns = static_cast<double>((index - wrapped) / end);
          index = wrapped;
        }
        if (index < 0 || index > end) continue;
        reach.position[reach.count] = nodes[static_cast<std::size_t>(index)] + turns * nodes.back();
        reach.corner_step[reach.count++] =
            static_cast<std::int32_t>((index - at) * static_cast<std::int64_t>(lattice_.corner_strides[axis]));
      }
    }
  }

  void add_block(std::uint32_t block) {
    std::uint32_t last = kUnknown;
    for (const std::uint32_t crossing : by_rank(blocks_.crossings[block])) {
      const auto first_stencil = static_cast<std::uint32_t>(plan_.stencils.size());
      const Point& p = first_[crossing];
      const std::uint32_t step = stride(p);
      std::uint32_t corner = 0;
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) corner += p[axis] * lattice_.corner_strides[axis];
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        if ((p[axis] & step) != 0) add_stencil(reaches_[axis][p[axis]], corner, block);
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

  // Those of equal rank stay in order.
  [[nodiscard]] std::vector<std::uint32_t> by_rank(const std::vector<std::uint32_t>& crossings) const {
    std::array<std::uint32_t, kMostRanks> end{};
    for (const std::uint32_t crossing : crossings) ++end[rank_[crossing]];
    std::uint32_t sum = 0;
    for (std::uint32_t& e : end) sum += std::exchange(e, sum);
    std::vector<std::uint32_t> order(crossings.size());
    for (const std::uint32_t crossing : crossings) order[end[rank_[crossing]]++] = crossing;
    return order;
  }

  void add_stencil(Reach& reach, std::uint32_t corner, std::uint32_t block) {
    Stencil& stencil = plan_.stencils.emplace_back();
    std::size_t known = 0;
    for (std::uint32_t k = 0; k < reach.count; ++k) {
      const std::uint32_t crossing = lattice_.corners[corner + static_cast<std::uint32_t>(reach.corner_step[k])];
      if (known_in_[crossing] != block) continue;
      stencil.member[stencil.count++] = crossing;
      known |= std::size_t{1} << k;
    }
    Weights& weights = reach.weights[known];
    if (weights.fitness == Fitness::kUntried) weights = make_weights(reach, known);
    stencil.weight = weights.weight;
    if (weights.fitness == Fitness::kUnusable) plan_.stencils.pop_back();
  }

  [[nodiscard]] static Weights make_weights(const Reach& reach, std::size_t known) {
    if (known == 0) return {Fitness::kUnusable, {}};
    std::array<double, kMostMembers> positions{};
    std::size_t count = 0;
    for (std::uint32_t k = 0; k < reach.count; ++k) {
      if ((known >> k & 1U) != 0) positions[count++] = reach.position[k];
    }
    Stencil stencil;
    set_weights(stencil, std::span(positions).first(count), reach.at_deg);
    const auto too_large = [](double w) { return std::abs(w) > kLargestWeight; };
    const bool usable = std::none_of(stencil.weight.begin(), stencil.weight.end(), too_large);
    return {usable ? Fitness::kUsable : Fitness::kUnusable, stencil.weight};
  }

  const Lattice& lattice_;
  const LatticeBlocks& blocks_;
  std::vector<Point> first_;
  std::vector<std::uint8_t> rank_;  ///< in the order of coding
  std::vector<std::uint32_t> known_in_;
  std::uint32_t coarsest_ = 1;
  std::array<std::vector<Reach>, kAxisCount> reaches_;  ///< by node
  CrossingPlan plan_;
};

// All weights get their first factor, then their second ...: divisions that do not wait for each other.
template <std::size_t Count>
void set_weights_of(Stencil& stencil, const double* positions, double at) {
  std::array<double, Count> weight;
  weight.fill(1);
  for (std::size_t factor = 0; factor + 1 < Count; ++factor) {
    for (std::size_t k = 0; k < Count; ++k) {
      const std::size_t j = factor < k ? factor : factor + 1;
      weight[k] *= (at - positions[j]) / (positions[k] - positions[j]);
    }
  }
  std::copy(weight.begin(), weight.end(), stencil.weight.begin());
}

}  // namespace

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

}  // namespace sbrdf::internal
