#include "tests/gpu/gl_objects.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

namespace sbrdf::internal {
namespace {

// Of extensions to OpenGL ES; the same values as in OpenGL.
constexpr GLenum kBc6hSignedFloat = 0x8E8E;
constexpr GLenum kBc6hUnsignedFloat = 0x8E8F;

constexpr std::size_t kFaces = 6;  // of a cube

struct Layout {
  GLint internal_format;
  GLenum format, type;  // format 0: compressed
  std::size_t bytes;    // of a texel, or of a block
};

Layout layout_of(GlFormat format) {
  switch (format) {
    case GlFormat::kRgba32f:
      return {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16};
    case GlFormat::kRgb32f:
      return {GL_RGB32F, GL_RGB, GL_FLOAT, 12};
    case GlFormat::kR32f:
      return {GL_R32F, GL_RED, GL_FLOAT, 4};
    case GlFormat::kRgba16f:
      return {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 8};
    case GlFormat::kRgba8:
      return {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4};
    case GlFormat::kRgb9E5:
      return {GL_RGB9_E5, GL_RGB, GL_UNSIGNED_INT_5_9_9_9_REV, 4};
    case GlFormat::kBc6hUnsigned:
      return {kBc6hUnsignedFloat, 0, 0, 16};
    case GlFormat::kBc6hSigned:
      return {kBc6hSignedFloat, 0, 0, 16};
  }
  std::abort();
}

// Mesa heeds the number of a line, but not that of a source string behind it.
constexpr int kMainLine = 100001;

constexpr const char* kVertexShader = R"(
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

bool has_version(const std::string& shader) { return shader.starts_with("#version"); }

// OpenGL ES links shaders of one version only.
std::string version_line(GlApi api, const std::string& shader) {
  if (has_version(shader)) return shader.substr(0, shader.find('\n')) + '\n';
  return api == GlApi::kEs30 ? "#version 300 es\n" : "#version 450 core\n";
}

std::string prelude(GlApi api, const std::string& shader) {
  if (has_version(shader)) return "";
  const char* precision =
      api == GlApi::kEs30 ? "precision highp float;\nprecision highp int;\nprecision highp sampler2D;\n" : "";
  return fmt::format("{}{}#line 1\n", version_line(api, shader), precision);
}

// `get` and `log` ask for what OpenGL has to say about a shader or a program.
template <class Get, class Log>
std::string whole_log(Get get, Log log, GLuint name) {
  GLint size = 0;
  get(name, GL_INFO_LOG_LENGTH, &size);
  std::string text(static_cast<std::size_t>(std::max(size, 1)), '\0');
  log(name, size, nullptr, text.data());
  text.resize(text.find('\0') == std::string::npos ? text.size() : text.find('\0'));
  return text;
}

Result<GlObject> compile(const GlCalls& gl, GLenum stage, std::span<const std::string> parts) {
  GlObject shader(gl, gl.create_shader(stage), [](const GlCalls& calls, GLuint name) { calls.delete_shader(name); });
  std::vector<const char*> texts;
  for (const std::string& part : parts) texts.push_back(part.c_str());
  gl.shader_source(shader.name(), static_cast<GLsizei>(texts.size()), texts.data(), nullptr);
  gl.compile_shader(shader.name());
  GLint done = 0;
  gl.get_shader(shader.name(), GL_COMPILE_STATUS, &done);
  if (done == GL_FALSE) {
    return usage_error(fmt::format("{} shader does not compile: {}", stage == GL_VERTEX_SHADER ? "vertex" : "fragment",
                                   whole_log(gl.get_shader, gl.shader_log, shader.name())));
  }
  return shader;
}

void upload(const GlCalls& gl, const GlTexture& texture) {
  const auto [internal_format, format, type, bytes] = layout_of(texture.format);
  if (format == 0) {
    gl.compressed_image(GL_TEXTURE_2D, 0, static_cast<GLenum>(internal_format), texture.width, texture.height, 0,
                        static_cast<GLsizei>(texture.bytes.size()), texture.bytes.data());
    return;
  }
  gl.pixel_store(GL_UNPACK_ALIGNMENT, 1);
  if (!texture.cube) {
    gl.image(GL_TEXTURE_2D, 0, internal_format, texture.width, texture.height, 0, format, type, texture.bytes.data());
    return;
  }
  const std::size_t face_size = gl_texture_size(texture.format, texture.width, texture.height);
  for (std::size_t face = 0; face < kFaces; ++face) {
    gl.image(GL_TEXTURE_CUBE_MAP_POSITIVE_X + static_cast<GLenum>(face), 0, internal_format, texture.width,
             texture.height, 0, format, type, texture.bytes.data() + face * face_size);
  }
}

GlObject generate_texture(const GlCalls& gl) {
  GLuint name = 0;
  gl.gen_textures(1, &name);
  return {gl, name, [](const GlCalls& calls, GLuint old) { calls.delete_textures(1, &old); }};
}

Status check_side(const GlCalls& gl, int width, int height) {
  GLint most = 0;
  gl.get_integer(GL_MAX_TEXTURE_SIZE, &most);
  if (std::min(width, height) >= 1 && std::max(width, height) <= most) return ok_status();
  return usage_error(fmt::format("{} x {} texels; a side has 1 to {}", width, height, most));
}

}  // namespace

std::size_t gl_texture_size(GlFormat format, int width, int height) {
  if (width < 1 || height < 1) return 0;
  const Layout layout = layout_of(format);
  const std::size_t side = layout.format == 0 ? 4 : 1;
  const std::size_t columns = (static_cast<std::size_t>(width) + side - 1) / side;
  const std::size_t rows = (static_cast<std::size_t>(height) + side - 1) / side;
  return columns * rows * layout.bytes;
}

Status check_gl(const GlCalls& gl, std::string_view what) {
  std::string found;
  // A lost context notes errors without end.
  for (int count = 0; count < 8; ++count) {
    const GLenum error = gl.get_error();
    if (error == GL_NO_ERROR) break;
    found += fmt::format(" {:#06x}", error);
  }
  if (found.empty()) return ok_status();
  return usage_error(fmt::format("{}: OpenGL errors{}", what, found));
}

Result<GlObject> make_texture(const GlCalls& gl, const GlTexture& texture, int unit) {
  if (const Status status = check_side(gl, texture.width, texture.height); !status) return status.error();
  if (texture.cube && (texture.width != texture.height || layout_of(texture.format).format == 0)) {
    return usage_error("cube map " + texture.name + ": faces are square, and have no blocks");
  }
  const std::size_t size = gl_texture_size(texture.format, texture.width, texture.height) * (texture.cube ? kFaces : 1);
  if (texture.bytes.size() != size) {
    return usage_error(fmt::format("texture {}: {} bytes rather than {}", texture.name, texture.bytes.size(), size));
  }
  GlObject made = generate_texture(gl);
  gl.active_texture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  const GLenum kind = texture.cube ? GL_TEXTURE_CUBE_MAP : GL_TEXTURE_2D;
  gl.bind_texture(kind, made.name());
  upload(gl, texture);
  const GLint filter = texture.filter == GlFilter::kLinear ? GL_LINEAR : GL_NEAREST;
  const std::array<GLenum, 2> axes = {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T};
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    const GLint wrap = texture.wrap[axis] == GlWrap::kRepeat ? GL_REPEAT : GL_CLAMP_TO_EDGE;
    gl.texture_parameter(kind, axes[axis], wrap);
  }
  gl.texture_parameter(kind, GL_TEXTURE_MIN_FILTER, filter);
  gl.texture_parameter(kind, GL_TEXTURE_MAG_FILTER, filter);
  gl.texture_parameter(kind, GL_TEXTURE_MAX_LEVEL, 0);
  if (const Status status = check_gl(gl, "texture " + texture.name); !status) return status.error();
  return made;
}

