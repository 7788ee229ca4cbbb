#include "converters/tables/grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "formats/core/numbers.h"

namespace sbrdf::internal {
namespace {

using glm::dvec3;

struct AxisKind {
  std::string_view name;
  double range_deg;
  Ends ends;
};
constexpr AxisKind theta(std::string_view name) { return {name, 90, Ends::kHeld}; }
constexpr AxisKind turn(std::string_view name) { return {name, 360, Ends::kFullTurn}; }

constexpr std::array<std::array<AxisKind, 4>, 4> kKinds = {{
    {theta("theta_i"), turn("phi_i"), theta("theta_v"), turn("phi_v")},
    {turn("phi_i"), theta("theta_i"), theta("theta_v"), turn("phi_v - phi_i")},
    {turn("phi_h"), theta("theta_h"), theta("theta_d"), AxisKind{"phi_d", 180, Ends::kHalfTurn}},
    {turn("phi_i"), theta("theta_i"), turn("azimuth"), AxisKind{"radius", 180, Ends::kHeld}},
}};

const AxisKind& kind_of(GridFrame frame, std::size_t axis) {
  return kKinds.at(static_cast<std::size_t>(frame)).at(axis);
}

/// The mirror direction of a light, the direction in which azimuth 0 leaves it, and that in which 90 degrees do.
struct MirrorFrame {
  dvec3 centre, towards_normal, across;
};

MirrorFrame mirror_frame(const Direction& i) {
  const double phi = i.phi + kPi;
  const dvec3 centre = vector_from_direction({i.theta, phi});
  const dvec3 towards_normal = {-std::cos(i.theta) * std::cos(phi), -std::cos(i.theta) * std::sin(phi),
                                std::sin(i.theta)};
  return {centre, towards_normal, glm::cross(centre, towards_normal)};
}

Grid::Place mirror_place(const DirectionPair& pair) {
  const MirrorFrame frame = mirror_frame(pair.i);
  const dvec3 v = vector_from_direction(pair.v);
  const double x = glm::dot(v, frame.towards_normal);
  const double y = glm::dot(v, frame.across);
  return {pair.i.phi, pair.i.theta, std::atan2(y, x), std::atan2(std::hypot(x, y), glm::dot(v, frame.centre))};
}

DirectionPair mirror_pair(const Grid::Place& at) {
  const Direction i = {at[1], at[0]};
  const MirrorFrame frame = mirror_frame(i);
  const dvec3 aside = std::cos(at[2]) * frame.towards_normal + std::sin(at[2]) * frame.across;
  return {i, direction_from_vector(std::cos(at[3]) * frame.centre + std::sin(at[3]) * aside)};
}

}  // namespace

std::string_view Grid::axis_name(GridFrame frame, std::size_t axis) { return kind_of(frame, axis).name; }
Ends Grid::natural_ends(GridFrame frame, std::size_t axis) { return kind_of(frame, axis).ends; }
double Grid::range_deg(GridFrame frame, std::size_t axis) { return kind_of(frame, axis).range_deg; }

bool Grid::can_have(GridFrame frame, std::size_t axis, const std::vector<double>& nodes_deg, Ends ends,
                    Spacing spacing) {
  if (!GridAxis::is_valid(nodes_deg, ends, spacing)) return false;
  if (natural_ends(frame, axis) != Ends::kHeld) return ends != Ends::kExtrapolated;
  const bool turns = ends == Ends::kFullTurn || ends == Ends::kHalfTurn || ends == Ends::kMirrored;
  return !turns && nodes_deg.front() >= 0 && nodes_deg.back() <= range_deg(frame, axis);
}

std::uint64_t Grid::node_count() const {
  std::uint64_t count = 1;
  for (const GridAxis& axis : axes) count *= axis.size();
  return count;
}

GridNode Grid::node(std::uint64_t index) const {
  GridNode node;
  for (std::size_t axis = axes.size(); axis-- > 0;) {
    node[axis] = static_cast<std::uint32_t>(index % axes[axis].size());
    index /= axes[axis].size();
  }
  return node;
}

std::uint64_t Grid::index(const GridNode& node) const {
  std::uint64_t index = 0;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) index = index * axes[axis].size() + node[axis];
  return index;
}

