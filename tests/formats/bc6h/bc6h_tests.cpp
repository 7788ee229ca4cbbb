#include "formats/texture/bc6h/bc6h.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "formats/core/half.h"
#include "formats/core/parallel.h"
#include "formats/texture/bc6h/block.h"
#include "formats/texture/bc6h/kernel.h"
#include "formats/texture/bc6h/region.h"
#include "tests/formats/bc6h/drawn_blocks.h"
#include "tests/formats/bc6h/long_search.h"

namespace sbrdf::internal {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

// Fields one after the other, each a value and its number of bits, the lowest bit first; zeros behind.
Bc6hBytes block_of(const std::vector<std::pair<std::uint64_t, int>>& fields) {
  Bc6hBytes bytes{};
  std::size_t at = 0;
  for (const auto& [value, count] : fields) {
    for (int bit = 0; bit < count; ++bit, ++at) {
      bytes[at / 8] = static_cast<std::uint8_t>(bytes[at / 8] | (value >> bit & 1U) << (at % 8));
    }
  }
  return bytes;
}

Bc6hTexels flat(std::uint16_t r, std::uint16_t g, std::uint16_t b) {
  Bc6hTexels texels;
  texels.fill({r, g, b});
  return texels;
}

Bc6hTexels through(const Bc6hTexels& texels, const Bc6hOptions& options) {
  return decode_bc6h_block(encode_bc6h_block(texels, options), options.is_signed);
}

double error_of(const Bc6hTexels& texels, const Bc6hOptions& options) {
  return bc6h_error(texels, through(texels, options), options.metric);
}

const std::array<Bc6hOptions, 4> kLogOptions = {{{.is_signed = false, .speed = Bc6hSpeed::kFast},
                                                 {.is_signed = false, .speed = Bc6hSpeed::kThorough},
                                                 {.is_signed = true, .speed = Bc6hSpeed::kFast},
                                                 {.is_signed = true, .speed = Bc6hSpeed::kThorough}}};

TEST(Bc6hDecode, MixesTheEndpointsOfOneRegion) {
  // Mode 3: ten bits each; texel 0 has index 0, texel 1 index 15, texel 2 index 1, the others 0.
  const Bc6hBytes bytes =
      block_of({{3, 5}, {1023, 10}, {0, 10}, {512, 10}, {0, 10}, {1023, 10}, {512, 10}, {0, 3}, {15, 4}, {1, 4}});
  const Bc6hTexels texels = decode_bc6h_block(bytes, false);
  EXPECT_THAT(texels[0], ElementsAre(0x7BFF, 0, 32800 * 31 / 64));
  EXPECT_THAT(texels[1], ElementsAre(0, 0x7BFF, 32800 * 31 / 64));
  // 60/64 and 4/64 of 0xFFFF, rounded: 61439 and 4096.
  EXPECT_THAT(texels[2], ElementsAre(61439 * 31 / 64, 4096 * 31 / 64, 32800 * 31 / 64));
  EXPECT_EQ(texels[3], texels[0]);
}

TEST(Bc6hDecode, ReadsTwoRegions) {
  // Mode 30: six bits each, in an order of its own; all endpoints 0 but red of the first and of the third, 21 =
  // 010101b.
  const Bc6hBytes bytes = block_of({{30, 5},
                                    {21, 6},
                                    {0, 24},  // green of the third endpoint and more
                                    {0, 6},
                                    {0, 24},
                                    {21, 6},
                                    {0, 6},
                                    {13, 5}});  // the lower half is the second region
  const Bc6hTexels texels = decode_bc6h_block(bytes, false);
  const std::uint16_t red = (21 * 1024 + 512) * 31 / 64;
  EXPECT_THAT(texels, Each(ElementsAre(red, 0, 0)));
  Bc6hBytes only_first = bytes;
  only_first[8] = only_first[8] & 1U;  // bits 65 to 70
  EXPECT_EQ(decode_bc6h_block(only_first, false)[7][0], red);
  EXPECT_EQ(decode_bc6h_block(only_first, false)[8][0], 0);
}

TEST(Bc6hDecode, ReadsNegativeNumbers) {
  const auto texel = [](std::uint32_t red) { return decode_bc6h_block(block_of({{3, 5}, {red, 10}}), true)[0][0]; };
  EXPECT_EQ(texel(511), 0x7BFF);
  EXPECT_EQ(texel(1), 96 * 31 / 32);
  EXPECT_EQ(texel(1023), 0x8000 | 96 * 31 / 32);  // -1
  EXPECT_EQ(texel(513), 0xFBFF);                  // -511
  EXPECT_EQ(texel(512), 0xFBFF);                  // -512 means the same
}

TEST(Bc6hDecode, GivesMinusInfinityForOnePatternOnly) {
  // Mode 15: 16 bits, the highest six of them in reverse order behind the four of the difference.
  const Bc6hBytes least = block_of({{15, 5}, {0, 34}, {1, 1}});
  EXPECT_EQ(decode_bc6h_block(least, true)[0][0], 0xFC00);
  EXPECT_EQ(decode_bc6h_block(least, false)[0][0], 0x8000 * 31 / 64);
}

TEST(Bc6hDecode, GivesWhatOpenImageIoGave) {
  // Of the halves of 10,000 random blocks; check_bc6h.py compares them with those of OpenImageIO one by one.
  for (const auto& [is_signed, expected] :
       {std::pair(false, 0x6A7D548C7BE82D20U), std::pair(true, 0xC695A73E951CCB76U)}) {
    std::mt19937 draw(10);
    std::uint64_t hash = 0xCBF29CE484222325U;
    for (int k = 0; k < 10000; ++k) {
      Bc6hBytes bytes;
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(draw());
      for (const auto& texel : decode_bc6h_block(bytes, is_signed)) {
        for (const std::uint16_t half : texel) hash = (hash ^ half) * 0x100000001B3U;
      }
    }
    EXPECT_EQ(hash, expected);
  }
}

TEST(Bc6hDecode, GivesZeroForReservedModes) {
  for (const std::uint32_t mode : {19U, 23U, 27U, 31U}) {
    Bc6hBytes bytes;
    bytes.fill(0xFF);
    bytes[0] = static_cast<std::uint8_t>(0xE0 | mode);
    EXPECT_THAT(decode_bc6h_block(bytes, false), Each(Each(0)));
    EXPECT_THAT(decode_bc6h_block(bytes, true), Each(Each(0)));
  }
}

TEST(Bc6hBlocks, AreTheSameBytesAfterParsingAndEmitting) {
  std::mt19937 draw(1);
  std::array<int, kBc6hModeCount> seen{};
  for (int k = 0; k < 20000; ++k) {
    Bc6hBytes bytes;
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(draw());
    const bool is_signed = k % 2 == 1;
    const auto block = parse_bc6h_block(bytes, is_signed);
    // A sum that wraps has no difference that an encoder would choose.
    if (!block || !fits_bc6h(kBc6hModes[block->mode], block->endpoints)) continue;
    ++seen[block->mode];
    ASSERT_EQ(emit_bc6h_block(*block), bytes);
  }
  EXPECT_GT(*std::min_element(seen.begin(), seen.end()), 200);
}

// The regions of a block that hold just what it decodes to, and the errors of its own endpoints there.
std::vector<std::pair<Bc6hRegion, Bc6hMatch>> matches_of(const Bc6hBlock& block, const Bc6hTexels& texels,
                                                         const Bc6hOptions& options) {
  std::array<float, 16> weights{};
  weights.fill(1);
  const Bc6hMode& mode = kBc6hModes[block.mode];
  const Bc6hRegion whole = make_bc6h_region(texels, weights, options);
  const std::array<Bc6hRegion, 2> parts = split_bc6h_region(whole, block.partition);
  const Bc6hScale scale = {mode.endpoint_bits, mode.index_count(), options.is_signed, options.metric};
  std::vector<std::pair<Bc6hRegion, Bc6hMatch>> matches;
  for (std::size_t k = 0; k < mode.region_count; ++k) {
    std::array<Bc6hEnds, 3> ends{};
    for (std::size_t c = 0; c < 3; ++c) ends[c] = {block.endpoints[2 * k][c], block.endpoints[2 * k + 1][c]};
    const Bc6hRegion& region = mode.region_count == 1 ? whole : parts[k];
    matches.emplace_back(region, match_bc6h(region, scale, ends));
    for (std::size_t c = 0; c < 3; ++c) {
      std::array<float, 1> error{-1};
      channel_errors_bc6h(region, scale, other_channels_bc6h(region, scale, ends, c), c, std::span(&ends[c], 1), error);
      EXPECT_EQ(error[0], matches.back().second.error);
    }
  }
  return matches;
}

TEST(Bc6hKernel, SeesWhatTheDecoderMakes) {
  std::mt19937 draw(9);
  for (int k = 0; k < 20000; ++k) {
    Bc6hBytes bytes;
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(draw());
    const Bc6hOptions options{.is_signed = k % 2 == 1, .metric = k % 4 < 2 ? Bc6hMetric::kLog : Bc6hMetric::kLinear};
    std::optional<Bc6hBlock> block = parse_bc6h_block(bytes, options.is_signed);
    if (!block) continue;
    const Bc6hTexels texels = decode_bc6h_block(bytes, options.is_signed);
    for (const auto& [region, match] : matches_of(*block, texels, options)) {
      ASSERT_EQ(match.error, 0) << k;
      for (std::size_t at = 0; at < region.size; ++at) {
        block->indices[region.texels[at]] = static_cast<std::uint8_t>(match.indices[at]);
      }
    }
    // Other indices may mean the same colours.
    if (!fits_bc6h(kBc6hModes[block->mode], block->endpoints)) continue;
    ASSERT_EQ(decode_bc6h_block(emit_bc6h_block(*block), options.is_signed), texels) << k;
  }
}

TEST(Bc6hEncode, KeepsOneColour) {
  for (const Bc6hOptions& options : kLogOptions) {
    for (std::uint32_t half = 0; half <= 0x7BFF; half += options.speed == Bc6hSpeed::kFast ? 37 : 1021) {
      const auto bits = static_cast<std::uint16_t>(half);
      const auto sign = static_cast<std::uint16_t>(options.is_signed ? 0x8000 : 0);
      const Bc6hTexels texels = flat(bits, static_cast<std::uint16_t>(0x7BFF - bits), sign | bits);
      ASSERT_EQ(error_of(texels, options), 0) << half;
    }
  }
}

TEST(Bc6hEncode, KeepsTwoColoursToStepsOfTenBits) {
  std::mt19937 draw(2);
  for (const Bc6hOptions& options : kLogOptions) {
    for (int k = 0; k < 50; ++k) {
      Bc6hTexels texels;
      std::array<Bc6hTexels::value_type, 2> colours{};
      for (auto& colour : colours) {
        for (std::uint16_t& half : colour) half = static_cast<std::uint16_t>(draw() % 0x7C00);
      }
      for (auto& texel : texels) texel = colours[draw() % 2];
      // Rounding to 10 bits is off by 16 at most, to 9 bits and a sign by 32; by more beside 0 and the largest number.
      const double most = options.is_signed ? 32 : 16;
      EXPECT_LE(error_of(texels, options), 48 * most * most);
    }
  }
}

TEST(Bc6hEncode, KeepsGradientsToHalfAStep) {
  for (const Bc6hOptions& options : kLogOptions) {
    for (const int slope : {1, 3, 10, 40, 200, 600}) {
      Bc6hTexels texels;
      for (std::size_t k = 0; k < 16; ++k) {
        const int half = 0x3C00 + slope * (static_cast<int>(k % 4) + static_cast<int>(k / 4) - 3);
        texels[k] = {static_cast<std::uint16_t>(half), static_cast<std::uint16_t>(half + 300),
                     static_cast<std::uint16_t>(half - 2000)};
      }
      // Six steps of the gradient among 15 of the indices: at most half an index off, and what endpoints are rounded
      // by.
      const double most = 0.5 * 6 * slope / 15 + (options.is_signed ? 32 : 16) * 0.5;
      EXPECT_LE(error_of(texels, options), 48 * most * most) << slope;
    }
  }
}

TEST(Bc6hEncode, LeavesOutTexelsWithoutWeight) {
  std::mt19937 draw(3);
  for (const Bc6hOptions& options : kLogOptions) {
    for (int k = 0; k < 20; ++k) {
      Bc6hTexels texels = flat(0x3C12, 0x1234, 0x4567);
      std::array<float, 16> weights{};
      for (std::size_t texel = 0; texel < 16; ++texel) {
        weights[texel] = k > 0 && draw() % 2 == 0 ? 1.0F : 0.0F;
        if (weights[texel] == 0) {
          for (std::uint16_t& half : texels[texel]) half = static_cast<std::uint16_t>(draw());
        }
      }
      const Bc6hTexels decoded = decode_bc6h_block(encode_bc6h_block(texels, weights, options), options.is_signed);
      for (std::size_t texel = 0; texel < 16; ++texel) {
        EXPECT_TRUE(weights[texel] == 0 || decoded[texel] == texels[texel]) << texel;
      }
    }
  }
}

TEST(Bc6hEncode, TakesTheNearestNumberThatThereIs) {
  for (const Bc6hOptions& options : kLogOptions) {
    const Bc6hTexels decoded = through(flat(0x7C00, 0x7E00, 0xFC00), options);  // infinity, NaN, minus infinity
    EXPECT_THAT(decoded, Each(ElementsAre(0x7BFF, 0, options.is_signed ? 0xFBFF : 0)));
  }
}

TEST(Bc6hEncode, MakesSmallWhatItsMetricMeasures) {
  for (const std::string_view kind : {"edges", "highlight", "noise"}) {
    std::array<double, 2> gain{};  // of the encoder that is meant, by metric [dB]
    std::mt19937 draw(4);
    for (int k = 0; k < 60; ++k) {
      const Bc6hTexels texels = draw_bc6h_block(kind, draw);
      const Bc6hTexels log = through(texels, {.speed = Bc6hSpeed::kFast, .metric = Bc6hMetric::kLog});
      const Bc6hTexels linear = through(texels, {.speed = Bc6hSpeed::kFast, .metric = Bc6hMetric::kLinear});
      gain[0] += std::log10(bc6h_error(texels, linear, Bc6hMetric::kLog) / bc6h_error(texels, log, Bc6hMetric::kLog));
      gain[1] +=
          std::log10(bc6h_error(texels, log, Bc6hMetric::kLinear) / bc6h_error(texels, linear, Bc6hMetric::kLinear));
    }
    EXPECT_GT(10 * gain[0] / 60, 0.5) << kind;
    EXPECT_GT(10 * gain[1] / 60, 0.5) << kind;
  }
}

TEST(Bc6hEncode, IsBetterWhenItIsThorough) {
  for (const std::string_view kind : kBc6hBlockKinds) {
    double gain = 0;  // [dB]
    std::mt19937 draw(5);
    for (int k = 0; k < 40; ++k) {
      const Bc6hTexels texels = draw_bc6h_block(kind, draw);
      const bool is_signed = kind == "signed";
      gain += 10 * std::log10((error_of(texels, {.is_signed = is_signed, .speed = Bc6hSpeed::kFast}) + 1) /
                              (error_of(texels, {.is_signed = is_signed, .speed = Bc6hSpeed::kThorough}) + 1));
    }
    EXPECT_GE(gain, 0) << kind;
  }
}

// Mean error of 40 blocks of each kind [dB], for both metrics fast and thorough, as it was when the encoder was last
// compared with the long search at length.
TEST(Bc6hQuality, IsWhatItWas) {
  const std::array<std::array<double, 4>, kBc6hBlockKinds.size()> expected = {{{40.99, 40.77, -18.86, -19.03},
                                                                               {49.00, 48.80, -4.77, -5.91},
                                                                               {52.16, 51.38, 7.83, 6.77},
                                                                               {62.76, 62.27, -0.42, -2.06},
                                                                               {75.65, 75.65, 14.19, 13.72}}};
  for (std::size_t kind = 0; kind < kBc6hBlockKinds.size(); ++kind) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Bc6hOptions options{.is_signed = kBc6hBlockKinds[kind] == "signed",
                                .speed = k % 2 == 0 ? Bc6hSpeed::kFast : Bc6hSpeed::kThorough,
                                .metric = k < 2 ? Bc6hMetric::kLog : Bc6hMetric::kLinear};
      std::mt19937 draw(12);
      double mean = 0;
      for (int block = 0; block < 40; ++block) {
        mean += 10 * std::log10(error_of(draw_bc6h_block(kBc6hBlockKinds[kind], draw), options)) / 40;
      }
      EXPECT_LT(mean, expected[kind][k] + 0.05) << kBc6hBlockKinds[kind] << ' ' << k;
    }
  }
}

