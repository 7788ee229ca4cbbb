#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "converters/baselines/schemes.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/byte_source.h"
#include "formats/core/named.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// What a goniometer that goes through a uniform scheme measures of a reciprocal material.
struct SchemeSamples {
  UniformScheme scheme;
  std::string description;    ///< of the material, one line; may be empty
  double theta_max_deg = 90;  ///< as far as it was measured, if the scheme goes on
  std::vector<std::string> channels;
  /// f_r [1/sr] of the pairs that reciprocity leaves, in the order of pair_number(), channel fastest.
  std::vector<float> values;
};

/// Where the pair of the a-th and the b-th direction stands, whichever of them is the light's.
[[nodiscard]] constexpr std::size_t pair_number(std::size_t a, std::size_t b) {
  const std::size_t high = std::max(a, b);
  return high * (high + 1) / 2 + std::min(a, b);
}

/// Samples a source, or the mean of f(i,v) and f(v,i) where it is not reciprocal. kUnsupported where pairs were not
/// measured; interrupted_error() where `progress` asked to stop.
[[nodiscard]] Result<SchemeSamples> sample_scheme(const BrdfSource& source, const UniformScheme& scheme,
                                                  const Progress& progress = {});

/// What a radial basis function makes of r, the length of the chord between two directions.
enum class RbfKernel : std::uint8_t {
  kLinear,               ///< r
  kCubic,                ///< r^3
  kThinPlate,            ///< r^2 log r
  kInverseMultiquadric,  ///< 1 / sqrt(r^2 + kRbfWidth^2)
};
inline constexpr double kRbfWidth = 0.3;
inline constexpr std::array kRbfKernelNames = {Named{"linear", RbfKernel::kLinear}, Named{"cubic", RbfKernel::kCubic},
                                               Named{"thin-plate", RbfKernel::kThinPlate},
                                               Named{"inverse-multiquadric", RbfKernel::kInverseMultiquadric}};

/// How values between uniform samples are found.
struct Interpolation {
  enum class Kind : std::uint8_t { kBarycentric, kRbf };

  Kind kind = Kind::kBarycentric;
  RbfKernel kernel = RbfKernel::kCubic;  ///< of kRbf
};
inline constexpr std::array kInterpolationNames = {Named{"barycentric", Interpolation::Kind::kBarycentric},
                                                   Named{"rbf", Interpolation::Kind::kRbf}};

/// Uniform samples and a way to interpolate them.
class SchemeSource : public BrdfSource {
 public:
  /// Errors as of Triangulation::make, or make_rbf.
  [[nodiscard]] static Result<std::unique_ptr<SchemeSource>> make(SchemeSamples samples,
                                                                  const Interpolation& interpolation);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  [[nodiscard]] const SchemeSamples& samples() const { return samples_; }
  [[nodiscard]] const Interpolation& interpolation() const { return interpolation_; }
  [[nodiscard]] const SchemeSource* uniform_samples() const override { return this; }

  /// Says that a file of the format of traits() has just this.
  void keep_file(std::shared_ptr<const ByteSource> file) { file_ = std::move(file); }
  [[nodiscard]] std::shared_ptr<const ByteSource> stored(std::string_view format) const override {
    return format == traits_.format ? file_ : nullptr;
  }

  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;
  void evaluate_vectors(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                        std::span<float> values) const override;

 protected:
  /// `beyond` says for people what is given below the last ring.
  SchemeSource(SchemeSamples samples, const Interpolation& interpolation, std::string beyond);

  /// At unit vectors above the horizon; `values` as of evaluate().
  virtual void interpolate(std::span<const glm::dvec3> w_i, std::span<const glm::dvec3> w_v,
                           std::span<float> values) const = 0;

 private:
  template <class VectorsOf>
  void evaluate_each(std::size_t count, const VectorsOf& vectors_of, std::span<float> values) const;

  SchemeSamples samples_;
  Interpolation interpolation_;
  SourceTraits traits_;
  std::shared_ptr<const ByteSource> file_;
};

}  // namespace sbrdf::internal
