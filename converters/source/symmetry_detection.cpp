#include "converters/source/symmetry_detection.h"

#include <cmath>
#include <random>
#include <vector>

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPairs = 4096;
constexpr double kTolerance = 1e-5;

template <class Image>
bool holds(const BrdfSource& source, const std::vector<DirectionPair>& pairs, const std::vector<float>& values,
           const Image& image) {
  std::vector<DirectionPair> images;
  for (const DirectionPair& pair : pairs) {
    images.push_back({{pair.i.theta, image(pair.i.phi)}, {pair.v.theta, image(pair.v.phi)}});
  }
  std::vector<float> there(values.size());
  source.evaluate(images, there);
  double difference = 0;
  double sum = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    difference += std::abs(static_cast<double>(values[k]) - there[k]);
    sum += std::abs(static_cast<double>(values[k]));
  }
  return difference <= kTolerance * sum;
}

}  // namespace

Symmetries detect_symmetries(const BrdfSource& source, double theta_max_deg) {
  std::mt19937_64 random(3);
  const auto uniform = [&](double end) { return end * static_cast<double>(random() >> 11U) * 0x1p-53; };
  std::vector<DirectionPair> pairs;
  for (std::size_t k = 0; k < kPairs; ++k) {
    const double theta_i = uniform(theta_max_deg);
    const double theta_v = uniform(theta_max_deg);
    const double phi_i = uniform(360);
    pairs.push_back({direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, uniform(360))});
  }
  std::vector<float> values(pairs.size() * source.channel_count());
  source.evaluate(pairs, values);
  Symmetries symmetries;
  symmetries.isotropic =
      source.traits().isotropic || holds(source, pairs, values, [](double phi) { return phi + 1.0; });
  symmetries.mirror_x = holds(source, pairs, values, [](double phi) { return -phi; });
  // For an isotropic material both mirrors are one.
  symmetries.mirror_y = !symmetries.isotropic && holds(source, pairs, values, [](double phi) { return kPi - phi; });
  return symmetries;
}

}  // namespace sbrdf::internal