Grid::Place Grid::place_of(const DirectionPair& pair) const {
  Place place{};
  switch (frame) {
    case GridFrame::kAngles:
      place = {pair.i.theta, pair.i.phi, pair.v.theta, pair.v.phi};
      break;
    case GridFrame::kDifference:
      place = {pair.i.phi, pair.i.theta, pair.v.theta, pair.v.phi - pair.i.phi};
      break;
    case GridFrame::kHalfDifference: {
      const HalfDifference angles = half_difference_from_pair(pair);
      // Under the normal phi_d is the azimuth of the light, which an isotropic material does not know.
      const bool nowhere = angles.theta_h == 0 && axes[0].size() == 1;
      place = {angles.phi_h, angles.theta_h, angles.theta_d, nowhere ? 0 : angles.phi_d};
      break;
    }
    case GridFrame::kMirror:
      place = mirror_place(pair);
      break;
  }
  for (double& angle : place) angle = degrees_from_radians(angle);
  return place;
}

DirectionPair Grid::pair_at(const Place& place) const {
  Place at = place;
  for (double& angle : at) angle = radians_from_degrees(angle);
  switch (frame) {
    case GridFrame::kDifference:
      return {{at[1], at[0]}, {at[2], at[0] + at[3]}};
    case GridFrame::kHalfDifference:
      return pair_from_half_difference({at[1], at[0], at[2], at[3]});
    case GridFrame::kMirror:
      return mirror_pair(at);
    case GridFrame::kAngles:
      break;
  }
  return {{at[0], at[1]}, {at[2], at[3]}};
}

DirectionPair Grid::pair_of(const GridNode& node) const {
  return pair_at(
      {axes[0].node_deg(node[0]), axes[1].node_deg(node[1]), axes[2].node_deg(node[2]), axes[3].node_deg(node[3])});
}

bool Grid::is_isotropic() const { return frame != GridFrame::kAngles && axes[0].size() == 1; }

bool Grid::is_reciprocal() const { return frame == GridFrame::kHalfDifference && axes[3].ends() == Ends::kHalfTurn; }

double Grid::theta_max_deg() const {
  double most = 90;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    const std::string_view name = axis_name(axis);
    if (name == "theta_i" || name == "theta_v") most = std::min(most, axes[axis].nodes_deg().back());
  }
  return most;
}

std::string Grid::node_text(const GridNode& node) const {
  std::string text;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    text += fmt::format("{}{} {:g}", axis == 0 ? "" : ", ", axis_name(axis), axes[axis].node_deg(node[axis]));
  }
  return text + " degrees";
}

std::string Grid::size_text() const {
  return fmt::format("{} x {} x {} x {} nodes", axes[0].size(), axes[1].size(), axes[2].size(), axes[3].size());
}

Grid merl_grid(std::uint32_t theta_h_count, std::uint32_t theta_d_count, std::uint32_t phi_d_count) {
  std::vector<double> theta_h(theta_h_count);
  for (std::uint32_t k = 0; k < theta_h_count; ++k) theta_h[k] = 90 * std::pow((k + 0.5) / theta_h_count, 2);
  const double d = 90.0 / theta_d_count;
  const double p = 180.0 / phi_d_count;
  return {
      GridFrame::kHalfDifference,
      {GridAxis(), GridAxis(std::move(theta_h), Ends::kHeld, Spacing::kRoot),
       GridAxis(even_nodes(d / 2, d, theta_d_count)), GridAxis(even_nodes(p / 2, p, phi_d_count), Ends::kHalfTurn)}};
}

Grid angles_grid(double theta_step_deg, double theta_last_deg, double phi_step_deg) {
  const auto thetas = static_cast<std::size_t>(std::lround(theta_last_deg / theta_step_deg)) + 1;
  const auto phis = static_cast<std::size_t>(std::lround(360 / phi_step_deg));
  const GridAxis theta(even_nodes(0, theta_step_deg, thetas));
  const GridAxis phi(even_nodes(0, phi_step_deg, phis), Ends::kFullTurn);
  return {GridFrame::kAngles, {theta, phi, theta, phi}};
}

