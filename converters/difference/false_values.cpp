#include "converters/difference/false_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

namespace sbrdf::internal {
namespace {

constexpr double kRingDeg = 0.5;  // between rings, and between points on one
constexpr int kRings = 6;

/// Directions `angle_deg` away from another, above the horizon.
std::vector<Direction> ring_around(const Direction& centre, int ring) {
  const double angle = radians_from_degrees(kRingDeg * ring);
  const glm::dvec3 w = vector_from_direction(centre);
  const glm::dvec3 along = vector_from_direction({centre.theta + kPi / 2, centre.phi});
  const glm::dvec3 across = glm::cross(w, along);
  const int count = 6 * ring;
  std::vector<Direction> directions;
  for (int k = 0; k < count; ++k) {
    const double turn = 2 * kPi * k / count;
    const glm::dvec3 moved = std::cos(angle) * w + std::sin(angle) * (std::cos(turn) * along + std::sin(turn) * across);
    if (moved.z > 0) directions.push_back(direction_from_vector(moved));
  }
  return directions;
}

double angle_between(const Direction& a, const Direction& b) {
  const glm::dvec3 va = vector_from_direction(a);
  const glm::dvec3 vb = vector_from_direction(b);
  return std::atan2(glm::length(glm::cross(va, vb)), glm::dot(va, vb));
}

std::vector<DirectionPair> mirror_pairs(const DirectionPair& pair) {
  const auto mirror = [](const Direction& d) { return Direction{d.theta, d.phi + kPi}; };
  const double limit = radians_from_degrees(kNeighbourhoodDeg);
  if (angle_between(mirror(pair.i), pair.v) > limit) return {};
  return {{pair.i, mirror(pair.i)}, {mirror(pair.v), pair.v}};
}

std::vector<DirectionPair> ring_pairs(const DirectionPair& pair, int ring) {
  std::vector<DirectionPair> pairs;
  for (const Direction& v : ring_around(pair.v, ring)) pairs.push_back({pair.i, v});
  for (const Direction& i : ring_around(pair.i, ring)) pairs.push_back({i, pair.v});
  return pairs;
}

/// What one channel of the reference is near a pair.
struct Near {
  double largest = 0;  ///< |f|
  double least = std::numeric_limits<double>::infinity();
  void take(double f) {
    largest = std::max(largest, std::abs(f));
    least = std::min(least, f);
  }
  [[nodiscard]] double upper() const { return kStrictFactor * largest; }
  [[nodiscard]] double lower() const { return least > 0 ? least / kStrictFactor : least * kStrictFactor; }
  [[nodiscard]] bool too_large(double r) const { return !(std::abs(r) <= upper()); }
  [[nodiscard]] bool too_small(double r) const { return !(r >= lower()); }
};

double largest_of(std::span<const Near> near) {
  double largest = 0;
  for (const Near& channel : near) largest = std::max(largest, channel.largest);
  return largest;
}

double size_of(float r) { return std::isnan(r) ? std::numeric_limits<double>::infinity() : std::abs(r); }

bool any_false(FalseValueSearch search, std::span<const Near> near, std::span<const float> r) {
  if (search == FalseValueSearch::kFar) {
    const double limit = kFalseFactor * largest_of(near);
    return std::any_of(r.begin(), r.end(), [&](float value) { return size_of(value) > limit; });
  }
  for (std::size_t c = 0; c < near.size(); ++c) {
    if (near[c].too_large(r[c]) || near[c].too_small(r[c])) return true;
  }
  return false;
}

/// Some value would be false if the reference were the same all around. Most values end here, so nothing is allocated.
bool any_differs(FalseValueSearch search, std::span<const float> f, std::span<const float> r) {
  if (search == FalseValueSearch::kFar) {
    Near here;
    for (const float value : f) here.take(value);
    return any_false(search, std::span(&here, 1), r);
  }
  for (std::size_t c = 0; c < f.size(); ++c) {
    Near here;
    here.take(f[c]);
    if (any_false(search, std::span(&here, 1), r.subspan(c, 1))) return true;
  }
  return false;
}

/// Looks around the pair for as long as some value is false by what was seen.
std::vector<Near> look_around(const BrdfSource& reference, const DirectionPair& pair, std::span<const float> f,
                              std::span<const float> r, FalseValueSearch search) {
  std::vector<Near> near(f.size());
  const auto take = [&](std::span<const float> values) {
    for (std::size_t k = 0; k < values.size(); ++k) near[k % near.size()].take(values[k]);
  };
  take(f);
  std::vector<float> values;
  // The widest ring first: it has the most to say of a slope.
  for (int ring = kRings + 1; ring > 0 && any_false(search, near, r); --ring) {
    const std::vector<DirectionPair> pairs = ring > kRings ? mirror_pairs(pair) : ring_pairs(pair, ring);
    values.resize(pairs.size() * near.size());
    reference.evaluate(pairs, values);
    take(values);
  }
  return near;
}

double over(double value, double unit) { return unit > 0 ? value / unit : std::numeric_limits<double>::infinity(); }

void take_worst(double candidate, const ValuePlace& place, double& worst, ValuePlace& at) {
  if (!(candidate > worst)) return;
  worst = candidate;
  at = place;
}

}  // namespace

void FalseValues::add(const FalseValues& other) {
  count += other.count;
  too_large += other.too_large;
  too_small += other.too_small;
  take_worst(other.worst_factor, other.worst, worst_factor, worst);
  take_worst(other.strict_worst, other.strict_worst_at, strict_worst, strict_worst_at);
  complete = complete && other.complete;
}

void find_false_values(const BrdfSource& reference, const DirectionPair& pair, std::span<const float> f,
                       std::span<const float> r, FalseValueSearch search, FalseValues& found) {
  if (search == FalseValueSearch::kNone || !any_differs(search, f, r)) return;
  const std::vector<Near> near = look_around(reference, pair, f, r, search);
  const double largest = largest_of(near);
  for (std::size_t c = 0; c < near.size(); ++c) {
    const double size = size_of(r[c]);
    const ValuePlace place = {pair, c, f[c], r[c]};
    if (size > kFalseFactor * largest) {
      ++found.count;
      take_worst(over(size, largest), place, found.worst_factor, found.worst);
    }
    if (search == FalseValueSearch::kFar) continue;
    const bool large = near[c].too_large(r[c]);
    const bool small = !large && near[c].too_small(r[c]);
    if (large) ++found.too_large;
    if (small) ++found.too_small;
    if (large || small) {
      const double beyond = large ? size - near[c].upper() : near[c].lower() - r[c];
      take_worst(over(beyond, near[c].largest), place, found.strict_worst, found.strict_worst_at);
    }
  }
}

}  // namespace sbrdf::internal
