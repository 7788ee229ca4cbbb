#include "codec/search/moves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace sbrdf::internal {
namespace {

constexpr std::array<double, kAxisCount> kLeastCellDeg = {4, 4, 2, 0.0625};
constexpr std::array kFloorHalvings = {2, 5, 10};
using Ratio = std::optional<double>;
constexpr std::array<Ratio, 2> kIsotropicRatios = {std::nullopt, 1};
constexpr std::array<Ratio, 6> kRatios = {std::nullopt, 1, 0.2, 0.4, 2.5, 5};

// In steps of 1/32 degree, which f64 holds exactly.
double third_of(double gap_deg) { return std::round(gap_deg * 32 / 3) / 32; }

void move_nodes(const Structure& from, std::size_t axis, std::vector<Move>& moves) {
  const std::vector<double>& list = from.outline.lists[axis];
  const auto changed = [&](std::size_t first, std::size_t last) -> std::vector<double>& {
    return moves.emplace_back(Move{from, axis, list[first], list[last]}).to.outline.lists[axis];
  };
  for (std::size_t k = 0; k + 1 < list.size(); ++k) {
    if (list[k + 1] - list[k] < 2 * kLeastCellDeg[axis]) continue;
    std::vector<double>& target = changed(k, k + 1);
    target.insert(target.begin() + static_cast<std::ptrdiff_t>(k + 1), (list[k] + list[k + 1]) / 2);
  }
  for (std::size_t k = 1; k + 1 < list.size(); ++k) {
    std::vector<double>& without = changed(k - 1, k + 1);
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(k));
    const double down = third_of(list[k] - list[k - 1]);
    if (down > 0) changed(k - 1, k + 1)[k] -= down;
    const double up = third_of(list[k + 1] - list[k]);
    if (up > 0) changed(k - 1, k + 1)[k] += up;
  }
}

/// Each of `values` in place of the structure's own, which is left out.
template <class T>
void replace(const Structure& from, T Structure::*member, std::span<const T> values, std::size_t part,
             std::vector<Move>& moves) {
  for (const T& value : values) {
    if (value != from.*member) moves.emplace_back(Move{from, part, 0, 0}).to.*member = value;
  }
}

}  // namespace

std::vector<Move> moves_from(const Structure& structure, const SearchOptions& options) {
  std::vector<Move> moves;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) move_nodes(structure, axis, moves);
  if (structure.domain != DomainKind::kLog) return moves;
  replace<int>(structure, &Structure::floor_halvings, kFloorHalvings, kFloorPart, moves);
  if (structure.outline.id != FrameId::kHalfDifference) return moves;
  const auto ratios = options.symmetries.isotropic ? std::span<const Ratio>(kIsotropicRatios) : kRatios;
  replace<Ratio>(structure, &Structure::guide_ratio, ratios, kGuidePart, moves);
  return moves;
}

bool are_apart(const Move& a, const Move& b) {
  if (a.part != b.part) return true;
  return a.part < kAxisCount && (a.last_deg <= b.first_deg || b.last_deg <= a.first_deg);
}

Structure with_moves(const Structure& from, std::span<const Move> moves) {
  Structure to = from;
  for (const Move& move : moves) {
    if (move.part == kFloorPart) {
      to.floor_halvings = move.to.floor_halvings;
    } else if (move.part == kGuidePart) {
      to.guide_ratio = move.to.guide_ratio;
    } else {
      const auto between = [&](double node) { return node > move.first_deg && node < move.last_deg; };
      std::vector<double>& list = to.outline.lists[move.part];
      std::erase_if(list, between);
      std::ranges::copy_if(move.to.outline.lists[move.part], std::back_inserter(list), between);
      std::ranges::sort(list);
    }
  }
  return to;
}

}  // namespace sbrdf::internal
