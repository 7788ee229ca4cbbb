#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/directions.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// A frame gives a pair of directions four coordinates; slices are the lines along which one coordinate varies while the
// other three stay at nodes. Everything in the codec that is not in frame_*.cpp works for any frame.
//
// Frame coordinates are in degrees, as in files: nodes and their halvings are then exact numbers.

inline constexpr std::size_t kAxisCount = 4;

/// The largest theta of either direction that the paper's frames cover.
inline constexpr double kPaperThetaMaxDeg = 80;

/// A slice is named after the axis along which it runs.
/// kAxial and kDiagonal are azimuths, kHorizontal and kVertical polar angles, in every frame.
enum SliceKind : std::uint8_t { kAxial = 0, kDiagonal = 1, kHorizontal = 2, kVertical = 3 };

/// The numbers stand in files and never change their meaning.
enum class FrameId : std::uint8_t {
  kElevation = 1,       ///< (s, u, theta_v, theta_i), s = phi_i + phi_v, u = phi_i - phi_v
  kHalfDifference = 2,  ///< (phi_h, phi_d, theta_d, theta_h)
};

/// One coordinate. Azimuthal nodes rise within [0, 360) (phi_d: [0, 180)) and begin with 0; polar nodes rise within
/// [0, 90] and begin with 0. Neighbours are at least 0.001 degrees apart. One single node means that the coordinate
/// does not matter.
struct Axis {
  std::string name;               ///< for messages and metadata, such as theta_v
  std::vector<double> nodes_deg;  ///< 1 to 4096, without the end of the turn of an azimuth

  bool operator==(const Axis&) const = default;
};

/// Symmetries of a material beside reciprocity, which every frame assumes.
struct Symmetries {
  bool isotropic = false;  ///< turning both directions about the normal changes nothing
  bool mirror_x = false;   ///< f unchanged under phi -> -phi of both directions (mirror plane along the tangent x)
  bool mirror_y = false;   ///< f unchanged under phi -> 180 - phi of both (mirror plane along y)

  bool operator==(const Symmetries&) const = default;
};

/// All that decides where crossings and slices lie. A frame from a file may hold anything: see check_frame.
struct FrameSpec {
  FrameId id = FrameId::kElevation;
  std::array<Axis, kAxisCount> axes;  ///< in the order of SliceKind
  Symmetries symmetries;
  /// The largest theta [degrees] of either direction that the frame covers, in (0, 90]; beyond, the value there is
  /// held. In the elevation frame the last elevation, in the half/difference frame in whole hundredths.
  double theta_max_deg = kPaperThetaMaxDeg;

  bool operator==(const FrameSpec&) const = default;
};

using Coordinates = std::array<double, kAxisCount>;  ///< [degrees], in the order of SliceKind

/// Whether both directions lie above the horizon or on it. Below, f_r is 0 by definition, whatever a slice would give
/// (specs/conventions.md). An angle that is no number lies nowhere, so not above.
[[nodiscard]] inline bool above_horizon(const DirectionPair& pair) {
  return pair.i.theta <= kPi / 2 && pair.v.theta <= kPi / 2;
}

/// A point (no slope) or a line (one or two slopes of +1 or -1) of the coordinate space: x_k = offset_k + slope_k p.
/// Two slopes come about where a symmetry mixes azimuths: at theta_i = 0 of the elevation frame only s - u matters, so
/// a line along u is one along s, too.
struct AffineLine {
  Coordinates offset{};                 ///< [degrees]; where the parameter p is 0
  std::array<int, kAxisCount> slope{};  ///< 0 where the coordinate stays
};

/// The symmetric images of a line: one for each combination of reciprocity and the mirrors that the material has, which
/// makes 8 at most. Images that come out equal are listed each.
struct Images {
  std::array<AffineLine, 8> lines;
  std::size_t count = 0;
};

/// At 0 of a polar axis two azimuths become one: only x[ring_axis] + sign x[the other azimuth] matters there, which is
/// ring_axis' coordinate where the other azimuth is 0. "Two" are axial and diagonal.
struct Merging {
  std::size_t polar_axis = kVertical;
  std::size_t ring_axis = kAxial;
  int sign = 1;
  double period_deg = 360;  ///< of the one that is left
};

/// What a frame means. Stateless; one object per FrameId.
class FrameGeometry {
 public:
  FrameGeometry() = default;
  FrameGeometry(const FrameGeometry&) = delete;
  FrameGeometry& operator=(const FrameGeometry&) = delete;
  virtual ~FrameGeometry() = default;

  /// As on the command line and in metadata, such as "half-difference".
  [[nodiscard]] virtual std::string_view name() const = 0;
  [[nodiscard]] virtual std::array<std::string_view, kAxisCount> axis_names() const = 0;

