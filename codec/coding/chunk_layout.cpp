#include "codec/coding/chunk_layout.h"

#include <algorithm>

namespace sbrdf::internal {
namespace {

using Point = LatticePoint;

/// Blocks numbered by their place on axis 3, then 2, 1, 0, with and without members.
class BlockGrid {
 public:
  BlockGrid(const Lattice& lattice, const std::array<std::uint32_t, kAxisCount>& block_nodes) {
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      const auto nodes = static_cast<std::uint32_t>(lattice.nodes[axis].size());
      const std::uint32_t size = block_nodes[axis] == 0 ? nodes : block_nodes[axis];
      for (std::uint32_t k = 0; k < nodes; ++k) part_[axis].push_back(k / size * count_);
      count_ *= (nodes - 1) / size + 1;
    }
  }

  void add(const Point& p, std::uint32_t member) {
    members_.push_back(member);
    places_.push_back(part_[0][p[0]] + part_[1][p[1]] + part_[2][p[2]] + part_[3][p[3]]);
  }

  /// The blocks with members.
  [[nodiscard]] Blocks blocks() const {
    std::vector<std::uint32_t> sizes(count_, 0);
    for (const std::uint32_t place : places_) ++sizes[place];
    Blocks blocks;
    std::vector<std::uint32_t> number(count_, 0);
    for (std::uint32_t place = 0; place < count_; ++place) {
      if (sizes[place] == 0) continue;
      number[place] = static_cast<std::uint32_t>(blocks.size());
      blocks.emplace_back().reserve(sizes[place]);
    }
    for (std::size_t k = 0; k < members_.size(); ++k) blocks[number[places_[k]]].push_back(members_[k]);
    return blocks;
  }

 private:
  std::array<std::vector<std::uint32_t>, kAxisCount> part_;  ///< of a block's number, by node
  std::uint32_t count_ = 1;
  std::vector<std::uint32_t> members_;
  std::vector<std::uint32_t> places_;
};

}  // namespace

std::pair<int, int> depths_of_piece(const ChunkLayout& layout, std::size_t piece) {
  const bool last = piece + 1 == layout.piece_depths.size();
  return {layout.piece_depths[piece], last ? kMaxDepth + 1 : layout.piece_depths[piece + 1]};
}

ChunkLayout split_layout(const Lattice& lattice, std::size_t sample_count) {
  // Found by trying some hundred choices on 10/36 files, for the least that one pair of directions and theta below 40
  // degrees read (tests/benchmarks/loading_benchmark): single nodes along the elevations, a few along the azimuths.
  ChunkLayout layout;
  layout.whole = false;
  layout.block_nodes[kAxial] = {0, 1, 1, 1};
  layout.block_nodes[kDiagonal] = {1, 0, 1, 1};
  layout.block_nodes[kHorizontal] = {2, 1, 0, 1};
  layout.block_nodes[kVertical] = {4, 4, 1, 0};
  layout.block_nodes[ChunkLayout::kCrossings] = {2, 2, 2, 1};
  constexpr std::size_t kManySamples = 65'536;
  if (sample_count >= kManySamples) layout.piece_depths = {1, 2, 4};
  const std::size_t most = std::max<std::size_t>(1536, sample_count / 64);
  const auto chunk_count = [&] {
    const LatticeBlocks blocks = make_blocks(lattice, layout);
    std::size_t count = 0;
    for (const Blocks& kind : blocks.slices) count += kind.size();
    return count * layout.piece_depths.size() + blocks.crossings.size();
  };
  for (std::size_t axis = 0; chunk_count() > most && axis < 8 * kAxisCount; ++axis) {
    for (auto& block : layout.block_nodes) block[axis % kAxisCount] *= 2;
  }
  return layout;
}

// Crossings and slices have their numbers in the order in which the walks meet them.

LatticeBlocks make_blocks(const Lattice& lattice, const ChunkLayout& layout) {
  LatticeBlocks blocks;
  BlockGrid crossings(lattice, layout.block_nodes[ChunkLayout::kCrossings]);
  std::uint32_t crossing = 0;
  for (const Point& p : first_points(lattice)) crossings.add(p, crossing++);
  blocks.crossings = crossings.blocks();

  std::vector<BlockGrid> by_kind;
  by_kind.reserve(kAxisCount);
  for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
    by_kind.emplace_back(lattice, layout.block_nodes[kind]);
  }
  std::uint32_t slice = 0;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (lattice.nodes[axis].size() < 2) continue;
    std::size_t line = 0;
    walk_lattice(lattice, axis, [&](const Point& p) {
      if (lattice.lines[axis][line++].target != slice) return;
      by_kind[lattice.slices[slice].kind].add(p, slice);
      ++slice;
    });
  }
  for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
    blocks.slices[kind] = by_kind[kind].blocks();
  }
  return blocks;
}

}  // namespace sbrdf::internal
