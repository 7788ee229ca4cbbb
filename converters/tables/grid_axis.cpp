#include "converters/tables/grid_axis.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

constexpr double kSnap = 1e-9;

double turn_of(Ends ends) { return ends == Ends::kHalfTurn ? 180 : 360; }

Bracket snapped(Bracket bracket) {
  if (std::abs(bracket.weight) < kSnap) bracket.weight = 0;
  if (std::abs(bracket.weight - 1) < kSnap) bracket.weight = 1;
  return bracket;
}

}  // namespace

std::vector<double> even_nodes(double first_deg, double step_deg, std::size_t count) {
  std::vector<double> nodes(count);
  for (std::size_t k = 0; k < count; ++k) nodes[k] = first_deg + static_cast<double>(k) * step_deg;
  return nodes;
}

bool GridAxis::is_valid(const std::vector<double>& nodes_deg, Ends ends, Spacing spacing) {
  if (nodes_deg.empty() || nodes_deg.size() > kMost) return false;
  for (std::size_t k = 0; k < nodes_deg.size(); ++k) {
    if (!std::isfinite(nodes_deg[k]) || (k > 0 && nodes_deg[k] <= nodes_deg[k - 1])) return false;
  }
  const double first = nodes_deg.front();
  const double last = nodes_deg.back();
  if (spacing == Spacing::kRoot && (first < 0 || ends == Ends::kFullTurn || ends == Ends::kHalfTurn)) return false;
  switch (ends) {
    case Ends::kFullTurn:
    case Ends::kHalfTurn:
      return last - first < turn_of(ends) && std::abs(first) <= 360;
    case Ends::kMirrored:
      return first >= 0 && last <= 180;
    case Ends::kExtrapolated:
      return nodes_deg.size() > 1 && first >= 0 && last <= 180;
    case Ends::kHeld:
      break;
  }
  return first >= -360 && last <= 360;
}

GridAxis::GridAxis(std::vector<double> nodes_deg, Ends ends, Spacing spacing)
    : nodes_deg_(std::move(nodes_deg)), scaled_(nodes_deg_.size()), ends_(ends), spacing_(spacing) {
  assert(is_valid(nodes_deg_, ends, spacing));
  std::transform(nodes_deg_.begin(), nodes_deg_.end(), scaled_.begin(), [this](double node) { return scaled(node); });
  if (scaled_.size() < 2) return;
  const double step = (scaled_.back() - scaled_.front()) / static_cast<double>(scaled_.size() - 1);
  const bool even = [&] {
    for (std::size_t k = 0; k < scaled_.size(); ++k) {
      if (std::abs(scaled_.front() + static_cast<double>(k) * step - scaled_[k]) > 1e-7 * step) return false;
    }
    return true;
  }();
  per_unit_ = even ? 1 / step : 0;
}

double GridAxis::scaled(double angle_deg) const {
  return spacing_ == Spacing::kRoot ? std::sqrt(std::max(angle_deg, 0.0)) : angle_deg;
}

// `at` in scaled units, inside or outside of the nodes; at least two nodes.
Bracket GridAxis::between(double at) const {
  const auto last = static_cast<std::uint32_t>(scaled_.size() - 1);
  std::uint32_t low = 0;
  if (per_unit_ > 0) {
    const double position = (at - scaled_.front()) * per_unit_;
    low = static_cast<std::uint32_t>(std::clamp(position, 0.0, static_cast<double>(last - 1)));
  } else {
    const auto above = std::upper_bound(scaled_.begin() + 1, scaled_.end() - 1, at);
    low = static_cast<std::uint32_t>(above - scaled_.begin()) - 1;
  }
  return {low, low + 1, (at - scaled_[low]) / (scaled_[low + 1] - scaled_[low])};
}

Bracket GridAxis::around(double angle_deg, double turn_deg) const {
  const double inside = nodes_deg_.front() + wrap(angle_deg - nodes_deg_.front(), turn_deg);
  if (inside <= nodes_deg_.back()) return between(scaled(inside));
  const double gap = nodes_deg_.front() + turn_deg - nodes_deg_.back();
  return {size() - 1, 0, (inside - nodes_deg_.back()) / gap};
}

Bracket GridAxis::bracket(double angle_deg) const {
  if (size() == 1) return {};
  Bracket found;
  switch (ends_) {
    case Ends::kFullTurn:
    case Ends::kHalfTurn:
      return snapped(around(angle_deg, turn_of(ends_)));
    case Ends::kMirrored:
      found = between(scaled(180 - std::abs(180 - wrap(angle_deg, 360))));
      break;
    case Ends::kExtrapolated:
      found = between(scaled(angle_deg));
      found.weight = std::max(found.weight, 0.0);
      return snapped(found);
    case Ends::kHeld:
      found = between(scaled(angle_deg));
      break;
  }
  found.weight = std::clamp(found.weight, 0.0, 1.0);
  return snapped(found);
}

}  // namespace sbrdf::internal
