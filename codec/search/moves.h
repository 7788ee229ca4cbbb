#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "codec/search/structure_search.h"

namespace sbrdf::internal {

/// A small change of a structure.
struct Move {
  Structure to;          ///< with this change alone
  std::size_t part = 0;  ///< what is changed: the nodes of that axis, or kFloorPart or kGuidePart
  double first_deg = 0;  ///< of an axis: only nodes between these two are changed
  double last_deg = 0;
};
inline constexpr std::size_t kFloorPart = kAxisCount;
inline constexpr std::size_t kGuidePart = kAxisCount + 1;

/// All single moves from a structure: on each axis a node more in the middle of each cell, each inner node gone, each
/// inner node a third of its way to a neighbour; another floor; another guide, where the frame and the domain may have
/// one. They come in this order, which decides between equals.
[[nodiscard]] std::vector<Move> moves_from(const Structure& structure, const SearchOptions& options);

/// Whether two moves from one structure change different things, so that both can be made.
[[nodiscard]] bool are_apart(const Move& a, const Move& b);

/// A structure with some moves from it made, all of which are apart.
[[nodiscard]] Structure with_moves(const Structure& from, std::span<const Move> moves);

}  // namespace sbrdf::internal
