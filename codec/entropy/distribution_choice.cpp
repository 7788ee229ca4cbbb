#include "codec/entropy/distribution_choice.h"

#include <algorithm>
#include <array>
#include <limits>

namespace sbrdf::internal {
namespace {

using Histograms = std::array<std::array<std::uint32_t, Token::kCount>, CodingContext::kResidualCount>;

// Cost of every token under every distribution of the family.
class FamilyCosts {
 public:
  explicit FamilyCosts(unsigned token_count) {
    for (unsigned number = 0; number < Distribution::kFamilySize; ++number) {
      const Distribution distribution = make_distribution(number, token_count);
      for (unsigned t = 0; t < token_count; ++t) cost_[number][t] = cost_256(distribution.frequency[t]);
    }
  }

  struct Choice {
    std::uint8_t number = 0;
    std::uint64_t cost = std::numeric_limits<std::uint64_t>::max();
  };
  [[nodiscard]] Choice cheapest(const std::array<std::uint32_t, Token::kCount>& histogram, unsigned token_count) const {
    std::array<unsigned, Token::kCount> used{};
    std::size_t used_count = 0;
    for (unsigned t = 0; t < token_count; ++t) {
      if (histogram[t] != 0) used[used_count++] = t;
    }
    Choice best;
    for (unsigned number = 0; number < Distribution::kFamilySize; ++number) {
      std::uint64_t cost = 0;
      for (std::size_t k = 0; k < used_count; ++k) cost += std::uint64_t{histogram[used[k]]} * cost_[number][used[k]];
      if (cost < best.cost) best = {static_cast<std::uint8_t>(number), cost};
    }
    return best;
  }

 private:
  std::array<std::array<std::uint32_t, Token::kCount>, Distribution::kFamilySize> cost_{};
};

}  // namespace

DistributionChoice choose_distributions(const std::vector<std::vector<Event>>& chunks) {
  Distributions chosen;
  Histograms histograms{};
  std::array<std::array<std::uint32_t, 2>, CodingContext::kFlagCount> flags{};
  unsigned token_count = Token::kDirect;
  std::uint64_t plain = 0;
  for (const std::vector<Event>& chunk : chunks) {
    for (const Event& event : chunk) {
      if (event.flag) {
        ++flags[event.context][event.value != 0 ? 1 : 0];
        continue;
      }
      const Token token = token_of(event.value);
      ++histograms[event.context][token.index];
      token_count = std::max(token_count, token.index + 1);
      plain += token.bit_count;
    }
  }
  static const FamilyCosts kCosts(Token::kCount);  // near enough to those of fewer tokens
  chosen.token_count = token_count;
  std::uint64_t cost = 256 * plain;
  for (std::size_t k = 0; k < histograms.size(); ++k) {
    const bool used = std::any_of(histograms[k].begin(), histograms[k].end(), [](auto n) { return n != 0; });
    chosen.residuals[k] = Distributions::kUnused;
    if (!used) continue;
    const FamilyCosts::Choice choice = kCosts.cheapest(histograms[k], token_count);
    chosen.residuals[k] = choice.number;
    cost += choice.cost;
  }
  for (std::size_t k = 0; k < flags.size(); ++k) {
    const std::uint64_t total = std::uint64_t{flags[k][0]} + flags[k][1];
    chosen.flags[k] = 0;
    if (total == 0) continue;
    const std::uint64_t share =
        std::clamp<std::uint64_t>((256 * std::uint64_t{flags[k][1]} + total / 2) / total, 1, 255);
    chosen.flags[k] = static_cast<std::uint8_t>(share);
    cost += flags[k][1] * std::uint64_t{cost_256(static_cast<std::uint32_t>(16 * share))} +
            flags[k][0] * std::uint64_t{cost_256(static_cast<std::uint32_t>(kProbabilityOne - 16 * share))};
  }
  return {chosen, cost};
}

}  // namespace sbrdf::internal
