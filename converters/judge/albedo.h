#pragma once

#include <cstdint>
#include <vector>

#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// How well an albedo is worked out.
struct AlbedoOptions {
  double accuracy = 1e-4;                      ///< of an albedo up to 1; relative to it above
  std::uint64_t most_evaluations = 1'000'000;  ///< pairs for one direction of the light
};

/// The share of the light from one direction that a material sends back in all directions:
/// a(i) = integral over the hemisphere of f_r(i,v) cos theta_v dv. Of each channel.
struct Albedo {
  Direction i;
  std::vector<double> measured;   ///< what comes from theta_v up to the source's theta_max
  std::vector<double> beyond;     ///< what comes from beyond, where values are made up
  std::vector<double> error;      ///< estimate of the error of the sum of both
  std::uint64_t evaluations = 0;  ///< pairs that were evaluated
  bool reached = false;           ///< every error is within the accuracy
  std::uint64_t not_finite = 0;   ///< values that were NaN or infinite, taken as 0
  std::uint64_t unmeasured = 0;   ///< pairs that the source did not measure; what it says there counts

  [[nodiscard]] double total(std::size_t channel) const { return measured[channel] + beyond[channel]; }
};

/// Integrates over theta_v and phi_v in rectangles that are halved where the error is: the rule of degree 7 with 17
/// points, and its embedded rule of degree 5 for the error (A. Genz, A. Malik, "An adaptive algorithm for numerical
/// integration over an N-dimensional rectangular region", Journal of Computational and Applied Mathematics 6(4), 1980).
/// The first rectangles are graded towards the mirror direction and back to the light, down to a hundredth of a degree,
/// so that narrow highlights are met; nowhere are they larger than 10 degrees of theta and 20 of phi.
/// The same bits for any number of threads.
[[nodiscard]] Albedo directional_albedo(const BrdfSource& source, const Direction& i,
                                        const AlbedoOptions& options = {});

}  // namespace sbrdf::internal
