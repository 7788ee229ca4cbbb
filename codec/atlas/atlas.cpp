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

double kept_among(const std::vector<double>& nodes, double x_deg) {
  return x_deg > nodes.front() ? std::min(x_deg, nodes.back()) : nodes.front();  // also what is no number
}

/// Of several nodes, for a coordinate among them.
std::size_t cell_on(const std::vector<double>& nodes, double x_deg) {
  return static_cast<std::size_t>(std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x_deg) - nodes.begin()) - 1;
}

}  // namespace

AtlasCells::Counts cell_counts(const AtlasLayout& layout) {
  AtlasCells::Counts counts;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    counts[axis] = static_cast<std::uint32_t>(std::max<std::size_t>(layout.axes[axis].nodes_deg.size(), 2) - 1);
  }
  return counts;
}

AtlasCell cell_of(const AtlasLayout& layout, const Coordinates& folded) {
  AtlasCell cell{};
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const std::vector<double>& nodes = layout.axes[axis].nodes_deg;
    if (layout.axes[axis].moves()) cell[axis] = cell_on(nodes, kept_among(nodes, folded[axis]));
  }
  return cell;
}

AtlasCell cell_of(const AtlasLayout& layout, const DirectionPair& pair) {
  return cell_of(layout, fold_coordinates(layout, geometry(layout.frame).coordinates(pair)));
}

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
  const double x = kept_among(nodes, x_deg);
  AtlasPlace place;
  place.cell = cell_on(nodes, x);
  place.fraction = (x - nodes[place.cell]) / (nodes[place.cell + 1] - nodes[place.cell]);
  const double warped = axis.root_spacing && place.cell == 0 ? std::sqrt(place.fraction) : place.fraction;
  place.texel = axis.texels[place.cell] + warped * (axis.texels[place.cell + 1] - axis.texels[place.cell]);
  return place;
}

std::size_t step_count(const AtlasLayout& layout, std::size_t axis) {
  return layout.dense_along ? layout.axes[axis].texel_count() : layout.axes[axis].nodes_deg.size();
}

AtlasPlace place_between(const AtlasLayout& layout, std::size_t axis, const AtlasPlace& place) {
  if (!layout.dense_along || !layout.axes[axis].moves()) return place;
  AtlasPlace between = place;
  between.cell = std::min(static_cast<std::size_t>(place.texel), step_count(layout, axis) - 2);
  between.fraction = place.texel - static_cast<double>(between.cell);
  return between;
}

std::uint32_t tile_number(const AtlasLayout& layout, const AtlasTable& table, std::size_t first, std::size_t second) {
  if (table.triangular) return static_cast<std::uint32_t>(first * (first + 3) / 2 + second);
  const std::size_t row = table.between.size() > 1 ? step_count(layout, table.between[1]) : 1;
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
