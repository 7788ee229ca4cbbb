#include "codec/frame/cells.h"

#include <algorithm>
#include <cmath>

namespace sbrdf::internal {
namespace {

// Wide enough for the rounding of any conversion between angles.
constexpr double kSlackDeg = 1e-6;

struct Interval {
  double from = 0;
  double to = 0;
};

/// Whether [node, next) and [from, to) meet; the last cell of an axis holds its end and all beyond.
bool meets(double node, double next, bool last, const Interval& wanted) {
  return node < wanted.to && (last || wanted.from < next + kSlackDeg) && wanted.from <= wanted.to;
}

// (s, u) and (s + 360, u + 360) are the same directions, so s, too, is only known up to whole turns here.
bool meets_azimuth(double node, double next, const Interval& wanted) {
  constexpr double kTurn = 360;
  if (wanted.to - wanted.from >= kTurn) return true;
  for (double turn = -4 * kTurn; turn <= 4 * kTurn; turn += kTurn) {
    if (node + turn < wanted.to + kSlackDeg && wanted.from < next + turn + kSlackDeg) return true;
  }
  return false;
}

Interval azimuths(const DirectionBox& box) {
  const double from = wrap(box.phi_from, 360);
  double length = std::fmod(box.phi_to - box.phi_from, 360.0);
  if (length <= 0) length += 360;
  return {from, from + length};
}

bool cell_meets(const Lattice& lattice, const CellSet::Cell& cell, const DirectionBox& i, const DirectionBox& v) {
  const auto polar = [&](std::size_t axis, double from, double to) {
    const std::vector<double>& nodes = lattice.nodes[axis];
    if (nodes.size() < 2) return true;
    return meets(nodes[cell[axis]], nodes[cell[axis] + 1], cell[axis] + 2 == nodes.size(), {from, to});
  };
  const auto azimuth = [&](std::size_t axis, const Interval& wanted) {
    const std::vector<double>& nodes = lattice.nodes[axis];
    if (nodes.size() < 2) return true;
    return meets_azimuth(nodes[cell[axis]], nodes[cell[axis] + 1], wanted);
  };
  if (lattice.spec.id == FrameId::kHalfDifference) {
    // Half of the angle between the directions is at most half of the sum of their elevations, and the half vector
    // lies no lower than the lower of them.
    return polar(kHorizontal, 0, (i.theta_to + v.theta_to) / 2) &&
           polar(kVertical, 0, std::max(i.theta_to, v.theta_to));
  }
  // Slots by elevation: the smaller one is theta_i of the lattice.
  const double low_from = std::min(i.theta_from, v.theta_from);
  const double high_from = std::max(i.theta_from, v.theta_from);
  const double low_to = std::min(i.theta_to, v.theta_to);
  const double high_to = std::max(i.theta_to, v.theta_to);
  if (!polar(kVertical, low_from, low_to) || !polar(kHorizontal, high_from, high_to)) return false;
  const bool at_pole = cell[kVertical] == 0;  // there u is 0 and s is 2 phi_v
  const Interval phi_i = azimuths(i);
  const Interval phi_v = azimuths(v);
  const Interval sum = {phi_i.from + phi_v.from, phi_i.to + phi_v.to};
  const Interval difference = {phi_i.from - phi_v.to, phi_i.to - phi_v.from};
  if (at_pole) return true;
  return azimuth(kAxial, sum) &&
         (azimuth(kDiagonal, difference) || azimuth(kDiagonal, {-difference.to, -difference.from}));
}

}  // namespace

CellSet::CellSet(const Lattice& lattice) {
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    counts_[axis] = static_cast<std::uint32_t>(std::max<std::size_t>(1, lattice.nodes[axis].size() - 1));
    count *= counts_[axis];
  }
  inside_.assign(count, false);
}

std::size_t CellSet::size() const { return static_cast<std::size_t>(std::count(inside_.begin(), inside_.end(), true)); }

CellSet::Cell cell_of(const Lattice& lattice, const DirectionPair& pair) {
  const Coordinates x = geometry(lattice.spec.id).coordinates(pair);
  CellSet::Cell cell{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const std::vector<double>& nodes = lattice.nodes[axis];
    if (nodes.size() > 1) cell[axis] = cell_on_axis(nodes, cells_per_degree(nodes), x[axis]).index;
  }
  return cell;
}

CellSet cells_in(const Lattice& lattice, const DirectionBox& i, const DirectionBox& v) {
  CellSet cells(lattice);
  CellSet all(lattice);
  all.add_all();
  all.for_each([&](const CellSet::Cell& cell) {
    if (cell_meets(lattice, cell, i, v)) cells.add(cell);
  });
  return cells;
}

CellSet cells_of(const Lattice& lattice, std::span<const DirectionPair> pairs) {
  CellSet cells(lattice);
  for (const DirectionPair& pair : pairs) cells.add(cell_of(lattice, pair));
  return cells;
}

}  // namespace sbrdf::internal
