#include "tools/bench/machine.h"

#include <sys/utsname.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include <fmt/format.h>

#include "converters/bench/timing.h"
#include "tools/console/plain_text.h"

namespace sbrdf::internal {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return one_line(line.substr(colon + 2), 80);
  }
  struct utsname system {};
  return uname(&system) == 0 ? system.machine : "unknown processor";
}

std::string compiler_name() {
#if defined(__clang__)
  return fmt::format("clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#elif defined(__GNUC__)
  return fmt::format("g++ {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#else
  return "unknown compiler";
#endif
}

}  // namespace

std::string Machine::line() const {
  return fmt::format("{}, {} cores, {}, {} build, Highway {}, sbrdf {}", processor, cores, compiler, build, vectors,
                     version);
}

Machine this_machine() {
  const std::string build = SBRDF_BUILD_TYPE;
  return {processor_name(), std::max(std::thread::hardware_concurrency(), 1U),
          compiler_name(),  build.empty() ? "plain" : build,
          vector_target(),  SBRDF_VERSION};
}

}  // namespace sbrdf::internal
