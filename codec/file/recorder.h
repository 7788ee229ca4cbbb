#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/coding/crossing_order.h"
#include "codec/coding/slice_steps.h"
#include "codec/coding/value_scaling.h"
#include "codec/entropy/event_stream.h"
#include "codec/file/index.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"

namespace sbrdf::internal {

/// The events of a chunk, in the order in which they are read.
using ChunkEvents = std::vector<Event>;

/// Walks over the samples of a material and records what is to be coded, for any choice of coding parameters.
/// Distributions play no part: they are chosen from the events of all chunks.
class SampleRecorder {
 public:
  /// `scaled` are the steps that are coded, the guide taken off. All must outlive the recorder.
  SampleRecorder(const SlicedBrdf& sliced, const Lattice& lattice, const Scaled& scaled, const ChunkLayout& layout);

  /// The events of all chunks in the order of ChunkOrder, from the guide on.
  [[nodiscard]] std::vector<ChunkEvents> record_all(const CodingParameters& coding);

  /// For trying parameters: the crossings, block by block, and a thousand or so samples of slices spread over the
  /// whole.
  [[nodiscard]] std::vector<ChunkEvents> record_crossings(const CodingParameters& coding);
  [[nodiscard]] std::vector<ChunkEvents> record_some_slices(const CodingParameters& coding);

 private:
  [[nodiscard]] ChunkEvents record_guide(const CodingParameters& coding) const;
  /// The events of a block of slices, piece by piece; a piece without a sample stays without an event.
  [[nodiscard]] std::vector<ChunkEvents> record_slices(std::span<const std::uint32_t> block,
                                                       const CodingParameters& coding);
  void record_slice(std::uint32_t slice, const std::vector<bool>& used, const CodingParameters& coding,
                    std::vector<ChunkEvents>& pieces);
  [[nodiscard]] std::vector<bool> pieces_with_samples(std::span<const std::uint32_t> block) const;

  const SlicedBrdf& sliced_;
  const Lattice& lattice_;
  const Scaled& scaled_;
  const ChunkLayout& layout_;
  std::size_t channels_;
  LatticeBlocks blocks_;  ///< as the layout says
  CrossingPlan plan_;
  std::vector<std::size_t> first_sample_ = {0};  ///< of each slice, one entry more
  StepTable crossings_;  ///< with the residuals of the parameters last recorded with: slices are coded from them
  SliceSteps slice_;     ///< the one that is being recorded
};

}  // namespace sbrdf::internal
