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

/// The distributions of a group of contexts, one for each class of activity. Classes are half octaves, as widths are:
/// so a group's widths rise by one from class to class, unless a file says by how much they are off.
struct GroupDistributions {
  static constexpr unsigned kMostWidth = 63;
  static constexpr int kFarthest = 8;  ///< off by -8 to 7

  std::uint8_t width = 32;  ///< of class 16, if there were one; 0 to kMostWidth
  bool long_tails = false;  ///< the shape of all
  bool stated = false;      ///< whether `off` is in the file, else all are 0
  std::array<std::int8_t, CodingContext::kClasses> off{};

  /// The member of the family for a class.
  [[nodiscard]] std::uint8_t number(unsigned activity_class) const;

  bool operator==(const GroupDistributions&) const = default;
};

/// The distributions of a file, as its index holds them. Those of contexts that the file has no use for do not count.
struct Distributions {
  std::uint32_t token_count = Token::kDirect;
  std::array<GroupDistributions, CodingContext::kGroups> groups{};
  std::array<std::uint8_t, 2> guide{};  ///< members of the family: for its nodes, for its samples
  /// Depths of which flags are ever yes; no flag is asked for at greater ones but for the sake of saying no.
  std::uint32_t flag_depths = 0;
  bool flags_by_depth = true;                                   ///< the flags of a depth share one probability
  std::array<std::uint8_t, CodingContext::kFlagCount> flags{};  ///< probability of yes in 1/256; 0: never

  /// The member of the family for a residual context.
  [[nodiscard]] std::uint8_t number(unsigned context) const;

  bool operator==(const Distributions&) const = default;
};

struct DistributionChoice {
  Distributions distributions;
  std::uint64_t cost_256 = 0;  ///< bits that the events and the distributions take, times 256
};

/// Those with which the events take the fewest bits, what the index takes for them included: a symbol of frequency f
/// takes log2(4096 / f) of them.
[[nodiscard]] DistributionChoice choose_distributions(const std::vector<std::vector<Event>>& chunks);

}  // namespace sbrdf::internal
