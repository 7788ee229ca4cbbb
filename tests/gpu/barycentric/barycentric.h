#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "converters/baselines/cube_map.h"
#include "converters/source/brdf_source.h"
#include "tests/gpu/gl_harness.h"

namespace sbrdf::internal {

/// The interpolation that the paper's section 8 compares with: directions of a uniform scheme, triangulated; a cube map
/// of 256 x 256 faces has the triangle and the weights of each direction, for the light and for the viewer alike; the
/// value is the sum over three times three samples. The paper leaves the layout open: three numbers of 8 bits and three
/// half-float weights in a texel, and float32 samples of the pairs that reciprocity leaves, make the bytes of its Table
/// 5 (up to the fourth channel that cards add).
class Barycentric {
 public:
  /// Samples of a source of three channels; at most 256 directions.
  Barycentric(const BrdfSource& source, const UniformScheme& scheme);

  /// f_r [1/sr] as the shader gives it: 0 where one of the unit vectors points below the horizon.
  [[nodiscard]] std::array<float, 3> evaluate(const glm::vec3& w_i, const glm::vec3& w_v) const;

  /// `vec3 barycentric_eval(vec3 w_i, vec3 w_v)`, which reads textures().
  [[nodiscard]] static std::string shader();
  /// Cube maps `barycentric_vertices` and `barycentric_weights`, and `barycentric_samples`.
  [[nodiscard]] std::vector<GlTexture> textures() const;

  [[nodiscard]] std::span<const glm::dvec3> directions() const { return directions_; }
  /// Bytes of the paper's Table 5: 9 of a texel of the cube map, 12 of a sample.
  [[nodiscard]] std::size_t table_5_bytes() const;

 private:
  std::vector<glm::dvec3> directions_;
  BarycentricCube cube_;
  std::vector<float> samples_;  // RGB, of the directions low <= high at high (high + 1) / 2 + low
};

}  // namespace sbrdf::internal
