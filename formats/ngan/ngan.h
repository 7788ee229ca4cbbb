#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// Sixteen int32, of which seven are used.
inline constexpr std::size_t kNganHeaderSize = 64;
/// Largest count of bins along one axis that is read or written; published files have at most 180.
inline constexpr std::uint32_t kNganMaxCount = 4096;
/// Largest count of channels that is read or written; published files have 3.
inline constexpr std::uint32_t kNganMaxChannels = 1024;

/// What a table begins with (specs/ngan.md): an anisotropic one over bins of the angles themselves. float32 values
/// follow, one for each bin and channel.
struct NganHeader {
  /// Bins along theta_in, theta_out, phi_diff = phi_out - phi_in, and phi_in: 1 to kNganMaxCount each.
  std::array<std::uint32_t, 4> counts = {1, 1, 1, 1};
  bool half = false;           ///< phi_diff covers 0 to 180 degrees, not the full turn
  std::uint32_t channels = 3;  ///< 1 to kNganMaxChannels
};

/// Bins of one channel.
[[nodiscard]] constexpr std::uint64_t ngan_bin_count(const NganHeader& header) {
  const auto& n = header.counts;
  return std::uint64_t{n[0]} * n[1] * n[2] * n[3];
}
/// Position of a bin within its channel: phi_in is fastest, theta_in slowest.
[[nodiscard]] constexpr std::uint64_t ngan_bin_index(const NganHeader& header, std::uint64_t theta_in,
                                                     std::uint64_t theta_out, std::uint64_t phi_diff,
                                                     std::uint64_t phi_in) {
  const auto& n = header.counts;
  return phi_in + n[3] * (phi_diff + n[2] * (theta_out + n[1] * theta_in));
}
/// Bytes of the file. Cannot wrap for counts and channels up to their largest.
[[nodiscard]] constexpr std::uint64_t ngan_file_size(const NganHeader& header) {
  return kNganHeaderSize + sizeof(float) * header.channels * ngan_bin_count(header);
}

/// The header of a file, from its first bytes (kNganHeaderSize suffice) and its whole size. kInvalidFile where it is
/// cut off, where a count, the number of channels or the mark of half data is out of range, or where the size is not
/// exactly the one that it asks for; kUnsupported for another parameterisation or binning than the published ones.
[[nodiscard]] Result<NganHeader> parse_ngan_header(std::span<const std::byte> head, std::uint64_t file_size);

/// The file has such a header and exactly the size that it asks for.
[[nodiscard]] bool recognises_ngan(std::span<const std::byte> head, std::uint64_t file_size);

/// The file begins with such a header, whatever its size: no table of another format here does.
[[nodiscard]] bool resembles_ngan(std::span<const std::byte> head);

/// What a file begins with; reserved numbers are 0.
[[nodiscard]] std::array<std::byte, kNganHeaderSize> emit_ngan_header(const NganHeader& header);

}  // namespace sbrdf::internal
