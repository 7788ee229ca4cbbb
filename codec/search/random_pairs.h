#pragma once

#include <array>
#include <cstddef>
#include <random>

#include "formats/core/directions.h"

namespace sbrdf::internal {

/// A pair and what it counts: how many of the pairs of a uniform draw it stands for.
struct WeightedPair {
  DirectionPair pair;
  double weight = 1;
};

/// In [0, end). The same on every system, unlike the distributions of the standard library.
[[nodiscard]] inline double draw_uniform(std::mt19937_64& random, double end) {
  return end * static_cast<double>(random() >> 11U) * 0x1p-53;
}

/// theta of both uniform in [0, theta_max_deg], both azimuths uniform: the uniform draw.
[[nodiscard]] DirectionPair draw_pair(std::mt19937_64& random, double theta_max_deg);

/// Pairs drawn densely around the mirror direction, which weigh less in return: weighted means are those of the uniform
/// draw, but see highlights a hundredth of a degree wide.
///
/// A third of the pairs comes from the uniform draw. Of each other pair i is drawn likewise, and v uniformly from the
/// part below theta_max of a box around the mirror direction, as large as what has a half vector within kScalesDeg of
/// the normal: theta_v within twice the scale of theta_i; phi_v within 2 asin(tan scale / tan theta_i) of phi_i + 180.
/// The weight is the density of the uniform draw over that of all these together, so at most 3.
class HighlightDraw {
 public:
  static constexpr std::array<double, 6> kScalesDeg = {1.0 / 64, 1.0 / 16, 0.25, 1, 4, 16};

  explicit HighlightDraw(double theta_max_deg);

  /// What a pair is made of, in [0, 1): drawn in one thread, so that pairs can be made in many.
  using Numbers = std::array<double, 5>;
  [[nodiscard]] static Numbers draw_numbers(std::mt19937_64& random);
  [[nodiscard]] WeightedPair operator()(const Numbers& numbers) const;

  [[nodiscard]] WeightedPair operator()(std::mt19937_64& random) const { return (*this)(draw_numbers(random)); }

 private:
  struct Box {
    double theta_low_deg, theta_high_deg;  ///< of theta_v
  };
  [[nodiscard]] Box box(std::size_t scale, double theta_i_deg) const;
  /// phi_v is at most so far from phi_i + 180 [degrees].
  [[nodiscard]] double phi_deg(std::size_t scale, double tan_theta_i) const;
  /// Of a pair whose phi_v is `turn_deg` in [-180, 180] from phi_i + 180.
  [[nodiscard]] double weight(double theta_i_deg, double theta_v_deg, double turn_deg) const;

  double theta_max_deg_;
  std::array<double, kScalesDeg.size()> tan_scale_{};
};

}  // namespace sbrdf::internal
