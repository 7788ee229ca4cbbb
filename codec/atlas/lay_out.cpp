#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "codec/atlas/atlas.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint32_t kBlock = 4;
constexpr std::uint32_t kMostTiles = 1U << 31U;  // so many are in no texture
constexpr std::uint32_t kMostTilesInPart = 1U << 20U;

std::uint32_t rounded_up(std::uint32_t count) { return (count + kBlock - 1) / kBlock * kBlock; }

/// A rectangle of tiles, to be put below others.
struct Area {
  std::uint32_t tile_width = 0, tile_height = 0, tile_count = 0;

  [[nodiscard]] std::uint32_t per_row(std::uint32_t width) const { return width / tile_width; }
  [[nodiscard]] std::uint64_t height(std::uint32_t width) const {
    return (std::uint64_t{tile_count} + per_row(width) - 1) / per_row(width) * tile_height;
  }
};

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
  table.tile_height = table.across ? static_cast<std::uint32_t>(step_count(layout, *table.across)) : 1;
  if (layout.blocks) {
    table.tile_width = rounded_up(table.tile_width);
    table.tile_height = rounded_up(table.tile_height);
  }
  std::size_t tiles = 1;
  for (const std::size_t axis : table.between) tiles *= step_count(layout, axis);
  const std::size_t n = step_count(layout, kHorizontal);
  if (table.triangular) tiles = n * (n + 3) / 2 - 1;
  table.tile_count = static_cast<std::uint32_t>(std::min<std::size_t>(tiles, kMostTiles));
  return table;
}

