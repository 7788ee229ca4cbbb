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

/// The frame of dense files, whose index is another one: codec/series.
inline constexpr std::uint8_t kDenseFrame = 10;

/// Bounds of the steps of one channel.
struct StepRange {
  std::int32_t least = 0;
  std::int32_t most = 0;
};

/// The index of a sliced file (specs/sbrdf.md, section 2): all that must be known before any chunk is read, and the
/// metadata.
struct SlicedIndex {
  FrameSpec frame;                            ///< coordinates, symmetries, nodes: what crossings and slices there are
  Quantizer scale;                            ///< what steps mean
  DomainKind domain = DomainKind::kLinear;    ///< how values are interpolated
  std::vector<std::string> channels;          ///< names, 1 to kMaxChannels
  GreyShares grey_shares;                     ///< of the channels
  std::vector<StepRange> ranges;              ///< of the stored values, per channel
  std::vector<std::int32_t> reference_steps;  ///< log only, per channel; the two are those of ValueDomain
  int floor_halvings = 0;
  bool guided = false;               ///< whether a guide is taken off; the two below belong to it
  double guide_ratio = 1;            ///< see Guide::ratio; 1 if isotropic
  std::uint32_t guide_count = 0;     ///< samples of the guide, its nodes included
  std::uint32_t adaptive_count = 0;  ///< samples that are not crossings

  // How residuals are coded.
  std::uint32_t base_channel = 0;    ///< see CodingParameters
  std::uint32_t activity_shift = 0;  ///< see CodingParameters
  Distributions distributions;       ///< of residuals and flags, by context

  std::optional<MaskGrid> mask;  ///< of unmeasured directions; nothing where all are measured
  std::uint32_t mask_size = 0;   ///< bytes of its runs once decompressed

  std::uint32_t metadata_size = 0;         ///< bytes once unpacked
  std::vector<std::byte> metadata;         ///< as packed
  ChunkLayout layout;                      ///< how samples are spread over chunks
  std::vector<std::uint32_t> chunk_sizes;  ///< stored bytes, 0 for a chunk without content

  /// How many chunks there are: one if whole, else one for each of so many streams; and the mask, which is the last.
  [[nodiscard]] std::size_t chunk_count(std::size_t streams) const {
    return (layout.whole ? 1 : streams) + (mask ? 1 : 0);
  }
  [[nodiscard]] std::size_t mask_chunk() const { return chunk_sizes.size() - 1; }

  /// What prediction needs to know of all this.
  [[nodiscard]] CodingParameters coding() const;
  [[nodiscard]] ValueDomain value_domain() const;
  [[nodiscard]] std::vector<ValueRange> value_ranges() const;
};

/// The streams of a file: the guide first, then crossings by block, then per piece the slices of each kind by block:
///
///     guide  crossings 0, 1 ...  | piece 0: axial 0, 1 ..., diagonal ..., horizontal ..., vertical ... | piece 1
///
/// so that what a lesser depth needs lies in front of what a greater one adds. Each is a chunk of its own, or, in a
/// whole layout, one goes on where the one before ends.
struct ChunkOrder {
  explicit ChunkOrder(const LatticeBlocks& blocks, std::size_t pieces);

  static constexpr std::size_t kGuide = 0;
  [[nodiscard]] static std::size_t crossings(std::size_t block) { return 1 + block; }
  [[nodiscard]] std::size_t slices(std::size_t piece, std::size_t kind, std::size_t block) const {
    return first_piece_ + piece * per_piece_ + kind_offset_[kind] + block;
  }
  [[nodiscard]] std::size_t per_piece() const { return per_piece_; }  ///< streams of each piece
  [[nodiscard]] std::size_t count() const { return count_; }          ///< of all streams, left out ones included

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
