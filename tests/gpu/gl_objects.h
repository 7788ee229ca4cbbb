#pragma once

#include <span>
#include <string>
#include <vector>

#include "tests/gpu/egl_context.h"

namespace sbrdf::internal {

/// Owner of one name that OpenGL handed out. Its context is current when it is destroyed.
class GlObject {
 public:
  using Delete = void (*)(const GlCalls&, GLuint);
  GlObject(const GlCalls& calls, GLuint name, Delete remove) : calls_(&calls), name_(name), remove_(remove) {}
  GlObject(GlObject&& other) noexcept : calls_(other.calls_), name_(other.name_), remove_(other.remove_) {
    other.name_ = 0;
  }
  GlObject& operator=(GlObject&&) = delete;
  ~GlObject() {
    if (name_ != 0) remove_(*calls_, name_);
  }
  [[nodiscard]] GLuint name() const { return name_; }

 private:
  const GlCalls* calls_;
  GLuint name_;
  Delete remove_;
};

/// A failure where OpenGL has noted errors since the last call, all of them named.
[[nodiscard]] Status check_gl(const GlCalls& gl, std::string_view what);

/// The texture with its samples, filter and wrapping, in the unit of this index.
[[nodiscard]] Result<GlObject> make_texture(const GlCalls& gl, const GlTexture& texture, int unit);

/// A vertex shader that covers the picture with one triangle, and this fragment shader in three parts, of which the
/// lines of the second are counted from 1. The program is in use afterwards.
[[nodiscard]] Result<GlObject> make_program(const GlCalls& gl, GlApi api, const std::string& shader,
                                            const std::string& main);

/// What is drawn goes into a picture of RGBA32F.
class GlTarget {
 public:
  [[nodiscard]] static Result<GlTarget> make(const GlCalls& gl, int width, int height);
  /// width x height x 4 floats, the lowest row first.
  [[nodiscard]] Result<std::vector<float>> read() const;
  void draw() const;

 private:
  GlTarget(const GlCalls& gl, int width, int height, GlObject picture, GlObject frame, GlObject vertices)
      : gl_(&gl),
        width_(width),
        height_(height),
        picture_(std::move(picture)),
        frame_(std::move(frame)),
        vertices_(std::move(vertices)) {}

  const GlCalls* gl_;
  int width_;
  int height_;
  GlObject picture_;
  GlObject frame_;
  GlObject vertices_;
};

}  // namespace sbrdf::internal
