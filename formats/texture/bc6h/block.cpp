#include "formats/texture/bc6h/block.h"

#include <cassert>

namespace sbrdf::internal {

// Table.MF and Table.F of the extension. `r0[9:0]` stands for ten bits of the block, the first of which is bit 0 of red
// of the first endpoint; with the numbers the other way round the first one is the highest.
constexpr std::array<Bc6hMode, kBc6hModeCount> kModes = {{
    {0,
     true,
     2,
     10,
     {5, 5, 5},
     "g2[4] b2[4] b3[4] r0[9:0] g0[9:0] b0[9:0] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[4:0] b3[1] b2[3:0] "
     "r2[4:0] b3[2] r3[4:0] b3[3]"},
    {1,
     true,
     2,
     7,
     {6, 6, 6},
     "g2[5] g3[4] g3[5] r0[6:0] b3[0] b3[1] b2[4] g0[6:0] b2[5] b3[2] g2[4] b0[6:0] b3[3] b3[5] b3[4] r1[5:0] g2[3:0] "
     "g1[5:0] g3[3:0] b1[5:0] b2[3:0] r2[5:0] r3[5:0]"},
    {2,
     true,
     2,
     11,
     {5, 4, 4},
     "r0[9:0] g0[9:0] b0[9:0] r1[4:0] r0[10] g2[3:0] g1[3:0] g0[10] b3[0] g3[3:0] b1[3:0] b0[10] b3[1] b2[3:0] "
     "r2[4:0] b3[2] r3[4:0] b3[3]"},
    {6,
     true,
     2,
     11,
     {4, 5, 4},
     "r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10] g3[4] g2[3:0] g1[4:0] g0[10] g3[3:0] b1[3:0] b0[10] b3[1] b2[3:0] "
     "r2[3:0] b3[0] b3[2] r3[3:0] g2[4] b3[3]"},
    {10,
     true,
     2,
     11,
     {4, 4, 5},
     "r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10] b2[4] g2[3:0] g1[3:0] g0[10] b3[0] g3[3:0] b1[4:0] b0[10] b2[3:0] "
     "r2[3:0] b3[1] b3[2] r3[3:0] b3[4] b3[3]"},
    {14,
     true,
     2,
     9,
     {5, 5, 5},
     "r0[8:0] b2[4] g0[8:0] g2[4] b0[8:0] b3[4] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[4:0] b3[1] b2[3:0] "
     "r2[4:0] b3[2] r3[4:0] b3[3]"},
    {18,
     true,
     2,
     8,
     {6, 5, 5},
     "r0[7:0] g3[4] b2[4] g0[7:0] b3[2] g2[4] b0[7:0] b3[3] b3[4] r1[5:0] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[4:0] b3[1] "
     "b2[3:0] r2[5:0] r3[5:0]"},
    {22,
     true,
     2,
     8,
     {5, 6, 5},
     "r0[7:0] b3[0] b2[4] g0[7:0] g2[5] g2[4] b0[7:0] g3[5] b3[4] r1[4:0] g3[4] g2[3:0] g1[5:0] g3[3:0] b1[4:0] b3[1] "
     "b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]"},
    {26,
     true,
     2,
     8,
     {5, 5, 6},
     "r0[7:0] b3[1] b2[4] g0[7:0] b2[5] g2[4] b0[7:0] b3[5] b3[4] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[5:0] "
     "b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]"},
    {30,
     false,
     2,
     6,
     {6, 6, 6},
     "r0[5:0] g3[4] b3[0] b3[1] b2[4] g0[5:0] g2[5] b2[5] b3[2] g2[4] b0[5:0] g3[5] b3[3] b3[5] b3[4] r1[5:0] g2[3:0] "
     "g1[5:0] g3[3:0] b1[5:0] b2[3:0] r2[5:0] r3[5:0]"},
    {3, false, 1, 10, {10, 10, 10}, "r0[9:0] g0[9:0] b0[9:0] r1[9:0] g1[9:0] b1[9:0]"},
    {7, true, 1, 11, {9, 9, 9}, "r0[9:0] g0[9:0] b0[9:0] r1[8:0] r0[10] g1[8:0] g0[10] b1[8:0] b0[10]"},
    {11, true, 1, 12, {8, 8, 8}, "r0[9:0] g0[9:0] b0[9:0] r1[7:0] r0[10:11] g1[7:0] g0[10:11] b1[7:0] b0[10:11]"},
    {15, true, 1, 16, {4, 4, 4}, "r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10:15] g1[3:0] g0[10:15] b1[3:0] b0[10:15]"},
}};
const std::array<Bc6hMode, kBc6hModeCount> kBc6hModes = kModes;

// Table.P2, its first half; a row of texels is a digit, and the first texel its lowest bit.
const std::array<std::uint16_t, kBc6hPartitionCount> kBc6hPartitions = {
    0xCCCC, 0x8888, 0xEEEE, 0xECC8, 0xC880, 0xFEEC, 0xFEC8, 0xEC80, 0xC800, 0xFFEC, 0xFE80,
    0xE800, 0xFFE8, 0xFF00, 0xFFF0, 0xF000, 0xF710, 0x008E, 0x7100, 0x08CE, 0x008C, 0x7310,
    0x3100, 0x8CCE, 0x088C, 0x3110, 0x6666, 0x366C, 0x17E8, 0x0FF0, 0x718E, 0x399C};
// Table.A2, its first half.
const std::array<std::uint8_t, kBc6hPartitionCount> kBc6hAnchors = {
    15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2, 8, 2, 2, 8, 8, 15, 2, 8, 2, 2, 8, 8, 2, 2};

namespace {

constexpr int kPartitionBits = 5;
constexpr int kMostFieldBits = 75;

// Where a bit of the block belongs.
struct FieldBit {
  std::uint8_t endpoint = 0;
  std::uint8_t channel = 0;
  std::uint8_t bit = 0;
};

struct Layout {
  std::array<FieldBit, kMostFieldBits> bits{};
  int count = 0;
};

constexpr int number_at(const char*& at) {
  int number = 0;
  for (; *at >= '0' && *at <= '9'; ++at) number = 10 * number + (*at - '0');
  return number;
}

constexpr Layout parse_layout(const char* at) {
  Layout layout;
  while (*at != '\0') {
    FieldBit field;
    field.channel = static_cast<std::uint8_t>(*at == 'r' ? 0 : *at == 'g' ? 1 : 2);
    field.endpoint = static_cast<std::uint8_t>(at[1] - '0');
    at += 3;
    const int last = number_at(at);
    int first = last;
    if (*at == ':') first = number_at(++at);
    for (int bit = first;; bit += first < last ? 1 : -1) {
      field.bit = static_cast<std::uint8_t>(bit);
      layout.bits[static_cast<std::size_t>(layout.count++)] = field;
      if (bit == last) break;
    }
    while (*at == ']' || *at == ' ') ++at;
  }
  return layout;
}

constexpr std::array<Layout, kBc6hModeCount> parse_layouts() {
  std::array<Layout, kBc6hModeCount> layouts{};
  for (std::size_t k = 0; k < kBc6hModeCount; ++k) layouts[k] = parse_layout(kModes[k].layout);
  return layouts;
}
constexpr std::array<Layout, kBc6hModeCount> kLayouts = parse_layouts();

// Mode, endpoints, partition and indices fill the block.
constexpr bool blocks_are_full() {
  for (std::size_t k = 0; k < kBc6hModeCount; ++k) {
    const bool two = kModes[k].region_count == 2;
    const int index_bits = two ? 3 * 16 - 2 : 4 * 16 - 1;
    if (kModes[k].mode_bits() + kLayouts[k].count + (two ? kPartitionBits : 0) + index_bits != 128) return false;
  }
  return true;
}
static_assert(blocks_are_full());

// The bits of a block, the lowest bit of the first byte first.
class Bits {
 public:
  Bits() = default;
  explicit Bits(std::span<const std::uint8_t, 16> bytes) {
    for (std::size_t k = 0; k < 16; ++k) words_[k / 8] |= std::uint64_t{bytes[k]} << (8 * (k % 8));
  }
  std::uint32_t get(int count) {
    std::uint32_t value = 0;
    for (int bit = 0; bit < count; ++bit, ++at_) {
      value |= static_cast<std::uint32_t>(words_[at_ / 64] >> (at_ % 64) & 1) << bit;
    }
    return value;
  }
  void put(std::uint32_t value, int count) {
    for (int bit = 0; bit < count; ++bit, ++at_) {
      words_[at_ / 64] |= std::uint64_t{value >> bit & 1} << (at_ % 64);
    }
  }
  [[nodiscard]] std::array<std::uint8_t, 16> bytes() const {
    std::array<std::uint8_t, 16> bytes{};
    for (std::size_t k = 0; k < 16; ++k) bytes[k] = static_cast<std::uint8_t>(words_[k / 8] >> (8 * (k % 8)));
    return bytes;
  }

