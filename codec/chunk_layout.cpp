#include "codec/chunk_layout.h"

#include <algorithm>
#include <bit>
#include <map>

namespace sbrdf {
namespace {

using Point = std::array<std::uint32_t, kAxisCount>;

constexpr std::uint32_t kUnseen = 0xFFFFFFFFU;

template <class Visit>
void walk(const Lattice& lattice, std::size_t left_out, const Visit& visit) {
  Point counts{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    counts[axis] = axis == left_out ? 1 : static_cast<std::uint32_t>(lattice.nodes[axis].size());
  }
  Point p{};
  for (p[3] = 0; p[3] < counts[3]; ++p[3])
    for (p[2] = 0; p[2] < counts[2]; ++p[2])
      for (p[1] = 0; p[1] < counts[1]; ++p[1])
        for (p[0] = 0; p[0] < counts[0]; ++p[0]) visit(p);
}

Point block_at(const Point& point, const std::array<std::uint32_t, kAxisCount>& block_nodes) {
  Point block{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    // Compared from axis 3 on.
    block[kAxisCount - 1 - axis] = block_nodes[axis] == 0 ? 0 : point[axis] / block_nodes[axis];
  }
  return block;
}

Blocks gather(const std::map<Point, std::vector<std::uint32_t>>& members, std::vector<std::uint32_t>& block_of) {
  Blocks blocks;
  for (const auto& [key, list] : members) {
    for (const std::uint32_t member : list) block_of[member] = static_cast<std::uint32_t>(blocks.size());
    blocks.push_back(list);
  }
  return blocks;
}

}  // namespace

int level_of(std::uint32_t fraction) {
  return fraction == 0 ? 0 : kMaxLevel - static_cast<int>(std::countr_zero(fraction));
}

ChunkLayout whole_layout() {
  ChunkLayout layout;
  layout.piece_levels = {1, 2, 3, 4, 5};
  return layout;
}

ChunkLayout split_layout(const Lattice& lattice, std::size_t sample_count) {
  // Found by trying block sizes on placements of the paper, for the least that one cell reads: short rows along the
  // elevations, a few nodes along the azimuths.
  ChunkLayout layout;
  layout.block_nodes[kAxial] = {0, 2, 1, 1};
  layout.block_nodes[kDiagonal] = {2, 0, 3, 1};
  layout.block_nodes[kHorizontal] = {2, 1, 0, 3};
  layout.block_nodes[kVertical] = {2, 1, 3, 0};
  layout.block_nodes[ChunkLayout::kCrossings] = {2, 2, 3, 1};
  constexpr std::size_t kManySamples = 65'536;
  if (sample_count >= kManySamples) layout.piece_levels = {1, 2, 4};
  const std::size_t most = std::max<std::size_t>(1536, sample_count / 64);
  const auto chunk_count = [&] {
    const LatticeBlocks blocks = make_blocks(lattice, layout);
    std::size_t count = 0;
    for (const Blocks& kind : blocks.slices) count += kind.size();
    return count * layout.piece_levels.size() + blocks.crossings.size();
  };
  for (std::size_t axis = 0; chunk_count() > most && axis < 8 * kAxisCount; ++axis) {
    for (auto& block : layout.block_nodes) block[axis % kAxisCount] *= 2;
  }
  return layout;
}

std::vector<Point> first_points(const Lattice& lattice) {
  std::vector<Point> first(lattice.crossings.size());
  std::vector<bool> seen(lattice.crossings.size(), false);
  std::size_t k = 0;
  walk(lattice, kAxisCount, [&](const Point& p) {
    const std::uint32_t crossing = lattice.corners[k++];
    if (!seen[crossing]) first[crossing] = p;
    seen[crossing] = true;
  });
  return first;
}

LatticeBlocks make_blocks(const Lattice& lattice, const ChunkLayout& layout) {
  LatticeBlocks blocks;
  blocks.block_of_crossing.resize(lattice.crossings.size());
  blocks.block_of_slice.assign(lattice.slices.size(), kUnseen);
  std::map<Point, std::vector<std::uint32_t>> members;
  const std::vector<Point> first = first_points(lattice);
  for (std::uint32_t k = 0; k < first.size(); ++k) {
    members[block_at(first[k], layout.block_nodes[ChunkLayout::kCrossings])].push_back(k);
  }
  blocks.crossings = gather(members, blocks.block_of_crossing);

  std::array<std::map<Point, std::vector<std::uint32_t>>, kAxisCount> by_kind;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (lattice.nodes[axis].size() < 2) continue;
    std::size_t line = 0;
    walk(lattice, axis, [&](const Point& p) {
      const LineReference& reference = lattice.lines[axis][line++];
      if (reference.is_constant() || blocks.block_of_slice[reference.target] != kUnseen) return;
      const SliceKind kind = lattice.slices[reference.target].kind;
      by_kind[kind][block_at(p, layout.block_nodes[kind])].push_back(reference.target);
      blocks.block_of_slice[reference.target] = 0;
    });
  }
  for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
    for (auto& [key, list] : by_kind[kind]) std::sort(list.begin(), list.end());
    blocks.slices[kind] = gather(by_kind[kind], blocks.block_of_slice);
  }
  return blocks;
}

}  // namespace sbrdf
