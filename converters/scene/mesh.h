#pragma once

#include <string_view>
#include <vector>

#include "converters/scene/surface.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// The triangles of a Wavefront OBJ file, polygons cut into some. Normals are those of the file, or of the triangles
/// where it has none; tangents run along u of the texture coordinates, or along x. Triangles without area are left out.
/// kInvalidFile for text that is none, an index of no vertex, a number that is not finite, and a file without
/// triangles.
[[nodiscard]] Result<std::vector<Patch>> read_obj(std::string_view text);

}  // namespace sbrdf::internal
