#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/support/analytic_brdf.h"
#include "tests/support/dense_spline.h"
#include "tests/support/limited_curve.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {

/// Frame coordinates of a pair, with the two directions as they are given. The azimuth of a direction at the pole means
/// nothing; in the elevation frame u is 0 there.
inline Coordinates plain_coordinates(const DirectionPair& pair, FrameId frame) {
  if (frame == FrameId::kElevation) {
    double phi_i = degrees_from_radians(pair.i.phi);
    double phi_v = degrees_from_radians(pair.v.phi);
    if (pair.i.theta == 0) phi_i = phi_v;
    if (pair.v.theta == 0) phi_v = phi_i;
    return {phi_i + phi_v, phi_i - phi_v, degrees_from_radians(pair.v.theta), degrees_from_radians(pair.i.theta)};
  }
  const HalfDifference angles = half_difference_from_pair(pair);
  return {degrees_from_radians(angles.phi_h), degrees_from_radians(angles.phi_d), degrees_from_radians(angles.theta_d),
          degrees_from_radians(angles.theta_h)};
}

/// Section 7 of the paper as it is printed, in long double and without regard to speed; in log values the sum is held
/// below the greatest slice, too, and a guide is taken off and added again. It takes from the lattice only
/// what is measured (crossings, slices and their nodes) and finds out by comparing directions which crossing is at
/// a corner and which slice along a line.
class LiteralEvaluator {
 public:
  LiteralEvaluator(const SlicedBrdf& sliced, const Lattice& lattice)
      : sliced_(sliced), lattice_(lattice), frame_(geometry(lattice.spec.id)) {
    std::size_t next = 0;
    for (std::size_t k = 0; k < lattice.slices.size(); ++k) {
      const Slice& slice = lattice.slices[k];
      std::map<double, const float*> samples;
      for (const SliceNode& node : lattice.nodes_of(slice)) {
        samples[node.position_deg] = sliced.crossing_values.data() + node.crossing * sliced.channel_count();
      }
      for (std::uint32_t s = 0; s < sliced.sample_counts[k]; ++s, ++next) {
        samples[place_in_degrees(lattice, slice, sliced.positions[next])] =
            sliced.sample_values.data() + next * sliced.channel_count();
      }
      samples_.push_back(std::move(samples));
    }
  }

  struct Answer {
    long double value = 0;
    int clamped = 0;  ///< -1 where the least of the slices stands for the sum, 1 where the greatest does
  };

  /// Coordinates as the paper counts them: s and u of any turn, theta_i and theta_v in any order.
  Answer operator()(const Coordinates& given, std::size_t channel) {
    const Coordinates point = within_first_turn(given);
    Sum sum = sum_in_cell(point, channel);
    const long double before = sum.value;
    if (varies(kAxial) && varies(kDiagonal) && varies(kHorizontal) && varies(kVertical)) {
      for (const std::size_t axis : {kVertical, kHorizontal}) {
        if (elevation_frame() || axis == kVertical) correct_at_pole(point, axis, channel, sum);
      }
    }
    const long double bounded = std::clamp(sum.value, sum.least, sum.most);
    const long double value = inverse(bounded + guide_at(point, channel), channel);
    return {has_negative(channel) ? value : std::max(0.0L, value), before == sum.least  ? -1
                                                                   : before == sum.most ? 1
                                                                                        : 0};
  }

 private:
  /// Held between the two.
  struct Sum {
    long double value = 0;
    long double least = 0;
    long double most = 0;
  };

  [[nodiscard]] Sum held(long double sum, long double least, long double most) const {
    if (sliced_.domain.kind == DomainKind::kLinear) most = std::numeric_limits<long double>::infinity();
    return {std::clamp(sum, least, most), least, most};
  }

  [[nodiscard]] bool varies(std::size_t axis) const { return lattice_.nodes[axis].size() > 1; }

