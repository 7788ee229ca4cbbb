#include "converters/stress/checks.h"

#include <cmath>

#include "converters/stress/trial.h"

namespace sbrdf::internal::stress {

StressRow check_theta(Trial& trial) {
  const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, kurt("Fabric112"));
  Tally tally;
  for (const double theta_i : {0.0, 80.0, 89.9, 90.0}) {
    for (const double theta_v : {0.0, 35.0, 80.0, 89.9, 90.0}) {
      for (int k = 0; k < 40; ++k) {
        const double phi = trial.draw(0, 360);
        // Both in the same azimuth, opposite, and any.
        const double phi_v = k % 4 == 0 ? phi : k % 4 == 1 ? phi + 180 : trial.draw(0, 360);
        const DirectionPair pair = {direction_from_degrees(theta_i, phi), direction_from_degrees(theta_v, phi_v)};
        add_errors(tally, trial, material, pair);
        add_errors(tally, trial, material, {pair.v, pair.i});
      }
    }
  }
  return tally.row("theta 0, 80, 89.9, 90: " + unit_of(trial.domain), limit_of(trial.domain));
}

StressRow check_turns(Trial& trial) {
  const Material material = sample(coarse_frame(trial.frame, false), {700, trial.domain}, smooth);
  std::uniform_int_distribution<int> phi(0, 360 * 64 - 1);  // in 64ths of a degree: whole turns added are exact
  Tally tally;
  for (int n = 0; n < 200; ++n) {
    const double theta_i = trial.draw(0, 90), theta_v = trial.draw(0, 90);
    const double phi_i = phi(trial.random) / 64.0, phi_v = phi(trial.random) / 64.0;
    const auto turned = [&](int turns_i, int turns_v) {
      return trial(material, {direction_from_degrees(theta_i, phi_i + 360.0 * turns_i),
                              direction_from_degrees(theta_v, phi_v + 360.0 * turns_v)});
    };
    const Channels<float> plain = turned(0, 0);
    for (int i = -3; i <= 3; ++i) {
      for (int v = -3; v <= 3; ++v) tally.count(same_bits(plain, turned(i, v)));
    }
  }
  return tally.row("phi + 360 k, k = -3..3: other bits", 0);
}

StressRow check_reciprocity(Trial& trial) {
  const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, kurt("Fabric112"));
  Tally tally;
  for (int k = 0; k < 4000; ++k) {
    DirectionPair pair = random_pair(trial.random);
    if (k % 3 == 0) pair.v.theta = pair.i.theta;
    if (k % 5 == 0) pair.i.theta = 0;
    if (k % 7 == 0) pair.v.theta = kPi / 2;
    tally.count(same_bits(trial(material, pair), trial(material, {pair.v, pair.i})));
  }
  return tally.row("f(i,v) and f(v,i): different bits", 0);
}

StressRow check_isotropy(Trial& trial) {
  const Material material = sample(fine_frame(trial.frame, true), {1500, trial.domain}, isotropic_kurt());
  Tally tally;
  for (int k = 0; k < 3000; ++k) {
    const DirectionPair pair = random_pair(trial.random);
    const double turn = trial.draw(0, 2 * kPi);
    const Channels<float> plain = trial(material, pair);
    const Channels<float> turned =
        trial(material, {{pair.i.theta, pair.i.phi + turn}, {pair.v.theta, pair.v.phi + turn}});
    for (std::size_t c = 0; c < kChannels; ++c) {
      tally.add(relative(static_cast<double>(plain[c]) - turned[c], std::abs(static_cast<double>(plain[c]))));
    }
  }
  return tally.row("both directions turned: relative change", kLogLimit);
}

StressRow check_continuity(Trial& trial) {
  const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, smooth);
  const ClampDetector detector(material);
  Tally tally;
  const auto compare = [&](const Coordinates& a, const Coordinates& b) {
    const auto clamped_a = detector.clamped(a);
    const auto clamped_b = detector.clamped(b);
    const Channels<float> value_a = trial.at(material, a);
    const Channels<float> value_b = trial.at(material, b);
    const Channels<double> local = local_maximum(material, a);
    for (std::size_t c = 0; c < kChannels; ++c) {
      // The least and the greatest of the slices change from cell to cell by definition.
      if (clamped_a[c] || clamped_b[c]) continue;
      tally.add(relative(static_cast<double>(value_a[c]) - value_b[c], local[c]));
    }
  };
  for (int k = 0; k < 100; ++k) {
    // The shorter step is below what floats see of a cell, the longer one is not.
    const Coordinates x = random_coordinates(trial.random, material.lattice);
    for (const double step : {1e-9, 1e-5}) for_each_boundary(material.lattice, x, step, compare);
  }
  return tally.row("across every node, no clamp: jump / local maximum", 1e-4);
}

}  // namespace sbrdf::internal::stress
