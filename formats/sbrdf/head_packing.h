#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace sbrdf::internal {

// How the heads in a bundle are compressed, specs/sbrdfz.md, sections 3 and 4: one zstd frame each, without its magic
// number, and with a dictionary that all of them share.

/// Compresses heads with one dictionary, which may be empty. For one thread at a time.
class HeadPacker {
 public:
  explicit HeadPacker(std::span<const std::byte> dictionary);
  HeadPacker(const HeadPacker&) = delete;
  HeadPacker& operator=(const HeadPacker&) = delete;
  ~HeadPacker();

  /// The head as it is stored: `head` itself unless a frame is smaller, and not by more than readers accept.
  [[nodiscard]] std::vector<std::byte> pack(std::span<const std::byte> head);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

/// The least that a head of so many bytes may be compressed to: a 4096th, so that little bytes cannot ask for much
/// memory.
[[nodiscard]] constexpr std::size_t least_stored_size(std::size_t head_size) { return (head_size + 4095) / 4096; }

/// The inverse for a frame: nothing unless it holds exactly `size` bytes, which is all that is allocated.
[[nodiscard]] std::optional<std::vector<std::byte>> unpack_head(std::span<const std::byte> frame, std::size_t size,
                                                                std::span<const std::byte> dictionary);

/// The dictionary with which these heads and itself are smallest; empty where none pays. Depends on nothing but the
/// heads, their order, and the version of zstd.
[[nodiscard]] std::vector<std::byte> choose_dictionary(std::span<const std::vector<std::byte>> heads);

}  // namespace sbrdf::internal
