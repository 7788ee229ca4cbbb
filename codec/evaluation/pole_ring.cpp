#include "codec/evaluation/pole_ring.h"

#include <algorithm>
#include <cmath>

namespace sbrdf::internal {
namespace {

constexpr double kSameDeg = 1e-6;  // as for nodes of a lattice

PoleRing make_ring(const Lattice& lattice, const Merging& merging) {
  PoleRing ring;
  ring.merging = merging;
  ring.along = merging.polar_axis == kHorizontal ? kVertical : kHorizontal;
  const std::size_t other = ring.other_azimuth();
  for (std::uint32_t a = 0; a < lattice.nodes[merging.ring_axis].size(); ++a) {
    for (std::uint32_t b = 0; b < lattice.nodes[other].size(); ++b) {
      Coordinates x{};
      x[merging.ring_axis] = lattice.nodes[merging.ring_axis][a];
      x[other] = lattice.nodes[other][b];
      double position = ring.position_deg(x);
      if (merging.period_deg - position < kSameDeg) position = 0;
      ring.nodes.push_back(
          {position, a * lattice.corner_strides[merging.ring_axis] + b * lattice.corner_strides[other],
           a * lattice.line_strides[ring.along][merging.ring_axis] + b * lattice.line_strides[ring.along][other]});
    }
  }
  std::stable_sort(ring.nodes.begin(), ring.nodes.end(),
                   [](const auto& p, const auto& q) { return p.position_deg < q.position_deg; });
  const auto same = [](const auto& p, const auto& q) { return q.position_deg - p.position_deg < kSameDeg; };
  ring.nodes.erase(std::unique(ring.nodes.begin(), ring.nodes.end(), same), ring.nodes.end());
  PoleRing::Node closing = ring.nodes.front();
  closing.position_deg = merging.period_deg;
  ring.nodes.push_back(closing);
  return ring;
}

}  // namespace

double PoleRing::position_deg(const Coordinates& x) const {
  return wrap(x[merging.ring_axis] + merging.sign * x[other_azimuth()], merging.period_deg);
}

std::size_t PoleRing::node_before(double position_deg) const {
  const auto after = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, position_deg,
                                      [](double at, const Node& node) { return at < node.position_deg; });
  return static_cast<std::size_t>(after - nodes.begin()) - 1;
}

std::vector<PoleRing> pole_rings(const Lattice& lattice) {
  std::vector<PoleRing> rings;
  for (const auto& nodes : lattice.nodes) {
    if (nodes.size() < 2) return rings;
  }
  for (const Merging& merging : geometry(lattice.spec.id).mergings()) rings.push_back(make_ring(lattice, merging));
  return rings;
}

}  // namespace sbrdf::internal
