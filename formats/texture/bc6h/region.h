#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <utility>

#include "formats/texture/bc6h/bc6h.h"
#include "formats/texture/bc6h/block.h"

// What an encoder is after, and how far two endpoints get there.

namespace sbrdf::internal {

/// A half on the scale on which errors are measured: an error is the squared difference of two such numbers. What the
/// metrics are is said here, in bc6h_metric_slope, and for several colours at once in make_palette (kernel.cpp).
[[nodiscard]] inline float bc6h_metric_value(Bc6hMetric metric, std::uint16_t half) {
  const bool negative = (half & 0x8000U) != 0;
  const std::uint32_t size = half & 0x7FFFU;
  // The exponent of a float is larger by 112; smaller halves have become denormal floats, which scales as well.
  const float value =
      metric == Bc6hMetric::kLog ? static_cast<float>(size) : std::bit_cast<float>(size << 13) * 0x1p112F;
  return negative ? -value : value;
}

/// By how much that number grows for each step of the half's bits, at a half.
[[nodiscard]] float bc6h_metric_slope(Bc6hMetric metric, std::uint16_t half);

/// One number for each texel of a region, or for each index.
using Bc6hRow = std::array<float, 16>;
/// The same for each channel.
using Bc6hRows = std::array<Bc6hRow, 3>;

/// Texels that share endpoints, laid side by side so that a loop may take eight at a time.
struct Bc6hRegion {
  std::size_t size = 0;
  std::size_t padded_size = 0;            ///< `size`, up to the next multiple of 8; what is behind weighs nothing
  std::array<std::uint8_t, 16> texels{};  ///< positions in the block; the anchor first
  Bc6hRows value{};                       ///< wanted, on the scale of the metric
  Bc6hRows mixed{};                       ///< wanted, on the scale on which colours are mixed
  Bc6hRows fit_weight{};                  ///< of squared differences of `mixed`, about as the metric sees them
  Bc6hRow weight{};                       ///< of squared differences of `value`
};

/// All texels of a block. `texels` hold finite halves, none below 0 where the format is not signed.
[[nodiscard]] Bc6hRegion make_bc6h_region(const Bc6hTexels& texels, const std::array<float, 16>& weights,
                                          const Bc6hOptions& options);

/// The two parts of a block.
[[nodiscard]] std::array<Bc6hRegion, 2> split_bc6h_region(const Bc6hRegion& whole, std::size_t partition);

/// How endpoints are turned into colours.
struct Bc6hScale {
  int endpoint_bits = 0;
  int index_count = 0;  ///< 8 or 16
  bool is_signed = false;
  Bc6hMetric metric = Bc6hMetric::kLog;

  [[nodiscard]] const std::uint8_t* weights() const {
    return index_count == 8 ? kBc6hWeights3.data() : kBc6hWeights4.data();
  }
};

}  // namespace sbrdf::internal
