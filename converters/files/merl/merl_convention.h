#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "formats/core/directions.h"
#include "formats/core/named.h"
#include "formats/merl/merl.h"

namespace sbrdf::internal {

/// Where in a cell its value belongs.
enum class MerlPosition : std::uint8_t {
  kCentre,
  kEdge,  ///< at the lower edge of each axis
};
enum class MerlLookup : std::uint8_t {
  kLinear,
  kNearest,  ///< the value of the cell that a pair lies in, as the published reader gives it
};
/// What the third dimension covers.
enum class MerlTurn : std::uint8_t {
  kHalf,  ///< phi_d in [0, pi): reciprocal
  kFull,  ///< phi_d in [0, 2 pi): f(i,v) and f(v,i) may differ
  kAuto,  ///< as the content tells
};
inline constexpr std::array kMerlPositionNames = {Named{"centre", MerlPosition::kCentre},
                                                  Named{"edge", MerlPosition::kEdge}};
inline constexpr std::array kMerlLookupNames = {Named{"linear", MerlLookup::kLinear},
                                                Named{"nearest", MerlLookup::kNearest}};
inline constexpr std::array kMerlTurnNames = {Named{"auto", MerlTurn::kAuto}, Named{"half", MerlTurn::kHalf},
                                              Named{"full", MerlTurn::kFull}};

/// What a file does not tell about its cells.
struct MerlConvention {
  MerlPosition position = MerlPosition::kCentre;
  MerlTurn turn = MerlTurn::kHalf;
  MerlLookup lookup = MerlLookup::kLinear;
  std::size_t value_size = sizeof(double);  ///< 8, or 4 where the numbers are 32-bit floats
};

/// What phi_d covers [radians]: a half or a full turn.
[[nodiscard]] constexpr double merl_turn(const MerlConvention& convention) {
  return convention.turn == MerlTurn::kFull ? 2 * kPi : kPi;
}
/// From a cell's lower edge to its value, in cells.
[[nodiscard]] constexpr double merl_offset(const MerlConvention& convention) {
  return convention.position == MerlPosition::kEdge ? 0 : 0.5;
}

/// Half and difference angles of the place that the value of a cell belongs to, with phi_h = 0.
[[nodiscard]] inline HalfDifference merl_cell_angles(const MerlShape& shape, const MerlConvention& convention,
                                                     std::uint64_t cell) {
  const auto at = [&](std::uint64_t index) { return static_cast<double>(index) + merl_offset(convention); };
  return {merl_theta_h(at(cell / shape[2] / shape[1]), shape[0]), 0,
          merl_theta_d(at(cell / shape[2] % shape[1]), shape[1]),
          at(cell % shape[2]) / shape[2] * merl_turn(convention)};
}

/// The pair that the value of a cell belongs to, with phi_h = 0; it may lie below the horizon.
[[nodiscard]] inline DirectionPair merl_cell_pair(const MerlShape& shape, const MerlConvention& convention,
                                                  std::uint64_t cell) {
  return pair_from_half_difference(merl_cell_angles(shape, convention, cell));
}
/// At the centre of a cell, of half a turn.
[[nodiscard]] inline DirectionPair merl_cell_centre(const MerlShape& shape, std::uint64_t cell) {
  return merl_cell_pair(shape, {}, cell);
}

}  // namespace sbrdf::internal
