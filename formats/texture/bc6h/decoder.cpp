#include "formats/texture/bc6h/bc6h.h"
#include "formats/texture/bc6h/block.h"

namespace sbrdf::internal {

Bc6hTexels decode_bc6h_block(std::span<const std::uint8_t, kBc6hBlockSize> bytes, bool is_signed) {
  Bc6hTexels texels{};
  const std::optional<Bc6hBlock> block = parse_bc6h_block(bytes, is_signed);
  if (!block) return texels;
  const Bc6hMode& mode = kBc6hModes[block->mode];
  std::array<Bc6hEndpoint, 4> ends = block->endpoints;
  for (Bc6hEndpoint& end : ends) {
    for (std::int32_t& value : end) value = unquantise_bc6h(value, mode.endpoint_bits, is_signed);
  }
  const unsigned second_region = mode.region_count == 2 ? kBc6hPartitions[block->partition] : 0U;
  for (std::size_t texel = 0; texel < texels.size(); ++texel) {
    const std::size_t first = 2 * (second_region >> texel & 1U);
    const int weight =
        mode.region_count == 2 ? kBc6hWeights3[block->indices[texel]] : kBc6hWeights4[block->indices[texel]];
    for (std::size_t channel = 0; channel < 3; ++channel) {
      texels[texel][channel] = finish_bc6h(mix_bc6h(ends[first][channel], ends[first + 1][channel], weight), is_signed);
    }
  }
  return texels;
}

}  // namespace sbrdf::internal