class Bc6hLongSearch : public testing::TestWithParam<Bc6hMetric> {};

TEST_P(Bc6hLongSearch, IsHardlyBetter) {
  double lead = 0;  // of the long search [dB]
  int count = 0;
  for (const std::string_view kind : kBc6hBlockKinds) {
    std::mt19937 draw(6);
    for (std::uint32_t k = 0; k < 4; ++k, ++count) {
      const Bc6hTexels texels = draw_bc6h_block(kind, draw);
      const Bc6hOptions options{.is_signed = kind == "signed", .metric = GetParam()};
      LongBc6hSearch search(texels, options.is_signed, options.metric, k);
      lead += 10 * std::log10(error_of(texels, options) / search.run(1, 400, 8, 8000));
    }
  }
  EXPECT_LE(lead / count, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Metrics, Bc6hLongSearch, testing::Values(Bc6hMetric::kLog, Bc6hMetric::kLinear));

std::vector<float> image_of(std::uint32_t width, std::uint32_t height) {
  std::vector<float> rgb(3 * std::size_t{width} * height);
  for (std::size_t k = 0; k < rgb.size(); ++k) {
    const std::size_t x = k / 3 % width / 4;
    const std::size_t y = k / 3 / width / 4;
    rgb[k] = static_cast<float>(1 + k % 3 + 3 * (x + width / 4 * y));  // one colour for each block
  }
  return rgb;
}

TEST(Bc6hImage, KeepsItsRowsAndColumns) {
  const std::vector<float> rgb = image_of(24, 12);
  const std::vector<std::uint8_t> bytes = encode_bc6h(24, 12, rgb, {}, {.speed = Bc6hSpeed::kFast});
  ASSERT_EQ(bytes.size(), bc6h_size(24, 12));
  const auto decoded = decode_bc6h(24, 12, bytes, false);
  ASSERT_TRUE(decoded.ok()) << decoded.error().message;
  EXPECT_EQ(*decoded, rgb);
}

TEST(Bc6hImage, HasTheTexelsOfABlockRowByRow) {
  std::mt19937 draw(11);
  std::vector<std::uint8_t> bytes(bc6h_size(12, 8));
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(draw());
  const auto decoded = decode_bc6h(12, 8, bytes, true);
  ASSERT_TRUE(decoded.ok());
  for (std::size_t k = 0; k < decoded->size(); ++k) {
    const std::size_t x = k / 3 % 12;
    const std::size_t y = k / 36;
    const auto block = std::span(bytes).subspan((y / 4 * 3 + x / 4) * kBc6hBlockSize).first<kBc6hBlockSize>();
    ASSERT_EQ((*decoded)[k], float_from_half(decode_bc6h_block(block, true)[y % 4 * 4 + x % 4][k % 3]));
  }
  // And the encoder takes them in the same order: a gradient along x stays one.
  std::vector<float> rgb(3 * 16);
  for (std::size_t k = 0; k < rgb.size(); ++k) rgb[k] = 1 + 0.25F * static_cast<float>(k / 3 % 4);
  const auto back = decode_bc6h(4, 4, encode_bc6h(4, 4, rgb, {}, {.speed = Bc6hSpeed::kFast}), false);
  ASSERT_TRUE(back.ok());
  for (std::size_t k = 0; k < rgb.size(); ++k) EXPECT_NEAR((*back)[k], rgb[k], 0.02);
}

TEST(Bc6hImage, TakesAWeightForEachTexel) {
  std::vector<float> rgb = image_of(8, 8);
  std::vector<float> weights(64, 1);
  for (const std::size_t texel : {0U, 21U, 63U}) {
    weights[texel] = 0;
    rgb[3 * texel] = 60000;
  }
  const auto decoded = decode_bc6h(8, 8, encode_bc6h(8, 8, rgb, weights, {.speed = Bc6hSpeed::kFast}), false);
  EXPECT_EQ(*decoded, image_of(8, 8));
}

TEST(Bc6hImage, IsTheSameForAnyNumberOfThreads) {
  std::mt19937 draw(8);
  std::vector<float> rgb(3 * 64 * 64);
  for (float& value : rgb) value = std::ldexp(static_cast<float>(draw() % 1000), -static_cast<int>(draw() % 10));
  const auto encoded = [&](std::size_t threads) {
    const ThreadLimit limit(threads);
    return encode_bc6h(64, 64, rgb, {}, {.speed = Bc6hSpeed::kFast});
  };
  EXPECT_EQ(encoded(1), encoded(4));
}

TEST(Bc6hImage, RefusesOtherSizes) {
  const std::vector<std::uint8_t> bytes(bc6h_size(8, 8));
  const auto message = [&](std::uint32_t width, std::uint32_t height) {
    const auto decoded = decode_bc6h(width, height, bytes, false);
    return decoded.ok() ? "" : decoded.error().message;
  };
  EXPECT_EQ(message(8, 8), "");
  EXPECT_EQ(message(4, 16), "");
  EXPECT_THAT(message(8, 6), HasSubstr("8 x 6 texels; sides must be multiples of 4"));
  EXPECT_THAT(message(0, 8), HasSubstr("not 0"));
  EXPECT_THAT(message(8, 4), HasSubstr("needs 32 bytes, there are 64"));
  EXPECT_THAT(message(0xFFFFFFFC, 0xFFFFFFFC), HasSubstr("there are 64"));
  EXPECT_EQ(decode_bc6h(16, 8, bytes, false).error().offset, 64U);
}

}  // namespace
}  // namespace sbrdf::internal
