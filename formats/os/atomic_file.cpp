#include "formats/os/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "formats/core/interrupted.h"
#include "formats/os/interrupt.h"

namespace sbrdf::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = std::size_t{1} << 20U;  // bytes between two looks at the interrupt
constexpr int kMostLinks = 40;                         // as many as the kernel follows
constexpr int kMostNames = 1000;

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

Status check_target(const fs::path& target) {
  struct stat status {};
  if (::stat(target.c_str(), &status) != 0) {
    return errno == ENOENT || errno == ENOTDIR ? ok_status() : Status(system_error("cannot be written"));
  }
  if (S_ISDIR(status.st_mode)) return io_error("is a directory");
  if (!S_ISREG(status.st_mode)) return io_error("exists and is not an ordinary file");
  if (::access(target.c_str(), W_OK) != 0) return system_error("cannot be written");
  return ok_status();
}

Status check_folder(const fs::path& folder) {
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return system_error("the folder " + folder.string() + " cannot be used");
  if (!S_ISDIR(status.st_mode)) return io_error(folder.string() + " is not a folder");
  return ok_status();
}

std::string path_of(const Descriptor& file) { return "/proc/self/fd/" + std::to_string(file.number()); }

/// A file without a name; none where the file system has no such thing, or could not be asked for a name later.
Descriptor open_nameless(const fs::path& folder) {
  Descriptor file(::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666));
  if (file.number() < 0 || ::access(path_of(file).c_str(), F_OK) == 0) return file;
  return Descriptor(-1);
}

/// Calls `make` with names in `folder` until it succeeds; false, with errno, where it fails for another reason than a
/// name that is taken. The name is the one to be removed by a second signal.
template <class Make>
bool take_name(const fs::path& folder, std::string& name, const Make& make) {
  for (int k = 0; k < kMostNames; ++k) {
    name = (folder / (".sbrdf-" + std::to_string(getpid()) + "-" + std::to_string(k) + ".tmp")).string();
    if (make(name.c_str())) {
      remove_on_abort(name.c_str());
      return true;
    }
    if (errno != EEXIST) break;
  }
  name.clear();
  return false;
}

bool link_to(const Descriptor& file, const char* path) {
  return ::linkat(AT_FDCWD, path_of(file).c_str(), AT_FDCWD, path, AT_SYMLINK_FOLLOW) == 0;
}

}  // namespace

// The last link of a chain may point to a file that is not there yet, which std::filesystem::canonical refuses.
Result<fs::path> write_target(const fs::path& path) {
  fs::path at = path;
  for (int k = 0; k < kMostLinks; ++k) {
    std::error_code none;
    const fs::path target = fs::read_symlink(at, none);
    if (none) return at;
    at = target.is_absolute() ? target : folder_of(at) / target;
  }
  errno = ELOOP;
  return system_error("cannot be written");
}

fs::path sibling_path(const fs::path& path, std::string_view suffix) {
  fs::path beside = path.string() + std::string(suffix);
  std::error_code none;
  if (fs::exists(fs::symlink_status(beside, none))) return beside;
  const Result<fs::path> target = write_target(path);
  return target ? fs::path(target->string() + std::string(suffix)) : beside;
}

AtomicFile::AtomicFile(fs::path asked, fs::path target, Descriptor file, std::string name, AfterSignal after_signal)
    : asked_(std::move(asked)),
      target_(std::move(target)),
      file_(std::move(file)),
      name_(std::move(name)),
      after_signal_(after_signal) {
  // Short names live inside the string, which has moved.
  if (!name_.empty()) remove_on_abort(name_.c_str());
}

AtomicFile::~AtomicFile() {
  if (name_.empty()) return;
  ::unlink(name_.c_str());
  remove_on_abort(nullptr);
}

Result<std::unique_ptr<AtomicFile>> AtomicFile::create(const fs::path& path, WhileWritten kind,
                                                       AfterSignal after_signal) {
  Result<fs::path> target = write_target(path);
  if (!target) return target.error();
  if (Status free = check_target(*target); !free) return free.error();
  const fs::path folder = folder_of(*target);
  if (Status usable = check_folder(folder); !usable) return usable.error();
  std::string name;
  Descriptor file = kind == WhileWritten::kNameless ? open_nameless(folder) : Descriptor(-1);
  if (file.number() < 0) {
    int number = -1;
    const bool made = take_name(folder, name, [&number](const char* tried) {
      number = ::open(tried, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      return number >= 0;
    });
    if (!made) return system_error("no file can be made in the folder " + folder.string());
    return std::unique_ptr<AtomicFile>(
        new AtomicFile(path, *std::move(target), Descriptor(number), std::move(name), after_signal));
  }
  return std::unique_ptr<AtomicFile>(new AtomicFile(path, *std::move(target), std::move(file), {}, after_signal));
}

Status AtomicFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    if (stopped()) return interrupted_error();
    const ssize_t put =
        ::pwrite(file_.number(), bytes.data(), std::min(kPiece, bytes.size()), static_cast<off_t>(offset));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return system_error("cannot be written");
    offset += static_cast<std::uint64_t>(put);
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return ok_status();
}

std::string AtomicFile::path() const { return name_.empty() ? path_of(file_) : name_; }

Result<ByteSink*> AtomicFile::sibling(std::string_view suffix) {
  Result<std::unique_ptr<AtomicFile>> file =
      create(sibling_path(asked_, suffix), WhileWritten::kNameless, after_signal_);
  if (!file) return file.error();
  siblings_.push_back(*std::move(file));
  return siblings_.back().get();
}

Status AtomicFile::commit() {
  for (const auto& sibling : siblings_) {
    if (Status committed = sibling->commit(); !committed) return committed;
    if (!name_.empty()) remove_on_abort(name_.c_str());
  }
  struct stat before {};
  const bool replaces = ::stat(target_.c_str(), &before) == 0;
  if (replaces && !S_ISREG(before.st_mode)) return io_error("exists and is not an ordinary file");
  if (replaces && ::fchmod(file_.number(), before.st_mode & 07777U) != 0) return system_error("cannot be written");
  if (after_signal_ == AfterSignal::kStop && ::fsync(file_.number()) != 0) return system_error("cannot be written");
  if (stopped()) return interrupted_error();
  return publish() ? ok_status() : Status(system_error("cannot be written"));
}

bool AtomicFile::stopped() const { return after_signal_ == AfterSignal::kStop && interrupted(); }

bool AtomicFile::publish() {
  if (name_.empty()) {
    if (link_to(file_, target_.c_str())) return true;
    // No call puts a nameless file in the place of another: it gets a name for the moment until it is renamed.
    if (errno != EEXIST) return false;
    if (!take_name(folder_of(target_), name_, [this](const char* tried) { return link_to(file_, tried); }))
      return false;
  }
  if (::rename(name_.c_str(), target_.c_str()) != 0) return false;
  remove_on_abort(nullptr);
  name_.clear();
  return true;
}

Status check_destination(const fs::path& path) {
  const Result<std::unique_ptr<AtomicFile>> file = AtomicFile::create(path);
  return file ? ok_status() : Status(file.error());
}

Status write_file_atomically(const fs::path& path, std::span<const std::byte> bytes, AfterSignal after_signal) {
  const Result<std::unique_ptr<AtomicFile>> file = AtomicFile::create(path, WhileWritten::kNameless, after_signal);
  if (!file) return file.error();
  if (Status written = (*file)->write(0, bytes); !written) return written.error();
  return (*file)->commit();
}

}  // namespace sbrdf::internal
