#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "codec/coding/chunk_layout.h"
#include "codec/coding/quantizer.h"
#include "codec/coding/sample_coder.h"
#include "codec/entropy/distribution_choice.h"
#include "codec/frame/frame.h"
#include "codec/mask/direction_mask.h"
#include "codec/material/sliced_brdf.h"
#include "codec/material/value_domain.h"

namespace sbrdf::internal {

/// "[clause] what": kInvalidFile for a rule of specs/sbrdf.md that is broken.
[[nodiscard]] Error refuse_sliced(const char* clause, const std::string& what);

/// The index of a sliced file (specs/sbrdf.md, section 2): all that must be known before any chunk is read.
struct SlicedIndex {
  FrameSpec frame;                    ///< coordinates, symmetries, nodes: what crossings and slices there are
  ValueDomain domain;                 ///< how values are interpolated
  std::vector<std::string> channels;  ///< names, 1 to kMaxChannels
  std::vector<ValueRange> ranges;     ///< of the stored values, per channel
  bool guided = false;                ///< whether a guide is taken off; the two below belong to it
  double guide_ratio = 1;             ///< see Guide::ratio
  std::uint32_t guide_count = 0;      ///< samples of the guide, its nodes included
  std::uint32_t adaptive_count = 0;   ///< samples that are not crossings
  Quantizer scale;                    ///< what steps mean

  // How residuals are coded.
  std::uint32_t base_channel = 0;    ///< see CodingParameters
  std::uint32_t activity_shift = 0;  ///< see CodingParameters
  Distributions distributions;       ///< of residuals and flags, by context

  std::optional<MaskGrid> mask;  ///< of unmeasured directions; nothing where all are measured
  std::uint32_t mask_size = 0;   ///< bytes of its runs once decompressed

  ChunkLayout layout;                      ///< how samples are spread over chunks
  std::uint32_t metadata_size = 0;         ///< bytes once decompressed
  std::vector<std::uint32_t> chunk_sizes;  ///< stored bytes, 0 for a chunk without content; order in ChunkOrder

  /// What prediction needs to know of all this.
  [[nodiscard]] CodingParameters coding() const;
};

/// Metadata and guide first, then crossings by block, then per piece the slices of each kind by block:
///
///     metadata  guide  crossings 0, 1 ...  | piece 0: axial 0, 1 ..., diagonal ..., horizontal ..., vertical ... |
///     piece 1 ... | mask, if there is one
///
/// so that what a lesser depth needs lies in front of what a greater one adds.
struct ChunkOrder {
  ChunkOrder(const LatticeBlocks& blocks, std::size_t pieces, bool masked);

  static constexpr std::size_t kMetadata = 0;
  static constexpr std::size_t kGuide = 1;
  [[nodiscard]] static std::size_t crossings(std::size_t block) { return 2 + block; }
  [[nodiscard]] std::size_t slices(std::size_t piece, std::size_t kind, std::size_t block) const {
    return first_piece_ + piece * per_piece_ + kind_offset_[kind] + block;
  }
  [[nodiscard]] std::size_t per_piece() const { return per_piece_; }  ///< chunks of each piece
  [[nodiscard]] std::size_t count() const { return count_; }          ///< of all chunks, left out ones included
  [[nodiscard]] std::size_t mask() const { return count_ - 1; }       ///< where there is one

 private:
  std::size_t first_piece_ = 0;
  std::size_t per_piece_ = 0;
  std::array<std::size_t, kAxisCount> kind_offset_{};
  std::size_t count_ = 0;
};

/// The inverse of parse_index.
[[nodiscard]] std::vector<std::byte> emit_index(const SlicedIndex& index);

/// Refuses what breaks a rule of section 2; bytes behind the end are an error unless `newer_minor`. The frame has
/// passed check_frame. Nothing in it is larger than the index itself allows.
[[nodiscard]] Result<SlicedIndex> parse_index(std::span<const std::byte> bytes, bool newer_minor);

}  // namespace sbrdf::internal
