#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/frame/lattice.h"
#include "codec/frame/lattice_walk.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// How the samples of a file are spread over its chunks: what can be read, and left out, by itself.
///
/// The smallest file has all of them in one. Otherwise crossings, and the slices of each kind, are gathered in blocks
/// of neighbouring nodes. Samples on slices are further told apart by the refinement depth at which they lie, so that a
/// reader can stop early. specs/sbrdf.md, section 3.
struct ChunkLayout {
  static constexpr std::size_t kCrossings = kAxisCount;  ///< behind the four kinds of slices

  /// Everything is one chunk. Then there is one piece, and blocks hold whole axes.
  bool whole = true;
  /// The lowest depth of each piece: begins with 1, rises, at most kMaxDepth.
  std::vector<std::uint8_t> piece_depths = {1};
  /// Nodes to a block on each axis of the padded lattice; 0: the whole axis. A slice's own axis has no blocks.
  std::array<std::array<std::uint32_t, kAxisCount>, kAxisCount + 1> block_nodes{};

  bool operator==(const ChunkLayout&) const = default;
};

/// Depths [first, end) of a piece.
[[nodiscard]] std::pair<int, int> depths_of_piece(const ChunkLayout& layout, std::size_t piece);

/// Small blocks, for loading a region: about a thousand chunks, more for many samples.
[[nodiscard]] ChunkLayout split_layout(const Lattice& lattice, std::size_t sample_count);

/// The members of each block, by rising number. Blocks are ordered by their place on axis 3, then 2, 1, 0; those
/// without a member do not count.
using Blocks = std::vector<std::vector<std::uint32_t>>;

struct LatticeBlocks {
  Blocks crossings;
  std::array<Blocks, kAxisCount> slices;  ///< per kind
};
[[nodiscard]] LatticeBlocks make_blocks(const Lattice& lattice, const ChunkLayout& layout);

}  // namespace sbrdf::internal
