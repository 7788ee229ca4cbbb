#include "formats/texture/texels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "formats/core/half.h"
#include "formats/texture/shared_exponent.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::HasSubstr;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kLargest = std::numeric_limits<float>::max();

// The distance of `value` to the nearest of all 512 numbers that one channel has with a given exponent.
double least_error(double value, int exponent) {
  double least = HUGE_VAL;
  for (int m = 0; m < 512; ++m) least = std::min(least, std::abs(std::ldexp(double(m), exponent - 24) - value));
  return least;
}

bool holds(double value, int exponent) { return value < std::ldexp(511.5, exponent - 24); }

void expect_nearest(const std::array<float, 3>& rgb) {
  const std::uint32_t texel = shared_exponent_from_rgb(rgb);
  const std::array<float, 3> back = rgb_from_shared_exponent(texel);
  const int exponent = static_cast<int>(texel >> 27U);
  const float largest = std::max({rgb[0], rgb[1], rgb[2]});
  for (std::size_t c = 0; c < 3; ++c) {
    const double error = std::abs(double{back[c]} - rgb[c]);
    ASSERT_EQ(error, least_error(rgb[c], exponent)) << rgb[c] << " of " << largest;
    ASSERT_LE(error, std::max(double{largest} / 511, std::ldexp(1, -25)));
  }
  ASSERT_TRUE(exponent == 0 || !holds(largest, exponent - 1)) << largest;
  ASSERT_TRUE(exponent == 31 || holds(largest, exponent)) << largest;
}

TEST(SharedExponent, IsNearestAmongAllNumbersOfItsExponentWhichIsTheLeast) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> power(-30, 16);
  std::uniform_real_distribution<float> part(0, 1);
  for (int k = 0; k < 20000; ++k) {
    const float largest = std::min(std::exp2(power(random)), kSharedExponentLargest);
    std::array<float, 3> rgb = {largest, largest * part(random), largest * std::exp2(-10 * part(random))};
    std::shuffle(rgb.begin(), rgb.end(), random);
    expect_nearest(rgb);
  }
}

TEST(SharedExponent, IsNearestAroundEveryMiddleBetweenTwoNumbers) {
  for (int exponent = 0; exponent < 32; ++exponent) {
    for (int m = 0; m < 512; ++m) {
      const float middle = std::ldexp(static_cast<float>(m) + 0.5F, exponent - 24);
      for (const float value : {std::nextafter(middle, 0.0F), middle, std::nextafter(middle, kLargest)}) {
        if (value <= kSharedExponentLargest) expect_nearest({value, value / 3, 0});
      }
    }
  }
}

TEST(SharedExponent, KeepsEveryTexelThatItWouldWrite) {
  for (std::uint32_t exponent = 0; exponent < 32; ++exponent) {
    for (std::uint32_t m = exponent == 0 ? 0 : 256; m < 512; ++m) {
      const std::uint32_t texel = exponent << 27U | m << 18U | (511 - m) << 9U | (m / 3);
      if (exponent != 0 && std::max(m, 511 - m) < 256) continue;
      ASSERT_EQ(shared_exponent_from_rgb(rgb_from_shared_exponent(texel)), texel);
    }
  }
}

TEST(SharedExponent, HasTheNumbersOfItsSpecification) {
  EXPECT_EQ(shared_exponent_from_rgb({0, 0, 0}), 0U);
  EXPECT_EQ(shared_exponent_from_rgb({1, 1, 1}), 0x84020100U);
  EXPECT_EQ(shared_exponent_from_rgb({65408, 0, 0}), 0xF80001FFU);
  EXPECT_EQ(shared_exponent_from_rgb({0, 0, 65408}), 0xFFFC0000U);
  EXPECT_EQ(shared_exponent_from_rgb({std::ldexp(1.0F, -24), 0, 0}), 1U);
  EXPECT_EQ(shared_exponent_from_rgb({std::ldexp(1.0F, -25), 0, 0}), 1U);
  EXPECT_EQ(shared_exponent_from_rgb({std::nextafter(std::ldexp(1.0F, -25), 0.0F), 0, 0}), 0U);
  EXPECT_EQ(shared_exponent_from_rgb({std::numeric_limits<float>::denorm_min(), 0, 0}), 0U);
  // Rounds up to the next exponent: 511.75 of 2^-9, beside a channel that is then rounded by the larger step.
  EXPECT_EQ(shared_exponent_from_rgb({511.75F / 512, 1.0F / 512, 0}), 16U << 27U | 1U << 9U | 256U);
  EXPECT_THAT(rgb_from_shared_exponent(0xFFFFFFFFU), ElementsAre(65408, 65408, 65408));
}

