#include "codec/mask/direction_mask.h"

#include <algorithm>
#include <cmath>

namespace sbrdf::internal {
namespace {

constexpr double kQuarter = kPi / 2;
constexpr double kTurn = 2 * kPi;

}  // namespace

bool MaskGrid::is_valid() const {
  const bool known = frame == MaskFrame::kAngles || frame == MaskFrame::kHalfDifference;
  const auto sane = [](std::uint32_t count) { return count >= 1 && count <= kMostAlongAxis; };
  return known && std::all_of(counts.begin(), counts.end(), sane) && cell_count() <= kMostCells;
}

MaskGrid::Place MaskGrid::place_of(const DirectionPair& pair) const {
  Place place{};
  if (frame == MaskFrame::kAngles) {
    const double from = counts[1] == 1 ? pair.i.phi : 0;
    place = {pair.i.theta / kQuarter, wrap(pair.i.phi, kTurn) / kTurn, pair.v.theta / kQuarter,
             wrap(pair.v.phi - from, kTurn) / kTurn};
  } else {
    const HalfDifference angles = half_difference_from_pair(pair);
    place = {angles.phi_h / kTurn, std::sqrt(angles.theta_h / kQuarter), angles.theta_d / kQuarter,
             wrap(angles.phi_d, kPi) / kPi};
  }
  for (std::size_t axis = 0; axis < counts.size(); ++axis)
    place[axis] = std::clamp(place[axis], 0.0, 1.0) * counts[axis];
  return place;
}

DirectionPair MaskGrid::pair_at(const Place& place) const {
  Place x{};
  for (std::size_t axis = 0; axis < counts.size(); ++axis) x[axis] = place[axis] / counts[axis];
  if (frame == MaskFrame::kAngles) {
    const double phi_i = counts[1] == 1 ? 0 : x[1] * kTurn;
    return {{x[0] * kQuarter, phi_i}, {x[2] * kQuarter, x[3] * kTurn}};
  }
  const double phi_h = counts[0] == 1 ? 0 : x[0] * kTurn;
  return pair_from_half_difference({x[1] * x[1] * kQuarter, phi_h, x[2] * kQuarter, x[3] * kPi});
}

std::uint64_t MaskGrid::cell_of(const DirectionPair& pair) const {
  const Place place = place_of(pair);
  std::uint64_t cell = 0;
  for (std::size_t axis = 0; axis < counts.size(); ++axis) {
    cell = cell * counts[axis] + static_cast<std::uint64_t>(std::min(place[axis], counts[axis] - 0.5));
  }
  return cell;
}

MaskGrid::Place MaskGrid::place_of_centre(std::uint64_t cell) const {
  Place place{};
  for (std::size_t axis = counts.size(); axis-- > 0; cell /= counts[axis]) {
    place[axis] = static_cast<double>(cell % counts[axis]) + 0.5;
  }
  return place;
}

double MaskGrid::distance_deg(std::size_t axis, double from, double to) const {
  const double a = from / counts[axis];
  const double b = to / counts[axis];
  if (frame == MaskFrame::kHalfDifference && axis == 1) return 90 * std::abs(a * a - b * b);
  const bool polar = frame == MaskFrame::kAngles ? axis % 2 == 0 : axis == 2;
  if (polar) return 90 * std::abs(a - b);
  const double turn = frame == MaskFrame::kHalfDifference && axis == 3 ? 180 : 360;
  const double way = std::abs(a - b);
  return turn * std::min(way, 1 - way);
}

}  // namespace sbrdf::internal
