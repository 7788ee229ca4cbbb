#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/evaluation/pole_ring.h"
#include "codec/evaluation/tables/place_search.h"
#include "codec/evaluation/tables/places.h"
#include "codec/frame/lattice.h"

namespace sbrdf::internal {

/// Lines along one axis of a cell in whole quads: where there are fewer, the first is there again.
inline constexpr std::size_t kQuad = 4;
[[nodiscard]] constexpr std::size_t lines_along(std::size_t moving) {
  return moving == 0 ? 0 : std::max(kQuad, (std::size_t{1} << moving) / 2);
}

/// A lattice as the flat arrays that the kernel of the evaluator reads: where each cell finds its corners and lines.
/// Holds for every material with the same frame. Immutable once it is made; a plain struct, since the kernel is
/// compiled once for each set of instructions and looks at everything.
struct LatticeTables {
  /// Lines along all axes of a cell, at most.
  static constexpr std::size_t kMostCellLines = kAxisCount * lines_along(kAxisCount);

  /// Lines along all axes where three move, and four times the guide's.
  static constexpr std::size_t kLinesOfThree = 16;

  /// A cell of an axis, or of a ring. The last one of a list has its end, too.
  struct Cell {
    std::int32_t begin = 0;
    std::int32_t end = 0;  ///< the next one begins here; kBeyond for the last
    float width = 1;       ///< [places]
  };
  static constexpr std::uint32_t kCellWords = 3;

  /// Words of 4 bytes that a line takes in SliceTables: numbers of lines count these.
  static constexpr std::uint32_t kLineWords = 3;

  /// A PoleRing. There are rings only where all four axes move.
  struct Ring {
    std::uint32_t polar_axis = 0;
    std::uint32_t ring_axis = 0;
    std::uint32_t other_azimuth = 0;
    std::uint32_t along = 0;
    bool difference = false;       ///< its position is the difference of the azimuths, else their sum
    std::uint32_t turn_shift = 0;  ///< log2 of its periods in the longest of the frame
    PlaceSearch search;
    std::uint32_t first_cell = 0;                           ///< in `cells`
    std::vector<std::array<std::uint32_t, 2>> node_tables;  ///< per node and the first one again: corner, line
  };

  explicit LatticeTables(const Lattice& lattice);
  /// Of a table of values at all combinations of nodes, axis 0 fastest: without lines, rings and `corners`. Nodes as in
  /// Lattice::nodes.
  LatticeTables(FrameId frame, const std::array<std::vector<double>, kAxisCount>& nodes);

  [[nodiscard]] std::size_t bytes() const;

  FrameId frame = FrameId::kElevation;
  std::vector<std::uint32_t> axes;  ///< those with two nodes or more, rising
  /// Per axis (all four): no point lies beyond this turn.
  alignas(16) std::array<std::uint32_t, kAxisCount> last_turn{};
  bool axial_stays = false;  ///< nothing varies along the first axis
  /// How the angle of an axis [degrees] becomes a turn: see TurnRule.
  alignas(32) std::array<double, kAxisCount> turn_scale{};
  alignas(32) std::array<double, kAxisCount> turn_bias{};
  alignas(16) std::array<std::int32_t, kAxisCount> turn_flip{};
  /// Of the search for a cell, per axis (all four; those that do not move have one cell for all turns).
  alignas(16) std::array<std::uint32_t, kAxisCount> first_bucket{};
  alignas(16) std::array<std::uint32_t, kAxisCount> bucket_shift{};
  alignas(16) std::array<std::uint32_t, kAxisCount> first_cell{};
  std::vector<Ring> rings;
  std::vector<Cell> cells;                ///< of axes and of rings
  std::vector<PlaceBucket> cell_buckets;  ///< of their searches
  std::vector<std::uint32_t> corners;     ///< the crossing at each point of the padded lattice
  Strides corner_strides{};               ///< by axis
  /// By axis: where its lines begin in SliceTables::lines, and what numbers them, both in kLineWords.
  std::array<std::uint32_t, kAxisCount> first_line{};
  std::array<Strides, kAxisCount> line_strides{};
  std::uint32_t guide_line = 0;  ///< behind all others, in kLineWords
  std::uint32_t line_count = 0;  ///< without the guide's

  // How the lines of a cell are numbered, lane by lane: those along the first moving axis, and so on. Bit k of their
  // order tells the two sides of the k-th of the other moving axes apart. Where three axes move, the guide's follow,
  // for a guide that is as wide both ways.
  template <class T>
  using Lanes = std::array<T, kMostCellLines>;
  alignas(64) Lanes<std::uint32_t> lane_axis{};   ///< along which axis it runs
  alignas(64) Lanes<std::uint32_t> lane_first{};  ///< its number where all cells are the first
  alignas(64) std::array<Lanes<std::uint32_t>, kAxisCount> lane_strides{};  ///< by axis
  alignas(
      64) std::array<std::uint32_t, 16> corner_steps{};  ///< of the corners of a cell from its first, in order of bits

 private:
  class Maker;
};

}  // namespace sbrdf::internal
