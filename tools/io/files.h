#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf {

/// All bytes of a file or a named pipe. kIo, with a message that says which it was: missing, a directory, a device,
/// unreadable, larger than half of the machine's memory, or interrupted.
[[nodiscard]] Result<std::vector<std::byte>> read_file(const std::filesystem::path& path);

/// An ordinary file, mapped: only what is read comes from the disk. kIo as for read_file. A file that another program
/// makes shorter while it is mapped ends this one, so use it for files that are read in part.
[[nodiscard]] Result<std::unique_ptr<ByteSource>> map_file(const std::filesystem::path& path);

/// SHA-256 of an ordinary file, 64 hexadecimal digits; empty where there is none at `path`, or it cannot be read twice.
[[nodiscard]] std::string sha256_of(const std::filesystem::path& path);

/// Whether write_file_atomically can begin: the folder exists and takes new files, and what `path` names already, if
/// anything, is an ordinary file that may be written. For asking before long work. kIo otherwise.
[[nodiscard]] Status check_destination(const std::filesystem::path& path);

/// Writes to a temporary name in the same folder, waits for the disk, and renames: `path` is either untouched or
/// complete. Keeps the permissions of a file that it replaces, and follows a symbolic link. kIo where the operating
/// system refuses any of it, interrupted_error() after a signal; nothing is left behind then.
[[nodiscard]] Status write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace sbrdf
