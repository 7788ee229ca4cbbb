#pragma once

#include "codec/atlas/atlas.h"
#include "codec/atlas/part/atlas_cells.h"
#include "converters/scene/scene.h"
#include "converters/source/progress.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// The cells of an atlas with these axes that a scene reaches: those of all pairs of directions under which a camera
/// sees a place of the surfaces and light reaches it. More than that, since nothing hides anything, and surfaces are
/// looked at in pieces of about 3 degrees. kUsage where no place is seen and lit; kUnsupported for a scene of too many
/// pieces.
[[nodiscard]] Result<AtlasCells> reach_of_scene(const Scene& scene, const AtlasLayout& axes,
                                                const Progress& progress = {});

}  // namespace sbrdf::internal
