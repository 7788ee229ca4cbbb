#include "tests/gpu/gl_harness.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class GlHarness : public testing::TestWithParam<GlApi> {};
INSTANTIATE_TEST_SUITE_P(Apis, GlHarness, testing::Values(GlApi::kCore45, GlApi::kEs30),
                         [](const auto& api) { return std::string(api.param == GlApi::kEs30 ? "Es30" : "Core45"); });

using Rgb = std::array<double, 3>;

constexpr const char* kLookUp = R"(uniform sampler2D atlas;
vec3 run(vec3 a, vec3 b) { return textureLod(atlas, a.xy, 0.0).rgb; }
)";

template <class T>
std::vector<std::byte> bytes_of(const std::vector<T>& values) {
  std::vector<std::byte> bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::vector<float> random_floats(std::size_t count, float low, float high) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> draw(low, high);
  std::vector<float> values(count);
  for (float& value : values) value = draw(random);
  return values;
}

// Inputs whose first two numbers are places in a texture.
std::vector<float> places(const std::vector<std::array<float, 2>>& points) {
  std::vector<float> inputs;
  for (const auto& [u, v] : points) inputs.insert(inputs.end(), {u, v, 0, 0, 0, 0, 0, 0});
  return inputs;
}

std::vector<std::array<float, 2>> texel_centres(int width, int height) {
  std::vector<std::array<float, 2>> points;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      points.push_back({(static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                        (static_cast<float>(y) + 0.5f) / static_cast<float>(height)});
    }
  }
  return points;
}

std::vector<std::array<float, 2>> random_places(std::size_t count) {
  const std::vector<float> numbers = random_floats(2 * count, -0.3f, 1.3f);
  std::vector<std::array<float, 2>> points;
  for (std::size_t index = 0; index < count; ++index) points.push_back({numbers[2 * index], numbers[2 * index + 1]});
  return points;
}

// The two texels beside a place along one axis, and the weight of the second: section 8.14.3 of the OpenGL 4.5
// specification.
struct Neighbours {
  int first, second;
  double weight;
};

int wrapped(int index, int size, GlWrap wrap) {
  return wrap == GlWrap::kRepeat ? (index % size + size) % size : std::clamp(index, 0, size - 1);
}

Neighbours neighbours(double place, int size, GlWrap wrap) {
  const double scaled = place * size - 0.5;
  const int floor = static_cast<int>(std::floor(scaled));
  return {wrapped(floor, size, wrap), wrapped(floor + 1, size, wrap), scaled - floor};
}

// `texels` are height x width.
Rgb bilinear(const GlTexture& texture, const std::vector<Rgb>& texels, const std::array<float, 2>& place) {
  const Neighbours x = neighbours(place[0], texture.width, texture.wrap[0]);
  const Neighbours y = neighbours(place[1], texture.height, texture.wrap[1]);
  const auto at = [&](int column, int row, std::size_t channel) {
    return texels[static_cast<std::size_t>(row * texture.width + column)][channel];
  };
  Rgb value = {};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const double low = std::lerp(at(x.first, y.first, channel), at(x.second, y.first, channel), x.weight);
    const double high = std::lerp(at(x.first, y.second, channel), at(x.second, y.second, channel), x.weight);
    value[channel] = std::lerp(low, high, y.weight);
  }
  return value;
}

// What the driver reads at the centres of texels, exactly; and between them, relative to the largest texel.
void expect_texels(GlContext& context, const GlTexture& texture, const std::vector<Rgb>& texels, double tolerance) {
  const auto centres = texel_centres(texture.width, texture.height);
  GlTexture nearest = texture;
  nearest.filter = GlFilter::kNearest;
  const auto exact = context.evaluate(kLookUp, {&nearest, 1}, places(centres));
  ASSERT_TRUE(exact.ok()) << exact.error().message;
  double largest = 0;
  for (std::size_t index = 0; index < texels.size(); ++index) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      EXPECT_EQ(exact.value()[3 * index + channel], texels[index][channel]) << "texel " << index << ", " << channel;
      largest = std::max(largest, std::abs(texels[index][channel]));
    }
  }
  const auto points = random_places(2000);
  const auto between = context.evaluate(kLookUp, {&texture, 1}, places(points));
  ASSERT_TRUE(between.ok()) << between.error().message;
  for (std::size_t index = 0; index < points.size(); ++index) {
    const Rgb expected = bilinear(texture, texels, points[index]);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      ASSERT_NEAR(between.value()[3 * index + channel], expected[channel], tolerance * largest)
          << points[index][0] << ", " << points[index][1];
    }
  }
}

