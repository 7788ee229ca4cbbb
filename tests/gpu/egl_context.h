#pragma once

#include <memory>

// Before any header of EGL: those of X11 define macros such as Status and None.
#define EGL_NO_X11
#define MESA_EGL_NO_X11_HEADERS
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>

#include "formats/core/result.h"
#include "tests/gpu/gl_harness.h"

namespace sbrdf::internal {

/// Every function of OpenGL that the harness calls: type of its pointer, member of GlCalls, name. All belong to
/// OpenGL 4.5 and to OpenGL ES 3.0.
#define SBRDF_GL_CALLS(X)                                                           \
  X(PFNGLACTIVETEXTUREPROC, active_texture, "glActiveTexture")                      \
  X(PFNGLATTACHSHADERPROC, attach_shader, "glAttachShader")                         \
  X(PFNGLBINDFRAMEBUFFERPROC, bind_framebuffer, "glBindFramebuffer")                \
  X(PFNGLBINDTEXTUREPROC, bind_texture, "glBindTexture")                            \
  X(PFNGLBINDVERTEXARRAYPROC, bind_vertex_array, "glBindVertexArray")               \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, check_framebuffer, "glCheckFramebufferStatus") \
  X(PFNGLCOMPILESHADERPROC, compile_shader, "glCompileShader")                      \
  X(PFNGLCOMPRESSEDTEXIMAGE2DPROC, compressed_image, "glCompressedTexImage2D")      \
  X(PFNGLCREATEPROGRAMPROC, create_program, "glCreateProgram")                      \
  X(PFNGLCREATESHADERPROC, create_shader, "glCreateShader")                         \
  X(PFNGLDELETEFRAMEBUFFERSPROC, delete_framebuffers, "glDeleteFramebuffers")       \
  X(PFNGLDELETEPROGRAMPROC, delete_program, "glDeleteProgram")                      \
  X(PFNGLDELETESHADERPROC, delete_shader, "glDeleteShader")                         \
  X(PFNGLDELETETEXTURESPROC, delete_textures, "glDeleteTextures")                   \
  X(PFNGLDELETEVERTEXARRAYSPROC, delete_vertex_arrays, "glDeleteVertexArrays")      \
  X(PFNGLDRAWARRAYSPROC, draw_arrays, "glDrawArrays")                               \
  X(PFNGLFINISHPROC, finish, "glFinish")                                            \
  X(PFNGLFRAMEBUFFERTEXTURE2DPROC, framebuffer_texture, "glFramebufferTexture2D")   \
  X(PFNGLGENFRAMEBUFFERSPROC, gen_framebuffers, "glGenFramebuffers")                \
  X(PFNGLGENTEXTURESPROC, gen_textures, "glGenTextures")                            \
  X(PFNGLGENVERTEXARRAYSPROC, gen_vertex_arrays, "glGenVertexArrays")               \
  X(PFNGLGETERRORPROC, get_error, "glGetError")                                     \
  X(PFNGLGETINTEGERVPROC, get_integer, "glGetIntegerv")                             \
  X(PFNGLGETPROGRAMINFOLOGPROC, program_log, "glGetProgramInfoLog")                 \
  X(PFNGLGETPROGRAMIVPROC, get_program, "glGetProgramiv")                           \
  X(PFNGLGETSHADERINFOLOGPROC, shader_log, "glGetShaderInfoLog")                    \
  X(PFNGLGETSHADERIVPROC, get_shader, "glGetShaderiv")                              \
  X(PFNGLGETSTRINGIPROC, get_string_of, "glGetStringi")                             \
  X(PFNGLGETSTRINGPROC, get_string, "glGetString")                                  \
  X(PFNGLGETUNIFORMLOCATIONPROC, uniform_location, "glGetUniformLocation")          \
  X(PFNGLLINKPROGRAMPROC, link_program, "glLinkProgram")                            \
  X(PFNGLPIXELSTOREIPROC, pixel_store, "glPixelStorei")                             \
  X(PFNGLREADPIXELSPROC, read_pixels, "glReadPixels")                               \
  X(PFNGLSHADERSOURCEPROC, shader_source, "glShaderSource")                         \
  X(PFNGLTEXIMAGE2DPROC, image, "glTexImage2D")                                     \
  X(PFNGLTEXPARAMETERIPROC, texture_parameter, "glTexParameteri")                   \
  X(PFNGLUNIFORM1IPROC, uniform_int, "glUniform1i")                                 \
  X(PFNGLUNIFORM2FPROC, uniform_vec2, "glUniform2f")                                \
  X(PFNGLUSEPROGRAMPROC, use_program, "glUseProgram")                               \
  X(PFNGLVIEWPORTPROC, viewport, "glViewport")

struct GlCalls {
#define SBRDF_GL_MEMBER(type, member, name) type member = nullptr;
  SBRDF_GL_CALLS(SBRDF_GL_MEMBER)
#undef SBRDF_GL_MEMBER
};

/// A context of EGL's surfaceless platform, with no surface either, and OpenGL's functions in it. Destroyed with its
/// owner; the display stays, as it is one for the whole process.
class EglContext {
 public:
  [[nodiscard]] static Result<std::unique_ptr<EglContext>> make(GlApi api);
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;
  ~EglContext();

  /// What is called next concerns this context.
  [[nodiscard]] Status make_current() const;
  [[nodiscard]] const GlCalls& calls() const { return calls_; }
  [[nodiscard]] GlApi api() const { return api_; }

 private:
  EglContext(EGLDisplay display, EGLContext context, GlApi api) : display_(display), context_(context), api_(api) {}
  [[nodiscard]] Status find_calls();

  EGLDisplay display_;
  EGLContext context_;
  GlApi api_;
  GlCalls calls_;
};

}  // namespace sbrdf::internal
