#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "converters/source/brdf_source.h"
#include "tests/fuzz/require.h"

namespace sbrdf::internal::fuzzing {

/// What holds of every source, whatever it was read from: values are finite, and each pair was measured or not. At the
/// normal, beside it, at the horizon and below, and at azimuths of any turn.
inline void evaluate_everywhere(const BrdfSource& source) {
  constexpr std::array kTheta = {0.0, 1e-9, 0.3, 1.2, kPi / 2, 1.6};
  constexpr std::array kPhi = {0.0, -1.0, kPi, 7.0};
  std::vector<float> values(source.channel_count());
  for (const double theta_i : kTheta) {
    for (const double theta_v : kTheta) {
      for (const double phi : kPhi) {
        const DirectionPair pair = {{theta_i, 0.5}, {theta_v, phi}};
        source.evaluate(std::span(&pair, 1), values);
        for (const float v : values) require(std::isfinite(v), "a source evaluates to finite values");
        std::uint8_t flag = 2;
        source.measured(std::span(&pair, 1), std::span(&flag, 1));
        require(flag <= 1, "a pair was measured or not");
      }
    }
  }
}

}  // namespace sbrdf::internal::fuzzing
