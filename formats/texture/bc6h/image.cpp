#include <algorithm>
#include <cassert>
#include <string>

#include "formats/core/half.h"
#include "formats/core/parallel.h"
#include "formats/texture/bc6h/bc6h.h"

namespace sbrdf::internal {

std::vector<std::uint8_t> encode_bc6h(std::uint32_t width, std::uint32_t height, std::span<const float> rgb,
                                      std::span<const float> weights, const Bc6hOptions& options) {
  assert(width % 4 == 0 && height % 4 == 0 && rgb.size() == 3 * std::size_t{width} * height);
  assert(weights.empty() || weights.size() == std::size_t{width} * height);
  std::vector<std::uint8_t> bytes(bc6h_size(width, height));
  for_all(bytes.size() / kBc6hBlockSize, 16, [&](std::size_t block) {
    const std::size_t x = block % (width / 4) * 4;
    const std::size_t y = block / (width / 4) * 4;
    Bc6hTexels texels{};
    std::array<float, 16> block_weights{};
    for (std::size_t k = 0; k < 16; ++k) {
      const std::size_t texel = (y + k / 4) * width + x + k % 4;
      for (std::size_t c = 0; c < 3; ++c) texels[k][c] = half_from_float(rgb[3 * texel + c]);
      block_weights[k] = weights.empty() ? 1.0F : weights[texel];
    }
    const Bc6hBytes encoded = encode_bc6h_block(texels, block_weights, options);
    std::copy(encoded.begin(), encoded.end(), bytes.begin() + static_cast<std::ptrdiff_t>(block * kBc6hBlockSize));
  });
  return bytes;
}

Result<std::vector<float>> decode_bc6h(std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> bytes,
                                       bool is_signed) {
  if (width == 0 || height == 0 || width % 4 != 0 || height % 4 != 0) {
    return invalid_file("a BC6H image of " + std::to_string(width) + " x " + std::to_string(height) +
                        " texels; sides must be multiples of 4, and not 0");
  }
  if (bytes.size() != bc6h_size(width, height)) {
    return invalid_file("a BC6H image of " + std::to_string(width) + " x " + std::to_string(height) + " texels needs " +
                            std::to_string(bc6h_size(width, height)) + " bytes, there are " +
                            std::to_string(bytes.size()),
                        std::min<std::uint64_t>(bytes.size(), bc6h_size(width, height)));
  }
  std::vector<float> rgb(3 * std::size_t{width} * height);
  for_all(bytes.size() / kBc6hBlockSize, 256, [&](std::size_t block) {
    const std::size_t x = block % (width / 4) * 4;
    const std::size_t y = block / (width / 4) * 4;
    const Bc6hTexels texels =
        decode_bc6h_block(bytes.subspan(block * kBc6hBlockSize).first<kBc6hBlockSize>(), is_signed);
    for (std::size_t k = 0; k < 16; ++k) {
      const std::size_t texel = (y + k / 4) * width + x + k % 4;
      for (std::size_t c = 0; c < 3; ++c) rgb[3 * texel + c] = float_from_half(texels[k][c]);
    }
  });
  return rgb;
}

}  // namespace sbrdf::internal
