#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "converters/tables/dense_table.h"

namespace sbrdf::internal {

/// Values of a table that is too large to be kept: read a box at a time, of which as many stay as `most_bytes` allows.
/// Those that were not asked for the longest go first.
class TiledValues final : public NodeValues {
 public:
  using Box = std::array<std::uint32_t, 4>;
  /// Fills `values` with the nodes of a box in C order, the channel fastest; NaN where nothing can be read. Called from
  /// several threads at once.
  using Read = std::function<void(const GridNode& first, const Box& count, std::span<double> values)>;

  /// `tile` is how many nodes of each axis make a box, fewer at the ends of the axes of `shape`.
  TiledValues(Box shape, std::size_t channel_count, Box tile, std::uint64_t most_bytes, Read read);

  void gather(std::span<const GridNode> nodes, std::span<double> values) const override;

 private:
  /// Float where that holds every number, to keep twice as many.
  struct Tile {
    std::uint64_t number = 0;
    std::vector<float> floats;
    std::vector<double> doubles;
  };
  using Kept = std::list<std::shared_ptr<const Tile>>;

  [[nodiscard]] std::uint64_t tile_number(const GridNode& node) const;
  [[nodiscard]] Box extent_of(const GridNode& first) const;
  [[nodiscard]] std::shared_ptr<const Tile> find(std::uint64_t number) const;
  [[nodiscard]] std::shared_ptr<const Tile> load(std::uint64_t number, const GridNode& node) const;
  [[nodiscard]] std::uint64_t position_in(const GridNode& node) const;

  Box shape_;
  std::size_t channel_count_;
  Box tile_;
  std::size_t most_tiles_;
  Read read_;
  mutable std::mutex mutex_;
  mutable Kept kept_;  ///< the last used first
  mutable std::unordered_map<std::uint64_t, Kept::iterator> places_;
};

}  // namespace sbrdf::internal
