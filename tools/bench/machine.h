#pragma once

#include <cstdint>
#include <string>

namespace sbrdf::internal {

/// What figures were measured on and with.
struct Machine {
  std::string processor;  ///< as the operating system names it
  std::uint64_t cores = 0;
  std::string compiler;  ///< "g++ 12.2.0"
  std::string build;     ///< "Release"
  std::string vectors;   ///< Highway's name of the set of instructions that is used
  std::string version;   ///< of this program

  /// All of it on one line.
  [[nodiscard]] std::string line() const;
};

[[nodiscard]] Machine this_machine();

}  // namespace sbrdf::internal
