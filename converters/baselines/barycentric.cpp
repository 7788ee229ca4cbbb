#include "converters/baselines/barycentric.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>

namespace sbrdf::internal {
namespace {

constexpr double kGreatest = std::numeric_limits<float>::max();

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
  for (std::size_t k = 0; k < w_i.size(); ++k) {
    const Place& light = last_light.at(w_i[k]);
    const Place& viewer = last_viewer.at(w_v[k]);
    std::array<const float*, 9> sample;
    std::array<double, 9> weight;
    for (std::size_t n = 0; n < sample.size(); ++n) {
      sample[n] = samples().values.data() + pair_number(light.triangle[n / 3], viewer.triangle[n % 3]) * channels;
      weight[n] = light.weights[n / 3] * viewer.weights[n % 3];
    }
    for (std::size_t c = 0; c < channels; ++c) {
      double sum = 0;
      for (std::size_t n = 0; n < sample.size(); ++n) sum += weight[n] * sample[n][c];
      values[k * channels + c] = static_cast<float>(std::clamp(sum, -kGreatest, kGreatest));  // sums of 1 may round up
    }
  }
}

}  // namespace sbrdf::internal