 private:
  std::array<std::uint64_t, 2> words_{};
  std::size_t at_ = 0;
};

std::optional<std::uint8_t> parse_mode(Bits& bits) {
  std::uint32_t number = bits.get(2);
  if (number >= 2) number |= bits.get(3) << 2;
  for (std::size_t k = 0; k < kBc6hModeCount; ++k) {
    if (kModes[k].number == number) return static_cast<std::uint8_t>(k);
  }
  return std::nullopt;
}

std::int32_t sign_extended(std::int32_t value, int bits) {
  const std::int32_t sign = std::int32_t{1} << (bits - 1);
  return ((value & (2 * sign - 1)) ^ sign) - sign;
}

// As stored -> all of one kind.
void sum_up(const Bc6hMode& mode, bool is_signed, std::array<Bc6hEndpoint, 4>& endpoints) {
  const std::int32_t mask = (std::int32_t{1} << mode.endpoint_bits) - 1;
  for (std::size_t e = 0; e < endpoints.size(); ++e) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      std::int32_t& value = endpoints[e][channel];
      if (mode.transformed && e > 0) {
        value = (endpoints[0][channel] + sign_extended(value, mode.delta_bits[channel])) & mask;
      }
      if (is_signed) value = sign_extended(value, mode.endpoint_bits);
    }
  }
}

