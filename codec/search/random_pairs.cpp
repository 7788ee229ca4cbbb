#include "codec/search/random_pairs.h"

#include <algorithm>
#include <cmath>

namespace sbrdf::internal {
namespace {

constexpr double kUniformShare = 1.0 / 3;
constexpr double kScaleShare = (1 - kUniformShare) / static_cast<double>(HighlightDraw::kScalesDeg.size());

}  // namespace

DirectionPair draw_pair(std::mt19937_64& random, double theta_max_deg) {
  const double theta_i = draw_uniform(random, theta_max_deg);
  const double phi_i = draw_uniform(random, 360);
  const double theta_v = draw_uniform(random, theta_max_deg);
  return {direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, draw_uniform(random, 360))};
}

HighlightDraw::Box HighlightDraw::box(std::size_t scale, double theta_i_deg) const {
  const double size = kScalesDeg[scale];
  // Of two directions at theta the half vector has tan theta_h = tan theta sin(turn / 2).
  const double ratio =
      std::tan(radians_from_degrees(size)) / std::max(std::tan(radians_from_degrees(theta_i_deg)), 1e-9);
  return {std::max(0.0, theta_i_deg - 2 * size), std::min(theta_max_deg_, theta_i_deg + 2 * size),
          degrees_from_radians(2 * std::asin(std::min(1.0, ratio)))};
}

double HighlightDraw::weight(double theta_i_deg, double theta_v_deg, double turn_deg) const {
  double density = kUniformShare;  // in units of the uniform draw's
  for (std::size_t scale = 0; scale < kScalesDeg.size(); ++scale) {
    const Box around = box(scale, theta_i_deg);
    if (theta_v_deg < around.theta_low_deg || theta_v_deg > around.theta_high_deg) continue;
    if (std::abs(turn_deg) > around.phi_deg) continue;
    density += kScaleShare * theta_max_deg_ / (around.theta_high_deg - around.theta_low_deg) * 180 / around.phi_deg;
  }
  return 1 / density;
}

WeightedPair HighlightDraw::operator()(std::mt19937_64& random) const {
  const double choice = draw_uniform(random, 1);
  const double theta_i = draw_uniform(random, theta_max_deg_);
  const double phi_i = draw_uniform(random, 360);
  Box from = {0, theta_max_deg_, 180};
  if (choice >= kUniformShare) {
    const auto scale = static_cast<std::size_t>((choice - kUniformShare) / kScaleShare);
    from = box(std::min(scale, kScalesDeg.size() - 1), theta_i);
  }
  const double theta_v = from.theta_low_deg + draw_uniform(random, from.theta_high_deg - from.theta_low_deg);
  const double turn = from.phi_deg * (draw_uniform(random, 2) - 1);
  return {{direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, wrap(phi_i + 180 + turn, 360))},
          weight(theta_i, theta_v, turn)};
}

}  // namespace sbrdf::internal