  /// Period [degrees] of an azimuthal axis' node list; 0 for a polar axis.
  [[nodiscard]] virtual double node_period(std::size_t axis) const = 0;
  /// Period of the function along a line of that axis: a multiple of node_period.
  [[nodiscard]] virtual double line_period(std::size_t axis, const Symmetries& symmetries) const = 0;
  /// Degrees of the slice's parameter (t = s/2, t = u/2 in the elevation frame) per degree of the coordinate.
  [[nodiscard]] virtual double arc_scale(std::size_t axis) const = 0;

  /// How large a part of all directions lies nearer to one node of an axis than to its neighbours, up to a factor that
  /// is the same for all. `padded` as in Lattice::nodes, `node` one of them (the nearest is taken).
  [[nodiscard]] virtual double share_served(std::size_t axis, std::span<const double> padded, double node) const = 0;

  /// Azimuths within the padded lattice (s in [0, 720), u in [0, 360), phi_h in [0, 360), phi_d in [0, 180)), polar
  /// angles not clamped. Exchanging i and v gives the same bits, which is what makes evaluation reciprocal.
  [[nodiscard]] virtual Coordinates coordinates(const DirectionPair& pair) const = 0;
  /// A pair of directions at these coordinates, both above the horizon: where the coordinates lead far beyond
  /// theta_max, a place shortly beyond stands for them. So every crossing can be measured.
  [[nodiscard]] virtual DirectionPair directions(const Coordinates& coordinates, double theta_max_deg) const = 0;

  /// Where azimuths become one. Where all azimuths cease to matter at once is not listed: there nothing is left to
  /// choose.
  [[nodiscard]] virtual std::span<const Merging> mergings() const = 0;

  /// The images of a point or line under all symmetries, each brought to normal form: azimuths that do not matter at a
  /// pole or for an isotropic material are taken out, fixed azimuths lie within their node period, and the moving one's
  /// offset within its line period.
  ///
  /// Axes 0 and 1 are azimuths, 2 and 3 polar. What becomes of the azimuths depends on the polar coordinates only by
  /// which of them stay at 0; these stay as they are, or, in a frame where both have the same nodes, change places.
  [[nodiscard]] virtual Images images(const AffineLine& line, const Symmetries& symmetries) const = 0;
};

/// The geometry of a known id; nullptr for others (ids come from files).
[[nodiscard]] const FrameGeometry* find_geometry(FrameId id);
[[nodiscard]] const FrameGeometry& geometry(FrameId id);

/// The pair of directions that is measured for a crossing or sample of a frame.
[[nodiscard]] inline DirectionPair directions_at(const FrameSpec& spec, const Coordinates& coordinates) {
  return geometry(spec.id).directions(coordinates, spec.theta_max_deg);
}

/// From here on [degrees] the half/difference frame lets directions slow down, to end a degree beyond.
[[nodiscard]] inline double ease_from_deg(double theta_max_deg) { return theta_max_deg < 89 ? theta_max_deg : 89; }

/// Elevations e_s, 2 e_s, ... below theta_max and theta_max itself, with 0 before them; axial and diagonal slices every
/// a_s degrees. For an isotropic material s has one node. kUsage unless theta_max lies in (0, 90], the elevation step
/// in [0.5, theta_max], and the azimuth step in [1, 360] divides 360.
[[nodiscard]] Result<FrameSpec> elevation_frame(double elevation_step_deg, double azimuth_step_deg,
                                                const Symmetries& symmetries, double theta_max_deg = kPaperThetaMaxDeg);

/// The elevation frame with its own lists: `elevations_deg` begins with 0; `s` and `u` begin with 0, within [0, 360),
/// and `u` is symmetric about 180. The last elevation is theta_max.
[[nodiscard]] FrameSpec elevation_frame_from_nodes(std::vector<double> elevations_deg, std::vector<double> s_nodes_deg,
                                                   std::vector<double> u_nodes_deg, const Symmetries& symmetries);

/// The half/difference frame. theta_h and theta_d begin with 0, within [0, 90]; phi_h begins with 0, within [0, 360),
/// and is just {0} for an isotropic material; phi_d begins with 0, within [0, 180).
[[nodiscard]] FrameSpec half_difference_frame(std::vector<double> theta_h_deg, std::vector<double> theta_d_deg,
                                              std::vector<double> phi_h_deg, std::vector<double> phi_d_deg,
                                              const Symmetries& symmetries, double theta_max_deg = kPaperThetaMaxDeg);

/// Checks every list against the rules at Axis and against the symmetries. In the elevation frame theta_i and theta_v
/// must have the same nodes, which end at theta_max, and u must have 360 - x wherever it has x > 0. kInvalidFile names
/// the axis and the node;
/// kUnsupported for an unknown id.
[[nodiscard]] Status check_frame(const FrameSpec& spec);

}  // namespace sbrdf::internal
