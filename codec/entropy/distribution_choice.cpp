#include "codec/entropy/distribution_choice.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kByte = 8 * 256;  // in 1/256 of a bit
constexpr unsigned kClasses = CodingContext::kClasses;

using Histogram = std::array<std::uint32_t, Token::kCount>;
/// What the events of one context take with each member of the family.
using FamilyCosts = std::array<std::uint64_t, Distribution::kFamilySize>;

/// Cost of every token under every distribution of the family, with all tokens: near enough to those of fewer.
class TokenCosts {
 public:
  TokenCosts() {
    for (unsigned number = 0; number < Distribution::kFamilySize; ++number) {
      const Distribution distribution = make_distribution(number, Token::kCount);
      for (unsigned t = 0; t < Token::kCount; ++t) cost_[number][t] = cost_256(distribution.frequency[t]);
    }
  }

  [[nodiscard]] FamilyCosts of(const Histogram& histogram) const {
    FamilyCosts costs{};
    for (unsigned t = 0; t < Token::kCount; ++t) {
      if (histogram[t] == 0) continue;
      for (unsigned number = 0; number < Distribution::kFamilySize; ++number) {
        costs[number] += std::uint64_t{histogram[t]} * cost_[number][t];
      }
    }
    return costs;
  }

 private:
  std::array<std::array<std::uint32_t, Token::kCount>, Distribution::kFamilySize> cost_{};
};

/// The events of all contexts, counted.
struct Counts {
  std::array<Histogram, CodingContext::kResidualCount> residuals{};
  std::array<std::array<std::uint64_t, 2>, CodingContext::kFlagCount> flags{};
  unsigned token_count = Token::kDirect;
  std::uint64_t plain_bits = 0;

  explicit Counts(const std::vector<std::vector<Event>>& chunks) {
    for (const std::vector<Event>& chunk : chunks) {
      for (const Event& event : chunk) count(event);
    }
  }

 private:
  void count(const Event& event) {
    if (event.flag) {
      ++flags[event.context][event.value != 0 ? 1 : 0];
      return;
    }
    const Token token = token_of(event.value);
    ++residuals[event.context][token.index];
    token_count = std::max(token_count, token.index + 1);
    plain_bits += token.bit_count;
  }
};

/// Something to choose, and what it costs.
template <class T>
struct Candidate {
  T choice{};
  std::uint64_t cost = std::numeric_limits<std::uint64_t>::max();

  void improve(const T& other, std::uint64_t other_cost) {
    if (other_cost < cost) *this = {other, other_cost};
  }
};

std::uint64_t cost_of(const GroupDistributions& group, std::span<const FamilyCosts> costs) {
  std::uint64_t sum = kByte;
  for (unsigned k = 0; k < kClasses; ++k) sum += costs[k][group.number(k)];
  return sum;
}

// The best distances from what the width and the shape of a group say.
void state_distances(GroupDistributions& group, std::span<const FamilyCosts> costs) {
  group.stated = true;
  for (unsigned k = 0; k < kClasses; ++k) {
    Candidate<std::int8_t> best;
    best.improve(0, costs[k][group.number(k)]);  // of equals the nearest to none
    for (int off = -GroupDistributions::kFarthest; off < GroupDistributions::kFarthest; ++off) {
      group.off[k] = static_cast<std::int8_t>(off);
      best.improve(group.off[k], costs[k][group.number(k)]);
    }
    group.off[k] = best.choice;
  }
}

/// No group of this shape costs less, whatever its width and distances.
std::uint64_t least_cost(bool long_tails, std::span<const FamilyCosts> costs) {
  std::uint64_t sum = kByte;
  for (const FamilyCosts& of_class : costs) {
    std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
    for (std::size_t number = long_tails ? 1 : 0; number < of_class.size(); number += 2) {
      least = std::min(least, of_class[number]);
    }
    sum += least;
  }
  return sum;
}

Candidate<GroupDistributions> choose_group(std::span<const FamilyCosts> costs) {
  constexpr std::uint64_t kDistances = kByte * kClasses / 2;
  Candidate<GroupDistributions> best;
  for (const bool long_tails : {false, true}) {
    const std::uint64_t least = least_cost(long_tails, costs) + kDistances;
    for (unsigned width = 0; width <= GroupDistributions::kMostWidth; ++width) {
      GroupDistributions group;
      group.width = static_cast<std::uint8_t>(width);
      group.long_tails = long_tails;
      best.improve(group, cost_of(group, costs));
      if (least >= best.cost) continue;  // distances, which take long to find, cannot pay
      state_distances(group, costs);
      best.improve(group, cost_of(group, costs) + kDistances);
    }
  }
  return best;
}

