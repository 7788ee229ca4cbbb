#include "formats/texture/ktx2_descriptor.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "formats/core/byte_reader.h"

namespace sbrdf::internal {
namespace {

constexpr std::array kFormats = {
    Ktx2Format{TexelFormat::kRgba16f, 97, 2},     Ktx2Format{TexelFormat::kRgba32f, 109, 4},
    Ktx2Format{TexelFormat::kE5b9g9r9, 123, 4},   Ktx2Format{TexelFormat::kBc6hUnsigned, 143, 1},
    Ktx2Format{TexelFormat::kBc6hSigned, 144, 1},
};

// Khronos Data Format Specification 1.3, section 5: fields of a basic descriptor block and their values.
constexpr std::uint16_t kKhronos = 0;
constexpr std::uint16_t kBasicBlock = 0;
constexpr std::uint16_t kVersion = 2;
constexpr std::size_t kBlockSize = 24;
constexpr std::size_t kSampleSize = 16;
constexpr std::uint8_t kModelRgb = 1;
constexpr std::uint8_t kModelBc6h = 133;
constexpr std::uint8_t kBt709 = 1;
constexpr std::uint8_t kLinear = 1;
constexpr std::uint8_t kAlpha = 15;
constexpr std::uint8_t kExponent = 0x20;
constexpr std::uint8_t kSigned = 0x40;
constexpr std::uint8_t kFloat = 0x80;

struct Sample {
  std::uint16_t bit_offset;
  std::uint8_t bit_length;
  std::uint8_t channel;  ///< with its qualifiers
  std::uint32_t lower;
  std::uint32_t upper;
};

std::uint32_t bits_of(float value) { return std::bit_cast<std::uint32_t>(value); }

std::vector<Sample> float_samples(unsigned bits) {
  std::vector<Sample> samples;
  for (unsigned c = 0; c < 4; ++c) {
    const auto channel = static_cast<std::uint8_t>((c < 3 ? c : kAlpha) | kFloat | kSigned);
    samples.push_back({static_cast<std::uint16_t>(c * bits), static_cast<std::uint8_t>(bits), channel, bits_of(-1.0F),
                       bits_of(1.0F)});
  }
  return samples;
}

std::vector<Sample> shared_exponent_samples() {
  std::vector<Sample> samples;
  for (unsigned c = 0; c < 3; ++c) {
    samples.push_back({static_cast<std::uint16_t>(9 * c), 9, static_cast<std::uint8_t>(c), 0, 8448});
    samples.push_back({27, 5, static_cast<std::uint8_t>(c | kExponent), 15, 31});
  }
  return samples;
}

std::vector<Sample> samples_of(TexelFormat format) {
  switch (format) {
    case TexelFormat::kRgba32f:
      return float_samples(32);
    case TexelFormat::kRgba16f:
      return float_samples(16);
    case TexelFormat::kE5b9g9r9:
      return shared_exponent_samples();
    case TexelFormat::kBc6hUnsigned:
      return {{0, 128, kFloat, bits_of(0.0F), bits_of(1.0F)}};
    case TexelFormat::kBc6hSigned:
      return {{0, 128, kFloat | kSigned, bits_of(-1.0F), bits_of(1.0F)}};
    case TexelFormat::kRgb32f:
      break;
  }
  return {};
}

template <class Choose>
std::optional<Ktx2Format> found(const Choose& choose) {
  const auto* const row = std::find_if(kFormats.begin(), kFormats.end(), choose);
  if (row == kFormats.end()) return std::nullopt;
  return *row;
}

std::vector<std::byte> emit_descriptor(const std::vector<Sample>& samples, const TexelBlock& block) {
  const std::size_t size = kBlockSize + samples.size() * kSampleSize;
  ByteWriter out;
  out.number(static_cast<std::uint32_t>(sizeof(std::uint32_t) + size));
  out.number(kKhronos);
  out.number(kBasicBlock);
  out.number(kVersion);
  out.number(static_cast<std::uint16_t>(size));
  out.number(block.side > 1 ? kModelBc6h : kModelRgb);
  out.number(kBt709);
  out.number(kLinear);
  out.number(std::uint8_t{0});  // straight alpha
  const auto last = static_cast<std::uint8_t>(block.side - 1);
  for (const std::uint8_t side : {last, last, std::uint8_t{0}, std::uint8_t{0}}) out.number(side);
  out.number(std::uint64_t{block.bytes});  // of the first plane; there are seven more
  for (const Sample& sample : samples) {
    out.number(sample.bit_offset);
    out.number(static_cast<std::uint8_t>(sample.bit_length - 1));
    out.number(sample.channel);
    out.number(std::uint32_t{0});  // where in the texel it was measured
    out.number(sample.lower);
    out.number(sample.upper);
  }
  return std::move(out).take();
}

}  // namespace

std::optional<Ktx2Format> ktx2_format_of(TexelFormat format) {
  return found([&](const Ktx2Format& row) { return row.format == format; });
}

std::optional<Ktx2Format> ktx2_format_of_number(std::uint32_t vk_format) {
  return found([&](const Ktx2Format& row) { return row.vk_format == vk_format; });
}

Ktx2CubeFormat ktx2_format_of(CubeTexture::Texel texel) {
  return texel == CubeTexture::Texel::kRgb8 ? Ktx2CubeFormat{23, 1, 3} : Ktx2CubeFormat{90, 2, 6};
}

std::vector<std::byte> ktx2_descriptor(CubeTexture::Texel texel) {
  const Ktx2CubeFormat format = ktx2_format_of(texel);
  std::vector<Sample> samples = float_samples(16);
  samples.pop_back();  // no alpha
  if (texel == CubeTexture::Texel::kRgb8) {
    for (std::uint8_t c = 0; c < 3; ++c) samples[c] = {static_cast<std::uint16_t>(8 * c), 8, c, 0, 255};
  }
  return emit_descriptor(samples, {1, format.texel_bytes});
}

std::vector<std::byte> ktx2_descriptor(TexelFormat format) {
  const std::vector<Sample> samples = samples_of(format);
  assert(!samples.empty());
  return emit_descriptor(samples, texel_block(format));
}

}  // namespace sbrdf::internal
