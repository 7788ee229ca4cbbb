// Stands for gl_harness.cpp where the build found no EGL.
#include "tests/gpu/gl_harness.h"

namespace sbrdf::internal {

class GlContext::Impl {};

GlContext::GlContext(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GlContext::GlContext(GlContext&&) noexcept = default;
GlContext& GlContext::operator=(GlContext&&) noexcept = default;
GlContext::~GlContext() = default;

Result<GlContext> GlContext::make(GlApi /*api*/) {
  return unsupported("built without EGL: install the package libegl-dev and configure again");
}

// No context is ever made.
GlApi GlContext::api() const { return GlApi::kCore45; }
std::string GlContext::driver() const { return ""; }

Result<std::vector<float>> GlContext::evaluate(const std::string& /*shader*/, std::span<const GlTexture> /*textures*/,
                                               std::span<const float> /*inputs*/, GlFunction /*function*/) {
  return unsupported("built without EGL");
}

Result<GlTiming> GlContext::time_frames(const std::string& /*shader*/, std::span<const GlTexture> /*textures*/,
                                        int /*width*/, int /*height*/, int /*frames*/) {
  return unsupported("built without EGL");
}

std::size_t gl_texture_size(GlFormat /*format*/, int /*width*/, int /*height*/) { return 0; }

}  // namespace sbrdf::internal