std::uint64_t cost_of_flags(const std::array<std::uint64_t, 2>& counts, std::uint8_t share) {
  const std::uint32_t yes = kProbabilityOne / 256 * share;
  return (counts[1] == 0 ? 0 : counts[1] * cost_256(yes)) +
         (counts[0] == 0 ? 0 : counts[0] * cost_256(kProbabilityOne - yes));
}

std::uint8_t share_of(const std::array<std::uint64_t, 2>& counts) {
  const std::uint64_t total = counts[0] + counts[1];
  if (counts[1] == 0) return 0;
  return static_cast<std::uint8_t>(std::clamp<std::uint64_t>((256 * counts[1] + total / 2) / total, 1, 255));
}

/// Sets all that Distributions holds of flags; gives the cost.
std::uint64_t choose_flags(const Counts& counts, Distributions& chosen) {
  constexpr unsigned kPerDepth = CodingContext::kFlagsPerDepth;
  std::uint64_t shared_cost = kByte;
  std::uint64_t own_cost = kByte;
  std::array<std::uint8_t, CodingContext::kFlagCount> shared{};
  std::array<std::uint8_t, CodingContext::kFlagCount> own{};
  for (unsigned depth = 0; depth < CodingContext::kFlagDepths; ++depth) {
    const std::span of_depth = std::span(counts.flags).subspan(depth * kPerDepth, kPerDepth);
    std::array<std::uint64_t, 2> together{};
    for (const auto& count : of_depth) together = {together[0] + count[0], together[1] + count[1]};
    if (together[1] == 0) continue;
    chosen.flag_depths = depth + 1;
    for (unsigned k = 0; k < kPerDepth; ++k) {
      shared[depth * kPerDepth + k] = share_of(together);
      own[depth * kPerDepth + k] = share_of(of_depth[k]);
      own_cost += cost_of_flags(of_depth[k], share_of(of_depth[k]));
    }
    shared_cost += cost_of_flags(together, share_of(together));
  }
  shared_cost += kByte * chosen.flag_depths;
  own_cost += kByte * chosen.flag_depths * kPerDepth;
  chosen.flags_by_depth = shared_cost <= own_cost;
  chosen.flags = chosen.flags_by_depth ? shared : own;
  return std::min(shared_cost, own_cost);
}

}  // namespace

std::uint8_t GroupDistributions::number(unsigned activity_class) const {
  constexpr int kWidths = Distribution::kWidths;
  const int at = width + static_cast<int>(activity_class) - static_cast<int>(kClasses) + off[activity_class];
  return static_cast<std::uint8_t>(2 * std::clamp(at, 0, kWidths - 1) + (long_tails ? 1 : 0));
}

std::uint8_t Distributions::number(unsigned context) const {
  if (context >= CodingContext::kGuideNode) return guide[context - CodingContext::kGuideNode];
  return groups[context / kClasses].number(context % kClasses);
}

DistributionChoice choose_distributions(const std::vector<std::vector<Event>>& chunks) {
  static const TokenCosts kCosts;
  const Counts counts(chunks);
  Distributions chosen;
  chosen.token_count = counts.token_count;
  std::uint64_t cost = 256 * counts.plain_bits;
  std::array<FamilyCosts, CodingContext::kResidualCount> costs;
  for (std::size_t k = 0; k < costs.size(); ++k) costs[k] = kCosts.of(counts.residuals[k]);
  for (std::size_t group = 0; group < chosen.groups.size(); ++group) {
    const auto best = choose_group(std::span(costs).subspan(group * kClasses, kClasses));
    chosen.groups[group] = best.choice;
    cost += best.cost;
  }
  for (std::size_t k = 0; k < chosen.guide.size(); ++k) {
    const FamilyCosts& of_guide = costs[CodingContext::kGuideNode + k];
    const auto best = std::min_element(of_guide.begin(), of_guide.end());
    chosen.guide[k] = static_cast<std::uint8_t>(best - of_guide.begin());
    cost += *best;
  }
  cost += choose_flags(counts, chosen);
  return {chosen, cost};
}

}  // namespace sbrdf::internal
