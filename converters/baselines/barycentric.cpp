#include "converters/baselines/barycentric.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

namespace sbrdf::internal {
namespace {

constexpr float kGreatest = std::numeric_limits<float>::max();

/// The place of the direction that was asked for last, as tables and grids have runs of the same.
class LastPlace {
 public:
  explicit LastPlace(const Triangulation& triangulation) : triangulation_(triangulation) {}
  const Place& at(const glm::dvec3& w) {
    if (w != direction_) {
      direction_ = w;
      place_ = triangulation_.place_of(w);
    }
    return place_;
  }

 private:
  const Triangulation& triangulation_;
  glm::dvec3 direction_{};  // none
  Place place_;
};

}  // namespace

Result<std::unique_ptr<SchemeSource>> BarycentricSource::make(SchemeSamples samples) {
  Result<Triangulation> triangulation = Triangulation::make(samples.scheme);
  if (!triangulation) return triangulation.error();
  return std::unique_ptr<SchemeSource>(new BarycentricSource(std::move(samples), *std::move(triangulation)));
}

BarycentricSource::BarycentricSource(SchemeSamples samples, Triangulation triangulation)
    : SchemeSource(std::move(samples), {Interpolation::Kind::kBarycentric}, "the value held at theta_max"),
      triangulation_(std::move(triangulation)) {}

void BarycentricSource::interpolate(std::span<const glm::dvec3> w_i, std::span<const glm::dvec3> w_v,
                                    std::span<float> values) const {
  LastPlace last_light(triangulation_);
  LastPlace last_viewer(triangulation_);
  const std::size_t channels = channel_count();
  std::ranges::fill(values, 0.0F);
  for (std::size_t k = 0; k < w_i.size(); ++k) {
    const Place& light = last_light.at(w_i[k]);
    const Place& viewer = last_viewer.at(w_v[k]);
    float* value = values.data() + k * channels;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        const auto weight = static_cast<float>(light.weights[a] * viewer.weights[b]);
        const float* sample = samples().values.data() + pair_number(light.triangle[a], viewer.triangle[b]) * channels;
        for (std::size_t c = 0; c < channels; ++c) value[c] += weight * sample[c];
      }
    }
    // Weights of sum 1 may round to more.
    for (std::size_t c = 0; c < channels; ++c) value[c] = std::clamp(value[c], -kGreatest, kGreatest);
  }
}

}  // namespace sbrdf::internal
