#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// Where bytes of a new file go, in any order: what is written at an offset stays there. Ranges that nobody wrote are
/// zero up to the end of the last one. May be written to from several threads at once, at different offsets.
class ByteSink {
 public:
  ByteSink() = default;
  ByteSink(const ByteSink&) = delete;
  ByteSink& operator=(const ByteSink&) = delete;
  virtual ~ByteSink() = default;

  /// kIo where the operating system refuses.
  [[nodiscard]] virtual Status write(std::uint64_t offset, std::span<const std::byte> bytes) = 0;

  /// Where the file lies while it is written, for libraries that insist on opening it themselves; empty where it has no
  /// place. Whoever let one write there tells how large the file became: `write(size, {})`.
  [[nodiscard]] virtual std::string path() const { return {}; }
  /// A second file that belongs to this one and appears along with it: its name is that of this one followed by
  /// `suffix`, such as ".json". Lives as long as this. nullptr where there can be none; kIo as `write`.
  [[nodiscard]] virtual Result<ByteSink*> sibling(std::string_view /*suffix*/) { return nullptr; }
};

/// A file that stays in memory.
class MemorySink final : public ByteSink {
 public:
  [[nodiscard]] Status write(std::uint64_t offset, std::span<const std::byte> bytes) override {
    const std::scoped_lock lock(growing_);
    const auto first = static_cast<std::size_t>(offset);
    if (bytes_.size() < first + bytes.size()) bytes_.resize(first + bytes.size());
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(first));
    return ok_status();
  }
  [[nodiscard]] std::vector<std::byte> take() && { return std::move(bytes_); }

 private:
  std::mutex growing_;
  std::vector<std::byte> bytes_;
};

}  // namespace sbrdf::internal
