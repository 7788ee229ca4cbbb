#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// Bytes that can be read a range at a time: a file in memory, a mapped file, a connection. All members may be called
/// from several threads at once.
class ByteSource {
 public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  virtual ~ByteSource() = default;

  /// Of the whole source [bytes].
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// How many bytes are stored for it: fewer than size() where some are unpacked or follow from others. What a file may
  /// ask for goes by this.
  [[nodiscard]] virtual std::uint64_t stored_size() const { return size(); }
  /// Fills `target` with the bytes from `offset` on; the range lies within `size()`.
  [[nodiscard]] virtual Status read(std::uint64_t offset, std::span<std::byte> target) const = 0;

  /// All bytes where they have an address, in memory or mapped, so that a reader of large files needs no copy; valid
  /// for as long as the source. Nothing where reading is the only way.
  [[nodiscard]] virtual std::optional<std::span<const std::byte>> view() const { return std::nullopt; }
  /// Where the file lies, for libraries that insist on opening it themselves; empty for bytes that are no whole file.
  [[nodiscard]] virtual std::string path() const { return {}; }
  /// The file that belongs to this one and has its name followed by `suffix`, such as ".json"; nullptr where there is
  /// none, or for bytes that are no file. kIo where it cannot be read.
  [[nodiscard]] virtual Result<std::shared_ptr<const ByteSource>> sibling(std::string_view /*suffix*/) const {
    return std::shared_ptr<const ByteSource>();
  }
  /// The file `name` in the folder of this one: a name without separators; nullptr and errors as of sibling().
  [[nodiscard]] virtual Result<std::shared_ptr<const ByteSource>> neighbour(const std::string& /*name*/) const {
    return std::shared_ptr<const ByteSource>();
  }
};

/// Bytes that somebody else keeps, at least for as long as this lives: a file read whole, or mapped.
class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), target.size(), target.begin());
    return ok_status();
  }
  [[nodiscard]] std::optional<std::span<const std::byte>> view() const override { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

/// Bytes of its own.
class OwnedMemorySource : public ByteSource {
 public:
  /// `path` is that of the file that they were read from; may be empty.
  explicit OwnedMemorySource(std::vector<std::byte> bytes, std::string path = {})
      : bytes_(std::move(bytes)), path_(std::move(path)) {}

  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    return MemorySource(bytes_).read(offset, target);
  }
  [[nodiscard]] std::optional<std::span<const std::byte>> view() const override { return bytes_; }
  [[nodiscard]] std::string path() const override { return path_; }

 private:
  std::vector<std::byte> bytes_;
  std::string path_;
};

/// Any way to get at a range of bytes, such as a request over a network.
class CallbackSource final : public ByteSource {
 public:
  using Read = std::function<Status(std::uint64_t offset, std::span<std::byte> target)>;
  CallbackSource(std::uint64_t size, Read read) : size_(size), read_(std::move(read)) {}

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> target) const override {
    return read_(offset, target);
  }

 private:
  std::uint64_t size_;
  Read read_;
};

/// A range of a source, copied.
[[nodiscard]] inline Result<std::vector<std::byte>> read_range(const ByteSource& source, std::uint64_t offset,
                                                               std::uint64_t size) {
  if (offset > source.size() || size > source.size() - offset) {
    return invalid_file("truncated: the file ends early", source.size());
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  if (Status status = source.read(offset, bytes); !status) return status.error();
  return bytes;
}

/// The first `size` bytes, or all where there are fewer.
[[nodiscard]] inline Result<std::vector<std::byte>> read_start(const ByteSource& source, std::uint64_t size) {
  return read_range(source, 0, std::min(size, source.size()));
}

/// The source itself where it has a view, else its bytes read into memory once. For formats whose readers go back and
/// forth: the span is view() of what is returned.
[[nodiscard]] inline Result<std::shared_ptr<const ByteSource>> with_view(std::shared_ptr<const ByteSource> source) {
  if (source->view()) return source;
  Result<std::vector<std::byte>> bytes = read_range(*source, 0, source->size());
  if (!bytes) return bytes.error();
  return std::shared_ptr<const ByteSource>(
      std::make_shared<OwnedMemorySource>(std::move(bytes).value(), source->path()));
}

}  // namespace sbrdf::internal
