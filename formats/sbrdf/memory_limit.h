#pragma once

#include <cstdint>
#include <optional>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// How much memory a file may ask for. A sample of a smooth material takes a hundredth of a bit, so that no rule of the
/// format keeps a file of 100 KB from stating more samples than a machine can hold. What a file needs follows from its
/// index; readers compare it with a limit before they allocate anything. specs/sbrdf.md, section 12.
///
/// By default the limit is 64 MiB and 1024 bytes for each byte stored. The most compressible materials that this
/// program writes (constant ones, or such with a precision of 50 %) need at most 85 % of that.
struct MemoryLimit {
  static constexpr std::uint64_t kAlways = std::uint64_t{64} << 20U;
  static constexpr std::uint64_t kPerByte = 1024;

  std::optional<std::uint64_t> bytes = {};  ///< instead of the default, whatever the size of the file

  /// For a file of which `stored_size` bytes are stored: its size, or what a bundle holds for it.
  [[nodiscard]] std::uint64_t of(std::uint64_t stored_size) const;
};

/// kUnsupported, with the limit that would do, where `needed` is more than `allowed` [bytes both].
[[nodiscard]] Status check_memory(double needed, std::uint64_t allowed);

}  // namespace sbrdf::internal
