#include "formats/texture/texels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

#include "formats/core/half.h"
#include "formats/texture/shared_exponent.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kChannels = 3;
constexpr std::uint16_t kHalfOne = 0x3C00;

using Colour = std::array<float, kChannels>;

/// Brings colours into the range of a format, and counts.
class Limiter {
 public:
  Limiter(TexelFormat format, TexelCounts& counts)
      : largest_(largest_texel(format)), has_sign_(has_sign(format)), counts_(counts) {}

  Colour operator()(const float* rgb) { return {limited(rgb[0]), limited(rgb[1]), limited(rgb[2])}; }

 private:
  float limited(float value) {
    if (value < 0 && !has_sign_) {
      ++counts_.negative;
      return 0;
    }
    if (std::abs(value) <= largest_) return has_sign_ ? value : std::abs(value);  // -0 has a sign as well
    ++counts_.clamped;
    return std::copysign(largest_, value);
  }

  float largest_;
  bool has_sign_;
  TexelCounts& counts_;
};

template <class Number>
void store(std::uint8_t*& target, Number number) {
  std::memcpy(target, &number, sizeof(number));
  target += sizeof(number);
}

template <class Number>
Number load(const std::uint8_t* source) {
  Number number{};
  std::memcpy(&number, source, sizeof(number));
  return number;
}

void store_texel(TexelFormat format, const Colour& rgb, std::uint8_t*& target) {
  switch (format) {
    case TexelFormat::kRgb32f:
    case TexelFormat::kRgba32f:
      for (const float value : rgb) store(target, value);
      if (format == TexelFormat::kRgba32f) store(target, 1.0F);
      return;
    case TexelFormat::kRgba16f:
      for (const float value : rgb) store(target, half_from_float(value));
      store(target, kHalfOne);
      return;
    case TexelFormat::kE5b9g9r9:
      store(target, shared_exponent_from_rgb(rgb));
      return;
    case TexelFormat::kBc6hUnsigned:
    case TexelFormat::kBc6hSigned:
      assert(false);
      return;
  }
}

Colour load_texel(TexelFormat format, const std::uint8_t* source) {
  switch (format) {
    case TexelFormat::kRgb32f:
    case TexelFormat::kRgba32f:
      return {load<float>(source), load<float>(source + 4), load<float>(source + 8)};
    case TexelFormat::kRgba16f:
      return {float_from_half(load<std::uint16_t>(source)), float_from_half(load<std::uint16_t>(source + 2)),
              float_from_half(load<std::uint16_t>(source + 4))};
    case TexelFormat::kE5b9g9r9:
      return rgb_from_shared_exponent(load<std::uint32_t>(source));
    case TexelFormat::kBc6hUnsigned:
    case TexelFormat::kBc6hSigned:
      break;
  }
  assert(false);
  return {};
}

bool has_blocks(TexelFormat format) { return texel_block(format).side > 1; }

}  // namespace

float largest_texel(TexelFormat format) {
  switch (format) {
    case TexelFormat::kRgb32f:
    case TexelFormat::kRgba32f:
      return std::numeric_limits<float>::max();
    case TexelFormat::kE5b9g9r9:
      return kSharedExponentLargest;
    case TexelFormat::kRgba16f:
    case TexelFormat::kBc6hUnsigned:
    case TexelFormat::kBc6hSigned:
      break;
  }
  return static_cast<float>(kHalfLargest);
}

bool has_sign(TexelFormat format) { return format != TexelFormat::kE5b9g9r9 && format != TexelFormat::kBc6hUnsigned; }

TexelBlock texel_block(TexelFormat format) {
  switch (format) {
    case TexelFormat::kRgb32f:
      return {1, 12};
    case TexelFormat::kRgba32f:
      return {1, 16};
    case TexelFormat::kRgba16f:
      return {1, 8};
    case TexelFormat::kE5b9g9r9:
      return {1, 4};
    case TexelFormat::kBc6hUnsigned:
    case TexelFormat::kBc6hSigned:
      break;
  }
  return {4, 16};
}

