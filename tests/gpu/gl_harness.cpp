#include "tests/gpu/gl_harness.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "tests/benchmarks/timing.h"
#include "tests/gpu/egl_context.h"
#include "tests/gpu/gl_objects.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kInputFloats = 8;
constexpr std::size_t kMostColumns = 1024;  // inputs side by side; two texels each

// highp everywhere, for shaders that bring their own #version and no default.
constexpr const char* kEvaluateMain = R"(
uniform highp sampler2D harness_inputs;
layout(location = 0) out highp vec4 harness_output;
void main() {{
  highp ivec2 pixel = ivec2(gl_FragCoord.xy);
  highp vec4 a = texelFetch(harness_inputs, ivec2(2 * pixel.x, pixel.y), 0);
  highp vec4 b = texelFetch(harness_inputs, ivec2(2 * pixel.x + 1, pixel.y), 0);
  harness_output = {};
}}
)";
constexpr const char* kShadeMain = R"(
uniform highp vec2 harness_size;
layout(location = 0) out highp vec4 harness_output;
void main() { harness_output = shade(gl_FragCoord.xy / harness_size); }
)";

// Without them OpenGL ES gives zeros rather than an error.
Status check_extensions(const GlCalls& gl) {
  GLint count = 0;
  gl.get_integer(GL_NUM_EXTENSIONS, &count);
  for (const char* needed :
       {"GL_EXT_color_buffer_float", "GL_OES_texture_float_linear", "GL_EXT_texture_compression_bptc"}) {
    bool found = false;
    for (GLint index = 0; index < count && !found; ++index) {
      const GLubyte* name = gl.get_string_of(GL_EXTENSIONS, static_cast<GLuint>(index));
      found = name != nullptr && std::strcmp(reinterpret_cast<const char*>(name), needed) == 0;
    }
    if (!found) return unsupported(fmt::format("the driver has no {}", needed));
  }
  return ok_status();
}

std::string text_of(const GLubyte* text) { return text == nullptr ? "" : reinterpret_cast<const char*>(text); }

// Rows of as many inputs as there are columns; what is missing in the last is 0.
GlTexture input_texture(std::span<const float> inputs, int columns, int rows) {
  GlTexture texture = {.name = "harness_inputs",
                       .format = GlFormat::kRgba32f,
                       .width = 2 * columns,
                       .height = rows,
                       .bytes = {},
                       .filter = GlFilter::kNearest};
  texture.bytes.resize(gl_texture_size(texture.format, texture.width, texture.height));
  std::memcpy(texture.bytes.data(), inputs.data(), inputs.size_bytes());
  return texture;
}

struct FrameTime {
  double wall = 0, processor = 0;  // [s]
};

FrameTime time_frame(const GlCalls& gl, const GlTarget& target) {
  const auto start = std::chrono::steady_clock::now();
  const double processor_start = processor_seconds();
  target.draw();
  gl.finish();
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          processor_seconds() - processor_start};
}

}  // namespace

class GlContext::Impl {
 public:
  explicit Impl(std::unique_ptr<EglContext> egl) : egl_(std::move(egl)) {}
  [[nodiscard]] const EglContext& egl() const { return *egl_; }
  [[nodiscard]] const GlCalls& gl() const { return egl_->calls(); }

  /// The textures in the units from 0 on, and their uniforms set in the program.
  Result<std::vector<GlObject>> bind(GLuint program, const std::string& shader,
                                     std::span<const GlTexture> textures) const {
    GLint most = 0;
    gl().get_integer(GL_MAX_TEXTURE_IMAGE_UNITS, &most);
    if (textures.size() > static_cast<std::size_t>(most)) {
      return usage_error(fmt::format("{} textures; there are {} units", textures.size(), most));
    }
    std::vector<GlObject> bound;
    for (const GlTexture& texture : textures) {
      const int unit = static_cast<int>(bound.size());
      // A sampler that is declared and not used has no place either.
      if (shader.find(texture.name) == std::string::npos) {
        return usage_error(
            fmt::format("the shader has no {} {}", texture.cube ? "samplerCube" : "sampler2D", texture.name));
      }
      Result<GlObject> made = make_texture(gl(), texture, unit);
      if (!made) return made.error();
      bound.push_back(*std::move(made));
      const GLint place = gl().uniform_location(program, texture.name.c_str());
      if (place >= 0) gl().uniform_int(place, unit);
    }
    if (const Status status = check_gl(gl(), "uniforms"); !status) return status.error();
    return bound;
  }

