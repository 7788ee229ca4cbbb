#pragma once

#include <filesystem>
#include <string>

namespace sbrdf::internal {

/// SHA-256 of an ordinary file, 64 hexadecimal digits; empty where there is none at `path`, or it cannot be read twice.
[[nodiscard]] std::string sha256_of(const std::filesystem::path& path);

}  // namespace sbrdf::internal