  // In the cells at a pole: what the sum has too much on the face is taken off, the less the farther away.
  void correct_at_pole(const Coordinates& point, std::size_t axis, std::size_t channel, Sum& sum) {
    const long double end = all_nodes(axis)[1];
    if (point[axis] >= end) return;
    const long double share = 1 - point[axis] / end;
    Coordinates face = point;
    face[axis] = 0;
    const Sum wrong = sum_in_cell(face, channel);
    const Sum right = sum_on_ring(face, axis, channel);
    sum.value += share * (right.value - wrong.value);
    sum.least = std::min(sum.least, right.least);
    sum.most = std::max(sum.most, right.most);
  }

  Sum sum_on_ring(const Coordinates& face, std::size_t axis, std::size_t channel) {
    const std::size_t ring_axis = elevation_frame() ? kAxial : kDiagonal;
    const std::size_t other_axis = elevation_frame() ? kDiagonal : kAxial;
    const std::size_t polar = axis == kVertical ? kHorizontal : kVertical;
    const double sign = elevation_frame() && axis == kVertical ? -1 : 1;
    const double turn = turn_of(ring_axis);
    const auto on_ring = [&](double a, double b) {
      const double at = std::fmod(a + sign * b + 4 * turn, turn);
      return turn - at < 1e-6 ? 0.0 : at;
    };
    std::vector<double> ring = {turn};
    for (const double a : all_nodes(ring_axis)) {
      for (const double b : all_nodes(other_axis)) ring.push_back(on_ring(a, b));
    }
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end(), [](double a, double b) { return b - a < 1e-6; }), ring.end());
    const double at = on_ring(face[ring_axis], face[other_axis]);
    const auto cell = [](const std::vector<double>& nodes, double x) {
      std::size_t k = 0;
      while (k + 2 < nodes.size() && nodes[k + 1] <= x) ++k;
      return std::pair(nodes[k], nodes[k + 1]);
    };
    const double height = std::min(face[polar], all_nodes(polar).back());
    const auto [r0, r1] = cell(ring, at);
    const auto [h0, h1] = cell(all_nodes(polar), height);
    const auto place = [&](double r, double h) {
      Coordinates x{};
      x[ring_axis] = r;
      x[polar] = h;
      return x;
    };
    const long double t = (static_cast<long double>(at) - r0) / (r1 - r0);
    const long double u = (static_cast<long double>(height) - h0) / (h1 - h0);
    const std::array<long double, 4> lines = {
        line_value(ring_axis, place(at, h0), channel), line_value(ring_axis, place(at, h1), channel),
        line_value(polar, place(r0, height), channel), line_value(polar, place(r1, height), channel)};
    const auto corner = [&](double r, double h) { return corner_value(place(r, h), channel); };
    const long double corners =
        (1 - t) * ((1 - u) * corner(r0, h0) + u * corner(r0, h1)) + t * ((1 - u) * corner(r1, h0) + u * corner(r1, h1));
    const auto [least, most] = std::minmax_element(lines.begin(), lines.end());
    return held((1 - u) * lines[0] + u * lines[1] + (1 - t) * lines[2] + t * lines[3] - corners, *least, *most);
  }

  Sum sum_in_cell(const Coordinates& point, std::size_t channel) {
    Coordinates x0;
    Coordinates x1;
    std::array<long double, kAxisCount> fraction{};
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      const std::vector<double> nodes = all_nodes(axis);
      const double at = std::min(point[axis], nodes.back());
      std::size_t k = 0;
      while (k + 2 < nodes.size() && nodes[k + 1] <= at) ++k;
      x0[axis] = nodes[k];
      x1[axis] = nodes[std::min(k + 1, nodes.size() - 1)];
      fraction[axis] = x1[axis] > x0[axis] ? (static_cast<long double>(at) - x0[axis]) / (x1[axis] - x0[axis]) : 0;
    }
    const auto [x, y, z, w] = fraction;
    const auto corner = [&](int i, int j, int k, int l) {
      return corner_value({i ? x1[0] : x0[0], j ? x1[1] : x0[1], k ? x1[2] : x0[2], l ? x1[3] : x0[3]}, channel);
    };
    const auto line = [&](std::size_t axis, int a, int b, int c) {
      std::array<int, 3> high = {a, b, c};
      Coordinates on{};
      for (std::size_t other = 0, k = 0; other < kAxisCount; ++other) {
        if (other != axis) on[other] = high[k++] != 0 ? x1[other] : x0[other];
      }
      on[axis] = std::min(point[axis], all_nodes(axis).back());
      return line_value(axis, on, channel);
    };

    const auto mix = [](long double t, long double a, long double b) { return (1 - t) * a + t * b; };
    const auto mix3 = [&](long double t0, long double t1, long double t2, const auto& f) {
      return mix(t0, mix(t1, mix(t2, f(0, 0, 0), f(0, 0, 1)), mix(t2, f(0, 1, 0), f(0, 1, 1))),
                 mix(t1, mix(t2, f(1, 0, 0), f(1, 0, 1)), mix(t2, f(1, 1, 0), f(1, 1, 1))));
    };
    const auto extremes = [](const auto& f) {
      return std::minmax(
          {f(0, 0, 0), f(0, 0, 1), f(0, 1, 0), f(0, 1, 1), f(1, 0, 0), f(1, 0, 1), f(1, 1, 0), f(1, 1, 1)});
    };
    const bool varies_along_axis_0 = lattice_.nodes[0].size() > 1;
    const auto p_at = [&](int j, int k, int l) { return line(0, j, k, l); };
    const auto q_at = [&](int i, int k, int l) { return line(1, i, k, l); };
    const auto s_at = [&](int i, int j, int l) { return line(2, i, j, l); };
    const auto t_at = [&](int i, int j, int k) { return line(3, i, j, k); };
    const long double c = mix(x, mix3(y, z, w, [&](int j, int k, int l) { return corner(0, j, k, l); }),
                              mix3(y, z, w, [&](int j, int k, int l) { return corner(1, j, k, l); }));
    const long double p = mix3(y, z, w, p_at);
    const long double q = mix3(x, z, w, q_at);
    const long double s = mix3(x, y, w, s_at);
    const long double t = mix3(x, y, z, t_at);
    auto [minimum, maximum] = extremes(q_at);
    for (const auto& [low, high] :
         {extremes(s_at), extremes(t_at), varies_along_axis_0 ? extremes(p_at) : extremes(q_at)}) {
      minimum = std::min(minimum, low);
      maximum = std::max(maximum, high);
    }
    return held(p + q + s + t - 3 * c, minimum, maximum);
  }

  [[nodiscard]] bool elevation_frame() const { return lattice_.spec.id == FrameId::kElevation; }
  /// Of a whole turn of the lattice along an azimuth.
  [[nodiscard]] double turn_of(std::size_t axis) const {
    if (elevation_frame()) return axis == kAxial ? 720 : 360;
    return axis == kAxial ? 360 : 180;
  }

  [[nodiscard]] Coordinates within_first_turn(Coordinates x) const {
    const double follows = elevation_frame() ? 360 : 0;
    while (x[kDiagonal] < 0) x[kDiagonal] += turn_of(kDiagonal), x[kAxial] += follows;
    while (x[kDiagonal] >= turn_of(kDiagonal)) x[kDiagonal] -= turn_of(kDiagonal), x[kAxial] -= follows;
    while (x[kAxial] < 0) x[kAxial] += turn_of(kAxial);
    while (x[kAxial] >= turn_of(kAxial)) x[kAxial] -= turn_of(kAxial);
    return x;
  }

  [[nodiscard]] std::vector<double> all_nodes(std::size_t axis) const {
    std::vector<double> nodes = lattice_.spec.axes[axis].nodes_deg;
    if (axis > kDiagonal || nodes.size() == 1) return nodes;
    const std::size_t count = nodes.size();
    for (std::size_t k = 0; k < count && turn_of(axis) == 720; ++k) nodes.push_back(nodes[k] + 360);
    nodes.push_back(turn_of(axis));
    return nodes;
  }

  [[nodiscard]] long double forward(long double f, std::size_t channel) const {
    if (sliced_.domain.kind == DomainKind::kLinear) return f;
    const long double reference = sliced_.domain.reference[channel];
    const long double floor = sliced_.domain.floor(channel);
    const long double at_zero = std::log(floor / reference) - 1;
    if (std::abs(f) < floor) return at_zero + f / floor;
    return at_zero + std::copysign(1 + std::log(std::abs(f) / floor), f);
  }

  [[nodiscard]] long double inverse(long double v, std::size_t channel) const {
    long double f = v;
    if (sliced_.domain.kind == DomainKind::kLog) {
      const long double floor = sliced_.domain.floor(channel);
      const long double from_zero = v - (std::log(floor / sliced_.domain.reference[channel]) - 1);
      f = std::abs(from_zero) < 1 ? floor * from_zero
                                  : std::copysign(floor * std::exp(std::abs(from_zero) - 1), from_zero);
    }
    return f;
  }

  /// The guide's profile, over the angle that the conventions give; 0 without a guide.
  long double guide_at(const Coordinates& x, std::size_t channel) {
    if (!sliced_.guide) return 0;
    const Guide& guide = *sliced_.guide;
    const std::vector<double>& nodes = lattice_.spec.axes[kVertical].nodes_deg;
    const long double phi_h = radians_from_degrees(x[kAxial]);
    const long double along_x = std::cos(phi_h) * std::min(1.0, guide.ratio);
    const long double along_y = std::sin(phi_h) / std::max(1.0, guide.ratio);
    const long double theta_h = radians_from_degrees(x[kVertical]);
    const long double tangent = std::tan(theta_h) * std::sqrt(along_x * along_x + along_y * along_y);
    const long double angle =
        std::min<long double>(degrees_from_radians(static_cast<double>(std::atan(tangent))), nodes.back());
    auto found = guides_.find(channel);
    if (found == guides_.end()) {
      std::vector<long double> positions;
      std::vector<long double> values;
      for (std::size_t k = 0; k < guide.places.size(); ++k) {
        const auto [interval, fraction] = guide.places[k];
        const long double next = fraction == 0 ? nodes[interval] : nodes[interval + 1];
        positions.push_back(nodes[interval] + (next - nodes[interval]) * fraction / 65536);
        values.push_back(guide.values[k * sliced_.channel_count() + channel]);
      }
      found =
          guides_.emplace(channel, DenseSpline(Boundary::kBounded, 0, std::move(positions), std::move(values))).first;
    }
    return found->second(angle);
  }

  /// Only a material with negative samples may be negative anywhere.
  [[nodiscard]] bool has_negative(std::size_t channel) const {
    for (const auto* values : {&sliced_.crossing_values, &sliced_.sample_values}) {
      for (std::size_t k = channel; k < values->size(); k += sliced_.channel_count()) {
        if ((*values)[k] < 0) return true;
      }
    }
    return false;
  }

  /// Not those that are measured: the half/difference frame moves directions from below the horizon to shortly above
  /// it, where different places can hardly be told apart.
  [[nodiscard]] DirectionPair directions(const Coordinates& x) const {
    if (elevation_frame()) return frame_.directions(x, lattice_.spec.theta_max_deg);
    return pair_from_half_difference({radians_from_degrees(x[kVertical]), radians_from_degrees(x[kAxial]),
                                      radians_from_degrees(x[kHorizontal]), radians_from_degrees(x[kDiagonal])});
  }

  [[nodiscard]] bool same(const DirectionPair& a, const DirectionPair& b) const {
    return measurement_distance(a, b, lattice_.spec.symmetries) < 1e-9;
  }

  long double corner_value(const Coordinates& x, std::size_t channel) {
    const auto [entry, added] = corners_.try_emplace(x, 0);
    if (added) {
      const DirectionPair pair = directions(x);
      const auto found = std::find_if(lattice_.crossings.begin(), lattice_.crossings.end(),
                                      [&](const Coordinates& at) { return same(directions(at), pair); });
      if (found == lattice_.crossings.end()) throw std::logic_error("no crossing at a corner");
      entry->second = static_cast<std::size_t>(found - lattice_.crossings.begin());
    }
    return forward(sliced_.crossing_values[entry->second * sliced_.channel_count() + channel], channel) -
           guide_at(x, channel);
  }

  /// Where `pair` lies on a slice, or a negative number where it does not.
  [[nodiscard]] double position_on(const Slice& slice, const DirectionPair& pair) const {
    const auto try_at = [&](double position) {
      const bool inside = position > slice.start_deg - 1e-9 && position < slice.start_deg + slice.length_deg + 1e-9;
      return inside && same(directions(coordinates_on(slice, position)), pair);
    };
    const HalfDifference angles = half_difference_from_pair(pair);
    std::vector<double> candidates;
    if (slice.kind >= kHorizontal) {
      candidates = {pair.i.theta, pair.v.theta, angles.theta_h, angles.theta_d};
    } else if (elevation_frame()) {
      candidates = {pair.i.phi + pair.v.phi, pair.i.phi - pair.v.phi, 2 * pair.i.phi, 2 * pair.v.phi};
    } else {
      candidates = {angles.phi_h, angles.phi_d, angles.phi_h + angles.phi_d};
    }
    for (const double radians : candidates) {
      for (const double image : {degrees_from_radians(radians), -degrees_from_radians(radians)}) {
        for (int turn = -6; turn <= 6; ++turn) {
          const double position = image + 180 * turn;
          if (try_at(position)) return std::clamp(position, slice.start_deg, slice.start_deg + slice.length_deg);
        }
      }
    }
    return -1;
  }

  [[nodiscard]] DirectionPair on_line(std::size_t axis, Coordinates x, double at) const {
    x[axis] = at;
    return directions(x);
  }

  static constexpr std::size_t kNothingVaries = SIZE_MAX;

  // The slice on which three points of the line lie that lie on no other line.
  std::size_t slice_of(std::size_t axis, Coordinates x) {
    x[axis] = 0;
    const auto [entry, added] = lines_.try_emplace({axis, x}, kNothingVaries);
    if (!added) return entry->second;
    const double extent = all_nodes(axis).back();
    std::array<DirectionPair, 3> probes;
    for (std::size_t k = 0; k < 3; ++k) probes[k] = on_line(axis, x, extent * std::array{0.1371, 0.4533, 0.8117}[k]);
    if (same(probes[0], probes[1]) && same(probes[0], probes[2])) return entry->second;
    std::size_t found = 0;
    for (std::size_t k = 0; k < lattice_.slices.size(); ++k) {
      const auto holds = [&](const DirectionPair& probe) { return position_on(lattice_.slices[k], probe) >= 0; };
      if (!std::all_of(probes.begin(), probes.end(), holds)) continue;
      entry->second = k;
      ++found;
    }
    if (found != 1) throw std::logic_error("a line has no slice, or several");
    return entry->second;
  }

  long double line_value(std::size_t axis, const Coordinates& x, std::size_t channel) {
    const std::size_t k = all_nodes(axis).size() > 1 ? slice_of(axis, x) : kNothingVaries;
    if (k == kNothingVaries) return corner_value(first_of_line(axis, x), channel);
    const Slice& slice = lattice_.slices[k];
    const double position = position_on(slice, on_line(axis, x, x[axis]));
    if (position < 0) throw std::logic_error("a point of a line is not on its slice");
    auto found = splines_.find({k, channel});
    if (found == splines_.end()) {
      std::vector<long double> positions;
      std::vector<long double> values;
      for (const auto& [at, value] : samples_[k]) {
        positions.push_back(at);
        values.push_back(forward(value[channel], channel) - guide_at(coordinates_on(slice, at), channel));
      }
      found = splines_
                  .emplace(std::pair(k, channel),
                           LimitedCurve(slice.boundary, slice.length_deg, std::move(positions), std::move(values)))
                  .first;
    }
    return found->second(position);
  }

  [[nodiscard]] Coordinates first_of_line(std::size_t axis, Coordinates x) const {
    x[axis] = 0;
    return x;
  }

  const SlicedBrdf& sliced_;
  const Lattice& lattice_;
  const FrameGeometry& frame_;
  std::vector<std::map<double, const float*>> samples_;
  std::map<Coordinates, std::size_t> corners_;
  std::map<std::pair<std::size_t, Coordinates>, std::size_t> lines_;
  std::map<std::pair<std::size_t, std::size_t>, LimitedCurve> splines_;
  std::map<std::size_t, DenseSpline> guides_;
};

}  // namespace sbrdf::internal
