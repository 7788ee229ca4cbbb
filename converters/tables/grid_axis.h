#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "formats/core/named.h"

namespace sbrdf::internal {

/// What lies beyond the first and the last node of an axis.
enum class Ends : std::uint8_t {
  kHeld,          ///< the end node's value
  kFullTurn,      ///< an azimuth that closes after 360 degrees
  kHalfTurn,      ///< one that closes after 180 degrees
  kMirrored,      ///< one of which 0 to 180 degrees are stored: the other half is the same mirrored
  kExtrapolated,  ///< the straight line through the last two nodes; below the first node as kHeld
};
inline constexpr std::array kEndsNames = {Named{"held", Ends::kHeld}, Named{"360", Ends::kFullTurn},
                                          Named{"180", Ends::kHalfTurn}, Named{"mirrored", Ends::kMirrored},
                                          Named{"extrapolated", Ends::kExtrapolated}};

/// What values are interpolated linearly in.
enum class Spacing : std::uint8_t {
  kAngle,
  kRoot,  ///< the square root of the angle, as along theta_h of MERL tables
};
inline constexpr std::array kSpacingNames = {Named{"angle", Spacing::kAngle}, Named{"root", Spacing::kRoot}};

/// Two neighbouring nodes and how far from the first to the second; beyond 1 where an axis is extrapolated. Within 1e-9
/// of a node the weight is exactly 0 or 1, so that a node's own directions give its own value.
struct Bracket {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  double weight = 0;  ///< of `high`
};

/// Nodes along one angle of a grid.
class GridAxis {
 public:
  GridAxis() = default;
  /// `nodes_deg` [degrees] is not empty, finite and rising; see is_valid().
  explicit GridAxis(std::vector<double> nodes_deg, Ends ends = Ends::kHeld, Spacing spacing = Spacing::kAngle);

  /// Whether an axis can have these nodes: 1 to kMost, rising, within the turn that `ends` says; at least two where
  /// ends are extrapolated, none below 0 where a root is taken.
  [[nodiscard]] static bool is_valid(const std::vector<double>& nodes_deg, Ends ends, Spacing spacing);
  static constexpr std::size_t kMost = 65536;

  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(nodes_deg_.size()); }
  [[nodiscard]] const std::vector<double>& nodes_deg() const { return nodes_deg_; }
  [[nodiscard]] double node_deg(std::uint32_t index) const { return nodes_deg_[index]; }
  [[nodiscard]] Ends ends() const { return ends_; }
  [[nodiscard]] Spacing spacing() const { return spacing_; }

  /// The nodes around an angle [degrees].
  [[nodiscard]] Bracket bracket(double angle_deg) const;

  bool operator==(const GridAxis& other) const {
    return nodes_deg_ == other.nodes_deg_ && ends_ == other.ends_ && spacing_ == other.spacing_;
  }

 private:
  [[nodiscard]] double scaled(double angle_deg) const;
  [[nodiscard]] Bracket between(double at) const;
  [[nodiscard]] Bracket around(double angle_deg, double turn_deg) const;

  std::vector<double> nodes_deg_ = {0};
  std::vector<double> scaled_ = {0};  ///< in what is interpolated linearly
  double per_unit_ = 0;               ///< nodes per unit of scaled_ where these are even, else 0
  Ends ends_ = Ends::kHeld;
  Spacing spacing_ = Spacing::kAngle;
};

/// `count` nodes from `first_deg` on, `step_deg` apart.
[[nodiscard]] std::vector<double> even_nodes(double first_deg, double step_deg, std::size_t count);

}  // namespace sbrdf::internal
