#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/byte_sink.h"
#include "formats/core/result.h"
#include "formats/os/descriptor.h"

namespace sbrdf::internal {

/// Whether a file that is being written has a name before it is complete.
enum class WhileWritten : std::uint8_t {
  kNameless,  ///< where the file system can (O_TMPFILE): whatever ends the program, SIGKILL included, the file is gone
  kNamed,     ///< .sbrdf-PID-N.tmp in the folder of the target; what a file system without O_TMPFILE gets
};

/// What a signal means for a file that is being written.
enum class AfterSignal : std::uint8_t {
  kStop,      ///< write() and commit() are the work that was to be interrupted
  kComplete,  ///< small files that say how far the work came: nothing is lost with them, so the disk is not waited for
};

/// Where a write to `path` goes: through symbolic links, also to a file that is still to be made. kIo where links go
/// round in circles.
[[nodiscard]] Result<std::filesystem::path> write_target(const std::filesystem::path& path);

/// The file that belongs to the one at `path` and has its name followed by `suffix`, read or written: beside the name
/// that was given if there is one already, else beside the file that a symbolic link leads to.
[[nodiscard]] std::filesystem::path sibling_path(const std::filesystem::path& path, std::string_view suffix);

/// A file that is there whole or not at all: bytes go to a new file in the folder of `path`, and commit() puts that in
/// the place of `path`. Without commit() nothing changes and nothing is left behind.
///
///   Result<std::unique_ptr<AtomicFile>> file = AtomicFile::create("material.sbrdf");
///   if (!file) return file.error();
///   if (Status written = (*file)->write(0, bytes); !written) return written.error();
///   return (*file)->commit();
class AtomicFile final : public ByteSink {
 public:
  /// Follows a symbolic link, also one to a file that is still to be made. kIo, with a message that says which it was:
  /// `path` is a directory, a device or pipe, or a file that may not be written; its folder is missing, is none, or
  /// takes no new files.
  [[nodiscard]] static Result<std::unique_ptr<AtomicFile>> create(const std::filesystem::path& path,
                                                                  WhileWritten kind = WhileWritten::kNameless,
                                                                  AfterSignal after_signal = AfterSignal::kStop);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile() override;

  /// From any number of threads at once. kIo where the operating system refuses, interrupted_error() after a signal
  /// that is to stop it.
  [[nodiscard]] Status write(std::uint64_t offset, std::span<const std::byte> bytes) override;

  /// Also of a file without a name: one by which this process can open it.
  [[nodiscard]] std::string path() const override;
  /// At sibling_path() of the path that was given. Gets its name in commit() of this one, just before.
  [[nodiscard]] Result<ByteSink*> sibling(std::string_view suffix) override;

  /// Waits for the disk (unless kComplete) and gives the file its name, with the permissions of the file that it
  /// replaces. Once, after all writing. kIo and interrupted_error() as for write(): what was at `path` is untouched
  /// then.
  [[nodiscard]] Status commit();

 private:
  AtomicFile(std::filesystem::path asked, std::filesystem::path target, Descriptor file, std::string name,
             AfterSignal after_signal);
  [[nodiscard]] bool publish();
  [[nodiscard]] bool stopped() const;

  std::filesystem::path asked_;   ///< the path that was given
  std::filesystem::path target_;  ///< where it leads
  Descriptor file_;
  std::string name_;  ///< of the temporary file, removed with this; empty where it has none
  std::vector<std::unique_ptr<AtomicFile>> siblings_;
  AfterSignal after_signal_ = AfterSignal::kStop;
};

/// Whether AtomicFile::create() succeeds now: for asking before long work. Leaves nothing behind.
[[nodiscard]] Status check_destination(const std::filesystem::path& path);

/// A whole file at once; see AtomicFile.
[[nodiscard]] Status write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes,
                                           AfterSignal after_signal = AfterSignal::kStop);

}  // namespace sbrdf::internal