Result<GlObject> make_program(const GlCalls& gl, GlApi api, const std::string& shader, const std::string& main) {
  const std::array<std::string, 1> vertex_parts = {version_line(api, shader) + kVertexShader};
  const std::array<std::string, 3> fragment_parts = {prelude(api, shader), shader,
                                                     fmt::format("\n#line {}\n", kMainLine) + main};
  Result<GlObject> vertex = compile(gl, GL_VERTEX_SHADER, vertex_parts);
  if (!vertex) return vertex.error();
  Result<GlObject> fragment = compile(gl, GL_FRAGMENT_SHADER, fragment_parts);
  if (!fragment) return fragment.error();

  GlObject program(gl, gl.create_program(), [](const GlCalls& calls, GLuint name) { calls.delete_program(name); });
  gl.attach_shader(program.name(), vertex->name());
  gl.attach_shader(program.name(), fragment->name());
  gl.link_program(program.name());
  GLint done = 0;
  gl.get_program(program.name(), GL_LINK_STATUS, &done);
  if (done == GL_FALSE) {
    return usage_error("program does not link: " + whole_log(gl.get_program, gl.program_log, program.name()));
  }
  gl.use_program(program.name());
  if (const Status status = check_gl(gl, "program"); !status) return status.error();
  return program;
}

Result<GlTarget> GlTarget::make(const GlCalls& gl, int width, int height) {
  if (const Status status = check_side(gl, width, height); !status) return status.error();
  GlObject picture = generate_texture(gl);
  gl.active_texture(GL_TEXTURE0);
  gl.bind_texture(GL_TEXTURE_2D, picture.name());
  gl.image(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
  gl.texture_parameter(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);

  GLuint name = 0;
  gl.gen_framebuffers(1, &name);
  GlObject frame(gl, name, [](const GlCalls& calls, GLuint old) { calls.delete_framebuffers(1, &old); });
  gl.bind_framebuffer(GL_FRAMEBUFFER, frame.name());
  gl.framebuffer_texture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture.name(), 0);
  if (gl.check_framebuffer(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    return unsupported("the driver does not draw into pictures of RGBA32F");
  }
  gl.gen_vertex_arrays(1, &name);
  GlObject vertices(gl, name, [](const GlCalls& calls, GLuint old) { calls.delete_vertex_arrays(1, &old); });
  gl.bind_vertex_array(vertices.name());
  gl.viewport(0, 0, width, height);
  if (const Status status = check_gl(gl, "picture"); !status) return status.error();
  return GlTarget(gl, width, height, std::move(picture), std::move(frame), std::move(vertices));
}

void GlTarget::draw() const { gl_->draw_arrays(GL_TRIANGLES, 0, 3); }

Result<std::vector<float>> GlTarget::read() const {
  std::vector<float> values(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 4);
  gl_->read_pixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, values.data());
  if (const Status status = check_gl(*gl_, "drawing"); !status) return status.error();
  return values;
}

}  // namespace sbrdf::internal
