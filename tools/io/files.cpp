#include "tools/io/files.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "converters/source/progress.h"
#include "tools/console/interrupt.h"

namespace sbrdf {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;  // bytes between two looks at the interrupt

/// `what` and the reason that the operating system gave last.
Error system_error(const std::string& what) {
  if (errno == EINTR && interrupted()) return interrupted_error();
  return io_error(what + ": " + std::generic_category().message(errno));
}

/// An open file. close() tells whether the last bytes arrived; the destructor does not ask.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] bool close() { return ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

class MappedSource final : public ByteSource {
 public:
  MappedSource(void* first, std::size_t size) : first_(first), size_(size) {}
  ~MappedSource() override {
    if (size_ > 0) ::munmap(first_, size_);
  }
  MappedSource(const MappedSource&) = delete;
  MappedSource& operator=(const MappedSource&) = delete;

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    std::copy_n(static_cast<const std::byte*>(first_) + offset, target.size(), target.begin());
    return ok_status();
  }

 private:
  void* first_;
  std::size_t size_;
};

std::uint64_t largest_file() {
  const auto pages = sysconf(_SC_PHYS_PAGES);
  const auto page_size = sysconf(_SC_PAGESIZE);
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_size) / 2;
}

Error too_large(std::uint64_t size) {
  return io_error("too large to be read at once: " + std::to_string(size) + " bytes, half of the memory is " +
                  std::to_string(largest_file()));
}

/// Reads to the end, or to `bytes.size()` where the size is known.
Status read_all(int descriptor, std::vector<std::byte>& bytes, bool size_known) {
  std::size_t filled = 0;
  while (!size_known || filled < bytes.size()) {
    if (!wait_for_input(descriptor)) return interrupted_error();
    if (filled == bytes.size()) bytes.resize(std::max(kPiece, 2 * filled));
    const ssize_t got = ::read(descriptor, bytes.data() + filled, std::min(64 * kPiece, bytes.size() - filled));
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got < 0) return system_error("cannot be read");
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
    if (filled > largest_file()) return too_large(filled);
  }
  bytes.resize(filled);
  return ok_status();
}

/// The file that a write goes to: that of a symbolic link, where there is one.
std::filesystem::path resolved(const std::filesystem::path& path) {
  std::error_code error;
  auto target = std::filesystem::canonical(path, error);
  return error ? path : target;
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

Status check_folder(const std::filesystem::path& folder) {
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return system_error("the folder " + folder.string() + " cannot be used");
  if (!S_ISDIR(status.st_mode)) return io_error(folder.string() + " is not a folder");
  return ok_status();
}

/// A new file in `folder`, removed again unless it is renamed.
class TemporaryFile {
 public:
  TemporaryFile(const std::filesystem::path& folder, mode_t mode) {
    int number = -1;
    for (int attempt = 0; attempt < 1000 && number < 0; ++attempt) {
      path_ = (folder / (".sbrdf-" + std::to_string(getpid()) + "-" + std::to_string(attempt) + ".tmp")).string();
      number = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
      if (number < 0 && errno != EEXIST && errno != EINTR) break;
    }
    created_ = number >= 0;
    if (created_) remove_on_abort(path_.c_str());
    descriptor_.emplace(number);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (created_) ::unlink(path_.c_str());
    remove_on_abort(nullptr);
  }

  /// Otherwise errno tells why.
  [[nodiscard]] bool created() const { return created_; }
  [[nodiscard]] Descriptor& descriptor() { return *descriptor_; }

  [[nodiscard]] bool rename_to(const std::filesystem::path& path) {
    if (::rename(path_.c_str(), path.c_str()) != 0) return false;
    created_ = false;
    return true;
  }

 private:
  std::string path_;
  std::optional<Descriptor> descriptor_;
  bool created_ = false;
};

Status write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    if (interrupted()) return interrupted_error();
    const ssize_t put = ::write(descriptor, bytes.data(), std::min(kPiece, bytes.size()));
    if (put < 0 && errno == EINTR && !interrupted()) continue;
    if (put < 0) return system_error("cannot be written");
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return ok_status();
}

}  // namespace

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path) {
  struct stat status {};
  // Asked before opening: opening a device can already do something.
  if (::stat(path.c_str(), &status) != 0) return system_error("cannot be opened");
  if (S_ISDIR(status.st_mode)) return io_error("is a directory");
  if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode)) return io_error("is neither a file nor a pipe");
  // A pipe without a writer would hold up open() where no signal ends it.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) return system_error("cannot be opened");
  std::vector<std::byte> bytes;
  if (S_ISREG(status.st_mode)) {
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > largest_file()) return too_large(size);
    bytes.resize(size);
  }
  if (Status read = read_all(file.number(), bytes, S_ISREG(status.st_mode)); !read) return read.error();
  return bytes;
}

Result<std::unique_ptr<ByteSource>> map_file(const std::filesystem::path& path) {
  // A named pipe without a writer must not hold up the opening.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) return system_error("cannot be opened");
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return system_error("cannot be read");
  if (!S_ISREG(status.st_mode)) return io_error("is not an ordinary file");
  const auto size = static_cast<std::size_t>(status.st_size);
  void* first = size == 0 ? nullptr : ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.number(), 0);
  if (first == MAP_FAILED) return system_error("cannot be mapped");
  return std::unique_ptr<ByteSource>(std::make_unique<MappedSource>(first, size));
}

std::string sha256_of(const std::filesystem::path& path) {
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  if (!file) return {};
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  if (!context || EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) != 1) return {};
  std::vector<std::byte> piece;
  for (std::uint64_t offset = 0; offset < (*file)->size(); offset += piece.size()) {
    piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, (*file)->size() - offset)));
    if (!(*file)->read(offset, piece) || EVP_DigestUpdate(context.get(), piece.data(), piece.size()) != 1) return {};
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_DigestFinal_ex(context.get(), digest.data(), &size) != 1) return {};
  std::string text;
  for (unsigned k = 0; k < size; ++k) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    text += kDigits[digest[k] >> 4U];
    text += kDigits[digest[k] & 15U];
  }
  return text;
}

Status check_destination(const std::filesystem::path& path) {
  const auto target = resolved(path);
  struct stat status {};
  if (::stat(target.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) return io_error("is a directory");
    if (!S_ISREG(status.st_mode)) return io_error("exists and is not an ordinary file");
    if (::access(target.c_str(), W_OK) != 0) return system_error("cannot be written");
  }
  const auto folder = folder_of(target);
  if (Status usable = check_folder(folder); !usable) return usable.error();
  // Tried rather than asked: permissions are not all that can be in the way.
  const TemporaryFile probe(folder, S_IRUSR | S_IWUSR);
  if (!probe.created()) return system_error("no file can be made in the folder " + folder.string());
  return ok_status();
}

Status write_file_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const auto target = resolved(path);
  struct stat before {};
  const bool replaces = ::stat(target.c_str(), &before) == 0;
  if (replaces && !S_ISREG(before.st_mode)) return io_error("exists and is not an ordinary file");
  TemporaryFile file(folder_of(target), 0666);
  if (!file.created()) return system_error("cannot be written");
  const int number = file.descriptor().number();
  if (replaces && ::fchmod(number, before.st_mode & 07777U) != 0) return system_error("cannot be written");
  if (Status written = write_all(number, bytes); !written) return written.error();
  if (::fsync(number) != 0) return system_error("cannot be written");
  if (!file.descriptor().close()) return system_error("cannot be written");
  if (interrupted()) return interrupted_error();
  if (!file.rename_to(target)) return system_error("cannot be written");
  return ok_status();
}

}  // namespace sbrdf
