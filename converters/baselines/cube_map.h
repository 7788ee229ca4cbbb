#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "converters/baselines/triangulation.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// How a graphics card finds the triangle of a direction (the paper's section 8): a cube map of 256 x 256 faces whose
/// texels have the numbers of three directions of a uniform scheme and their weights. The paper leaves the layout open:
/// numbers of 8 bits and half-float weights, 9 bytes a texel, make the figures of its Table 5.
struct BarycentricCube {
  static constexpr std::size_t kFaceSide = 256;  ///< texels
  static constexpr std::size_t kFaces = 6;       ///< +x, -x, +y, -y, +z, -z

  struct Texel {
    std::array<std::uint8_t, 3> vertices{};
    std::array<std::uint16_t, 3> weights{};  ///< half floats
  };

  /// kUnsupported for more than 256 directions, else as Triangulation::make.
  [[nodiscard]] static Result<BarycentricCube> make(const UniformScheme& scheme);

  [[nodiscard]] const Texel& at(const glm::dvec3& w) const;

  std::vector<Texel> texels;  ///< by face, row, column
};

/// The texel of a cube map of such faces that holds a direction, by the rules of OpenGL: face, column and row from 0
/// on, as fractions of a texel.
struct CubePlace {
  std::size_t face = 0;
  glm::dvec2 at{};
};
[[nodiscard]] CubePlace cube_place(const glm::dvec3& w, std::size_t side);

}  // namespace sbrdf::internal
