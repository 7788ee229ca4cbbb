#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "codec/file/encoder.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/slicing/slicing.h"
#include "tests/gpu/gl_harness.h"

namespace sbrdf::internal {

/// Unit vectors to the light and to the viewer.
struct Pairs {
  std::vector<glm::vec3> i, v;
};

/// A third anywhere, a third about the mirror direction, a third with one direction near a pole, at the horizon, or on
/// a plane of symmetry; always the same.
[[nodiscard]] Pairs draw_pairs(std::size_t count);

/// How the paper samples: 8,911 samples at 14/36 in the elevation frame, here of logarithms, as they are measured.
[[nodiscard]] SliceOptions paper_options();

/// The slices that slice_source makes, in the form of a file that was read.
[[nodiscard]] Result<DecodedSliced> sliced_of(const BrdfSource& source, const SliceOptions& options);

/// The texture of an atlas, as its shader asks for it.
[[nodiscard]] GlTexture texture_of(const Texture& texture);

/// Three values of each pair by `vec3 function(vec3 w_i, vec3 w_v)` of a shader.
[[nodiscard]] Result<std::vector<float>> run_shader(GlContext& context, const std::string& shader,
                                                    const std::string& function, std::span<const GlTexture> textures,
                                                    const Pairs& pairs);

struct ShaderDifference {
  double largest = 0;  ///< of a channel to the evaluator's largest there, or 1e-3 of the material's mean
  std::size_t at = 0;  ///< number of that pair
  double mean = 0;
};

/// How far values of a shader are off those of the same atlas on the processor.
[[nodiscard]] ShaderDifference difference(const Atlas& atlas, const Pairs& pairs, std::span<const float> values);

}  // namespace sbrdf::internal
