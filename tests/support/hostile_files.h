#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "codec/entropy/rans.h"
#include "codec/file/index.h"
#include "codec/frame/frame.h"
#include "formats/core/byte_source.h"
#include "formats/sbrdf/bundle.h"
#include "formats/sbrdf/container.h"
#include "formats/sbrdf/metadata.h"
#include "formats/sbrdf/zstd_frame.h"

namespace sbrdf::internal {

// Files that keep every rule of the format, checksums included, and cost almost nothing to store: all values are 0, all
// flags yes. What a reader would need for them is thousands of times their size.

/// What a hostile file says that it holds.
struct HostileSizes {
  FrameSpec frame;
  std::size_t channels = 1;
  int depth = 0;                 ///< every interval of every slice is halved down to this
  std::uint32_t mask = 0;        ///< times 2^24 cells, measured and unmeasured in turn
  std::size_t metadata = 0;      ///< bytes of a JSON list of zeros
  std::size_t behind_index = 0;  ///< bytes that a later minor version might add to the index
};

namespace hostile {

inline constexpr std::uint8_t kCheapest = 1;     // the distribution that gives a residual of 0 the greatest frequency
inline constexpr std::uint8_t kMostlyYes = 255;  // of 256
inline constexpr std::size_t kNoise = 9000;      // bundles take no head that shrinks to less than a 4096th

/// A stream of so many times `flag` (or not) and `zeros` residuals of 0; all contexts are coded alike.
inline std::vector<std::byte> stream_of(std::uint64_t times, bool flag, std::size_t zeros) {
  const Distribution distribution = make_distribution(kCheapest, Token::kDirect);
  RansEncoder out;
  for (; times > 0; --times) {
    for (std::size_t k = 0; k < zeros; ++k) out.put(distribution.start[0], distribution.frequency[0]);
    if (flag) out.put(0, 16U * kMostlyYes);
  }
  return out.finish();
}

inline std::vector<std::byte> list_of_zeros(std::size_t size) {
  std::string text = "[0";
  while (text.size() + 3 <= size) text += ",0";
  text += std::string(size > text.size() ? size - text.size() - 1 : 0, ' ') + "]";
  return pack_metadata(text);
}

inline SlicedIndex index_of(const HostileSizes& sizes) {
  SlicedIndex index;
  index.frame = sizes.frame;
  index.channels.assign(sizes.channels, "");
  index.ranges.resize(sizes.channels);
  for (GroupDistributions& group : index.distributions.groups) group = {.width = 0, .long_tails = true};
  index.distributions.flag_depths = CodingContext::kFlagDepths;
  index.distributions.flags.fill(kMostlyYes);
  index.layout.whole = false;
  if (sizes.depth > 0 && sizes.depth < kMaxDepth) {
    index.layout.piece_depths = {1, static_cast<std::uint8_t>(sizes.depth + 1)};
  }
  index.metadata_size = static_cast<std::uint32_t>(sizes.metadata);
  if (sizes.mask > 0) {
    index.mask = MaskGrid{MaskFrame::kAngles, {sizes.mask, 4096, 4096, 1}};
    index.mask_size = sizes.mask << 24U;
  }
  if (sizes.metadata > 0) index.metadata = list_of_zeros(sizes.metadata);
  return index;
}

}  // namespace hostile

inline std::vector<std::byte> hostile_file(const HostileSizes& sizes) {
  const Lattice lattice = build_lattice(sizes.frame).value();
  SlicedIndex index = hostile::index_of(sizes);
  const LatticeBlocks blocks = make_blocks(lattice, index.layout);
  const ChunkOrder order(blocks, index.layout.piece_depths.size());
  std::vector<std::vector<std::byte>> payloads(order.count());
  payloads[ChunkOrder::crossings(0)] = hostile::stream_of(lattice.crossings.size(), false, sizes.channels);
  for (std::size_t kind = 0; sizes.depth > 0 && kind < kAxisCount; ++kind) {
    for (std::size_t block = 0; block < blocks.slices[kind].size(); ++block) {
      std::uint64_t intervals = 0;
      for (const std::uint32_t k : blocks.slices[kind][block]) intervals += lattice.slices[k].interval_count();
      const std::uint64_t samples = intervals * ((std::uint64_t{1} << static_cast<unsigned>(sizes.depth)) - 1);
      index.adaptive_count += static_cast<std::uint32_t>(samples);
      payloads[order.slices(0, kind, block)] = hostile::stream_of(samples, true, sizes.channels);
    }
  }
  if (sizes.mask > 0) payloads.push_back(pack_bytes(std::vector<std::byte>(index.mask_size, std::byte{1})));
  std::vector<std::byte> chunks;
  for (const std::vector<std::byte>& payload : payloads) {
    const std::size_t before = chunks.size();
    append_chunk(chunks, payload);
    index.chunk_sizes.push_back(static_cast<std::uint32_t>(chunks.size() - before));
  }
  std::vector<std::byte> head = emit_index(index);
  std::uint32_t noise = 1;
  for (std::size_t k = 0; k < sizes.behind_index; ++k) {
    noise = noise * 1664525U + 1013904223U;
    head.push_back(k < hostile::kNoise ? static_cast<std::byte>(noise >> 24U) : std::byte{0});
  }
  const auto minor = static_cast<std::uint8_t>(kContainerMinor + (sizes.behind_index > 0 ? 1 : 0));
  return emit_container(head, chunks, kContainerMajor, minor);
}

/// A bundle of one material, named `a`.
inline std::vector<std::byte> hostile_bundle(const HostileSizes& sizes) {
  const std::vector<std::byte> file = hostile_file(sizes);
  const std::vector<BundleInput> inputs = {{"a", file}};
  return emit_bundle(inputs).value();
}

struct HostileCase {
  std::string name;
  std::vector<std::byte> bytes;
};

/// One for each thing that a file can state much of. With `share` below 1 there are fewer values, for tests.
inline std::vector<HostileCase> hostile_cases(double share = 1) {
  const auto part = [share](double most) { return static_cast<std::size_t>(most * share); };
  const FrameSpec few = elevation_frame(40, 180, {.isotropic = true}).value();
  const FrameSpec many = elevation_frame(10, 20, {}).value();
  const auto multiples = [](std::size_t count, double step) {
    std::vector<double> nodes;
    for (std::size_t k = 0; k < count; ++k) nodes.push_back(static_cast<double>(k) * step);
    return nodes;
  };
  const FrameSpec fine =
      half_difference_frame(multiples(38, 2), multiples(38, 2), multiples(36, 10), multiples(36, 5), {});
  return {
      {"crossings.sbrdf", hostile_file({.frame = many, .channels = part(4096)})},
      {"samples.sbrdf", hostile_file({.frame = many, .depth = share < 1 ? 7 : 9})},
      {"sample_channels.sbrdf", hostile_file({.frame = few, .channels = part(1024), .depth = 12})},
      {"lattice.sbrdf", hostile_file({.frame = fine})},
      {"metadata.sbrdf", hostile_file({.frame = few, .metadata = kMaxMetadataSize})},
      {"mask.sbrdf", hostile_file({.frame = few, .mask = 3})},
      {"head.sbrdfz", hostile_bundle({.frame = few, .behind_index = kMaxIndexSize - 4096})},
  };
}

}  // namespace sbrdf::internal
