#pragma once

#include <filesystem>
#include <string>

#include "formats/core/byte_source.h"

namespace sbrdf::internal {

/// SHA-256 of an ordinary file, 64 hexadecimal digits; empty where there is none at `path`, or it cannot be read twice.
[[nodiscard]] std::string sha256_of(const std::filesystem::path& path);

/// The same of bytes; empty where they cannot be read, or a signal came.
[[nodiscard]] std::string sha256_of(const ByteSource& bytes);

}  // namespace sbrdf::internal
