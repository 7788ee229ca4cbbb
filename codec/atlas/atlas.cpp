#include "codec/atlas/atlas.h"

#include <algorithm>
#include <cmath>

#include "codec/frame/frame.h"

namespace sbrdf::internal {
namespace {

// phi -> -phi of both directions.
void mirror(Coordinates& x, double phi_h_deg) {
  x[kAxial] = phi_h_deg - x[kAxial];
  x[kDiagonal] = x[kDiagonal] == 0 ? 0 : 180 - x[kDiagonal];
}

}  // namespace

Coordinates fold_coordinates(const AtlasLayout& layout, Coordinates x) {
  const Symmetries& symmetries = layout.symmetries;
  const bool half = layout.frame == FrameId::kHalfDifference;
  if (symmetries.isotropic) {
    x[kAxial] = 0;
    const double turn = half ? 180 : 360;
    if (symmetries.mirror_x || symmetries.mirror_y) x[kDiagonal] = std::min(x[kDiagonal], turn - x[kDiagonal]);
    return x;
  }
  if (!half || !symmetries.mirror_x) return x;
  if (symmetries.mirror_y && x[kAxial] >= 180) x[kAxial] -= 180;
  const double plane = symmetries.mirror_y ? 90 : 180;
  if (x[kAxial] > plane) mirror(x, 2 * plane);
  return x;
}

AtlasPlace place_on(const AtlasAxis& axis, double x_deg) {
  if (!axis.moves()) return {};
  const std::vector<double>& nodes = axis.nodes_deg;
  const double x = x_deg > nodes.front() ? std::min(x_deg, nodes.back()) : nodes.front();  // also what is no number
  const auto after = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x);
  AtlasPlace place;
  place.cell = static_cast<std::size_t>(after - nodes.begin()) - 1;
  place.fraction = (x - nodes[place.cell]) / (nodes[place.cell + 1] - nodes[place.cell]);
  const double warped = axis.root_spacing && place.cell == 0 ? std::sqrt(place.fraction) : place.fraction;
  place.texel = axis.texels[place.cell] + warped * (axis.texels[place.cell + 1] - axis.texels[place.cell]);
  return place;
}

std::uint32_t tile_number(const AtlasLayout& layout, const AtlasTable& table, std::size_t first, std::size_t second) {
  if (table.triangular) return static_cast<std::uint32_t>(first * (first + 3) / 2 + second);
  const std::size_t row = table.between.size() > 1 ? layout.axes[table.between[1]].nodes_deg.size() : 1;
  return static_cast<std::uint32_t>(first * row + second);
}

std::vector<AtlasPole> poles(const AtlasLayout& layout) {
  std::vector<AtlasPole> poles;
  if (!layout.ring) return poles;
  for (const Merging& merging : geometry(layout.frame).mergings()) {
    poles.push_back({merging.polar_axis, merging.polar_axis == kHorizontal ? kVertical : kHorizontal, merging.ring_axis,
                     static_cast<double>(merging.sign)});
  }
  return poles;
}

}  // namespace sbrdf::internal
