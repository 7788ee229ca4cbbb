#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "converters/scene/surface.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// Who looks at a material, and what lights it (specs/atlas.md, Scenes): from which directions it is seen and lit, and
// so what of it a scene needs. Nothing hides anything, nothing is drawn.

struct SceneCamera {
  glm::dvec3 position{};
  glm::dvec3 forward{0, 0, -1}, right{1, 0, 0}, up{0, 1, 0};  ///< unit vectors, across each other
  double tan_half_width = 1, tan_half_height = 1;             ///< of the field of view
};

struct SceneLight {
  bool far = false;  ///< `at` is the direction to it; else its place
  glm::dvec3 at{};
};

/// From which directions of the world light comes: row by row from straight up (+y), columns from -x over -z, +x and
/// +z.
struct Environment {
  std::uint32_t width = 0, height = 0;  ///< cells
  std::vector<bool> lit;

  [[nodiscard]] bool everywhere() const;
  /// To the middle of a cell.
  [[nodiscard]] glm::dvec3 direction(std::uint32_t column, std::uint32_t row) const;
};

struct Scene {
  std::vector<SceneCamera> cameras;
  std::vector<SceneLight> lights;
  std::optional<Environment> environment;
  std::vector<Patch> patches;  ///< of all objects of the material
};

/// Reads a scene and the files that it names, beside it. kInvalidFile names the member that is missing or wrong;
/// kUnsupported for scenes of more than 16 MB.
[[nodiscard]] Result<Scene> read_scene(const ByteSource& bytes);

}  // namespace sbrdf::internal
