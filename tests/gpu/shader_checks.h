#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "formats/core/result.h"
#include "tests/gpu/shader_tools.h"

namespace sbrdf::internal {

enum class ShaderStage : std::uint8_t { kVertex, kFragment, kCompute };

/// What a shader is compiled to.
enum class ShaderTarget : std::uint8_t {
  kLanguage,  ///< nothing: it obeys the rules of its `#version`, GLSL ES 1.00 and 3.00 among them
  kOpenGl,    ///< SPIR-V for OpenGL 4.5, from GLSL 3.30 or ES 3.10 on
  kVulkan,    ///< SPIR-V for Vulkan 1.0, from GLSL 1.40 or ES 3.10 on; no uniforms outside blocks but samplers
};

/// How a compiler or checker ended, and all that it printed. A line of a message names the line of the shader.
struct ShaderCheck {
  int exit_code = 0;  ///< 0: nothing to complain of
  std::string output;
};

/// glslangValidator on a whole shader, and spirv-val on what it makes of it. Locations and bindings that the shader
/// leaves open are chosen.
[[nodiscard]] ShaderCheck check_glsl(ShaderStage stage, const std::string& shader, ShaderTarget target);

/// The same for HLSL with this entry point; it is compiled to SPIR-V for Vulkan.
[[nodiscard]] ShaderCheck check_hlsl(ShaderStage stage, const std::string& shader, const std::string& entry = "main");

/// HLSL of shader model 5.0, by spirv-cross from the SPIR-V for Vulkan of a GLSL shader. kUsage with all that was
/// printed where one of the programs complains.
[[nodiscard]] Result<std::string> glsl_to_hlsl(ShaderStage stage, const std::string& shader);

/// What a fragment shader is made of once everything is inlined and folded: SPIR-V for Vulkan, as spirv-opt -O leaves
/// it.
struct ShaderCounts {
  std::size_t instructions = 0;  ///< without declarations and labels; a loop or a branch counts once
  std::size_t fetches = 0;       ///< those of them that read a texture
};
/// kUsage with all that was printed where one of the programs complains.
[[nodiscard]] Result<ShaderCounts> count_instructions(const std::string& fragment_shader);

/// Names of those programs that cannot be started, with blanks between; empty where all are there.
[[nodiscard]] std::string missing_shader_programs();

}  // namespace sbrdf::internal

/// Skips a test, or fails it where they are required, unless the programs that check shaders are there.
#define SBRDF_NEED_SHADER_PROGRAMS()                                                              \
  if (const std::string missing = ::sbrdf::internal::missing_shader_programs(); !missing.empty()) \
  SBRDF_MISSING_SHADER_TOOL("missing: " + missing + " (packages glslang-tools, spirv-tools, spirv-cross)")
