#include "codec/atlas/texel_range.h"

#include <algorithm>
#include <limits>

namespace sbrdf::internal {
namespace {

/// Tables of more tiles, the primary one aside, have one scale for all: a shader holds scales as constants.
constexpr std::size_t kMostScales = 32;

/// Texels of an atlas, all channels of each.
struct Rectangle {
  std::uint32_t x = 0, y = 0, width = 0, height = 0;
};

template <class Visit>
void for_texels(Atlas& atlas, const Rectangle& area, const Visit& visit) {
  for (std::uint32_t y = area.y; y < area.y + area.height; ++y) {
    for (std::uint32_t x = area.x; x < area.x + area.width; ++x) {
      visit(atlas.texels.data() + (std::size_t{y} * atlas.layout.width + x) * 3);
    }
  }
}

/// What `range` begins with; it ends with 1.
float least_of(TexelRange range) {
  return range == TexelRange::kSigned ? -1.0F : range == TexelRange::kBlocks ? kLeastInBlocks : 0.0F;
}

AtlasScale scale_of(std::span<const float, 3> least, std::span<const float, 3> most, TexelRange range) {
  AtlasScale scale;
  const float low = least_of(range);
  for (std::size_t c = 0; c < 3; ++c) {
    const float span = most[c] - least[c];
    scale.scale[c] = span > 0 ? span / (1 - low) : 1;
    scale.offset[c] = least[c] - scale.scale[c] * low;
  }
  return scale;
}

/// All of these get one scale.
AtlasScale bring_into(Atlas& atlas, std::span<const Rectangle> areas, TexelRange range) {
  const auto is_empty = [](const Rectangle& area) { return area.width == 0; };
  if (std::all_of(areas.begin(), areas.end(), is_empty)) return {};
  constexpr float kMost = std::numeric_limits<float>::max();
  std::array<float, 3> least = {kMost, kMost, kMost};
  std::array<float, 3> most = {-kMost, -kMost, -kMost};
  for (const Rectangle& area : areas) {
    for_texels(atlas, area, [&](const float* texel) {
      for (std::size_t c = 0; c < 3; ++c) {
        least[c] = std::min(least[c], texel[c]);
        most[c] = std::max(most[c], texel[c]);
      }
    });
  }
  const AtlasScale scale = scale_of(least, most, range);
  const float low = least_of(range);
  for (const Rectangle& area : areas) {
    for_texels(atlas, area, [&](float* texel) {
      for (std::size_t c = 0; c < 3; ++c) {
        texel[c] = std::clamp((texel[c] - scale.offset[c]) / scale.scale[c], low, 1.0F);
      }
    });
  }
  return scale;
}

std::vector<Rectangle> tiles_of(const AtlasTable& table) {
  std::vector<Rectangle> tiles;
  for (const AtlasTile& tile : table.tiles) tiles.push_back({tile.x, tile.y, tile.width, tile.height});
  return tiles;
}

}  // namespace

void use_range(Atlas& atlas, TexelRange range) {
  if (range == TexelRange::kAsIs) return;
  const AtlasLayout& layout = atlas.layout;
  for (std::size_t k = 0; k < layout.tables.size(); ++k) {
    const std::vector<Rectangle> tiles = tiles_of(layout.tables[k]);
    atlas.scales[k].clear();
    if (range != TexelRange::kSigned && (k == 0 || tiles.size() <= kMostScales)) {
      for (const Rectangle& tile : tiles) atlas.scales[k].push_back(bring_into(atlas, std::span(&tile, 1), range));
    } else {
      atlas.scales[k].push_back(bring_into(atlas, tiles, range));
    }
  }
  if (!layout.ring) return;
  const Rectangle ring = {layout.ring->x, layout.ring->y, layout.ring->tile_width, layout.ring->tile_height};
  atlas.scales.back() = {bring_into(atlas, std::span(&ring, 1), range)};
}

}  // namespace sbrdf::internal