Status check_texture_sides(TexelFormat format, std::uint32_t width, std::uint32_t height) {
  if (width == 0 || height == 0 || width > kLongestTextureSide || height > kLongestTextureSide) {
    return unsupported(
        fmt::format("a texture of {} x {} texels; its sides are 1 to {}", width, height, kLongestTextureSide));
  }
  const std::uint32_t side = texel_block(format).side;
  if (width % side != 0 || height % side != 0) {
    return unsupported(fmt::format("a texture of {} x {} texels; those of {} have sides that are multiples of {}",
                                   width, height, name_of(kTexelFormatNames, format), side));
  }
  return ok_status();
}

std::size_t texture_bytes(TexelFormat format, std::uint32_t width, std::uint32_t height) {
  const TexelBlock block = texel_block(format);
  return std::size_t{width / block.side} * (height / block.side) * block.bytes;
}

Status check_texture(const Texture& texture) {
  if (Status fits = check_texture_sides(texture.format, texture.width, texture.height); !fits) return fits;
  const std::size_t expected = texture_bytes(texture.format, texture.width, texture.height);
  if (texture.bytes.size() == expected) return ok_status();
  return usage_error(fmt::format("a texture of {} x {} texels of {} has {} bytes, not {}", texture.width,
                                 texture.height, name_of(kTexelFormatNames, texture.format), expected,
                                 texture.bytes.size()));
}

Result<Texture> encode_texels(TexelFormat format, std::uint32_t width, std::uint32_t height, std::span<const float> rgb,
                              TexelCounts& counts, const BlockEncoding& blocks) {
  if (Status fits = check_texture_sides(format, width, height); !fits) return fits.error();
  if (rgb.size() != std::size_t{width} * height * kChannels) {
    return usage_error(fmt::format("{} numbers for a texture of {} x {} texels", rgb.size(), width, height));
  }
  const auto no_number = std::find_if(rgb.begin(), rgb.end(), [](float value) { return std::isnan(value); });
  if (no_number != rgb.end()) {
    const std::size_t texel = static_cast<std::size_t>(no_number - rgb.begin()) / kChannels;
    return invalid_file(fmt::format("the texel in column {}, row {} is not a number", texel % width, texel / width));
  }
  Texture texture{format, width, height, std::vector<std::uint8_t>(texture_bytes(format, width, height))};
  Limiter limited(format, counts);
  if (has_blocks(format)) {
    std::vector<float> held(rgb.size());
    for (std::size_t k = 0; k < rgb.size(); k += kChannels) {
      const Colour colour = limited(&rgb[k]);
      std::copy(colour.begin(), colour.end(), held.begin() + static_cast<std::ptrdiff_t>(k));
    }
    texture.bytes = encode_bc6h(width, height, held, {}, {has_sign(format), blocks.speed, blocks.metric});
    return texture;
  }
  std::uint8_t* target = texture.bytes.data();
  for (std::size_t k = 0; k < rgb.size(); k += kChannels) store_texel(format, limited(&rgb[k]), target);
  return texture;
}

Result<std::vector<float>> decode_texels(const Texture& texture) {
  if (Status fits = check_texture(texture); !fits) return fits.error();
  if (has_blocks(texture.format)) {
    return decode_bc6h(texture.width, texture.height, texture.bytes, has_sign(texture.format));
  }
  std::vector<float> rgb(std::size_t{texture.width} * texture.height * kChannels);
  const std::uint8_t* source = texture.bytes.data();
  for (std::size_t k = 0; k < rgb.size(); k += kChannels, source += texel_block(texture.format).bytes) {
    const Colour colour = load_texel(texture.format, source);
    std::copy(colour.begin(), colour.end(), rgb.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return rgb;
}

}  // namespace sbrdf::internal
