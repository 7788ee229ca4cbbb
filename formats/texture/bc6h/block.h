#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

// The parts of a BC6H block, and what they mean. Source of every table and rule here: the OpenGL extension
// ARB_texture_compression_bptc, appendix ("BPTC_FLOAT"); Direct3D 11 defines the same format as BC6H.

namespace sbrdf::internal {

/// One of the 14 ways to use the 128 bits of a block.
struct Bc6hMode {
  std::uint8_t number = 0;                   ///< what its mode bits say: two bits where it is below 2, else five
  bool transformed = false;                  ///< all endpoints but the first are stored as differences from the first
  std::uint8_t region_count = 1;             ///< 1, or 2 that a partition tells apart; each has two endpoints
  std::uint8_t endpoint_bits = 0;            ///< of each channel of the first endpoint, and of the others once summed
  std::array<std::uint8_t, 3> delta_bits{};  ///< of R, G and B of the other endpoints as they are stored
  const char* layout = nullptr;              ///< of the endpoints, from the bit behind the mode on; see Table.F

  [[nodiscard]] constexpr int index_count() const { return region_count == 2 ? 8 : 16; }
  [[nodiscard]] constexpr int mode_bits() const { return number < 2 ? 2 : 5; }
};

inline constexpr std::size_t kBc6hModeCount = 14;
inline constexpr std::size_t kBc6hPartitionCount = 32;

/// Two-region modes first.
extern const std::array<Bc6hMode, kBc6hModeCount> kBc6hModes;
/// Bit k of an entry is set where texel k (row by row) is in the second region.
extern const std::array<std::uint16_t, kBc6hPartitionCount> kBc6hPartitions;
/// The texel of the second region whose index has no top bit; in the first region it is texel 0.
extern const std::array<std::uint8_t, kBc6hPartitionCount> kBc6hAnchors;
/// How much of the second endpoint [1/64] each index means.
inline constexpr std::array<std::uint8_t, 8> kBc6hWeights3 = {0, 9, 18, 27, 37, 46, 55, 64};
inline constexpr std::array<std::uint8_t, 16> kBc6hWeights4 = {0,  4,  9,  13, 17, 21, 26, 30,
                                                               34, 38, 43, 47, 51, 55, 60, 64};

/// R, G and B of an endpoint: whole numbers of `endpoint_bits` bits, with a sign where the format is signed.
using Bc6hEndpoint = std::array<std::int32_t, 3>;

/// A block taken apart. Differences are summed up, so that all endpoints are of one kind.
struct Bc6hBlock {
  std::uint8_t mode = 0;       ///< position in kBc6hModes
  std::uint8_t partition = 0;  ///< position in kBc6hPartitions; 0 with one region
  /// Of the first region, then of the second.
  std::array<Bc6hEndpoint, 4> endpoints{};
  std::array<std::uint8_t, 16> indices{};  ///< of the texels, row by row
};

/// Nothing where the mode is one of the four that are reserved.
[[nodiscard]] std::optional<Bc6hBlock> parse_bc6h_block(std::span<const std::uint8_t, 16> bytes, bool is_signed);

/// The inverse. The endpoints have to fit (fits_bc6h), and anchors have indices in the lower half.
[[nodiscard]] std::array<std::uint8_t, 16> emit_bc6h_block(const Bc6hBlock& block);

/// Whether a mode can store these endpoints, as far as differences go.
[[nodiscard]] bool fits_bc6h(const Bc6hMode& mode, const std::array<Bc6hEndpoint, 4>& endpoints);

/// An endpoint's channel as a number on the scale on which colours are mixed: [0, 0xFFFF], or [-0x7FFF, 0x7FFF] signed
/// (-0x8000 with 16 bits).
[[nodiscard]] constexpr std::int32_t unquantise_bc6h(std::int32_t value, int endpoint_bits, bool is_signed) {
  if (endpoint_bits == 16 || value == 0) return value;
  const std::int32_t size = value < 0 ? -value : value;
  const std::int32_t last = (std::int32_t{1} << (is_signed ? endpoint_bits - 1 : endpoint_bits)) - 1;
  const std::int32_t largest = is_signed ? 0x7FFF : 0xFFFF;
  const std::int32_t scaled = size >= last ? largest : ((size << 15) + 0x4000) >> (endpoint_bits - 1);
  return value < 0 ? -scaled : scaled;
}

/// Two such numbers mixed. `weight`: of the second one [1/64].
[[nodiscard]] constexpr std::int32_t mix_bc6h(std::int32_t first, std::int32_t second, int weight) {
  return (first * (64 - weight) + second * weight + 32) >> 6;
}

/// What was mixed, as the bits of a half: 31/64 of it, or 31/32 and the sign. The size is at most 0x7BFF (65504);
/// -0x8000 alone becomes minus infinity. -1 becomes +0, as Direct3D says; the extension's words give -0.
[[nodiscard]] constexpr std::uint16_t finish_bc6h(std::int32_t mixed, bool is_signed) {
  if (!is_signed) return static_cast<std::uint16_t>(mixed * 31 >> 6);
  if (mixed >= 0) return static_cast<std::uint16_t>(mixed * 31 >> 5);
  const std::int32_t size = -mixed * 31 >> 5;
  return static_cast<std::uint16_t>(size == 0 ? 0 : 0x8000 | size);
}

}  // namespace sbrdf::internal
