#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "converters/judge/pair_checks.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "converters/tables/dense_table.h"

namespace sbrdf::internal {

/// Shares over every node of a table that lies above the horizon: plain, and by the solid angle of both directions that
/// a node stands for. The same bits for any number of threads.
[[nodiscard]] Shares shares_of_nodes(const DenseTable& table);

/// A node that stands out from all that is around it.
struct Spike {
  GridNode node = {0, 0, 0, 0};
  DirectionPair pair;
  std::string place;  ///< "theta_i 30, phi_i 0, theta_v 45, phi_v 180 degrees"
  std::size_t channel = 0;
  double value = 0;    ///< f_r
  double least = 0;    ///< of the nodes around it
  double largest = 0;  ///< likewise
  double excess = 0;   ///< by how much, as a logarithm
};

struct SpikeSearch {
  std::uint64_t nodes = 0;   ///< that were looked at
  std::uint64_t count = 0;   ///< nodes with a spike in some channel
  std::vector<Spike> worst;  ///< the farthest out, at most kMostSpikes, each node once
  /// Nodes where so many around stand out, or in their whole plane of the last two axes, that single ones cannot be
  /// told.
  std::uint64_t too_noisy = 0;
};
inline constexpr std::size_t kMostSpikes = 10;

/// Looks for single nodes that no material makes. With L = asinh(f / 2 floor), about log(f / floor), where floor is a
/// hundredth of the channel's median |f| and no less than a tenth of the largest channel of the node, a node is a spike
/// where in each of the up to 40 directions of the grid through it (along axes and diagonals) it lies on the same side
/// of the middle of its two neighbours by more than log 2 and by more than three times the median step across it; on an
/// axis' end it is held against the line through the two nodes inside. Its f is also farther than 8 median deviations
/// from the median of the nodes around. A highlight goes on along some diagonal, and is none. At least two axes must
/// have neighbours on both sides that it is beyond by a quarter: a candidate. Where candidates crowd, the table is
/// noise. The same for any number of threads. interrupted_error().
[[nodiscard]] Result<SpikeSearch> find_spikes(const DenseTable& table, const Progress& progress);

}  // namespace sbrdf::internal
