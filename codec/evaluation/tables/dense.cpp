#include "codec/evaluation/tables/dense.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "codec/evaluation/simd/kernel.h"
#include "codec/frame/frame.h"
#include "codec/material/value_domain.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

constexpr int kMostRounds = 24;
constexpr std::size_t kDraws = 20000;
constexpr std::size_t kDrawsEach = 64;       // of them, at most, at which an interval is looked at
constexpr double kLeastIntervalDeg = 0.005;  // shorter ones are not halved

using Nodes = std::array<std::vector<double>, kAxisCount>;

/// A function in the value domain, guide and all.
class Values {
 public:
  Values(const SliceTables& exact, const SlicedBrdf& sliced) : exact_(exact), f_(exact.channels) {
    for (std::size_t c = 0; c < exact.channels; ++c) maps_.emplace_back(sliced.domain, c);
  }

  void evaluate(const Coordinates& x, std::span<double> v) {
    evaluate_coordinates(exact_, x, exact_.guided ? guide_angle_deg(exact_.guide_ratio, x) : 0, f_.data());
    exact_.grey_shares.add(f_);
    for (std::size_t c = 0; c < f_.size(); ++c) v[c] = maps_[c].forward(f_[c]);
  }

 private:
  const SliceTables& exact_;
  std::vector<DomainMap<double>> maps_;
  std::vector<float> f_;
};

/// Where a renderer asks: half of the places belong to directions that are uniform in theta and phi, the other half lie
/// about highlights, the denser the smaller theta_h is.
std::vector<Coordinates> draw_places(const Lattice& lattice) {
  const FrameGeometry& frame = geometry(lattice.spec.id);
  const double theta_max = radians_from_degrees(lattice.spec.theta_max_deg);
  std::mt19937 random(17);
  const auto share = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::vector<Coordinates> places;
  while (places.size() < kDraws) {
    DirectionPair pair = {{theta_max * share(), 2 * kPi * share()}, {theta_max * share(), 2 * kPi * share()}};
    // Where hardly any are above the horizon, or within a narrow frame, the uniform ones have to do.
    for (int tries = 0; places.size() % 2 == 1 && tries < 16; ++tries) {
      const double root = share();
      const DirectionPair about = pair_from_half_difference(
          {root * root * root * kPi / 2, 2 * kPi * share(), kPi / 2 * share(), kPi * share()});
      if (about.i.theta > theta_max || about.v.theta > theta_max) continue;
      pair = about;
      break;
    }
    places.push_back(frame.coordinates(pair));
  }
  return places;
}

/// Chooses the nodes.
class Refinement {
 public:
  Refinement(const SliceTables& exact, const SlicedBrdf& sliced, const Lattice& lattice, const DenseLimits& limits)
      : exact_(exact), values_(exact, sliced), limits_(limits), nodes_(lattice.nodes), places_(draw_places(lattice)) {}

  Nodes choose() {
    for (int round = 0; round < kMostRounds; ++round) {
      if (!halve_intervals()) break;
    }
    return std::move(nodes_);
  }

 private:
  struct Interval {
    double loss = 0;  ///< mean error x places in it
    std::size_t axis = 0;
    double middle_deg = 0;
  };

  // The worst intervals of all axes, as many as there is room for. Whether there were any.
  bool halve_intervals() {
    std::vector<Interval> worst;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      if (nodes_[axis].size() > 1) find_worst(axis, worst);
    }
    std::sort(worst.begin(), worst.end(), [](const Interval& a, const Interval& b) { return a.loss > b.loss; });
    std::array<std::size_t, kAxisCount> counts;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) counts[axis] = nodes_[axis].size();
    // Half of them, since what the best are changes with each.
    bool any = false;
    for (std::size_t k = 0; k < (worst.size() + 1) / 2; ++k) {
      ++counts[worst[k].axis];
      if (bytes(counts) > limits_.most_bytes) break;
      nodes_[worst[k].axis].push_back(worst[k].middle_deg);
      any = true;
    }
    for (std::vector<double>& nodes : nodes_) std::sort(nodes.begin(), nodes.end());
    return any;
  }

  [[nodiscard]] std::size_t bytes(const std::array<std::size_t, kAxisCount>& counts) const {
    return counts[0] * counts[1] * counts[2] * counts[3] * exact_.channels * sizeof(float);
  }

  void find_worst(std::size_t axis, std::vector<Interval>& worst) {
    const std::vector<double>& nodes = nodes_[axis];
    std::vector<std::size_t> hits(nodes.size() - 1);
    std::vector<double> errors(nodes.size() - 1);
    for (const Coordinates& x : places_) {
      const auto after = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x[axis]);
      const auto k = static_cast<std::size_t>(after - nodes.begin()) - 1;
      if (hits[k]++ < kDrawsEach) errors[k] += error_at(x, axis, nodes[k], nodes[k + 1]);
    }
    for (std::size_t k = 0; k < hits.size(); ++k) {
      if (nodes[k + 1] - nodes[k] < 2 * kLeastIntervalDeg || hits[k] == 0) continue;
      const double error = errors[k] / static_cast<double>(std::min(hits[k], kDrawsEach));
      if (error <= limits_.tolerance) continue;
      worst.push_back({error * static_cast<double>(hits[k]), axis, 0.5 * (nodes[k] + nodes[k + 1])});
    }
  }

  double error_at(Coordinates x, std::size_t axis, double low, double high) {
    const std::size_t channels = exact_.channels;
    std::array<std::vector<double>, 3>& v = scratch_;
    for (std::size_t k = 0; k < 3; ++k) {
      v[k].resize(channels);
      x[axis] = k == 0 ? low : k == 1 ? high : 0.5 * (low + high);
      values_.evaluate(x, v[k]);
    }
    double difference = 0;
    double size = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      difference += std::abs(v[2][c] - 0.5 * (v[0][c] + v[1][c]));
      size += exact_.log ? 1 : std::abs(v[2][c]);
    }
    return size > 0 ? difference / size : 0;
  }

  const SliceTables& exact_;
  Values values_;
  DenseLimits limits_;
  Nodes nodes_;
  std::vector<Coordinates> places_;
  std::array<std::vector<double>, 3> scratch_;
};

}  // namespace

SliceTables make_dense(const SliceTables& exact, const SlicedBrdf& sliced, const Lattice& lattice,
                       const DenseLimits& limits) {
  const Nodes nodes = Refinement(exact, sliced, lattice, limits).choose();
  SliceTables made(sliced, std::make_shared<const LatticeTables>(exact.lattice->frame, nodes));
  made.form = SliceTables::Form::kDense;
  made.groups = exact.groups;
  Values values(exact, sliced);
  std::vector<double> v(exact.channels);
  made.crossing_values.reserve(nodes[0].size() * nodes[1].size() * nodes[2].size() * nodes[3].size() * v.size() +
                               SliceTables::kLanes);
  for (const double x3 : nodes[3]) {
    for (const double x2 : nodes[2]) {
      for (const double x1 : nodes[1]) {
        for (const double x0 : nodes[0]) {
          values.evaluate({x0, x1, x2, x3}, v);
          for (const double each : v) made.crossing_values.push_back(static_cast<float>(each));
        }
      }
    }
  }
  made.crossing_values.resize(made.crossing_values.size() + SliceTables::kLanes);
  return made;
}

}  // namespace sbrdf::internal