std::vector<float> round_trip(TexelFormat format, const std::vector<float>& rgb, TexelCounts* counts = nullptr) {
  TexelCounts own;
  const auto texture =
      encode_texels(format, static_cast<std::uint32_t>(rgb.size() / 3), 1, rgb, counts != nullptr ? *counts : own);
  EXPECT_TRUE(texture.ok()) << texture.error().message;
  EXPECT_EQ(texture->bytes.size(), texture_bytes(format, texture->width, texture->height));
  const auto back = decode_texels(*texture);
  EXPECT_TRUE(back.ok());
  return *back;
}

TEST(Texels, KeepFloatsBitForBit) {
  const std::vector<float> rgb = {0, -1, 1e-40F, kLargest, -kLargest, 0.1F};
  EXPECT_EQ(round_trip(TexelFormat::kRgb32f, rgb), rgb);
  EXPECT_EQ(round_trip(TexelFormat::kRgba32f, rgb), rgb);
}

TEST(Texels, KeepEveryFiniteHalf) {
  std::vector<float> rgb;
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    if ((bits & 0x7C00U) != 0x7C00U) rgb.push_back(float_from_half(static_cast<std::uint16_t>(bits)));
  }
  while (rgb.size() % 3 != 0) rgb.push_back(0);
  TexelCounts counts;
  EXPECT_EQ(round_trip(TexelFormat::kRgba16f, rgb, &counts), rgb);
  EXPECT_EQ(counts.clamped + counts.negative, 0U);
}

TEST(Texels, HaveAnAlphaOfOne) {
  TexelCounts counts;
  const std::vector<float> rgb = {0, 0, 0};
  const auto half = encode_texels(TexelFormat::kRgba16f, 1, 1, rgb, counts);
  EXPECT_THAT(half->bytes, ElementsAre(0, 0, 0, 0, 0, 0, 0, 0x3C));
  const auto full = encode_texels(TexelFormat::kRgba32f, 1, 1, rgb, counts);
  EXPECT_THAT(full->bytes, ElementsAre(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3F));
}

TEST(Texels, CountWhatDoesNotFit) {
  const std::vector<float> rgb = {kInfinity, -kInfinity, 65505, -70000, 65504, -0.0F, -1e-30F, 1, 0};
  const auto expect = [&](TexelFormat format, const std::vector<float>& values, std::uint64_t clamped,
                          std::uint64_t negative) {
    TexelCounts counts{10, 20};
    EXPECT_THAT(round_trip(format, rgb, &counts), ElementsAreArray(values));
    EXPECT_EQ(counts.clamped, 10 + clamped);
    EXPECT_EQ(counts.negative, 20 + negative);
  };
  expect(TexelFormat::kRgb32f, {kLargest, -kLargest, 65505, -70000, 65504, 0, -1e-30F, 1, 0}, 2, 0);
  expect(TexelFormat::kRgba16f, {65504, -65504, 65504, -65504, 65504, 0, 0, 1, 0}, 4, 0);
  expect(TexelFormat::kE5b9g9r9, {65408, 0, 65408, 0, 65408, 0, 0, 1, 0}, 3, 3);
}

TEST(Texels, RefuseWhatIsNoNumberAndSayWhere) {
  for (const auto& [name, format] : kTexelFormatNames) {
    if (texel_block(format).side > 1) continue;
    std::vector<float> rgb(3 * 5 * 2, 1.0F);
    rgb[3 * 7 + 1] = kNan;
    TexelCounts counts;
    const auto texture = encode_texels(format, 5, 2, rgb, counts);
    ASSERT_FALSE(texture.ok()) << name;
    EXPECT_EQ(texture.error().code, ErrorCode::kInvalidFile);
    EXPECT_THAT(texture.error().message, HasSubstr("column 2, row 1"));
  }
}

TEST(Texels, RefuseSidesThatNoTextureHas) {
  TexelCounts counts;
  for (const auto& [width, height] : {std::pair{0U, 1U}, {1U, 0U}, {65537U, 1U}, {1U, 0xFFFFFFFFU}}) {
    const auto texture = encode_texels(TexelFormat::kRgba32f, width, height, {}, counts);
    ASSERT_FALSE(texture.ok());
    EXPECT_EQ(texture.error().code, ErrorCode::kUnsupported);
  }
  EXPECT_EQ(encode_texels(TexelFormat::kRgba32f, 1, 1, std::vector<float>(4), counts).error().code, ErrorCode::kUsage);
  EXPECT_EQ(decode_texels({TexelFormat::kRgba32f, 1, 1, {1, 2, 3}}).error().code, ErrorCode::kUsage);
  for (const TexelFormat format : {TexelFormat::kBc6hUnsigned, TexelFormat::kBc6hSigned}) {
    EXPECT_THAT(check_texture_sides(format, 8, 6).error().message, HasSubstr("multiples of 4"));
    EXPECT_EQ(texture_bytes(format, 8, 12), 96U);
  }
  EXPECT_EQ(texture_bytes(TexelFormat::kRgba32f, 65536, 65536), std::size_t{1} << 36U);
}

}  // namespace
}  // namespace sbrdf::internal
