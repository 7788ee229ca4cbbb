#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "codec/coding/crossing_order.h"
#include "codec/file/index.h"
#include "codec/frame/cells.h"
#include "formats/core/byte_source.h"

namespace sbrdf::internal {

/// The order in which crossings are coded. Made when crossings are first read: who only looks at the index does not
/// need it. May be called from several threads at once.
class LazyCrossingPlan {
 public:
  [[nodiscard]] const CrossingPlan& get(const Lattice& lattice, const LatticeBlocks& blocks) {
    std::call_once(made_, [&] { plan_ = plan_crossings(lattice, blocks); });
    return plan_;
  }

 private:
  std::once_flag made_;
  CrossingPlan plan_;
};

/// An opened file: what its head says, and what follows from that.
struct SlicedFile {
  const ByteSource* source = nullptr;
  SlicedIndex index;
  std::shared_ptr<const Lattice> lattice;
  LatticeBlocks blocks;
  std::shared_ptr<LazyCrossingPlan> plan;
  ChunkOrder order;
  std::vector<std::uint64_t> offsets;  ///< of chunks, one entry more than there are
  std::uint64_t memory_allowed = 0;    ///< for everything that is read of it together [bytes]

  /// The payload of a chunk, its checksum verified.
  [[nodiscard]] Result<std::vector<std::byte>> chunk(std::size_t number) const;
};

/// Reads and decodes the chunks that hold all samples up to a depth, and the guide. kUnsupported where the whole file
/// would take more memory than is allowed.
[[nodiscard]] Result<SlicedBrdf> load_samples(const SlicedFile& file, int max_depth);
/// Those that evaluating within some cells needs; crossings that were not read are 0.
[[nodiscard]] Result<SlicedBrdf> load_samples(const SlicedFile& file, const CellSet& cells, int max_depth);

}  // namespace sbrdf::internal
