#include "tests/gpu/egl_context.h"

#include <array>
#include <cstdlib>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace sbrdf::internal {
namespace {

Error no_driver(std::string_view what) {
  return unsupported(
      fmt::format("no OpenGL without a display: {} (EGL error {:#x}); the packages libegl1 and "
                  "libgl1-mesa-dri bring a driver",
                  what, eglGetError()));
}

bool lists(const char* extensions, std::string_view name) {
  return extensions != nullptr && fmt::format(" {} ", extensions).find(fmt::format(" {} ", name)) != std::string::npos;
}

// Mesa reads these when it is loaded. Compiled shaders are not kept on disk, so that no run depends on an earlier one.
void choose_software() {
  setenv("LIBGL_ALWAYS_SOFTWARE", "1", 0);
  setenv("GALLIUM_DRIVER", "llvmpipe", 0);
  setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
}

Result<EGLDisplay> open_display() {
  choose_software();
  if (!lists(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_MESA_platform_surfaceless")) {
    return no_driver("the platform EGL_MESA_platform_surfaceless is missing");
  }
  EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
  if (display == EGL_NO_DISPLAY) return no_driver("eglGetPlatformDisplay found no display");
  if (!eglInitialize(display, nullptr, nullptr)) return no_driver("eglInitialize failed");
  for (const char* extension : {"EGL_KHR_no_config_context", "EGL_KHR_surfaceless_context"}) {
    if (!lists(eglQueryString(display, EGL_EXTENSIONS), extension)) return no_driver(fmt::format("no {}", extension));
  }
  return display;
}

// One for the process, never closed: to close it would end the contexts of other tests, and unload the driver, of whose
// leaks a sanitizer could then no longer tell the origin.
const Result<EGLDisplay>& the_display() {
  static const Result<EGLDisplay> kDisplay = open_display();
  return kDisplay;
}

EGLenum egl_api(GlApi api) { return api == GlApi::kEs30 ? EGL_OPENGL_ES_API : EGL_OPENGL_API; }

}  // namespace

Result<std::unique_ptr<EglContext>> EglContext::make(GlApi api) {
  const Result<EGLDisplay>& display = the_display();
  if (!display) return display.error();
  if (!eglBindAPI(egl_api(api))) return no_driver("eglBindAPI failed");
  constexpr std::array<EGLint, 7> kCore = {
      EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  constexpr std::array<EGLint, 5> kEs = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE};
  const EGLint* attributes = api == GlApi::kEs30 ? kEs.data() : kCore.data();
  EGLContext context = eglCreateContext(*display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  if (context == EGL_NO_CONTEXT) {
    return no_driver(fmt::format("no context of OpenGL {}", api == GlApi::kEs30 ? "ES 3.0" : "4.5"));
  }
  std::unique_ptr<EglContext> made(new EglContext(*display, context, api));
  if (const Status status = made->make_current(); !status) return status.error();
  if (const Status status = made->find_calls(); !status) return status.error();
  return made;
}

EglContext::~EglContext() {
  eglBindAPI(egl_api(api_));
  if (eglGetCurrentContext() == context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

Status EglContext::make_current() const {
  if (!eglBindAPI(egl_api(api_)) || !eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
    return no_driver("eglMakeCurrent failed");
  }
  return ok_status();
}

Status EglContext::find_calls() {
#define SBRDF_GL_FIND(type, member, name)                          \
  calls_.member = reinterpret_cast<type>(eglGetProcAddress(name)); \
  if (calls_.member == nullptr) return no_driver("there is no " name);
  SBRDF_GL_CALLS(SBRDF_GL_FIND)
#undef SBRDF_GL_FIND
  return ok_status();
}

}  // namespace sbrdf::internal
