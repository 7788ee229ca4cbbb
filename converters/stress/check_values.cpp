#include "converters/stress/checks.h"

#include <array>
#include <cmath>

#include "converters/stress/trial.h"

namespace sbrdf::internal::stress {

StressRow check_range(Trial& trial) {
  Tally tally;
  for (const double usual : {1e-30, 1e-3, 1e6}) {
    // Most values are `usual`, so that the reference of the log domain is; the others lie anywhere.
    const auto wild = [&](const DirectionPair& /*pair*/) {
      Channels<double> f;
      for (double& value : f) {
        const double kind = trial.draw(0, 10);
        value = kind < 6 ? usual : kind < 7 ? 1e12 : kind < 8 ? 1e-30 : std::pow(10, trial.draw(-30, 12));
      }
      return f;
    };
    const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, wild);
    for (int k = 0; k < 1500; ++k) {
      for (const float value : trial(material, random_pair(trial.random))) {
        tally.count(std::isfinite(value) && value >= 0);
      }
    }
  }
  return tally.row("samples 1e-30 to 1e12: not finite or negative", 0);
}

StressRow check_zeros(Trial& trial) {
  const auto with_zeros = [](const DirectionPair& pair) {
    Channels<double> f = smooth(pair);
    for (double& value : f) {
      if (pair.i.theta + pair.v.theta > 1.8 || std::fmod(value * 1000, 1) < 0.2) value = 0;
    }
    return f;
  };
  const Material material = sample(coarse_frame(trial.frame, false), {900, trial.domain}, with_zeros);
  Tally tally;
  for_each_sample(material, [&](const Coordinates& x, std::span<const float> measured) {
    const Channels<float> values = trial.at(material, x);
    for (std::size_t c = 0; c < kChannels; ++c) {
      if (measured[c] == 0) tally.add(std::abs(static_cast<double>(values[c])));
    }
  });
  return tally.row("at samples that are 0: largest value", 0);
}

StressRow check_constants(Trial& trial) {
  constexpr std::array<Channels<float>, 2> kConstants = {
      {{0.1F, 1e-30F, 1e12F, 0.0F}, {0.7182818F, 1.0F / 3, 16777215.0F, 3e-7F}}};
  const bool exact = trial.evaluation == StressEvaluation::kPlain || trial.domain == DomainKind::kLog;
  Tally tally;
  for (const auto& constants : kConstants) {
    const Channels<double> f = {constants[0], constants[1], constants[2], constants[3]};
    const Material material =
        sample(coarse_frame(trial.frame, false), {400, trial.domain}, [&](const DirectionPair& /*pair*/) { return f; });
    for (int k = 0; k < 1000; ++k) {
      const Channels<float> values = trial(material, random_pair(trial.random));
      if (exact) {
        tally.count(same_bits(values, constants));
        continue;
      }
      for (std::size_t c = 0; c < kChannels; ++c) {
        tally.add(relative(static_cast<double>(values[c]) - constants[c], std::abs(static_cast<double>(constants[c]))));
      }
    }
  }
  // The kernel weighs with products, so that linear values are rounded; logarithms of constants are 0.
  return exact ? tally.row("8 constants, 1e-30 to 1e12 and 0: other bits", 0)
               : tally.row("8 constants, 1e-30 to 1e12 and 0: relative error", 1e-6);
}

StressRow check_spikes(Trial& trial) {
  const auto spiky = [&](const DirectionPair& /*pair*/) {
    Channels<double> f;
    for (double& value : f) {
      const double kind = trial.draw(0, 10);
      value = kind < 1 ? 1e6 : kind < 2 ? 0 : kind < 3 ? 1e3 : 1;
    }
    return f;
  };
  Tally tally;
  for (const std::uint64_t samples : {0U, 800U, 1600U}) {
    const Material material = sample(coarse_frame(trial.frame, false), {samples, trial.domain}, spiky);
    for (int k = 0; k < 2000; ++k) {
      for (const float value : trial(material, random_pair(trial.random))) {
        tally.count(std::isfinite(value) && value >= 0);
      }
    }
  }
  return tally.row("0, 1, 1e3 and 1e6 side by side: not finite or negative", 0);
}

StressRow check_minimum_gap(Trial& trial) {
  const FrameSpec spec = trial.frame == FrameId::kElevation
                             ? elevation_frame_from_nodes({0, 80}, {0}, {0, 180}, {.isotropic = true})
                             : half_difference_frame({0, 40}, {0, 40}, {0}, {0, 90}, {.isotropic = true});
  const Material material = sample(spec, {1'000'000, trial.domain, 0.02}, isotropic_kurt());
  Tally tally;
  tally.count(material.full);
  for_each_sample(material, [&](const Coordinates& x, std::span<const float> measured) {
    const Channels<float> values = trial.at(material, x);
    for (std::size_t c = 0; c < kChannels; ++c) {
      tally.add(relative(static_cast<double>(values[c]) - measured[c], std::abs(static_cast<double>(measured[c]))));
    }
  });
  for (int k = 0; k < 500; ++k) {
    for (const float value : trial(material, random_pair(trial.random))) tally.add(std::isfinite(value) ? 0 : 1);
  }
  // Linear values come back as they are; logarithms were rounded once and raised again.
  return tally.row("gaps of 0.02 deg, full: relative error at samples", trial.domain == DomainKind::kLog ? 2e-6 : 0);
}

}  // namespace sbrdf::internal::stress
