#pragma once

#include <cstddef>
#include <vector>

#include "codec/search/structure_search.h"

namespace sbrdf::internal {

/// What a round of a search tries.
struct Moves {
  std::vector<Structure> structures;  ///< each differs from where it was begun
  std::size_t known = 0;              ///< moves left out because they lead to where it was begun
};

/// All single moves from a structure: on each axis a node more in the middle of each cell, each inner node gone, each
/// inner node a third of its way to a neighbour; the other domain, where it is open; another floor; another guide,
/// where the frame and the domain may have one. They come in this order, which decides between equals.
[[nodiscard]] Moves moves_from(const Structure& structure, const SearchOptions& options);

}  // namespace sbrdf::internal
