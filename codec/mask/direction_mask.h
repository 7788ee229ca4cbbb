#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/core/directions.h"

namespace sbrdf::internal {

// Which pairs of directions somebody measured. A table has holes: cells that a device could not reach, or that hold no
// number. What stands there in a sliced BRDF is made up, and whoever writes a table of it again can leave them empty.

/// What the axes of a MaskGrid are. The numbers stand in files and never change their meaning.
enum class MaskFrame : std::uint8_t {
  kAngles = 1,          ///< theta_i, phi_i, theta_v, phi_v; with one cell along phi_i, phi_v - phi_i in its place
  kHalfDifference = 2,  ///< phi_h, theta_h, theta_d, phi_d
};

/// Cells over all pairs of directions: k of n along an angle spans [k / n, (k + 1) / n] of its range. Ranges: 90
/// degrees of a theta, 360 of a phi, 180 of phi_d, where reciprocity makes the rest. Along theta_h the square root of
/// the angle is what is divided, so that cells are narrow at the highlight, as in MERL tables.
struct MaskGrid {
  static constexpr std::uint32_t kMostAlongAxis = 4096;
  static constexpr std::uint64_t kMostCells = std::uint64_t{1} << 26U;

  MaskFrame frame = MaskFrame::kHalfDifference;
  std::array<std::uint32_t, 4> counts = {1, 1, 1, 1};  ///< in the order of MaskFrame; the last is the fastest

  [[nodiscard]] std::uint64_t cell_count() const {
    return std::uint64_t{counts[0]} * counts[1] * counts[2] * counts[3];
  }
  /// A known frame, and counts in [1, kMostAlongAxis] with kMostCells or fewer in all.
  [[nodiscard]] bool is_valid() const;
  /// A place along each axis: cell k from k to k + 1, its centre at k + 0.5.
  using Place = std::array<double, 4>;
  /// Within [0, counts].
  [[nodiscard]] Place place_of(const DirectionPair& pair) const;
  /// May lie below the horizon. Along an axis of one cell the azimuth is 0.
  [[nodiscard]] DirectionPair pair_at(const Place& place) const;

  /// The cell that a pair lies in; the outer one for angles that rounding leaves outside.
  [[nodiscard]] std::uint64_t cell_of(const DirectionPair& pair) const;
  [[nodiscard]] Place place_of_centre(std::uint64_t cell) const;
  [[nodiscard]] DirectionPair centre_of(std::uint64_t cell) const { return pair_at(place_of_centre(cell)); }
  /// From one place to another along an axis [degrees]; an azimuth goes the short way round.
  [[nodiscard]] double distance_deg(std::size_t axis, double from, double to) const;

  bool operator==(const MaskGrid&) const = default;
};

/// One bit for each cell. What is said of cells with their centre below the horizon means nothing.
struct DirectionMask {
  MaskGrid grid;
  std::vector<bool> unmeasured;

  /// Of a pair above the horizon.
  [[nodiscard]] bool is_measured(const DirectionPair& pair) const {
    return !unmeasured[static_cast<std::size_t>(grid.cell_of(pair))];
  }

  bool operator==(const DirectionMask&) const = default;
};

}  // namespace sbrdf::internal
