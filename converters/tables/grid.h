#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "converters/tables/grid_axis.h"
#include "formats/core/directions.h"
#include "formats/core/named.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// What the four axes of a grid are, the slowest first. The names stand in files and never change their meaning.
enum class GridFrame : std::uint8_t {
  kAngles,          ///< theta_i, phi_i, theta_v, phi_v
  kDifference,      ///< phi_i, theta_i, theta_v, phi_v - phi_i; one node along phi_i: isotropic
  kHalfDifference,  ///< phi_h, theta_h, theta_d, phi_d; one node along phi_h: isotropic
  /// phi_i, theta_i, and v around the mirror direction of i: azimuth, radius. The radius is the angle between v and the
  /// mirror direction (theta_i, phi_i + 180); azimuth 0 leads from there over the normal, and grows counter-clockwise
  /// as seen from outside.
  kMirror,
};
inline constexpr std::array kGridFrameNames = {
    Named{"angles", GridFrame::kAngles}, Named{"difference", GridFrame::kDifference},
    Named{"half-difference", GridFrame::kHalfDifference}, Named{"mirror", GridFrame::kMirror}};

/// A node of a grid: an index along each axis.
using GridNode = std::array<std::uint32_t, 4>;

/// Where the values of a dense table lie: at all combinations of the nodes of four axes.
struct Grid {
  GridFrame frame = GridFrame::kAngles;
  std::array<GridAxis, 4> axes;

  /// "theta_i", "phi_v - phi_i", "azimuth".
  [[nodiscard]] static std::string_view axis_name(GridFrame frame, std::size_t axis);
  [[nodiscard]] std::string_view axis_name(std::size_t axis) const { return axis_name(frame, axis); }
  /// Of an axis that is a full turn, or all that there is of a mirrored or half one; else kHeld. For axes made of
  /// steps.
  [[nodiscard]] static Ends natural_ends(GridFrame frame, std::size_t axis);
  /// The last angle of an axis [degrees]: 90 of a theta, 360 or 180 of an azimuth, 180 of a radius.
  [[nodiscard]] static double range_deg(GridFrame frame, std::size_t axis);

  /// Whether an axis of a frame can have these nodes and ends: GridAxis::is_valid, a theta within its range and not
  /// closed, an azimuth not extrapolated.
  [[nodiscard]] static bool can_have(GridFrame frame, std::size_t axis, const std::vector<double>& nodes_deg, Ends ends,
                                     Spacing spacing);

  [[nodiscard]] std::uint64_t node_count() const;
  [[nodiscard]] GridNode node(std::uint64_t index) const;
  [[nodiscard]] std::uint64_t index(const GridNode& node) const;

  /// The four coordinates of a pair above the horizon [degrees], and back. A pair that comes back may lie below.
  using Place = std::array<double, 4>;
  [[nodiscard]] Place place_of(const DirectionPair& pair) const;
  [[nodiscard]] DirectionPair pair_at(const Place& place) const;
  [[nodiscard]] DirectionPair pair_of(const GridNode& node) const;

  /// Values depend on phi_v - phi_i only: there is nothing along the axis that says more.
  [[nodiscard]] bool is_isotropic() const;
  /// f(i,v) = f(v,i) by construction.
  [[nodiscard]] bool is_reciprocal() const;
  /// The largest theta of a node on the axes that are a theta of a direction; 90 where none is.
  [[nodiscard]] double theta_max_deg() const;

  /// "theta_i 30, phi_i 0, theta_v 45, phi_v 180 degrees", for messages.
  [[nodiscard]] std::string node_text(const GridNode& node) const;
  /// "6 x 48 x 6 x 48 nodes".
  [[nodiscard]] std::string size_text() const;

  bool operator==(const Grid&) const = default;
};

/// Largest number of nodes of a grid that is written.
inline constexpr std::uint64_t kGridMostNodes = std::uint64_t{1} << 36U;

/// A grid as written on the command line: [FRAME/]A:B:C:D, or the name of one that many use.
///
/// FRAME is angles (taken where none stands), difference, half-difference or mirror. Along each axis stands a step
/// [degrees], which divides the range of the axis, or a list "0,5,15,30"; "0" is the single node 0. Names: utia (6 x 48
/// x 6 x 48), utia-dense (44 x 180 x 44 x 180), merl (1 x 90 x 90 x 180 half and difference angles).
/// kUsage otherwise, with what is wrong.
[[nodiscard]] Result<Grid> parse_grid(std::string_view text);

/// The grid of MERL tables: the centres of their cells.
[[nodiscard]] Grid merl_grid(std::uint32_t theta_h_count, std::uint32_t theta_d_count, std::uint32_t phi_d_count);
/// Every `theta_step_deg` from 0 to `theta_last_deg` and every `phi_step_deg` of the turn, for both directions.
[[nodiscard]] Grid angles_grid(double theta_step_deg, double theta_last_deg, double phi_step_deg);

}  // namespace sbrdf::internal
