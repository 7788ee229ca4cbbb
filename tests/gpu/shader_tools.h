#pragma once

#include <cstdlib>

#include <gtest/gtest.h>

namespace sbrdf::internal {

/// A missing driver or compiler of shaders fails a test rather than skips it: SBRDF_REQUIRE_SHADER_TOOLS is set in the
/// environment.
inline bool shader_tools_are_required() { return std::getenv("SBRDF_REQUIRE_SHADER_TOOLS") != nullptr; }

}  // namespace sbrdf::internal

/// Skips the test because of what is missing, or fails it where that is required.
#define SBRDF_MISSING_SHADER_TOOL(message)                                   \
  do {                                                                       \
    if (::sbrdf::internal::shader_tools_are_required()) FAIL() << (message); \
    GTEST_SKIP() << (message);                                               \
  } while (false)
