#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "codec/coding/crossing_order.h"
#include "codec/file/index.h"
#include "codec/frame/cells.h"
#include "formats/core/byte_source.h"

namespace sbrdf::internal {

/// An opened file: what its head says, and what follows from that.
struct SlicedFile {
  const ByteSource* source = nullptr;
  SlicedIndex index;
  std::shared_ptr<const Lattice> lattice;
  LatticeBlocks blocks;
  CrossingPlan plan;
  ChunkOrder order;
  std::vector<std::uint64_t> offsets;  ///< of chunks, one entry more than there are

  /// The payload of a chunk, its checksum verified.
  [[nodiscard]] Result<std::vector<std::byte>> chunk(std::size_t number) const;
};

/// Reads and decodes the chunks that hold all samples up to a level, and the guide.
[[nodiscard]] Result<SlicedBrdf> load_samples(const SlicedFile& file, int max_depth);
/// Those that evaluating within some cells needs; crossings that were not read are 0.
[[nodiscard]] Result<SlicedBrdf> load_samples(const SlicedFile& file, const CellSet& cells, int max_depth);

}  // namespace sbrdf::internal