double half_value(std::uint32_t bits) {
  const double sign = (bits & 0x8000u) != 0 ? -1 : 1;
  const int exponent = static_cast<int>((bits >> 10) & 31u);
  const double mantissa = bits & 1023u;
  return sign * (exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25));
}

TEST_P(GlHarness, NamesItsDriver) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  EXPECT_THAT(context.driver(), HasSubstr("llvmpipe"));
  EXPECT_THAT(context.driver(), HasSubstr(GetParam() == GlApi::kEs30 ? "OpenGL ES 3" : "4.5"));
  RecordProperty("driver", context.driver());
}

TEST_P(GlHarness, AddsAndMultipliesExactly) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  // More than one row of inputs, the last of them not full.
  const std::size_t count = 2500;
  const std::vector<float> inputs = random_floats(8 * count, -10, 10);
  const auto values =
      context.evaluate("vec3 run(vec3 a, vec3 b) { return vec3(a.x + b.x, a.y * b.y, a.z - b.z); }\n", {}, inputs);
  ASSERT_TRUE(values.ok()) << values.error().message;
  ASSERT_EQ(values->size(), 3 * count);
  for (std::size_t index = 0; index < count; ++index) {
    const float* a = &inputs[8 * index];
    const float* b = a + 4;
    ASSERT_EQ(values.value()[3 * index], a[0] + b[0]) << index;
    ASSERT_EQ(values.value()[3 * index + 1], a[1] * b[1]) << index;
    ASSERT_EQ(values.value()[3 * index + 2], a[2] - b[2]) << index;
  }
}

TEST_P(GlHarness, FourNumbersGoInAndOut) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const std::vector<float> inputs = {1, 2, 3, 4, 5, 6, 7, 8};
  const auto values =
      context.evaluate("vec4 run(vec4 a, vec4 b) { return a * b.wzyx; }\n", {}, inputs, GlFunction::kVec4);
  ASSERT_TRUE(values.ok()) << values.error().message;
  EXPECT_EQ(*values, (std::vector<float>{8, 14, 18, 20}));
}

TEST_P(GlHarness, IntegersHaveThirtyTwoBits) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const auto values = context.evaluate(
      "vec3 run(vec3 a, vec3 b) { int large = int(a.x) * 65537; return vec3(large >> 16, large & 65535, large < 0); "
      "}\n",
      {}, std::vector<float>{4321, 0, 0, 0, 0, 0, 0, 0});
  ASSERT_TRUE(values.ok()) << values.error().message;
  EXPECT_EQ(*values, (std::vector<float>{4321, 4321, 0}));
}

TEST_P(GlHarness, NoInputGivesNoResult) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const auto values = context.evaluate("vec3 run(vec3 a, vec3 b) { return a; }\n", {}, {});
  ASSERT_TRUE(values.ok()) << values.error().message;
  EXPECT_TRUE(values->empty());
}

TEST_P(GlHarness, FloatTexturesAreFilteredInFullPrecision) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  for (const GlFormat format : {GlFormat::kRgba32f, GlFormat::kRgb32f}) {
    for (const GlWrap wrap : {GlWrap::kClampToEdge, GlWrap::kRepeat}) {
      GlTexture texture = {
          .name = "atlas", .format = format, .width = 5, .height = 3, .bytes = {}, .wrap = {wrap, wrap}};
      const std::size_t channels = format == GlFormat::kRgba32f ? 4 : 3;
      const std::vector<float> values = random_floats(15 * channels, 0, 1);
      texture.bytes = bytes_of(values);
      std::vector<Rgb> texels;
      for (std::size_t index = 0; index < 15; ++index) {
        const float* texel = &values[channels * index];
        texels.push_back({texel[0], texel[1], texel[2]});
      }
      expect_texels(context, texture, texels, 1e-6);
    }
  }
}

