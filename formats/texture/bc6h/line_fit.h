#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "formats/texture/bc6h/region.h"

// Endpoints before they are rounded: lines through the texels of a region, on the scale on which colours are mixed.

namespace sbrdf::internal {

/// Colours of index 0 and of the last one.
struct Bc6hLine {
  std::array<float, 3> first{};
  std::array<float, 3> second{};
};

/// The principal axis of a region, as long as the texels need it, and then moved by least squares with the indices that
/// follow. The anchor is in the first half.
[[nodiscard]] Bc6hLine fit_bc6h_line(const Bc6hRegion& region, int index_count);

/// Lines along the principal axis that give the outermost texels other indices than the first and the last one, moved
/// by least squares; the best first. They matter where texels lie in a few heaps, which steps should hit. As many as
/// `lines` holds, the best one again and again where there are fewer. The anchors are in the first halves.
void fit_bc6h_lines(const Bc6hRegion& region, int index_count, std::span<Bc6hLine> lines);

/// The line with the least squared differences for given indices. `fit_weight`: of each texel and channel. A channel in
/// which all texels have one index is constant.
[[nodiscard]] Bc6hLine fit_bc6h_line(const Bc6hRegion& region, const Bc6hRows& fit_weight,
                                     std::span<const std::int32_t, 16> indices, const Bc6hScale& scale);

/// Turns a line round if the anchor is in its second half.
void orient_bc6h_line(const Bc6hRegion& region, Bc6hLine& line);

/// How many other lines stretched_bc6h_lines makes.
inline constexpr std::size_t kBc6hStretches = 4;

/// Lines along another one that go further, some of them the other way round; the anchor is in their first halves. They
/// have less use for the indices, but begin elsewhere, so that differences from the first endpoint may be small enough.
[[nodiscard]] std::array<Bc6hLine, kBc6hStretches> stretched_bc6h_lines(const Bc6hRegion& region, const Bc6hLine& line,
                                                                        int index_count);

/// How well each way to split a block in two suits lines: about what is off, on the scale of `mixed`, with partitions
/// as numbered by the format.
[[nodiscard]] std::array<float, kBc6hPartitionCount> rate_bc6h_partitions(const Bc6hRegion& whole);

}  // namespace sbrdf::internal
