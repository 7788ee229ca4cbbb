#include "codec/atlas/part/reached_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codec/frame/frame.h"

namespace sbrdf::internal {
namespace {

constexpr double kRounding = 0.01;  // degrees: what single precision makes of an azimuth near a pole, and more

double sin_deg(double degrees) { return std::sin(radians_from_degrees(degrees)); }
double cos_deg(double degrees) { return std::cos(radians_from_degrees(degrees)); }

/// How far an azimuth moves at most where its direction, `polar` degrees from the pole, moves by `moved`.
double azimuth_moved(double polar, double moved) {
  if (polar <= moved) return 180;
  return degrees_from_radians(std::asin(std::min(1.0, sin_deg(moved) / sin_deg(polar))));
}

}  // namespace

ReachedCells::ReachedCells(const AtlasLayout& layout) : layout_(layout), cells_(cell_counts(layout)) {
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const std::vector<double>& nodes = layout.axes[axis].nodes_deg;
    narrowest_[axis] = 720;
    for (std::size_t k = 1; k < nodes.size(); ++k) {
      narrowest_[axis] = std::min(narrowest_[axis], nodes[k] - nodes[k - 1]);
    }
  }
}

void ReachedCells::add(const DirectionPair& pair, double margin_deg) {
  const double margin = std::max(margin_deg, kRounding);
  if (layout_.frame == FrameId::kHalfDifference) {
    add_half_difference(pair, margin);
  } else {
    add_elevation(pair, margin);
  }
}

template <class Visit>
void ReachedCells::for_places(const Box& box, const Coordinates& narrowest, const Visit& visit) const {
  std::array<std::size_t, kAxisCount> counts;
  Coordinates steps;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
    const double width = box[axis].last - box[axis].first;
    const double intervals = std::max(1.0, std::ceil(width / narrowest[axis]));
    counts[axis] = static_cast<std::size_t>(intervals) + 1;
    steps[axis] = width / intervals;
  }
  std::array<std::size_t, kAxisCount> k{};
  for (k[0] = 0; k[0] < counts[0]; ++k[0]) {
    for (k[1] = 0; k[1] < counts[1]; ++k[1]) {
      for (k[2] = 0; k[2] < counts[2]; ++k[2]) {
        for (k[3] = 0; k[3] < counts[3]; ++k[3]) {
          Coordinates x;
          for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
            x[axis] = box[axis].first + static_cast<double>(k[axis]) * steps[axis];
          }
          visit(x);
        }
      }
    }
  }
}

// The half vector of unit vectors that move by chords of at most e each moves by a chord of 2 e / |i + v| at most,
// which is e / cos(theta_d); theta_d, half the angle between them, moves by the margin at most. The light as seen from
// the half vector moves by what it moves itself and by the turn of the half vector's frame: about the normal by phi_h,
// and down by theta_h.
void ReachedCells::add_half_difference(const DirectionPair& pair, double margin_deg) {
  const Coordinates x = geometry(layout_.frame).coordinates(pair);
  const double chord = 2 * sin_deg(margin_deg / 2);
  const double tilt = degrees_from_radians(2 * std::asin(std::min(1.0, chord / (2 * std::max(cos_deg(x[2]), 1e-9)))));
  const double turn = azimuth_moved(x[3], tilt);
  const double spin = std::min(90.0, azimuth_moved(x[2], margin_deg + tilt) + turn);
  const Box box = {Range{x[0] - turn, x[0] + turn}, Range{x[1] - spin, x[1] + spin},
                   Range{std::max(0.0, x[2] - margin_deg), std::min(90.0, x[2] + margin_deg)},
                   Range{std::max(0.0, x[3] - tilt), std::min(90.0, x[3] + tilt)}};
  for_places(box, narrowest_, [&](Coordinates at) {
    at[0] = wrap(at[0], 360);
    at[1] = wrap(at[1], 180);
    cells_.add(cell_of(layout_, fold_coordinates(layout_, at)));
  });
}

// s and u move by what both azimuths move together. Where the thetas change places u changes its sign.
void ReachedCells::add_elevation(const DirectionPair& pair, double margin_deg) {
  const double theta_i = degrees_from_radians(pair.i.theta);
  const double theta_v = degrees_from_radians(pair.v.theta);
  const double s = degrees_from_radians(pair.i.phi + pair.v.phi);
  const double u = degrees_from_radians(pair.i.phi - pair.v.phi);
  const double turn = std::min(360.0, azimuth_moved(theta_i, margin_deg) + azimuth_moved(theta_v, margin_deg));
  const auto about = [&](double theta) {
    return Range{std::max(0.0, theta - margin_deg), std::min(90.0, theta + margin_deg)};
  };
  const Box box = {Range{s - turn, s + turn}, Range{u - turn, u + turn}, about(theta_v), about(theta_i)};
  const auto add = [&](Coordinates at) {
    const double turns = 360 * std::floor(at[kDiagonal] / 360);
    at[kAxial] = wrap(at[kAxial] - turns, 720);
    at[kDiagonal] -= turns;
    cells_.add(cell_of(layout_, fold_coordinates(layout_, at)));
  };
  // Between places in one order there may be some in the other.
  const bool either = std::abs(theta_i - theta_v) <= 2 * margin_deg;
  for_places(box, narrowest_, [&](Coordinates at) {
    const bool swapped = at[kVertical] > at[kHorizontal];
    if (swapped) std::swap(at[kVertical], at[kHorizontal]);
    if (!swapped || either) add(at);
    at[kDiagonal] = -at[kDiagonal];
    if (swapped || either) add(at);
  });
}

// The larger theta of a cell's pairs is least where theta_h and theta_d are, and phi_d is nearest to 90 degrees: the
// cosines are cos(theta_h) cos(theta_d) -+ sin(theta_h) sin(theta_d) cos(phi_d).
void ReachedCells::add_up_to(double theta_max_deg) {
  AtlasCell cell{};
  const AtlasCells::Counts counts = cells_.counts();
  const auto low = [&](std::size_t axis) {
    const AtlasAxis& on = layout_.axes[axis];
    return on.moves() ? on.nodes_deg[cell[axis]] : 0.0;
  };
  const auto is_reached = [&] {
    if (layout_.frame == FrameId::kElevation) return low(kHorizontal) <= theta_max_deg;
    const AtlasAxis& spin = layout_.axes[kDiagonal];
    const double nearest =
        spin.moves() ? std::clamp(90.0, spin.nodes_deg[cell[kDiagonal]], spin.nodes_deg[cell[kDiagonal] + 1]) : 90.0;
    const double cosine = cos_deg(low(kVertical)) * cos_deg(low(kHorizontal)) -
                          sin_deg(low(kVertical)) * sin_deg(low(kHorizontal)) * std::abs(cos_deg(nearest));
    return cosine >= cos_deg(theta_max_deg) - 1e-12;
  };
  for (cell[0] = 0; cell[0] < counts[0]; ++cell[0]) {
    for (cell[1] = 0; cell[1] < counts[1]; ++cell[1]) {
      for (cell[2] = 0; cell[2] < counts[2]; ++cell[2]) {
        for (cell[3] = 0; cell[3] < counts[3]; ++cell[3]) {
          if (is_reached()) cells_.add(cell);
        }
      }
    }
  }
}

}  // namespace sbrdf::internal
