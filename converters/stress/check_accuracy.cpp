#include "converters/stress/checks.h"

#include <cmath>
#include <vector>

#include "converters/stress/trial.h"

namespace sbrdf::internal::stress {
namespace {

/// a + b (x + y) + c x y of the two polar coordinates.
Channels<double> bilinear(double x, double y) {
  return {1 + 0.01 * (x + y) + 0.0003 * x * y, 5 - 0.01 * (x + y), 0.5 + 0.0002 * x * y,
          2 - 0.005 * (x + y) + 0.0001 * x * y};
}

}  // namespace

StressRow check_linear(Trial& trial) {
  const bool elevation = trial.frame == FrameId::kElevation;
  // Half/difference: only as far as no slice runs below the horizon, where it ends in another value.
  const FrameSpec spec = elevation
                             ? coarse_frame(trial.frame, false)
                             : half_difference_frame({0, 15, 40}, {0, 20, 40}, {0, 90, 180, 270}, {0, 60, 120}, {});
  const auto function = [&](const DirectionPair& pair) {
    const HalfDifference half = half_difference_from_pair(pair);
    return elevation ? bilinear(degrees_from_radians(pair.i.theta), degrees_from_radians(pair.v.theta))
                     : bilinear(degrees_from_radians(half.theta_h), degrees_from_radians(half.theta_d));
  };
  const Material material = sample(spec, {700, trial.domain}, function);
  Tally tally;
  for (int k = 0; k < 3000; ++k) {
    const Coordinates x = random_coordinates(trial.random, material.lattice);
    const Channels<double> expected = bilinear(x[kHorizontal], x[kVertical]);
    const Channels<float> values = trial.at(material, x);
    for (std::size_t c = 0; c < kChannels; ++c) {
      tally.add(std::abs(values[c] - expected[c]) / material.largest[c]);
    }
  }
  // Samples are floats: seven of them, each rounded, and the sum's own roundings.
  return tally.row("linear in each theta: error / largest sample", 1e-6);
}

StressRow check_single(Trial& trial) {
  Tally tally;
  for (unsigned bits = 0; bits < 16; ++bits) {
    const auto list = [&](unsigned bit, std::vector<double> nodes) {
      return ((bits >> bit) & 1U) != 0 ? nodes : std::vector<double>{0};
    };
    const FrameSpec spec =
        trial.frame == FrameId::kElevation
            ? elevation_frame_from_nodes(list(3, {0, 80}), list(0, {0, 200}), list(1, {0, 100, 260}), {})
            : half_difference_frame(list(3, {0, 50}), list(2, {0, 40}), list(0, {0, 200}), list(1, {0, 100}), {});
    for (const std::uint64_t samples : {0U, 12U}) {
      const Material material = sample(spec, {samples, trial.domain}, smooth);
      for (int k = 0; k < 100; ++k) add_errors(tally, trial, material, random_pair(trial.random));
    }
  }
  return tally.row("axes and slices of one sample: " + unit_of(trial.domain), limit_of(trial.domain));
}

StressRow check_accuracy(Trial& trial) {
  Tally tally;
  const auto judge = [&](const Brdf& function, bool isotropic) {
    const Material material = sample(fine_frame(trial.frame, isotropic), {4000, trial.domain}, function);
    for (int k = 0; k < 1500; ++k) add_errors(tally, trial, material, random_pair(trial.random));
  };
  for (const char* name : {"Brushed alum", "Fabric112", "Red velvet", "Yellow satin"}) judge(kurt(name), false);
  judge(isotropic_kurt(), true);
  return tally.row("5 Kurt materials, 4,000 samples: " + unit_of(trial.domain), limit_of(trial.domain));
}

}  // namespace sbrdf::internal::stress
