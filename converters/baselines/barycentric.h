#pragma once

#include <memory>
#include <span>

#include <glm/vec3.hpp>

#include "converters/baselines/scheme_samples.h"
#include "converters/baselines/triangulation.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Uniform samples between which light and viewer are each interpolated in the triangle that their direction meets: the
/// weighted mean of nine samples. Directions below the last ring are taken to its rim.
class BarycentricSource final : public SchemeSource {
 public:
  /// Errors as of Triangulation::make.
  [[nodiscard]] static Result<std::unique_ptr<SchemeSource>> make(SchemeSamples samples);

 private:
  BarycentricSource(SchemeSamples samples, Triangulation triangulation);
  void interpolate(std::span<const glm::dvec3> w_i, std::span<const glm::dvec3> w_v,
                   std::span<float> values) const override;

  Triangulation triangulation_;
};

}  // namespace sbrdf::internal
