#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/core/byte_source.h"
#include "formats/core/result.h"
#include "formats/os/atomic_file.h"  // IWYU pragma: export

namespace sbrdf::internal {

/// An ordinary file, mapped: only what is read comes from the disk. kIo as for open_file. A file that another program
/// makes shorter while it is mapped ends this one, so use it for files that are read in part.
[[nodiscard]] Result<std::unique_ptr<ByteSource>> map_file(const std::filesystem::path& path);

/// What is larger is mapped by open_file [bytes].
inline constexpr std::uint64_t kMapFrom = std::uint64_t{1} << 26U;

/// The bytes of a file or a named pipe, to be kept: read into memory, where nobody can make them fewer, but mapped
/// where an ordinary file is larger than kMapFrom; any size of one will do. kIo, with a message that says which it was:
/// missing, a directory, a device, unreadable, a pipe that gives more than half of the machine's memory, or
/// interrupted.
[[nodiscard]] Result<std::shared_ptr<const ByteSource>> open_file(const std::filesystem::path& path);

/// What a name stands for: anything at all, or an ordinary file.
[[nodiscard]] bool exists(const std::filesystem::path& path);
[[nodiscard]] bool is_ordinary_file(const std::filesystem::path& path);

/// The extension of a name with its dot, such as ".sbrdf".
[[nodiscard]] std::string extension_of(const std::string& name);

}  // namespace sbrdf::internal
