#include "codec/evaluation/needs.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "codec/evaluation/pole_ring.h"

namespace sbrdf::internal {
namespace {

constexpr double kSlackDeg = 1e-6;  // wide enough for the rounding of any conversion between angles

void mark_line(const LineReference& line, LatticeParts& parts) {
  if (line.is_constant()) {
    parts.crossings[line.crossing()] = true;
  } else {
    parts.slices[line.target] = true;
  }
}

// Bit k of `bits` tells the two sides of the cell on axis k apart; an axis of one node has one side only.
LatticePoint corner_of(const Lattice& lattice, const CellSet::Cell& cell, unsigned bits) {
  LatticePoint corner = cell;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const auto last = static_cast<std::uint32_t>(lattice.nodes[axis].size() - 1);
    corner[axis] = std::min(last, cell[axis] + ((bits >> axis) & 1U));
  }
  return corner;
}

// The lines that begin at a corner on the lower side of their axis, and what lies under it.
void mark_corner(const Lattice& lattice, const LatticePoint& corner, unsigned bits, LatticeParts& parts) {
  parts.crossings[lattice.corners[index_at(corner, lattice.corner_strides)]] = true;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (((bits >> axis) & 1U) != 0 || lattice.nodes[axis].size() < 2) continue;
    const LineReference& line = lattice.lines[axis][index_at(corner, lattice.line_strides[axis])];
    mark_line(line, parts);
  }
}

// Whether the azimuths of a cell can lead to a place between two nodes of the ring.
bool meets(const Lattice& lattice, const PoleRing& ring, const CellSet::Cell& cell, std::size_t node) {
  const Merging& merging = ring.merging;
  const std::size_t other = ring.other_azimuth();
  const auto side = [&](std::size_t axis, std::uint32_t k) { return lattice.nodes[axis][cell[axis] + k]; };
  const double low = side(merging.ring_axis, 0) + merging.sign * side(other, merging.sign > 0 ? 0 : 1);
  const double high = side(merging.ring_axis, 1) + merging.sign * side(other, merging.sign > 0 ? 1 : 0);
  for (double turn = -2 * merging.period_deg; turn <= 2 * merging.period_deg; turn += merging.period_deg) {
    if (ring.nodes[node].position_deg + turn < high + kSlackDeg &&
        low < ring.nodes[node + 1].position_deg + turn + kSlackDeg) {
      return true;
    }
  }
  return false;
}

void mark_ring(const Lattice& lattice, const PoleRing& ring, const CellSet::Cell& cell, LatticeParts& parts) {
  if (cell[ring.merging.polar_axis] != 0) return;
  const std::size_t ring_axis = ring.merging.ring_axis;
  for (std::uint32_t at = cell[ring.along]; at < cell[ring.along] + 2; ++at) {
    mark_line(lattice.lines[ring_axis][at * lattice.line_strides[ring_axis][ring.along]], parts);
  }
  for (std::size_t k = 0; k + 1 < ring.nodes.size(); ++k) {
    if (!meets(lattice, ring, cell, k)) continue;
    for (const std::size_t node : {k, k + 1}) {
      mark_line(lattice.lines[ring.along][ring.nodes[node].line], parts);
      for (std::uint32_t at = cell[ring.along]; at < cell[ring.along] + 2; ++at) {
        const std::uint32_t corner = ring.nodes[node].corner + at * lattice.corner_strides[ring.along];
        parts.crossings[lattice.corners[corner]] = true;
      }
    }
  }
}

}  // namespace

LatticeParts needs_of(const Lattice& lattice, const CellSet& cells) {
  LatticeParts needs = {std::vector<bool>(lattice.crossings.size()), std::vector<bool>(lattice.slices.size())};
  const std::vector<PoleRing> rings = pole_rings(lattice);
  cells.for_each([&](const CellSet::Cell& cell) {
    for (unsigned bits = 0; bits < 16; ++bits) mark_corner(lattice, corner_of(lattice, cell, bits), bits, needs);
    for (const PoleRing& ring : rings) mark_ring(lattice, ring, cell, needs);
  });
  for (std::size_t k = 0; k < lattice.slices.size(); ++k) {
    if (!needs.slices[k]) continue;
    for (const SliceNode& node : lattice.nodes_of(lattice.slices[k])) needs.crossings[node.crossing] = true;
  }
  return needs;
}

}  // namespace sbrdf::internal