/// The width with the fewest texels; of equals the one nearest to a square.
template <class HeightOf>
Status choose_width(std::uint32_t least, std::uint32_t most_side, const HeightOf& height_of, AtlasLayout& layout) {
  std::uint64_t best = std::numeric_limits<std::uint64_t>::max();
  for (std::uint32_t width = least; width <= most_side; width += kBlock) {
    const std::uint64_t height = (height_of(width) + kBlock - 1) / kBlock * kBlock;
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

Status choose_sides(const std::vector<Area>& areas, std::uint32_t most_side, AtlasLayout& layout) {
  std::uint32_t least = kBlock;
  for (const Area& area : areas) least = std::max(least, rounded_up(area.tile_width));
  const auto height_of = [&](std::uint32_t width) {
    std::uint64_t height = 0;
    for (const Area& area : areas) height += area.height(width);
    return height;
  };
  return choose_width(least, most_side, height_of, layout);
}

// Row by row, from the place of each table on.
void place_whole_tiles(AtlasTable& table) {
  for (std::uint32_t k = 0; k < table.tile_count; ++k) {
    table.tiles.push_back({.x = table.x + k % table.tiles_per_row * table.tile_width,
                           .y = table.y + k / table.tiles_per_row * table.tile_height,
                           .width = table.tile_width,
                           .height = table.tile_height});
  }
}

Status lay_out_whole(AtlasLayout& layout, std::uint32_t most_side) {
  std::vector<Area> areas;
  for (const AtlasTable& table : layout.tables)
    areas.push_back({table.tile_width, table.tile_height, table.tile_count});
  if (layout.ring) areas.push_back({layout.ring->tile_width, layout.ring->tile_height, 1});
  if (Status chosen = choose_sides(areas, most_side, layout); !chosen) return chosen;
  std::uint32_t y = 0;
  for (std::size_t k = 0; k < areas.size(); ++k) {
    if (k < layout.tables.size()) {
      layout.tables[k].y = y;
      layout.tables[k].tiles_per_row = areas[k].per_row(layout.width);
      place_whole_tiles(layout.tables[k]);
    } else {
      layout.ring->y = y;
    }
    y += static_cast<std::uint32_t>(areas[k].height(layout.width));
  }
  return ok_status();
}

/// The first and the last of some texels, rows or tiles.
using Steps = std::array<std::uint32_t, 2>;

/// Those of an axis that a cell lies between, for tables along other axes.
Steps steps_of(const AtlasLayout& layout, std::size_t axis, const AtlasCell& cell) {
  const auto node = static_cast<std::uint32_t>(cell[axis]);
  if (!layout.dense_along) return {node, node + 1};
  const std::vector<std::uint32_t>& texels = layout.axes[axis].texels;
  return {texels[node], texels[node + 1]};
}

/// Widens the part of a tile that is held, which may be none yet.
void hold(AtlasTile& tile, const Steps& columns, const Steps& rows) {
  const auto widen = [](std::uint32_t& first, std::uint32_t& size, const Steps& part) {
    const std::uint32_t end = size == 0 ? part[1] : std::max(first + size - 1, part[1]);
    first = size == 0 ? part[0] : std::min(first, part[0]);
    size = end - first + 1;
  };
  widen(tile.first_column, tile.width, columns);
  widen(tile.first_row, tile.height, rows);
}

// Of each tile, the texels between which the cells lie that use it.
void hold_needed(const AtlasLayout& layout, AtlasTable& table) {
  table.tiles.assign(table.tile_count, {});
  layout.cells.for_each([&](const AtlasCell& cell) {
    const std::vector<std::uint32_t>& texels = layout.axes[table.along].texels;
    const Steps columns = {texels[cell[table.along]], texels[cell[table.along] + 1]};
    const Steps rows = table.across ? steps_of(layout, *table.across, cell) : Steps{0, 0};
    const Steps first = table.between.empty() ? Steps{0, 0} : steps_of(layout, table.between[0], cell);
    const Steps second = table.between.size() < 2 ? Steps{0, 0} : steps_of(layout, table.between[1], cell);
    for (std::uint32_t a = first[0]; a <= first[1]; ++a) {
      for (std::uint32_t b = second[0]; b <= second[1]; ++b) {
        // Of cells where theta_i is above theta_v, which nobody asks for.
        if (table.triangular && b > a + 1) continue;
        hold(table.tiles[tile_number(layout, table, a, b)], columns, rows);
      }
    }
  });
  for (AtlasTile& tile : table.tiles) {
    if (!layout.blocks) continue;
    tile.width = rounded_up(tile.width);
    tile.height = rounded_up(tile.height);
  }
}

bool needs_ring(const AtlasLayout& layout) {
  const std::vector<AtlasPole> at = poles(layout);
  bool needed = false;
  layout.cells.for_each([&](const AtlasCell& cell) {
    for (const AtlasPole& pole : at) needed = needed || cell[pole.polar_axis] == 0;
  });
  return needed;
}

/// Puts tiles side by side on shelves of a width, in their order; the height of all shelves.
std::uint64_t shelve(const std::vector<AtlasTile*>& tiles, std::uint32_t width, bool place) {
  std::uint32_t x = 0;
  std::uint64_t y = 0;
  std::uint32_t shelf = 0;
  for (AtlasTile* const tile : tiles) {
    if (x + tile->width > width) {
      y += shelf;
      x = 0;
      shelf = 0;
    }
    if (place) {
      tile->x = x;
      tile->y = static_cast<std::uint32_t>(y);
    }
    x += tile->width;
    shelf = std::max(shelf, tile->height);
  }
  return y + shelf;
}

Status lay_out_part(AtlasLayout& layout, std::uint32_t most_side) {
  if (layout.cells.counts() != cell_counts(layout)) return usage_error("cells of other axes");
  if (layout.cells.size() == 0) return usage_error("an atlas of no cell at all");
  AtlasTile ring;
  std::vector<AtlasTile*> tiles;
  for (AtlasTable& table : layout.tables) {
    if (table.tile_count > kMostTilesInPart) return unsupported("too many tiles, of which some are left out");
    table.tiles_per_row = 0;
    hold_needed(layout, table);
    for (AtlasTile& tile : table.tiles) {
      if (tile.width > 0) tiles.push_back(&tile);
    }
  }
  if (layout.ring && !needs_ring(layout)) layout.ring->tile_width = layout.ring->tile_height = 0;
  if (layout.ring && layout.ring->tile_width > 0) {
    ring.width = layout.ring->tile_width;
    ring.height = layout.ring->tile_height;
    tiles.push_back(&ring);
  }
  std::stable_sort(tiles.begin(), tiles.end(),
                   [](const AtlasTile* a, const AtlasTile* b) { return a->height > b->height; });
  std::uint32_t widest = kBlock;
  for (const AtlasTile* const tile : tiles) widest = std::max(widest, rounded_up(tile->width));
  const auto height_of = [&](std::uint32_t width) { return shelve(tiles, width, false); };
  if (Status chosen = choose_width(widest, most_side, height_of, layout); !chosen) return chosen;
  shelve(tiles, layout.width, true);
  if (layout.ring) {
    layout.ring->x = ring.x;
    layout.ring->y = ring.y;
  }
  return ok_status();
}

}  // namespace

Status lay_out(AtlasLayout& layout, std::uint32_t most_side) {
  layout.tables.clear();
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const bool kept = !layout.dense_along || axis == *layout.dense_along;
    if (kept && layout.axes[axis].moves()) layout.tables.push_back(make_table(layout, axis));
  }
  if (layout.ring) {
    AtlasRing& ring = *layout.ring;
    ring.x = ring.y = 0;
    ring.tile_width = ring.ring_texels + 1;
    ring.tile_height = layout.axes[kHorizontal].texel_count();
    if (layout.blocks) {
      ring.tile_width = rounded_up(ring.tile_width);
      ring.tile_height = rounded_up(ring.tile_height);
    }
  }
  return layout.cells.is_everything() ? lay_out_whole(layout, most_side) : lay_out_part(layout, most_side);
}

}  // namespace sbrdf::internal