int index_bits(const Bc6hMode& mode, int partition, std::size_t texel) {
  if (mode.region_count == 1) return texel == 0 ? 3 : 4;
  return texel == 0 || texel == kBc6hAnchors[static_cast<std::size_t>(partition)] ? 2 : 3;
}

}  // namespace

std::optional<Bc6hBlock> parse_bc6h_block(std::span<const std::uint8_t, 16> bytes, bool is_signed) {
  Bits bits(bytes);
  const std::optional<std::uint8_t> position = parse_mode(bits);
  if (!position) return std::nullopt;
  const Bc6hMode& mode = kModes[*position];
  const Layout& layout = kLayouts[*position];
  Bc6hBlock block;
  block.mode = *position;
  for (int k = 0; k < layout.count; ++k) {
    const FieldBit& field = layout.bits[static_cast<std::size_t>(k)];
    block.endpoints[field.endpoint][field.channel] |= static_cast<std::int32_t>(bits.get(1) << field.bit);
  }
  if (mode.region_count == 2) block.partition = static_cast<std::uint8_t>(bits.get(kPartitionBits));
  for (std::size_t texel = 0; texel < 16; ++texel) {
    block.indices[texel] = static_cast<std::uint8_t>(bits.get(index_bits(mode, block.partition, texel)));
  }
  sum_up(mode, is_signed, block.endpoints);
  return block;
}

std::array<std::uint8_t, 16> emit_bc6h_block(const Bc6hBlock& block) {
  const Bc6hMode& mode = kModes[block.mode];
  const Layout& layout = kLayouts[block.mode];
  assert(fits_bc6h(mode, block.endpoints));
  Bits bits;
  bits.put(mode.number, mode.mode_bits());
  for (int k = 0; k < layout.count; ++k) {
    const FieldBit& field = layout.bits[static_cast<std::size_t>(k)];
    std::int32_t value = block.endpoints[field.endpoint][field.channel];
    if (mode.transformed && field.endpoint > 0) value -= block.endpoints[0][field.channel];
    bits.put(static_cast<std::uint32_t>(value) >> field.bit & 1, 1);
  }
  if (mode.region_count == 2) bits.put(block.partition, kPartitionBits);
  for (std::size_t texel = 0; texel < 16; ++texel) {
    const int count = index_bits(mode, block.partition, texel);
    assert(block.indices[texel] >> count == 0);
    bits.put(block.indices[texel], count);
  }
  return bits.bytes();
}

bool fits_bc6h(const Bc6hMode& mode, const std::array<Bc6hEndpoint, 4>& endpoints) {
  if (!mode.transformed) return true;
  for (std::size_t e = 1; e < 2U * mode.region_count; ++e) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const std::int32_t limit = std::int32_t{1} << (mode.delta_bits[channel] - 1);
      const std::int32_t delta = endpoints[e][channel] - endpoints[0][channel];
      if (delta < -limit || delta >= limit) return false;
    }
  }
  return true;
}

}  // namespace sbrdf::internal
