#include "converters/tables/tile_cache.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace sbrdf::internal {

TiledValues::TiledValues(Box shape, std::size_t channel_count, Box tile, std::uint64_t most_bytes, Read read)
    : shape_(shape), channel_count_(channel_count), tile_(tile), read_(std::move(read)) {
  const std::uint64_t numbers = std::uint64_t{tile[0]} * tile[1] * tile[2] * tile[3] * channel_count;
  most_tiles_ = static_cast<std::size_t>(std::max<std::uint64_t>(16, most_bytes / (sizeof(double) * numbers)));
}

std::uint64_t TiledValues::tile_number(const GridNode& node) const {
  std::uint64_t number = 0;
  for (std::size_t axis = 0; axis < node.size(); ++axis) {
    number = number * ((shape_[axis] + tile_[axis] - 1) / tile_[axis]) + node[axis] / tile_[axis];
  }
  return number;
}

TiledValues::Box TiledValues::extent_of(const GridNode& first) const {
  Box extent{};
  for (std::size_t axis = 0; axis < extent.size(); ++axis) {
    extent[axis] = std::min(tile_[axis], shape_[axis] - first[axis]);
  }
  return extent;
}

std::shared_ptr<const TiledValues::Tile> TiledValues::find(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  const auto at = places_.find(number);
  if (at == places_.end()) return nullptr;
  kept_.splice(kept_.begin(), kept_, at->second);
  return kept_.front();
}

std::shared_ptr<const TiledValues::Tile> TiledValues::load(std::uint64_t number, const GridNode& node) const {
  GridNode first{};
  for (std::size_t axis = 0; axis < first.size(); ++axis) first[axis] = node[axis] / tile_[axis] * tile_[axis];
  const Box extent = extent_of(first);
  auto tile = std::make_shared<Tile>();
  tile->number = number;
  tile->doubles.resize(std::uint64_t{extent[0]} * extent[1] * extent[2] * extent[3] * channel_count_);
  read_(first, extent, tile->doubles);
  const bool fit = std::all_of(tile->doubles.begin(), tile->doubles.end(), [](double value) {
    return !(std::abs(value) <= std::numeric_limits<float>::max())
               ? !std::isfinite(value)
               : static_cast<double>(static_cast<float>(value)) == value;
  });
  if (fit) {
    tile->floats.assign(tile->doubles.begin(), tile->doubles.end());
    tile->doubles = {};
  }
  const std::scoped_lock lock(mutex_);
  if (places_.contains(number)) return *places_[number];  // another thread was faster
  kept_.push_front(tile);
  places_[number] = kept_.begin();
  if (kept_.size() > most_tiles_) {
    places_.erase(kept_.back()->number);
    kept_.pop_back();
  }
  return tile;
}

std::uint64_t TiledValues::position_in(const GridNode& node) const {
  std::uint64_t position = 0;
  for (std::size_t axis = 0; axis < node.size(); ++axis) {
    const std::uint32_t first = node[axis] / tile_[axis] * tile_[axis];
    position = position * std::min(tile_[axis], shape_[axis] - first) + (node[axis] - first);
  }
  return position * channel_count_;
}

void TiledValues::gather(std::span<const GridNode> nodes, std::span<double> values) const {
  assert(values.size() == nodes.size() * channel_count_);
  std::shared_ptr<const Tile> tile;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const std::uint64_t number = tile_number(nodes[n]);
    if (tile == nullptr || tile->number != number) {
      tile = find(number);
      if (tile == nullptr) tile = load(number, nodes[n]);
    }
    const std::uint64_t position = position_in(nodes[n]);
    const std::span<double> colour = values.subspan(n * channel_count_, channel_count_);
    bool hole = false;
    for (std::size_t c = 0; c < channel_count_; ++c) {
      colour[c] = tile->floats.empty() ? tile->doubles[position + c] : tile->floats[position + c];
      hole = hole || std::isnan(colour[c]);
    }
    if (hole) std::fill(colour.begin(), colour.end(), std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace sbrdf::internal