TEST_P(GlHarness, TexturesOfOneChannelAreRed) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const std::vector<float> values = random_floats(6, 0, 1);
  const GlTexture texture = {
      .name = "atlas", .format = GlFormat::kR32f, .width = 3, .height = 2, .bytes = bytes_of(values)};
  std::vector<Rgb> texels;
  for (const float value : values) texels.push_back({value, 0, 0});
  expect_texels(context, texture, texels, 1e-6);
}

TEST_P(GlHarness, WrapsEachAxisByItself) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const std::vector<float> values = random_floats(12, 0, 1);
  GlTexture texture = {
      .name = "atlas", .format = GlFormat::kRgb32f, .width = 2, .height = 2, .bytes = bytes_of(values)};
  texture.wrap = {GlWrap::kRepeat, GlWrap::kClampToEdge};
  std::vector<Rgb> texels;
  for (std::size_t index = 0; index < 4; ++index) {
    texels.push_back({values[3 * index], values[3 * index + 1], values[3 * index + 2]});
  }
  expect_texels(context, texture, texels, 1e-6);
}

TEST_P(GlHarness, HalfTexturesKeepEveryNormalHalf) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  // Of every exponent some mantissas, both signs; no subnormal ones, which the driver may flush.
  std::vector<std::uint16_t> halves;
  std::vector<Rgb> texels;
  for (std::uint32_t exponent = 1; exponent < 31; ++exponent) {
    for (const std::uint32_t mantissa : {0u, 1u, 682u, 1023u}) {
      const std::uint32_t bits = exponent << 10 | mantissa;
      for (const std::uint32_t channel : {bits, bits | 0x8000u, bits ^ 5u, 0x3c00u}) {
        halves.push_back(static_cast<std::uint16_t>(channel));
      }
      texels.push_back({half_value(bits), half_value(bits | 0x8000u), half_value(bits ^ 5u)});
    }
  }
  const GlTexture texture = {
      .name = "atlas", .format = GlFormat::kRgba16f, .width = 12, .height = 10, .bytes = bytes_of(halves)};
  expect_texels(context, texture, texels, 1e-6);
}

TEST_P(GlHarness, SharedExponentsAreThoseOfTheSpecification) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  std::mt19937 random(3);
  std::vector<std::uint32_t> packed;
  std::vector<Rgb> texels;
  for (std::uint32_t exponent = 0; exponent < 32; ++exponent) {
    for (int repeat = 0; repeat < 4; ++repeat) {
      const std::array<std::uint32_t, 3> mantissas = {static_cast<std::uint32_t>(random() % 512),
                                                      static_cast<std::uint32_t>(random() % 512), 511};
      packed.push_back(mantissas[0] | mantissas[1] << 9 | mantissas[2] << 18 | exponent << 27);
      // Section 8.25: m * 2^(e - 15 - 9).
      Rgb& texel = texels.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) texel[c] = std::ldexp(mantissas[c], static_cast<int>(exponent) - 24);
    }
  }
  const GlTexture texture = {
      .name = "atlas", .format = GlFormat::kRgb9E5, .width = 16, .height = 8, .bytes = bytes_of(packed)};
  expect_texels(context, texture, texels, 1e-6);
}

// A block of BC6H in its mode of one region and two ends of 10 bits for each channel (bits 00011), as the Khronos Data
// Format Specification lays it out: mode, r0 g0 b0 r1 g1 b1, then an index of 4 bits for each texel, the first without
// its highest bit.
std::vector<std::byte> bc6h_block(const std::array<std::uint32_t, 3>& first, const std::array<std::uint32_t, 3>& second,
                                  const std::array<std::uint32_t, 16>& indices) {
  std::vector<std::byte> block(16);
  std::size_t bit = 0;
  const auto append = [&](std::uint32_t value, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n, ++bit) {
      block[bit / 8] |= static_cast<std::byte>(((value >> n) & 1u) << (bit % 8));
    }
  };
  append(3, 5);
  for (const std::uint32_t value : first) append(value, 10);
  for (const std::uint32_t value : second) append(value, 10);
  for (std::size_t texel = 0; texel < 16; ++texel) append(indices[texel], texel == 0 ? 3 : 4);
  EXPECT_EQ(bit, 128u);
  return block;
}

constexpr std::array<int, 16> kBc6hWeights = {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};

