#include "formats/os/files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "formats/core/interrupted.h"
#include "formats/os/descriptor.h"
#include "formats/os/interrupt.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;  // bytes between two looks at the interrupt

Result<std::shared_ptr<const ByteSource>> open_sibling(const std::string& path, std::string_view suffix) {
  const std::filesystem::path name = sibling_path(path, suffix);
  if (!is_ordinary_file(name)) return std::shared_ptr<const ByteSource>();
  return open_file(name);
}

Result<std::shared_ptr<const ByteSource>> open_neighbour(const std::string& path, const std::string& name) {
  const std::filesystem::path beside = std::filesystem::path(path).parent_path() / name;
  if (!is_ordinary_file(beside)) return std::shared_ptr<const ByteSource>();
  return open_file(beside);
}

/// Bytes that were read. Not zeroed before, as those of a vector: that takes half as long as reading them.
struct ReadBytes {
  std::unique_ptr<std::byte[]> first;
  std::size_t size = 0;

  /// Room for `capacity` bytes, of which the first `size` stay.
  void grow(std::size_t capacity) {
    auto larger = std::make_unique_for_overwrite<std::byte[]>(capacity);
    std::copy_n(first.get(), size, larger.get());
    first = std::move(larger);
  }
};

/// A file read whole.
class ReadSource final : public ByteSource {
 public:
  ReadSource(ReadBytes bytes, std::string path) : bytes_(std::move(bytes)), path_(std::move(path)) {}

  [[nodiscard]] std::uint64_t size() const override { return bytes_.size; }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    return MemorySource(*view()).read(offset, target);
  }
  [[nodiscard]] std::optional<std::span<const std::byte>> view() const override {
    return std::span<const std::byte>(bytes_.first.get(), bytes_.size);
  }
  [[nodiscard]] std::string path() const override { return path_; }
  [[nodiscard]] Result<std::shared_ptr<const ByteSource>> sibling(std::string_view suffix) const override {
    return open_sibling(path_, suffix);
  }
  [[nodiscard]] Result<std::shared_ptr<const ByteSource>> neighbour(const std::string& name) const override {
    return open_neighbour(path_, name);
  }

 private:
  ReadBytes bytes_;
  std::string path_;
};

class MappedSource final : public ByteSource {
 public:
  MappedSource(Descriptor file, void* first, std::size_t size, std::string path)
      : file_(std::move(file)), first_(first), size_(size), path_(std::move(path)) {}
  ~MappedSource() override {
    if (size_ > 0) ::munmap(first_, size_);
  }
  MappedSource(const MappedSource&) = delete;
  MappedSource& operator=(const MappedSource&) = delete;

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  // Not through the mapping: who reads a large file from one end to the other would have all of it counted as memory.
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    while (!target.empty()) {
      const ssize_t got = ::pread(file_.number(), target.data(), target.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return system_error("cannot be read");
      if (got == 0) return io_error("became shorter while it was read");
      offset += static_cast<std::uint64_t>(got);
      target = target.subspan(static_cast<std::size_t>(got));
    }
    return ok_status();
  }
  [[nodiscard]] std::optional<std::span<const std::byte>> view() const override {
    return std::span(static_cast<const std::byte*>(first_), size_);
  }
  [[nodiscard]] std::string path() const override { return path_; }
  [[nodiscard]] Result<std::shared_ptr<const ByteSource>> sibling(std::string_view suffix) const override {
    return open_sibling(path_, suffix);
  }
  [[nodiscard]] Result<std::shared_ptr<const ByteSource>> neighbour(const std::string& name) const override {
    return open_neighbour(path_, name);
  }

 private:
  Descriptor file_;
  void* first_;
  std::size_t size_;
  std::string path_;
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

/// The reason that errno gives, told of the file that is missing where a link leads nowhere.
Error cannot_be_opened(const std::filesystem::path& path) {
  const bool missing = errno == ENOENT;
  const Error error = system_error("cannot be opened");
  std::error_code none;
  const std::filesystem::path target = std::filesystem::read_symlink(path, none);
  return none || !missing ? error : io_error("is a link to " + target.string() + ", which is not there");
}

/// Reads to the end, or to `capacity` where the size is known.
Status read_all(int descriptor, std::size_t capacity, bool size_known, ReadBytes& bytes) {
  bytes.grow(capacity);
  while (!size_known || bytes.size < capacity) {
    if (!wait_for_input(descriptor)) return interrupted_error();
    if (bytes.size == capacity) bytes.grow(capacity = std::max(kPiece, 2 * capacity));
    const ssize_t got =
        ::read(descriptor, bytes.first.get() + bytes.size, std::min(64 * kPiece, capacity - bytes.size));
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got < 0) return system_error("cannot be read");
    if (got == 0) break;
    bytes.size += static_cast<std::size_t>(got);
    if (bytes.size > largest_file()) return too_large(bytes.size);
  }
  return ok_status();
}

/// All bytes of a file or a named pipe.
Result<ReadBytes> read_file(const std::filesystem::path& path) {
  struct stat status {};
  // Asked before opening: opening a device can already do something.
  if (::stat(path.c_str(), &status) != 0) return cannot_be_opened(path);
  if (S_ISDIR(status.st_mode)) return io_error("is a directory");
  if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode)) return io_error("is neither a file nor a pipe");
  // A pipe without a writer would hold up open() where no signal ends it.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) return cannot_be_opened(path);
  std::size_t size = 0;
  if (S_ISREG(status.st_mode)) {
    size = static_cast<std::size_t>(status.st_size);
    if (size > largest_file()) return too_large(size);
  }
  ReadBytes bytes;
  if (Status read = read_all(file.number(), size, S_ISREG(status.st_mode), bytes); !read) return read.error();
  return bytes;
}

}  // namespace

Result<std::unique_ptr<ByteSource>> map_file(const std::filesystem::path& path) {
  // A named pipe without a writer must not hold up the opening.
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) return cannot_be_opened(path);
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return system_error("cannot be read");
  if (!S_ISREG(status.st_mode)) return io_error("is not an ordinary file");
  const auto size = static_cast<std::size_t>(status.st_size);
  void* first = size == 0 ? nullptr : ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.number(), 0);
  if (first == MAP_FAILED) return system_error("cannot be mapped");
  return std::unique_ptr<ByteSource>(std::make_unique<MappedSource>(std::move(file), first, size, path.string()));
}

Result<std::shared_ptr<const ByteSource>> open_file(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) &&
      static_cast<std::uint64_t>(status.st_size) > kMapFrom) {
    Result<std::unique_ptr<ByteSource>> mapped = map_file(path);
    if (!mapped) return mapped.error();
    return std::shared_ptr<const ByteSource>(*std::move(mapped));
  }
  Result<ReadBytes> bytes = read_file(path);
  if (!bytes) return bytes.error();
  return std::shared_ptr<const ByteSource>(std::make_shared<ReadSource>(*std::move(bytes), path.string()));
}

bool exists(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

bool is_ordinary_file(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

std::string extension_of(const std::string& name) { return std::filesystem::path(name).extension().string(); }

}  // namespace sbrdf::internal