 private:
  std::unique_ptr<EglContext> egl_;
};

GlContext::GlContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GlContext::GlContext(GlContext&&) noexcept = default;
GlContext& GlContext::operator=(GlContext&&) noexcept = default;
GlContext::~GlContext() = default;

Result<GlContext> GlContext::make(GlApi api) {
  Result<std::unique_ptr<EglContext>> egl = EglContext::make(api);
  if (!egl) return egl.error();
  if (api == GlApi::kEs30) {
    if (const Status status = check_extensions((*egl)->calls()); !status) return status.error();
  }
  return GlContext(std::make_unique<Impl>(*std::move(egl)));
}

GlApi GlContext::api() const { return impl_->egl().api(); }

std::string GlContext::driver() const {
  if (!impl_->egl().make_current()) return "";
  const GlCalls& gl = impl_->gl();
  return fmt::format("{}, {}", text_of(gl.get_string(GL_RENDERER)), text_of(gl.get_string(GL_VERSION)));
}

Result<std::vector<float>> GlContext::evaluate(const std::string& shader, std::span<const GlTexture> textures,
                                               std::span<const float> inputs, GlFunction function) {
  if (const Status status = impl_->egl().make_current(); !status) return status.error();
  if (inputs.size() % kInputFloats != 0) return usage_error("inputs are 8 floats each");
  const bool of_three = function == GlFunction::kVec3;
  const std::string main = fmt::format(kEvaluateMain, of_three ? "vec4(run(a.xyz, b.xyz), 0.0)" : "run(a, b)");
  const Result<GlObject> program = make_program(impl_->gl(), api(), shader, main);
  if (!program) return program.error();
  const std::size_t count = inputs.size() / kInputFloats;
  if (count == 0) return std::vector<float>();

  const int columns = static_cast<int>(std::min(count, kMostColumns));
  const int rows = static_cast<int>((count + kMostColumns - 1) / kMostColumns);
  const Result<GlTarget> target = GlTarget::make(impl_->gl(), columns, rows);
  if (!target) return target.error();
  std::vector<GlTexture> all(textures.begin(), textures.end());
  all.push_back(input_texture(inputs, columns, rows));
  const Result<std::vector<GlObject>> bound = impl_->bind(program->name(), shader + main, all);
  if (!bound) return bound.error();
  target->draw();
  Result<std::vector<float>> values = target->read();
  if (!values) return values.error();

  const std::size_t channels = of_three ? 3 : 4;
  std::vector<float> results(count * channels);
  for (std::size_t index = 0; index < count; ++index) {
    std::copy_n(values->begin() + static_cast<std::ptrdiff_t>(4 * index), channels,
                results.begin() + static_cast<std::ptrdiff_t>(channels * index));
  }
  return results;
}

Result<GlTiming> GlContext::time_frames(const std::string& shader, std::span<const GlTexture> textures, int width,
                                        int height, int frames) {
  if (const Status status = impl_->egl().make_current(); !status) return status.error();
  if (frames < 1) return usage_error(fmt::format("{} frames; there is at least 1", frames));
  const GlCalls& gl = impl_->gl();
  const Result<GlObject> program = make_program(gl, api(), shader, kShadeMain);
  if (!program) return program.error();
  const Result<GlTarget> target = GlTarget::make(gl, width, height);
  if (!target) return target.error();
  const Result<std::vector<GlObject>> bound = impl_->bind(program->name(), shader, textures);
  if (!bound) return bound.error();
  gl.uniform_vec2(gl.uniform_location(program->name(), "harness_size"), static_cast<float>(width),
                  static_cast<float>(height));
  gl.finish();

  GlTiming timing;
  timing.first_seconds = time_frame(gl, *target).wall;
  for (int frame = 0; frame < frames; ++frame) {
    const FrameTime time = time_frame(gl, *target);
    timing.frames.push_back(time.wall);
    timing.processor.push_back(time.processor);
  }
  std::vector<double> seconds = timing.frames;
  std::sort(seconds.begin(), seconds.end());
  timing.fastest_seconds = seconds.front();
  timing.median_seconds = (seconds[(seconds.size() - 1) / 2] + seconds[seconds.size() / 2]) / 2;
  Result<std::vector<float>> image = target->read();
  if (!image) return image.error();
  timing.image = *std::move(image);
  return timing;
}

}  // namespace sbrdf::internal