double unsigned_bc6h(int first, int second, std::uint32_t index) {
  const auto widened = [](int end) { return end == 0 ? 0 : end == 1023 ? 0xffff : ((end << 16) + 0x8000) >> 10; };
  const int weight = kBc6hWeights[index];
  const int value = ((64 - weight) * widened(first) + weight * widened(second) + 32) >> 6;
  return half_value(static_cast<std::uint32_t>((value * 31) >> 6));
}

double signed_bc6h(int first, int second, std::uint32_t index) {
  const auto widened = [](int end) {
    const int size = std::abs(end);
    const int wide = size == 0 ? 0 : size >= 511 ? 0x7fff : ((size << 15) + 0x4000) >> 9;
    return end < 0 ? -wide : wide;
  };
  const int weight = kBc6hWeights[index];
  const int value = ((64 - weight) * widened(first) + weight * widened(second) + 32) >> 6;
  const std::uint32_t size = static_cast<std::uint32_t>((std::abs(value) * 31) >> 5);
  return half_value(value < 0 ? size | 0x8000u : size);
}

TEST_P(GlHarness, SolidBlocksOfBc6hHaveOneColour) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const GlTexture texture = {.name = "atlas",
                             .format = GlFormat::kBc6hUnsigned,
                             .width = 4,
                             .height = 4,
                             .bytes = bc6h_block({300, 480, 700}, {300, 480, 700}, {})};
  // 480: (480 * 65536 + 32768) / 1024 = 30752, * 31 / 64 = 14895 = 0x3a2f, which is the half 0.77294921875.
  EXPECT_EQ(unsigned_bc6h(480, 480, 0), 0.77294921875);
  const Rgb colour = {unsigned_bc6h(300, 300, 0), unsigned_bc6h(480, 480, 0), unsigned_bc6h(700, 700, 0)};
  expect_texels(context, texture, std::vector<Rgb>(16, colour), 1e-6);
}

TEST_P(GlHarness, BlocksOfBc6hAreDecodedAsSpecified) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const std::array<std::uint32_t, 16> indices = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const std::array<int, 3> first = {0, 400, -300};
  const std::array<int, 3> second = {511, 350, 450};
  for (const GlFormat format : {GlFormat::kBc6hUnsigned, GlFormat::kBc6hSigned}) {
    const bool has_sign = format == GlFormat::kBc6hSigned;
    std::array<std::uint32_t, 3> first_bits = {}, second_bits = {};
    for (std::size_t c = 0; c < 3; ++c) {
      first_bits[c] = static_cast<std::uint32_t>(has_sign ? first[c] : std::abs(first[c])) & 1023u;
      second_bits[c] = static_cast<std::uint32_t>(second[c]);
    }
    std::vector<Rgb> texels(16);
    for (std::size_t texel = 0; texel < 16; ++texel) {
      for (std::size_t c = 0; c < 3; ++c) {
        texels[texel][c] = has_sign ? signed_bc6h(first[c], second[c], indices[texel])
                                    : unsigned_bc6h(std::abs(first[c]), second[c], indices[texel]);
      }
    }
    const GlTexture texture = {.name = "atlas",
                               .format = format,
                               .width = 4,
                               .height = 4,
                               .bytes = bc6h_block(first_bits, second_bits, indices)};
    expect_texels(context, texture, texels, 1e-6);
  }
}

// Eight-bit weights would give 257 values.
TEST_P(GlHarness, WeightsBetweenTwoTexelsHaveMoreThanEightBits) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const int count = 10001;
  std::vector<std::array<float, 2>> points;
  for (int n = 0; n < count; ++n) points.push_back({0.25f + 0.5f * static_cast<float>(n) / (count - 1), 0.5f});
  // 0 and 1 in each format.
  const std::vector<std::uint16_t> halves = {0, 0, 0, 0, 0x3c00, 0x3c00, 0x3c00, 0x3c00};
  const std::vector<std::uint32_t> shared = {0, 256u | 256u << 9 | 256u << 18 | 16u << 27};
  for (const GlTexture& texture :
       {GlTexture{"atlas", GlFormat::kRgb32f, 2, 1, bytes_of(std::vector<float>{0, 0, 0, 1, 1, 1})},
        GlTexture{"atlas", GlFormat::kRgba16f, 2, 1, bytes_of(halves)},
        GlTexture{"atlas", GlFormat::kRgb9E5, 2, 1, bytes_of(shared)}}) {
    const auto values = context.evaluate(kLookUp, {&texture, 1}, places(points));
    ASSERT_TRUE(values.ok()) << values.error().message;
    double largest_error = 0;
    for (std::size_t n = 0; n < points.size(); ++n) {
      largest_error = std::max(largest_error, std::abs(values.value()[3 * n] - (2.0 * points[n][0] - 0.5)));
    }
    EXPECT_LT(largest_error, 2e-7) << "format " << static_cast<int>(texture.format);
  }
}

