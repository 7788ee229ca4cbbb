#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "formats/core/directions.h"

namespace sbrdf::internal {

/// The upper hemisphere in rectangles of z = cos theta and phi, whose areas are solid angles. They are halved towards
/// one direction and where a density is large, until none holds more than `most` of it; `accuracy` is that of parts of
/// a bin. Knows nothing of how directions are drawn.
class HemisphereBins {
 public:
  using Density = std::function<double(const glm::dvec3& w)>;

  HemisphereBins(const Density& density, const glm::dvec3& centre, double most, double accuracy)
      : density_(density), centre_(direction_from_vector(centre)), most_(most), accuracy_(accuracy) {
    build({0, 1, 0, 2 * kPi}, 0);
  }

  /// Of the density over each bin.
  [[nodiscard]] const std::vector<double>& masses() const { return masses_; }
  [[nodiscard]] double total() const {
    double sum = 0;
    for (const double mass : masses_) sum += mass;
    return sum;
  }

  /// The bin of a direction above the horizon.
  [[nodiscard]] std::size_t find(const glm::dvec3& w) const {
    const glm::dvec3 unit = glm::normalize(w);
    const double phi = wrap(std::atan2(unit.y, unit.x), 2 * kPi);
    std::size_t at = 0;
    while (nodes_[at].children != 0) {
      const Node& node = nodes_[at];
      at = node.children + ((node.along_z ? unit.z : phi) < node.middle ? 0 : 1);
    }
    return nodes_[at].bin;
  }

 private:
  struct Patch {
    double z_low, z_high, phi_low, phi_high;

    [[nodiscard]] double height() const { return std::acos(z_low) - std::acos(z_high); }
    [[nodiscard]] double width() const { return std::sqrt(1 - z_low * z_low) * (phi_high - phi_low); }
    [[nodiscard]] bool upright() const { return height() > width(); }
    [[nodiscard]] double middle() const { return upright() ? (z_low + z_high) / 2 : (phi_low + phi_high) / 2; }
    [[nodiscard]] std::array<Patch, 2> halves() const {
      if (upright()) return {{{z_low, middle(), phi_low, phi_high}, {middle(), z_high, phi_low, phi_high}}};
      return {{{z_low, z_high, phi_low, middle()}, {z_low, z_high, middle(), phi_high}}};
    }
  };
  struct Node {
    std::size_t children = 0;  ///< the first of two; 0 for a bin
    std::size_t bin = 0;
    bool along_z = false;
    double middle = 0;
  };

  // Depth first; a node's two children lie side by side.
  void build(const Patch& patch, std::size_t at) {
    if (at == 0) nodes_.emplace_back();
    const bool fine = std::max(patch.height(), patch.width()) < kSmallest;
    const double mass = fine || far_from_centre(patch) ? integral(patch, lattice_sum(patch), 0) : 1;
    if (mass <= most_ || fine) {
      nodes_[at].bin = masses_.size();
      masses_.push_back(mass);
      return;
    }
    const std::size_t children = nodes_.size();
    nodes_[at] = {children, 0, patch.upright(), patch.middle()};
    nodes_.resize(children + 2);
    build(patch.halves()[0], children);
    build(patch.halves()[1], children + 1);
  }

  /// Further away than it is large.
  [[nodiscard]] bool far_from_centre(const Patch& patch) const {
    const double theta = std::clamp(centre_.theta, std::acos(patch.z_high), std::acos(patch.z_low));
    const double phi = std::clamp(centre_.phi, patch.phi_low, patch.phi_high);
    const double turn = std::abs(phi - centre_.phi);
    const double across = std::sin(std::min(theta, centre_.theta)) * std::min(turn, 2 * kPi - turn);
    const double distance = std::hypot(theta - centre_.theta, across);
    return distance > std::max(patch.height(), patch.width()) / 2;
  }

  /// By a Fibonacci lattice, no two of whose points share z or phi: steps of the density that run along either would be
  /// seen alike by all grids that halve each other.
  [[nodiscard]] double lattice_sum(const Patch& patch) const {
    constexpr int kCount = 55;
    constexpr int kBefore = 34;
    double sum = 0;
    for (int k = 0; k < kCount; ++k) {
      const double z = patch.z_low + (k + 0.5) / kCount * (patch.z_high - patch.z_low);
      const double phi = patch.phi_low + (k * kBefore % kCount + 0.5) / kCount * (patch.phi_high - patch.phi_low);
      const double r = std::sqrt(1 - z * z);
      sum += density_({r * std::cos(phi), r * std::sin(phi), z});
    }
    return sum * (patch.z_high - patch.z_low) * (patch.phi_high - patch.phi_low) / kCount;
  }

  /// Quartered until quarters agree with the whole; the density has steps.
  [[nodiscard]] double integral(const Patch& patch, double whole, int depth) const {
    const double z = (patch.z_low + patch.z_high) / 2;
    const double phi = (patch.phi_low + patch.phi_high) / 2;
    const std::array<Patch, 4> quarters = {{{patch.z_low, z, patch.phi_low, phi},
                                            {z, patch.z_high, patch.phi_low, phi},
                                            {patch.z_low, z, phi, patch.phi_high},
                                            {z, patch.z_high, phi, patch.phi_high}}};
    std::array<double, 4> masses;
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += masses[k] = lattice_sum(quarters[k]);
    if ((depth >= 1 && std::abs(sum - whole) < accuracy_) || depth == 8) return sum;
    sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += integral(quarters[k], masses[k], depth + 1);
    return sum;
  }

  static constexpr double kSmallest = 2e-4;  // [radians]

  Density density_;
  Direction centre_;
  double most_;
  double accuracy_;
  std::vector<Node> nodes_;
  std::vector<double> masses_;
};

/// The chance that a sum of `degrees` squares of normal variables is larger than `chi_square`, as if its cube root were
/// normal (E. Wilson, M. Hilferty, "The Distribution of Chi-Square", 1931).
inline double chi_square_chance(double chi_square, double degrees) {
  const double spread = 2 / (9 * degrees);
  const double normal = (std::cbrt(chi_square / degrees) - (1 - spread)) / std::sqrt(spread);
  return std::erfc(normal / std::sqrt(2.0)) / 2;
}

/// Pearson's statistic of counts in bins with expected masses; those with less than ten expected count as one.
inline double chi_square_chance(const std::vector<double>& masses, const std::vector<double>& counts) {
  double all = 0;
  for (const double count : counts) all += count;
  double sum = 0;
  double bins = 0;
  double rest_expected = 0;
  double rest_counted = 0;
  const auto add = [&](double counted, double expected) {
    sum += (counted - expected) * (counted - expected) / expected;
    ++bins;
  };
  for (std::size_t k = 0; k < masses.size(); ++k) {
    const double expected = masses[k] * all;
    if (expected >= 10) {
      add(counts[k], expected);
    } else {
      rest_expected += expected;
      rest_counted += counts[k];
    }
  }
  if (rest_expected > 1) add(rest_counted, rest_expected);
  return chi_square_chance(sum, bins - 1);
}

}  // namespace sbrdf::internal
