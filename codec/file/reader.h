#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "codec/evaluation/evaluator.h"
#include "codec/file/encoder.h"
#include "codec/file/loader.h"
#include "codec/frame/cells.h"
#include "formats/core/byte_source.h"
#include "formats/sbrdf/memory_limit.h"

namespace sbrdf::internal {

/// A part of a sliced BRDF: exact within its cells (down to its depth), an error everywhere else. Immutable; one object
/// serves any number of threads.
class PartialSliced {
 public:
  PartialSliced(SlicedBrdf sliced, std::shared_ptr<const Lattice> lattice, CellSet cells);

  /// f_r [1/sr], the same bits as the whole file gives: 0 below the horizon, whatever was loaded. kUsage for a pair
  /// above it whose cell was not loaded.
  [[nodiscard]] Status evaluate(const DirectionPair& pair, std::span<float> values) const;
  [[nodiscard]] bool covers(const DirectionPair& pair) const;
  /// Samples that were not loaded are left out, crossings among them are 0.
  [[nodiscard]] const SlicedBrdf& sliced() const { return sliced_; }

 private:
  SlicedBrdf sliced_;
  CellSet cells_;
  Evaluator evaluator_;
  std::shared_ptr<const Lattice> lattice_;
};

/// Reads a sliced file bit by bit: `open` takes header and index, everything else reads just the chunks that it needs.
/// Immutable; all members may be called from several threads at once.
class SlicedReader {
 public:
  /// `source` must live as long as the reader. kUnsupported where index, metadata and lattice would take more memory
  /// than `limit` allows for the stored size of the source, before they take it; the members that load samples do the
  /// same for all samples of the file.
  [[nodiscard]] static Result<SlicedReader> open(const ByteSource& source, const MemoryLimit& limit = {});

  [[nodiscard]] const SlicedIndex& index() const { return file_.index; }
  [[nodiscard]] const Lattice& lattice() const { return *file_.lattice; }
  [[nodiscard]] const std::string& version() const { return version_; }
  /// The lattice, for keeping: not copied if nobody else has it. The reader must not be used any more.
  [[nodiscard]] Lattice take_lattice() &&;

  /// The JSON object of how the file came to be; may be empty.
  [[nodiscard]] Result<std::string> metadata() const;

  /// Which directions were not measured; nullptr where all were.
  [[nodiscard]] Result<std::shared_ptr<const DirectionMask>> mask() const;

  /// All samples down to a depth (crossings are depth 0), with guide, mask and metadata.
  [[nodiscard]] Result<SlicedBrdf> load_all(int max_depth = kMaxDepth) const;
  /// What the evaluation within some cells needs, without mask and metadata.
  [[nodiscard]] Result<PartialSliced> load(const CellSet& cells, int max_depth = kMaxDepth) const;

  /// Bytes of the file that load_all(max_depth) needs, header, index, metadata and mask included.
  [[nodiscard]] std::uint64_t bytes_up_to(int max_depth) const;

 private:
  SlicedReader(SlicedFile file, std::string version) : file_(std::move(file)), version_(std::move(version)) {}

  SlicedFile file_;
  std::string version_;
};

}  // namespace sbrdf::internal