TEST_P(GlHarness, SeveralTexturesKeepTheirNames) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const auto of_one = [](const char* name, float value) {
    return GlTexture{name, GlFormat::kRgb32f, 1, 1, bytes_of(std::vector<float>(3, value))};
  };
  const std::vector<GlTexture> textures = {of_one("crossings", 2), of_one("slices", 3), of_one("unused", 5)};
  const auto values = context.evaluate(R"(uniform sampler2D slices, crossings, unused;
vec3 run(vec3 a, vec3 b) { return vec3(texture(crossings, a.xy).r, texture(slices, a.xy).g, 7.0); }
)",
                                       textures, std::vector<float>(8, 0.5f));
  ASSERT_TRUE(values.ok()) << values.error().message;
  EXPECT_EQ(*values, (std::vector<float>{2, 3, 7}));
}

TEST_P(GlHarness, CubeMapsHaveSixFaces) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  GlTexture cube = {.name = "cube",
                    .format = GlFormat::kRgba8,
                    .width = 2,
                    .height = 2,
                    .bytes = {},
                    .filter = GlFilter::kNearest,
                    .cube = true};
  for (unsigned char number = 0; number < 6 * 4; ++number) {
    for (int channel = 0; channel < 4; ++channel) cube.bytes.push_back(std::byte{number});
  }
  const std::string shader =
      "uniform highp samplerCube cube;\nvec3 run(vec3 a, vec3 b) { return textureLod(cube, a, 0.0).rgb * 255.0; }\n";
  // Faces +x, -x, +y, -y, +z, -z; columns and rows of each as OpenGL has them.
  const std::vector<float> inputs = {2, 1,  1, 0, 0, 0, 0, 0, -2, 1, 1, 0, 0, 0, 0, 0, 1, 2, 1,  0, 0, 0, 0, 0,
                                     1, -2, 1, 0, 0, 0, 0, 0, 1,  1, 2, 0, 0, 0, 0, 0, 1, 1, -2, 0, 0, 0, 0, 0};
  const auto values = context.evaluate(shader, {&cube, 1}, inputs);
  ASSERT_TRUE(values.ok()) << values.error().message;
  const std::vector<float> expected = {0, 5, 11, 13, 17, 20};
  for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_NEAR((*values)[3 * k], expected[k], 1e-3) << k;
  cube.height = 1;
  EXPECT_FALSE(context.evaluate(shader, {&cube, 1}, inputs));
}

TEST_P(GlHarness, CompileErrorsNameTheLineOfTheText) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const std::string shader = "// line 1\nvec3 run(vec3 a, vec3 b) {\n  return a + undeclared_name;\n}\n";
  const auto values = context.evaluate(shader, {}, std::vector<float>(8));
  ASSERT_FALSE(values.ok());
  EXPECT_EQ(values.error().code, ErrorCode::kUsage);
  EXPECT_THAT(values.error().message, HasSubstr("0:3(")) << "as Mesa writes string 0, line 3";
  EXPECT_THAT(values.error().message, HasSubstr("undeclared_name"));
}

TEST_P(GlHarness, ShadersMayBringTheirVersion) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const std::string version =
      GetParam() == GlApi::kEs30 ? "#version 300 es\nprecision highp float;\n" : "#version 330\n";
  const auto values =
      context.evaluate(version + "vec3 run(vec3 a, vec3 b) { return a; }\n", {}, std::vector<float>(8, 2.5f));
  ASSERT_TRUE(values.ok()) << values.error().message;
  EXPECT_EQ(*values, std::vector<float>(3, 2.5f));
  const auto refused = context.evaluate(version + "\nvec3 run(vec3 a, vec3 b) { return x; }\n", {}, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, HasSubstr(GetParam() == GlApi::kEs30 ? "0:4(" : "0:3("));
}

