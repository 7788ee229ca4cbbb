#include "tests/gpu/shader_checks.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>

namespace sbrdf::internal {
namespace {

// Of a shell that knows no such program.
constexpr int kNotFound = 127;

class ScratchFolder {
 public:
  ScratchFolder() : path_((std::filesystem::temp_directory_path() / "sbrdf_shader_XXXXXX").string()) {
    if (mkdtemp(path_.data()) == nullptr) throw std::runtime_error("cannot make the folder " + path_);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  [[nodiscard]] std::string operator/(const char* name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

// The arguments are words of this file and paths of ScratchFolder, so nothing in them means anything to a shell.
ShaderCheck run(const std::string& command) {
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot start " + command);
  ShaderCheck check;
  std::array<char, 4096> block = {};
  for (std::size_t got = 1; got > 0;) {
    got = std::fread(block.data(), 1, block.size(), pipe);
    check.output.append(block.data(), got);
  }
  const int status = pclose(pipe);
  check.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return check;
}

const char* name_of(ShaderStage stage) {
  switch (stage) {
    case ShaderStage::kVertex:
      return "vert";
    case ShaderStage::kFragment:
      return "frag";
    case ShaderStage::kCompute:
      return "comp";
  }
  std::abort();
}

void write(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  if (!(file << text).flush()) throw std::runtime_error("cannot write " + path);
}

constexpr const char* kChosenPlaces = "--auto-map-locations --auto-map-bindings";

ShaderCheck compile(const ScratchFolder& folder, ShaderStage stage, const std::string& shader,
                    const std::string& options) {
  write(folder / "shader", shader);
  return run(fmt::format("glslangValidator -S {} {} {}", name_of(stage), options, folder / "shader"));
}

ShaderCheck compile_to_spirv(const ScratchFolder& folder, ShaderStage stage, const std::string& shader,
                             const std::string& options, const char* environment) {
  ShaderCheck compiled = compile(folder, stage, shader, fmt::format("{} -o {}", options, folder / "spirv"));
  if (compiled.exit_code != 0) return compiled;
  return run(fmt::format("spirv-val --target-env {} {}", environment, folder / "spirv"));
}

std::string vulkan_options() { return fmt::format("-V --target-env vulkan1.0 {}", kChosenPlaces); }

}  // namespace

ShaderCheck check_glsl(ShaderStage stage, const std::string& shader, ShaderTarget target) {
  const ScratchFolder folder;
  switch (target) {
    case ShaderTarget::kLanguage:
      return compile(folder, stage, shader, "");
    case ShaderTarget::kOpenGl:
      return compile_to_spirv(folder, stage, shader, fmt::format("-G --target-env opengl {}", kChosenPlaces),
                              "opengl4.5");
    case ShaderTarget::kVulkan:
      return compile_to_spirv(folder, stage, shader, vulkan_options(), "vulkan1.0");
  }
  std::abort();
}

ShaderCheck check_hlsl(ShaderStage stage, const std::string& shader, const std::string& entry) {
  const ScratchFolder folder;
  return compile_to_spirv(folder, stage, shader, fmt::format("-D -e {} {}", entry, vulkan_options()), "vulkan1.0");
}

Result<std::string> glsl_to_hlsl(ShaderStage stage, const std::string& shader) {
  const ScratchFolder folder;
  const ShaderCheck compiled = compile_to_spirv(folder, stage, shader, vulkan_options(), "vulkan1.0");
  if (compiled.exit_code != 0) return usage_error(compiled.output);
  const std::string hlsl = folder / "hlsl";
  const ShaderCheck translated =
      run(fmt::format("spirv-cross --hlsl --shader-model 50 --output {} {}", hlsl, folder / "spirv"));
  if (translated.exit_code != 0) return usage_error(translated.output);
  std::ifstream file(hlsl, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

Result<ShaderCounts> count_instructions(const std::string& fragment_shader) {
  const ScratchFolder folder;
  const ShaderCheck compiled =
      compile_to_spirv(folder, ShaderStage::kFragment, fragment_shader, vulkan_options(), "vulkan1.0");
  if (compiled.exit_code != 0) return usage_error(compiled.output);
  const ShaderCheck listed = run(fmt::format("spirv-opt -O {0} -o {0} && spirv-dis --raw-id {0}", folder / "spirv"));
  if (listed.exit_code != 0) return usage_error(listed.output);
  ShaderCounts counts;
  bool inside = false;
  std::istringstream lines(listed.output);
  for (std::string line; std::getline(lines, line);) {
    const auto has = [&](const char* word) { return line.find(word) != std::string::npos; };
    if (has("OpFunctionEnd")) inside = false;
    if (inside && !has("OpLabel") && !has("OpVariable")) ++counts.instructions;
    if (inside && (has("OpImageSample") || has("OpImageFetch"))) ++counts.fetches;
    if (has("= OpFunction ")) inside = true;
  }
  return counts;
}

std::string missing_shader_programs() {
  std::string missing;
  for (const char* program : {"glslangValidator --version", "spirv-val --version", "spirv-opt --version",
                              "spirv-dis --version", "spirv-cross --help"}) {
    const std::string command(program);
    if (run(command).exit_code != kNotFound) continue;
    missing += (missing.empty() ? "" : " ") + command.substr(0, command.find(' '));
  }
  return missing;
}

}  // namespace sbrdf::internal
