#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "codec/atlas/atlas.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kBlock = 4;

std::uint32_t rounded_up(std::uint32_t count) { return (count + kBlock - 1) / kBlock * kBlock; }

/// A rectangle of tiles, to be put below others.
struct Area {
  std::uint32_t tile_width = 0, tile_height = 0, tile_count = 0;

  [[nodiscard]] std::uint32_t per_row(std::uint32_t width) const { return width / tile_width; }
  [[nodiscard]] std::uint64_t height(std::uint32_t width) const {
    return std::uint64_t{(tile_count + per_row(width) - 1) / per_row(width)} * tile_height;
  }
};

std::size_t node_count(const AtlasLayout& layout, std::size_t axis) { return layout.axes[axis].nodes_deg.size(); }

AtlasTable make_table(const AtlasLayout& layout, std::size_t along) {
  AtlasTable table;
  table.along = along;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (axis == along || !layout.axes[axis].moves()) continue;
    if (!table.across) {
      table.across = axis;
    } else {
      table.between.push_back(axis);
    }
  }
  table.triangular =
      layout.frame == FrameId::kElevation && table.between == std::vector<std::size_t>{kHorizontal, kVertical};
  table.tile_width = layout.axes[along].texel_count();
  table.tile_height = table.across ? static_cast<std::uint32_t>(node_count(layout, *table.across)) : 1;
  if (layout.blocks) {
    table.tile_width = rounded_up(table.tile_width);
    table.tile_height = rounded_up(table.tile_height);
  }
  std::size_t tiles = 1;
  for (const std::size_t axis : table.between) tiles *= node_count(layout, axis);
  const std::size_t n = node_count(layout, kHorizontal);
  if (table.triangular) tiles = n * (n + 3) / 2 - 1;
  table.tile_count = static_cast<std::uint32_t>(tiles);
  return table;
}

Status choose_sides(const std::vector<Area>& areas, std::uint32_t most_side, AtlasLayout& layout) {
  // The width with the fewest texels; of equals the one nearest to a square.
  std::uint32_t least = kBlock;
  for (const Area& area : areas) least = std::max(least, rounded_up(area.tile_width));
  std::uint64_t best = std::numeric_limits<std::uint64_t>::max();
  for (std::uint32_t width = least; width <= most_side; width += kBlock) {
    std::uint64_t height = 0;
    for (const Area& area : areas) height += area.height(width);
    height = (height + kBlock - 1) / kBlock * kBlock;
    if (height > most_side || width > 4 * height + least) continue;
    if (height * width >= best) continue;
    best = height * width;
    layout.width = width;
    layout.height = static_cast<std::uint32_t>(height);
  }
  if (best == std::numeric_limits<std::uint64_t>::max()) {
    return unsupported("no texture of " + std::to_string(most_side) + " x " + std::to_string(most_side) +
                       " texels holds this material");
  }
  return ok_status();
}

}  // namespace

Status lay_out(AtlasLayout& layout, std::uint32_t most_side) {
  layout.tables.clear();
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    if (layout.axes[axis].moves()) layout.tables.push_back(make_table(layout, axis));
  }
  std::vector<Area> areas;
  for (const AtlasTable& table : layout.tables)
    areas.push_back({table.tile_width, table.tile_height, table.tile_count});
  if (layout.ring) {
    AtlasRing& ring = *layout.ring;
    ring.tile_width = layout.blocks ? rounded_up(ring.ring_texels + 1) : ring.ring_texels + 1;
    const std::uint32_t height = layout.axes[kHorizontal].texel_count();
    ring.tile_height = layout.blocks ? rounded_up(height) : height;
    areas.push_back({ring.tile_width, ring.tile_height, 1});
  }
  if (Status chosen = choose_sides(areas, most_side, layout); !chosen) return chosen;
  std::uint32_t y = 0;
  for (std::size_t k = 0; k < areas.size(); ++k) {
    if (k < layout.tables.size()) {
      layout.tables[k].y = y;
      layout.tables[k].tiles_per_row = areas[k].per_row(layout.width);
    } else {
      layout.ring->y = y;
    }
    y += static_cast<std::uint32_t>(areas[k].height(layout.width));
  }
  return ok_status();
}

}  // namespace sbrdf::internal
