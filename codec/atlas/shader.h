#pragma once

#include <string>

#include "codec/atlas/atlas.h"

namespace sbrdf::internal {

/// GLSL text for a fragment shader to include: `vec3 sbrdf_eval(vec3 w_i, vec3 w_v)`, f_r [1/sr] of unit vectors in the
/// surface's frame (x the tangent, z the normal), what AtlasEvaluator gives. It reads `uniform highp sampler2D
/// sbrdf_atlas`, filtered linearly and clamped to its edges, unless SBRDF_ATLAS is defined to another sampler
/// beforehand. All else is constant, so no uniforms need to be set. Of an atlas that leaves cells out, it gives
/// kLeftOutColour there if SBRDF_DEBUG is defined, and else what happens to lie at hand. Compiles as GLSL 3.30 and
/// later, GLSL ES 3.00 (with highp floats and ints), and for Vulkan; needs no extension, but that OpenGL ES filters
/// float32 textures by OES_texture_float_linear only.
[[nodiscard]] std::string atlas_shader(const Atlas& atlas);

}  // namespace sbrdf::internal
