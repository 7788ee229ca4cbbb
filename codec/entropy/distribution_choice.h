#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "codec/entropy/contexts.h"
#include "codec/entropy/rans.h"

namespace sbrdf::internal {

/// What a chunk holds, before the distributions are known: first everything is recorded, then distributions are chosen
/// for all chunks together, then each is coded. A file then needs one byte for each context that it uses, and a chunk
/// no tables at all.
struct Event {
  std::int64_t value = 0;  ///< a residual, or 0 and 1 for a flag
  std::uint8_t context = 0;
  bool flag = false;
};

/// The distributions of a file, as its index holds them.
struct Distributions {
  static constexpr std::uint8_t kUnused = 0xFF;
  std::uint32_t token_count = Token::kDirect;
  std::array<std::uint8_t, CodingContext::kResidualCount> residuals{};  ///< numbers in the family, or kUnused
  std::array<std::uint8_t, CodingContext::kFlagCount> flags{};          ///< probability of yes in 1/256; 0 unused
};

struct DistributionChoice {
  Distributions distributions;
  std::uint64_t cost_256 = 0;  ///< bits that the events take with them, times 256
};

/// Gives every context that occurs the distribution, or the probability, with which it takes the fewest bits: a symbol
/// of frequency f takes log2(4096 / f) of them.
[[nodiscard]] DistributionChoice choose_distributions(const std::vector<std::vector<Event>>& chunks);

}  // namespace sbrdf::internal