namespace {

Result<GridAxis> axis_of_step(GridFrame frame, std::size_t axis, double step) {
  const double range = Grid::range_deg(frame, axis);
  const Ends ends = Grid::natural_ends(frame, axis);
  const std::string name(Grid::axis_name(frame, axis));
  const double count = std::round(range / step);
  if (step < 0 || count < 1 || count > static_cast<double>(GridAxis::kMost - 1) || std::abs(count * step - range) > 1e-6 * step) {
    return usage_error(fmt::format("a step of {:g} does not divide the {:g} degrees of {}", step, range, name));
  }
  const bool closes = ends == Ends::kFullTurn || ends == Ends::kHalfTurn;
  return GridAxis(even_nodes(0, range / count, static_cast<std::size_t>(count) + (closes ? 0 : 1)), ends);
}

Result<GridAxis> axis_of_list(GridFrame frame, std::size_t axis, std::vector<double> nodes) {
  const double range = Grid::range_deg(frame, axis);
  const Ends ends = nodes.size() == 1 ? Ends::kHeld : Grid::natural_ends(frame, axis);
  const bool inside = nodes.front() >= 0 && nodes.back() <= range;
  if (!inside || !GridAxis::is_valid(nodes, ends, Spacing::kAngle)) {
    return usage_error(fmt::format("nodes along {} must rise from 0 or more to {} {:g} degrees",
                                   Grid::axis_name(frame, axis), ends == Ends::kHeld ? "at most" : "less than", range));
  }
  return GridAxis(std::move(nodes), ends);
}

std::optional<std::vector<double>> parse_list(std::string_view text) {
  std::vector<double> nodes;
  while (true) {
    const std::size_t end = std::min(text.find(','), text.size());
    const std::optional<double> number = parse_number(text.substr(0, end));
    if (!number) return std::nullopt;
    nodes.push_back(*number + 0.0);
    if (end == text.size()) return nodes;
    text.remove_prefix(end + 1);
  }
}

Result<GridAxis> parse_axis(GridFrame frame, std::size_t axis, std::string_view text) {
  std::optional<std::vector<double>> list = parse_list(text);
  if (!list) {
    return usage_error(
        fmt::format("'{}' is neither a step nor a list of degrees for {}", text, Grid::axis_name(frame, axis)));
  }
  if (list->size() == 1 && list->front() != 0) return axis_of_step(frame, axis, list->front());
  return axis_of_list(frame, axis, *std::move(list));
}

}  // namespace

Result<Grid> parse_grid(std::string_view text) {
  if (text == "utia") return angles_grid(15, 75, 7.5);
  if (text == "utia-dense") return angles_grid(2, 86, 2);
  if (text == "merl") return merl_grid(90, 90, 180);
  Grid grid;
  std::string_view rest = text;
  if (const std::size_t slash = rest.find('/'); slash != std::string_view::npos) {
    const auto frame = value_of(kGridFrameNames, rest.substr(0, slash));
    if (!frame) {
      return usage_error(
          fmt::format("'{}' is none of {}", rest.substr(0, slash), fmt::join(names_of(kGridFrameNames), ", ")));
    }
    grid.frame = *frame;
    rest.remove_prefix(slash + 1);
  }
  for (std::size_t axis = 0; axis < grid.axes.size(); ++axis) {
    const bool last = axis + 1 == grid.axes.size();
    const std::size_t end = last ? rest.size() : rest.find(':');
    if (end == std::string_view::npos || (last && rest.find(':') != std::string_view::npos)) {
      return usage_error(fmt::format("'{}' is neither utia, utia-dense, merl nor four axes such as 5:10:5:10", text));
    }
    Result<GridAxis> parsed = parse_axis(grid.frame, axis, rest.substr(0, end));
    if (!parsed) return parsed.error();
    grid.axes[axis] = *std::move(parsed);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (grid.node_count() > kGridMostNodes) {
    return usage_error(fmt::format("{} are more than 2^36", grid.size_text()));
  }
  return grid;
}

}  // namespace sbrdf::internal
