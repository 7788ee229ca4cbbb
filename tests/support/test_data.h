#pragma once

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {

/// Where the measured files lie: the folder that the environment variable SBRDF_TEST_DATA names, else the one that the
/// build was made with.
inline std::filesystem::path test_data_folder() {
  const char* named = std::getenv("SBRDF_TEST_DATA");
  return named != nullptr && *named != '\0' ? named : SBRDF_DEFAULT_TEST_DATA;
}

/// A missing folder fails a test rather than skips it: SBRDF_REQUIRE_TEST_DATA is set in the environment.
inline bool test_data_is_required() { return std::getenv("SBRDF_REQUIRE_TEST_DATA") != nullptr; }

/// The file of that name in the folder, or nothing where there is none.
inline std::optional<std::filesystem::path> test_data(std::string_view relative) {
  std::filesystem::path path = test_data_folder() / relative;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  return path;
}

/// The whole file. Throws where it cannot be read, which fails the test.
inline std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (size < 0) throw std::runtime_error("cannot open " + path.string());
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), size)) throw std::runtime_error("cannot read " + path.string());
  return bytes;
}

}  // namespace sbrdf::internal

/// Defines the path `variable` for a test that needs a measured file. Without the folder the test is skipped, or fails
/// where the data are required; a folder that lacks the file always fails.
#define SBRDF_FIND_TEST_DATA(variable, relative)                                                                   \
  const std::filesystem::path variable = ::sbrdf::internal::test_data(relative).value_or(std::filesystem::path()); \
  if (variable.empty()) {                                                                                          \
    const std::filesystem::path folder = ::sbrdf::internal::test_data_folder();                                    \
    if (std::filesystem::exists(folder)) FAIL() << (relative) << " is missing from " << folder;                    \
    if (::sbrdf::internal::test_data_is_required()) FAIL() << "no test data: " << folder << " does not exist";     \
    GTEST_SKIP() << "no test data: " << folder << " does not exist; name another folder by SBRDF_TEST_DATA";       \
  }                                                                                                                \
  static_assert(true)
