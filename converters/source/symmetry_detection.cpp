#include "converters/source/symmetry_detection.h"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "codec/search/random_pairs.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPairs = 4096;
constexpr double kTolerance = 1e-5;

/// Directions at which a source is compared with its images: many near the mirror direction, since a narrow highlight
/// is hardly ever met by others.
struct Places {
  std::vector<DirectionPair> pairs;
  std::vector<double> weights;  ///< that make sums those of the uniform draw
  std::vector<float> values;
};

Places draw_places(const BrdfSource& source, double theta_max_deg) {
  std::mt19937_64 random(3);
  const HighlightDraw draw(theta_max_deg);
  Places places;
  for (std::size_t k = 0; k < kPairs; ++k) {
    const WeightedPair drawn = draw(random);
    places.pairs.push_back(drawn.pair);
    places.weights.push_back(drawn.weight);
  }
  places.values.resize(kPairs * source.channel_count());
  source.evaluate(places.pairs, places.values);
  return places;
}

// Over the directions as they were drawn, which the highlight rules, and as if they were uniform.
template <class Image>
bool holds(const BrdfSource& source, const Places& places, const Image& image) {
  std::vector<DirectionPair> images;
  for (const DirectionPair& pair : places.pairs) {
    images.push_back({{pair.i.theta, image(pair.i.phi)}, {pair.v.theta, image(pair.v.phi)}});
  }
  std::vector<float> there(places.values.size());
  source.evaluate(images, there);
  std::array<double, 2> difference{};
  std::array<double, 2> sum{};
  for (std::size_t k = 0; k < there.size(); ++k) {
    const double f = places.values[k];
    const std::array<double, 2> weights = {1, places.weights[k / source.channel_count()]};
    for (std::size_t way = 0; way < 2; ++way) {
      difference[way] += weights[way] * std::abs(f - there[k]);
      sum[way] += weights[way] * std::abs(f);
    }
  }
  return difference[0] <= kTolerance * sum[0] && difference[1] <= kTolerance * sum[1];
}

}  // namespace

Symmetries detect_symmetries(const BrdfSource& source, double theta_max_deg) {
  const Places places = draw_places(source, theta_max_deg);
  Symmetries symmetries;
  symmetries.isotropic = source.traits().isotropic || holds(source, places, [](double phi) { return phi + 1.0; });
  symmetries.mirror_x = holds(source, places, [](double phi) { return -phi; });
  // For an isotropic material both mirrors are one.
  symmetries.mirror_y = !symmetries.isotropic && holds(source, places, [](double phi) { return kPi - phi; });
  return symmetries;
}

}  // namespace sbrdf::internal
