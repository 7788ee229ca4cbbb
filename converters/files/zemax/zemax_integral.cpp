#include "converters/files/zemax/zemax_integral.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>

#include "formats/core/directions.h"
#include "formats/core/parallel.h"

namespace sbrdf::internal {
namespace {

/// Steps for the whole of a file, whatever it lists.
constexpr double kMostSteps = 3e7;

double step_deg(const ZemaxTable& table) {
  const double steps = 360.0 * 180.0 * static_cast<double>(table.incidences.size());
  return std::max(1.0, std::sqrt(steps / kMostSteps));
}

/// A stretch between two nodes of a list; the same node twice where a value is held.
struct Stretch {
  double first_deg;
  double width_deg;
  std::size_t low;
  std::size_t high;
};

/// All azimuths, as far as they count twice where half of them mirrors the other.
std::vector<Stretch> azimuth_stretches(const ZemaxTable& table) {
  const std::vector<double>& nodes = table.azimuths;
  const std::size_t last = nodes.size() - 1;
  std::vector<Stretch> stretches;
  for (std::size_t k = 0; k < last; ++k) stretches.push_back({nodes[k], nodes[k + 1] - nodes[k], k, k + 1});
  if (table.symmetry == ZemaxSymmetry::kPlaneSymmetrical) {
    stretches.push_back({0, nodes.front(), 0, 0});
    stretches.push_back({nodes.back(), 180 - nodes.back(), last, last});
  } else {
    stretches.push_back({nodes.back(), nodes.front() + 360 - nodes.back(), last, 0});
  }
  return stretches;
}

std::vector<Stretch> radial_stretches(const ZemaxTable& table) {
  const std::vector<double>& nodes = table.radials;
  std::vector<Stretch> stretches = {{0, nodes.front(), 0, 0}};
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) stretches.push_back({nodes[k], nodes[k + 1] - nodes[k], k, k + 1});
  return stretches;
}

/// What each value of a block counts in its integral.
class Weights {
 public:
  Weights(const ZemaxTable& table, double incidence_deg, ZemaxIntegrand integrand)
      : step_deg_(step_deg(table)),
        radial_count_(table.radials.size()),
        weights_(table.block_size()),
        cosine_(integrand == ZemaxIntegrand::kCosine) {
    const double theta_i = radians_from_degrees(incidence_deg);
    cos_i_ = std::cos(theta_i);
    sin_i_ = std::sin(theta_i);
    const std::vector<Stretch> radials = radial_stretches(table);
    for (const Stretch& azimuth : azimuth_stretches(table)) {
      if (azimuth.width_deg <= 0) continue;
      for (const Stretch& radial : radials) {
        if (radial.width_deg > 0) add(azimuth, radial);
      }
    }
    const double turns = table.symmetry == ZemaxSymmetry::kPlaneSymmetrical ? 2 : 1;
    for (double& weight : weights_) weight *= turns;
  }

  [[nodiscard]] double integral(std::span<const double> block) const {
    return std::inner_product(block.begin(), block.end(), weights_.begin(), 0.0);
  }

 private:
  [[nodiscard]] std::size_t steps_of(const Stretch& stretch) const {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(stretch.width_deg / step_deg_ - 1e-9)));
  }

  void add(const Stretch& azimuth, const Stretch& radial) {
    const std::size_t across = steps_of(azimuth);
    const std::size_t outwards = steps_of(radial);
    const double area = radians_from_degrees(azimuth.width_deg) / static_cast<double>(across) *
                        radians_from_degrees(radial.width_deg) / static_cast<double>(outwards);
    for (std::size_t q = 0; q < outwards; ++q) {
      const double r = (static_cast<double>(q) + 0.5) / static_cast<double>(outwards);
      const double angle = radians_from_degrees(radial.first_deg + r * radial.width_deg);
      for (std::size_t p = 0; p < across; ++p) {
        const double a = (static_cast<double>(p) + 0.5) / static_cast<double>(across);
        const double turned = radians_from_degrees(azimuth.first_deg + a * azimuth.width_deg);
        // The viewer's z around the mirror direction; azimuth 0 leads over the normal.
        const double cos_v = std::cos(angle) * cos_i_ + std::sin(angle) * std::cos(turned) * sin_i_;
        if (cos_v <= 0) continue;
        const double weight = (cosine_ ? cos_v : 1) * std::sin(angle) * area;
        at(azimuth.low, radial.low) += weight * (1 - a) * (1 - r);
        at(azimuth.low, radial.high) += weight * (1 - a) * r;
        at(azimuth.high, radial.low) += weight * a * (1 - r);
        at(azimuth.high, radial.high) += weight * a * r;
      }
    }
  }
  double& at(std::size_t azimuth, std::size_t radial) { return weights_[azimuth * radial_count_ + radial]; }

  double step_deg_;
  std::size_t radial_count_;
  std::vector<double> weights_;
  bool cosine_;
  double cos_i_ = 1;
  double sin_i_ = 0;
};

}  // namespace

std::vector<double> zemax_integrals(const ZemaxTable& table, ZemaxIntegrand integrand) {
  const std::size_t incidences = table.incidences.size();
  const std::size_t size = table.block_size();
  std::vector<double> integrals(table.tis.size());
  parallel_for(incidences, [&](std::uint64_t incidence) {
    const Weights weights(table, table.incidences[incidence], integrand);
    for (std::size_t block = incidence; block < integrals.size(); block += incidences) {
      integrals[block] = weights.integral(std::span(table.values).subspan(block * size, size));
    }
  });
  return integrals;
}

}  // namespace sbrdf::internal
