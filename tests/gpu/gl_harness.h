#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/core/result.h"
#include "tests/gpu/shader_tools.h"

namespace sbrdf::internal {

/// Which language the shaders of a context are in. Without a line `#version` of their own they get `version 450 core`,
/// or `version 300 es` with `precision highp` for float, int and sampler2D.
enum class GlApi : std::uint8_t { kCore45, kEs30 };

/// What a texel is kept as. All are little-endian, red first.
enum class GlFormat : std::uint8_t {
  kRgba32f,       ///< 4 floats
  kRgb32f,        ///< 3 floats
  kR32f,          ///< 1 float
  kRgba16f,       ///< 4 halves
  kRgba8,         ///< 4 bytes, each a fraction of 255
  kRgb9E5,        ///< 9 bits for each channel from bit 0 on, the shared exponent from bit 27 on: m * 2^(e - 24)
  kBc6hUnsigned,  ///< blocks of 4 x 4 texels in 16 bytes: BC6H_UFLOAT
  kBc6hSigned,    ///< the same with signs: BC6H_SFLOAT
};

enum class GlFilter : std::uint8_t { kNearest, kLinear };
enum class GlWrap : std::uint8_t { kClampToEdge, kRepeat };

/// A 2-D texture without smaller levels. `name` is that of its `uniform sampler2D` in the shader. `bytes` are rows from
/// t = 0 on without gaps: texels, or blocks where the format has them (rows of blocks are then rounded up). A cube map,
/// `uniform samplerCube`, has six faces one behind the other: +x, -x, +y, -y, +z, -z.
struct GlTexture {
  std::string name;
  GlFormat format = GlFormat::kRgba32f;
  int width = 0;   ///< texels
  int height = 0;  ///< texels
  std::vector<std::byte> bytes;
  GlFilter filter = GlFilter::kLinear;
  std::array<GlWrap, 2> wrap = {GlWrap::kClampToEdge, GlWrap::kClampToEdge};  ///< along s, along t
  bool cube = false;                                                          ///< of square faces; no blocks
};

/// Bytes that a texture of this size, or one face of a cube, needs; 0 where a side is not positive.
[[nodiscard]] std::size_t gl_texture_size(GlFormat format, int width, int height);

/// What the shader of GlContext::evaluate defines.
enum class GlFunction : std::uint8_t {
  kVec3,  ///< `vec3 run(vec3 a, vec3 b)`: the 4th and 8th number of an input are not used; 3 results
  kVec4,  ///< `vec4 run(vec4 a, vec4 b)`; 4 results
};

struct GlTiming {
  double median_seconds = 0;   ///< of a frame, from its draw call until glFinish returns
  double fastest_seconds = 0;  ///< of a frame
  double first_seconds = 0;    ///< the frame before those that count; the driver may finish compiling in it
  /// Of each frame that counts, in the order drawn [s]; `processor` is what the threads of this process took together,
  /// whatever else the machine does.
  std::vector<double> frames, processor;
  std::vector<float> image;  ///< height x width x 4, the lowest row first
};

/// An OpenGL context without display or window, drawn by the processor: Mesa's llvmpipe, unless the environment
/// variables LIBGL_ALWAYS_SOFTWARE and GALLIUM_DRIVER say otherwise. Subnormal numbers count as 0 in what is computed.
/// All cores take part; LP_NUM_THREADS=1 in the environment makes it one. Linear filters weigh in full single
/// precision, where most GPUs have steps of 1/256 of a texel. Each member must be called on the thread that made the
/// context.
///
/// Shaders are what a user would paste into a fragment shader: they declare the samplers that they use. Lines in
/// messages count from the first of the given text; those from 100001 on are of the `main` behind it. A text that
/// begins with `#version` gets nothing put before it; only such a text may have `#extension`. The names harness_* and
/// main are taken.
///
/// kUnsupported where there is no driver or it lacks something; kUsage where a shader or a texture is wrong: the
/// message is then the driver's whole log.
class GlContext {
 public:
  [[nodiscard]] static Result<GlContext> make(GlApi api = GlApi::kCore45);
  GlContext(GlContext&&) noexcept;
  GlContext& operator=(GlContext&&) noexcept;
  ~GlContext();

  [[nodiscard]] GlApi api() const;
  /// Renderer and version, as the driver names them.
  [[nodiscard]] std::string driver() const;

  /// Runs the shader's function once for each input. `inputs` is count x 8 floats: a.xyzw, then b.xyzw. The result is
  /// count x 3 or count x 4 floats in the same order, in single precision from end to end.
  [[nodiscard]] Result<std::vector<float>> evaluate(const std::string& shader, std::span<const GlTexture> textures,
                                                    std::span<const float> inputs,
                                                    GlFunction function = GlFunction::kVec3);

  /// Draws `vec4 shade(vec2 uv)` of the shader over a picture of width x height pixels, once and then `frames` times;
  /// uv is the centre of the pixel in 0...1 from the lower left corner.
  [[nodiscard]] Result<GlTiming> time_frames(const std::string& shader, std::span<const GlTexture> textures, int width,
                                             int height, int frames);

 private:
  class Impl;
  explicit GlContext(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sbrdf::internal

/// Defines the GlContext `variable`. Without a driver the test is skipped, or fails where one is required.
#define SBRDF_MAKE_GL_CONTEXT(variable, api)                                                \
  auto variable##_or_error = ::sbrdf::internal::GlContext::make(api);                       \
  if (!variable##_or_error) SBRDF_MISSING_SHADER_TOOL(variable##_or_error.error().message); \
  ::sbrdf::internal::GlContext& variable = *variable##_or_error