TEST_P(GlHarness, RefusesWhatCannotBeDrawn) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const auto message = [&](GlTexture texture, std::size_t floats = 8) {
    const auto values = context.evaluate(kLookUp, {&texture, 1}, std::vector<float>(floats));
    return values.ok() ? "" : values.error().message;
  };
  const std::vector<std::byte> one = bytes_of(std::vector<float>(3));
  EXPECT_EQ(message({"atlas", GlFormat::kRgb32f, 1, 1, one}), "");
  EXPECT_EQ(message({"atlas", GlFormat::kRgb32f, 2, 1, one}), "texture atlas: 12 bytes rather than 24");
  EXPECT_EQ(message({"atlas", GlFormat::kBc6hSigned, 5, 4, one}), "texture atlas: 12 bytes rather than 32");
  EXPECT_EQ(message({"atlas", GlFormat::kRgb32f, 0, 1, one}), "0 x 1 texels; a side has 1 to 16384");
  EXPECT_EQ(message({"no_such", GlFormat::kRgb32f, 1, 1, one}), "the shader has no sampler2D no_such");
  EXPECT_EQ(message({"atlas", GlFormat::kRgb32f, 1, 1, one}, 12), "inputs are 8 floats each");
  // Lines of what stands behind the text are not taken for those of the text.
  const auto without_run = context.evaluate("vec3 walk(vec3 a) { return a; }\n", {}, {});
  ASSERT_FALSE(without_run.ok());
  EXPECT_THAT(without_run.error().message, AllOf(HasSubstr("0:10000"), HasSubstr("run")));
}

TEST_P(GlHarness, FramesAreTimedAndComeBack) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const auto timing = context.time_frames("vec4 shade(vec2 uv) { return vec4(uv, 0.25, 1.0); }\n", {}, 64, 32, 5);
  ASSERT_TRUE(timing.ok()) << timing.error().message;
  EXPECT_GT(timing->median_seconds, 0);
  EXPECT_LE(timing->fastest_seconds, timing->median_seconds);
  EXPECT_LT(timing->median_seconds, 10);
  ASSERT_EQ(timing->image.size(), 64u * 32 * 4);
  for (std::size_t y = 0; y < 32; ++y) {
    for (std::size_t x = 0; x < 64; ++x) {
      const float* pixel = &timing->image[4 * (64 * y + x)];
      ASSERT_EQ(pixel[0], (static_cast<float>(x) + 0.5f) / 64);
      ASSERT_EQ(pixel[1], (static_cast<float>(y) + 0.5f) / 32);
      ASSERT_EQ(pixel[2], 0.25f);
      ASSERT_EQ(pixel[3], 1);
    }
  }
}

TEST_P(GlHarness, MoreWorkTakesLonger) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  const auto seconds = [&](int steps) {
    const auto timing =
        context.time_frames("vec4 shade(vec2 uv) { float x = uv.x; for (int n = 0; n < " + std::to_string(steps) +
                                "; ++n) x = fract(x * 1.7 + uv.y); return vec4(x); }\n",
                            {}, 256, 256, 3);
    return timing.ok() ? timing->fastest_seconds : std::numeric_limits<double>::quiet_NaN();
  };
  EXPECT_GT(seconds(2000), 3 * seconds(20));
}

TEST(GlContexts, TwoLiveSideBySide) {
  SBRDF_MAKE_GL_CONTEXT(core, GlApi::kCore45);
  SBRDF_MAKE_GL_CONTEXT(es, GlApi::kEs30);
  const std::string shader = "vec3 run(vec3 a, vec3 b) { return a + b; }\n";
  const std::vector<float> inputs(8, 1);
  for (GlContext* context : {&core, &es, &core}) {
    const auto values = context->evaluate(shader, {}, inputs);
    ASSERT_TRUE(values.ok()) << values.error().message;
    EXPECT_EQ(*values, std::vector<float>(3, 2));
  }
  EXPECT_THAT(es.driver(), HasSubstr("OpenGL ES"));
  EXPECT_THAT(core.driver(), HasSubstr("Core Profile"));
}

}  // namespace
}  // namespace sbrdf::internal
