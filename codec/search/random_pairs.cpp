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

HighlightDraw::HighlightDraw(double theta_max_deg) : theta_max_deg_(theta_max_deg) {
  for (std::size_t k = 0; k < kScalesDeg.size(); ++k) tan_scale_[k] = std::tan(radians_from_degrees(kScalesDeg[k]));
}

HighlightDraw::Box HighlightDraw::box(std::size_t scale, double theta_i_deg) const {
  const double size = kScalesDeg[scale];
  return {std::max(0.0, theta_i_deg - 2 * size), std::min(theta_max_deg_, theta_i_deg + 2 * size)};
}

// Of two directions at theta the half vector has tan theta_h = tan theta sin(turn / 2).
double HighlightDraw::phi_deg(std::size_t scale, double tan_theta_i) const {
  const double ratio = tan_scale_[scale] / std::max(tan_theta_i, 1e-9);
  return degrees_from_radians(2 * std::asin(std::min(1.0, ratio)));
}

double HighlightDraw::weight(double theta_i_deg, double theta_v_deg, double turn_deg) const {
  const double tan_theta_i = std::tan(radians_from_degrees(theta_i_deg));
  double density = kUniformShare;  // in units of the uniform draw's
  for (std::size_t scale = 0; scale < kScalesDeg.size(); ++scale) {
    const Box around = box(scale, theta_i_deg);
    if (theta_v_deg < around.theta_low_deg || theta_v_deg > around.theta_high_deg) continue;
    const double most_deg = phi_deg(scale, tan_theta_i);
    if (std::abs(turn_deg) > most_deg) continue;
    density += kScaleShare * theta_max_deg_ / (around.theta_high_deg - around.theta_low_deg) * 180 / most_deg;
  }
  return 1 / density;
}

HighlightDraw::Numbers HighlightDraw::draw_numbers(std::mt19937_64& random) {
  Numbers numbers;
  for (double& number : numbers) number = draw_uniform(random, 1);
  return numbers;
}

WeightedPair HighlightDraw::operator()(const Numbers& numbers) const {
  const double choice = numbers[0];
  const double theta_i = numbers[1] * theta_max_deg_;
  const double phi_i = numbers[2] * 360;
  Box from = {0, theta_max_deg_};
  double most_deg = 180;
  if (choice >= kUniformShare) {
    const auto drawn = static_cast<std::size_t>((choice - kUniformShare) / kScaleShare);
    const std::size_t scale = std::min(drawn, kScalesDeg.size() - 1);
    from = box(scale, theta_i);
    most_deg = phi_deg(scale, std::tan(radians_from_degrees(theta_i)));
  }
  const double theta_v = from.theta_low_deg + numbers[3] * (from.theta_high_deg - from.theta_low_deg);
  const double turn = most_deg * (2 * numbers[4] - 1);
  return {{direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, wrap(phi_i + 180 + turn, 360))},
          weight(theta_i, theta_v, turn)};
}

}  // namespace sbrdf::internal
