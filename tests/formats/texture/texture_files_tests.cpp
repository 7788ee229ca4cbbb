#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "formats/texture/dds.h"
#include "formats/texture/exr_texture.h"
#include "formats/texture/ktx2.h"

namespace sbrdf::internal {
namespace {

using namespace std::string_view_literals;
using testing::HasSubstr;

using Bytes = std::vector<std::byte>;
using Read = std::function<Result<Texture>(const Bytes&)>;

// Any bytes: what texels mean is no matter of files.
Texture texture_of(TexelFormat format, std::uint32_t width = 8, std::uint32_t height = 4) {
  Texture texture{format, width, height, std::vector<std::uint8_t>(texture_bytes(format, width, height))};
  std::iota(texture.bytes.begin(), texture.bytes.end(), std::uint8_t{7});
  return texture;
}

Result<Texture> read_exr(const Bytes& bytes) { return read_exr_texture(std::make_shared<MemorySource>(bytes)); }
Result<Texture> read_ktx(const Bytes& bytes) { return read_ktx2(bytes); }
Result<Texture> read_direct(const Bytes& bytes) { return read_dds(bytes); }

void expect_back(const Texture& texture, const Result<Bytes>& file, const Read& read) {
  ASSERT_TRUE(file.ok()) << file.error().message;
  const Result<Texture> back = read(*file);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->format, texture.format);
  EXPECT_EQ(back->width, texture.width);
  EXPECT_EQ(back->height, texture.height);
  EXPECT_EQ(back->bytes, texture.bytes);
}

void expect_every_other_length_refused(const Bytes& file, const Read& read) {
  for (std::size_t size = 0; size < file.size(); ++size) {
    const auto cut = read(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_FALSE(cut.ok()) << size;
    ASSERT_EQ(cut.error().code, ErrorCode::kInvalidFile) << size << ": " << cut.error().message;
    ASSERT_LE(cut.error().offset.value_or(0), size);
  }
  Bytes longer = file;
  longer.push_back({});
  const auto refused = read(longer);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, HasSubstr("after the end"));
}

// No byte may crash the reader, whatever it says; what is still read has the size that it claims.
void expect_every_byte_checked(const Bytes& file, const Read& read) {
  for (std::size_t k = 0; k < file.size(); ++k) {
    for (const int value : {0, 1, 2, 0x7F, 0x80, 0xFF}) {
      Bytes changed = file;
      changed[k] = static_cast<std::byte>(value);
      const Result<Texture> texture = read(changed);
      EXPECT_TRUE(!texture || check_texture(*texture)) << k;
    }
  }
}

template <class Number>
Error error_with(Bytes file, std::size_t offset, Number number, const Read& read) {
  std::memcpy(file.data() + offset, &number, sizeof(number));
  const Result<Texture> texture = read(file);
  EXPECT_FALSE(texture.ok()) << offset;
  return texture ? Error{} : texture.error();
}

constexpr std::array kKtx2Formats = {TexelFormat::kRgba32f, TexelFormat::kRgba16f, TexelFormat::kE5b9g9r9,
                                     TexelFormat::kBc6hUnsigned, TexelFormat::kBc6hSigned};
constexpr std::array kDdsFormats = {TexelFormat::kRgba32f, TexelFormat::kE5b9g9r9, TexelFormat::kBc6hUnsigned,
                                    TexelFormat::kBc6hSigned};

TEST(Ktx2, ComesBackByteForByte) {
  for (const TexelFormat format : kKtx2Formats) {
    for (const bool zstd : {false, true}) {
      for (const char* key : {"a", "Ab", "scale", "zebra"}) {
        const Texture texture = texture_of(format);
        expect_back(texture, write_ktx2(texture, {zstd, {{key, "value"}, {"b", ""}}}), read_ktx);
      }
    }
  }
}

TEST(Ktx2, RefusesEveryTruncationAndAnyByteMore) {
  for (const TexelFormat format : kKtx2Formats) {
    expect_every_other_length_refused(*write_ktx2(texture_of(format)), read_ktx);
    expect_every_byte_checked(*write_ktx2(texture_of(format)), read_ktx);
  }
  const Bytes packed = *write_ktx2(texture_of(TexelFormat::kRgba16f), {true, {}});
  expect_every_other_length_refused(packed, read_ktx);
  expect_every_byte_checked(packed, read_ktx);
}

TEST(Ktx2, RefusesATruncatedFrameWithTheSizesOfIt) {
  Bytes file = *write_ktx2(texture_of(TexelFormat::kRgba16f), {true, {}});
  std::uint64_t size = 0;
  std::memcpy(&size, file.data() + 88, sizeof(size));
  --size;
  file.pop_back();
  const Error cut = error_with(file, 88, size, read_ktx);
  EXPECT_EQ(cut.code, ErrorCode::kInvalidFile);
  EXPECT_THAT(cut.message, HasSubstr("zstd frame"));
}

TEST(Ktx2, NamesWhatItDoesNotRead) {
  const Bytes file = *write_ktx2(texture_of(TexelFormat::kRgba16f));
  const auto expect = [&](std::size_t offset, std::uint32_t number, const char* text) {
    const Error error = error_with(file, offset, number, read_ktx);
    EXPECT_EQ(error.code, ErrorCode::kUnsupported) << offset;
    EXPECT_EQ(error.offset, offset);
    EXPECT_THAT(error.message, HasSubstr(text));
  };
  expect(12, 106, "VkFormat 106");
  expect(12, 0, "VkFormat 0");
  expect(28, 1, "volume");
  expect(32, 1, "layers");
  expect(36, 6, "faces");
  expect(40, 0, "levels");
  expect(40, 3, "levels");
  expect(44, 1, "supercompression scheme 1");
  expect(20, 0, "0 x 4");
  expect(20, 0xFFFFFFFF, "sides");
  const Error primaries = error_with(file, 117, std::uint8_t{9}, read_ktx);
  EXPECT_EQ(primaries.code, ErrorCode::kUnsupported);
  EXPECT_EQ(primaries.offset, 117U);
}

TEST(Ktx2, RefusesSizesThatContradictEachOther) {
  const Bytes file = *write_ktx2(texture_of(TexelFormat::kRgba16f));
  const auto expect = [&](std::size_t offset, std::uint64_t number) {
    EXPECT_EQ(error_with(file, offset, number, read_ktx).code, ErrorCode::kInvalidFile) << offset;
  };
  for (const std::size_t offset : {80U, 88U, 96U}) {
    for (const std::uint64_t number : {std::uint64_t{0}, std::uint64_t{1}, ~std::uint64_t{0}, ~std::uint64_t{7}}) {
      expect(offset, number);
    }
  }
  for (const std::size_t offset : {16U, 48U, 52U, 56U, 60U, 64U, 72U}) {
    EXPECT_EQ(error_with(file, offset, ~std::uint32_t{0}, read_ktx).code, ErrorCode::kInvalidFile) << offset;
  }
}

TEST(Ktx2, AsksBeforeItUnpacksMuch) {
  Texture flat = texture_of(TexelFormat::kRgba32f, 4096, 1024);
  std::fill(flat.bytes.begin(), flat.bytes.end(), std::uint8_t{1});
  const Bytes file = *write_ktx2(flat, {true, {}});
  expect_back(flat, file, [](const Bytes& bytes) { return read_ktx2(bytes); });
  const auto refused = read_ktx2(file, {.bytes = flat.bytes.size() - 1});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(refused.error().message, HasSubstr("67108864 bytes"));
}

TEST(Ktx2, RefusesKeysThatAreNotSortedOrEndNowhere) {
  const Bytes file = *write_ktx2(texture_of(TexelFormat::kE5b9g9r9));
  const std::string text(reinterpret_cast<const char*>(file.data()), file.size());
  const std::size_t orientation = text.find("KTXorientation");
  const std::size_t writer = text.find("KTXwriter");
  EXPECT_THAT(error_with(file, writer, 'A', read_ktx).message, HasSubstr("sorted"));
  EXPECT_THAT(error_with(file, orientation, '\0', read_ktx).message, HasSubstr("empty"));
  EXPECT_THAT(error_with(file, orientation + 16, 'u', read_ktx).message, HasSubstr("rows"));
  EXPECT_THAT(error_with(file, orientation + 18, 'x', read_ktx).message, HasSubstr("padding"));
  for (const std::uint32_t size : {0U, 19U, 1000U, 0xFFFFFFFFU}) {
    EXPECT_FALSE(error_with(file, orientation - 4, size, read_ktx).message.empty()) << size;
  }
}

TEST(Ktx2, RefusesKeysThatItMayNotWrite) {
  const Texture texture = texture_of(TexelFormat::kRgba16f);
  const std::string zero("a\0b", 3);
  const std::vector<std::vector<std::pair<std::string, std::string>>> wrong = {
      {{"", "x"}}, {{"KTXswizzle", "rgba"}}, {{"ktxwhat", ""}}, {{zero, "x"}}, {{"x", zero}}, {{"a", "1"}, {"a", "2"}}};
  for (const auto& keys : wrong) {
    const auto file = write_ktx2(texture, {false, keys});
    ASSERT_FALSE(file.ok());
    EXPECT_EQ(file.error().code, ErrorCode::kUsage);
  }
}

TEST(Dds, ComesBackByteForByte) {
  for (const TexelFormat format : kDdsFormats) {
    const Texture texture = texture_of(format, 12, 8);
    expect_back(texture, write_dds(texture), read_direct);
    EXPECT_TRUE(recognises_dds(*write_dds(texture)));
  }
}

TEST(Dds, RefusesEveryTruncationAndAnyByteMore) {
  for (const TexelFormat format : kDdsFormats) {
    expect_every_other_length_refused(*write_dds(texture_of(format)), read_direct);
    expect_every_byte_checked(*write_dds(texture_of(format)), read_direct);
  }
}

TEST(Dds, NamesWhatItDoesNotRead) {
  const Bytes file = *write_dds(texture_of(TexelFormat::kBc6hUnsigned));
  const auto expect = [&](std::size_t offset, std::uint32_t number, const char* text) {
    const Error error = error_with(file, offset, number, read_direct);
    EXPECT_EQ(error.code, ErrorCode::kUnsupported) << offset;
    EXPECT_THAT(error.message, HasSubstr(text));
  };
  expect(12, 0xFFFFFFFC, "sides");
  expect(16, 6, "multiples of 4");
  expect(24, 2, "volume");
  expect(28, 4, "levels");
  expect(80, 0x40, "DX10");
  expect(84, 0x31545844, "DX10");
  expect(128, 10, "DXGI format 10");
  expect(132, 4, "2-D");
  expect(136, 4, "cube");
  expect(140, 2, "layers");
  EXPECT_EQ(error_with(file, 4, 100U, read_direct).code, ErrorCode::kInvalidFile);
  EXPECT_EQ(error_with(file, 76, 24U, read_direct).code, ErrorCode::kInvalidFile);
  EXPECT_THAT(error_with(file, 12, 65536U, read_direct).message, HasSubstr("truncated"));
}

TEST(ExrTexture, ComesBackByteForByte) {
  TexelCounts counts;
  std::vector<float> rgb(3 * 21 * 37);
  for (std::size_t k = 0; k < rgb.size(); ++k) rgb[k] = static_cast<float>(k) / 7 - 5;
  for (const TexelFormat format : {TexelFormat::kRgb32f, TexelFormat::kRgba16f}) {
    const auto texture = encode_texels(format, 21, 37, rgb, counts);
    expect_back(*texture, write_exr_texture(*texture), read_exr);
  }
  const auto with_alpha = encode_texels(TexelFormat::kRgba32f, 21, 37, rgb, counts);
  expect_back(*encode_texels(TexelFormat::kRgb32f, 21, 37, rgb, counts), write_exr_texture(*with_alpha), read_exr);
}

TEST(ExrTexture, RefusesTruncations) {
  TexelCounts counts;
  const std::vector<float> rgb(3 * 4 * 20, 0.5F);
  const Bytes file = *write_exr_texture(*encode_texels(TexelFormat::kRgb32f, 4, 20, rgb, counts));
  for (std::size_t size = 0; size < file.size(); ++size) {
    EXPECT_FALSE(read_exr(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size))).ok()) << size;
  }
}

// The library does not look at these sizes: what it then takes for the next attribute can ask for any number of bytes.
TEST(ExrTexture, RefusesAttributesOfASizeThatTheirTypeDoesNotHave) {
  TexelCounts counts;
  const std::vector<float> rgb(3 * 4 * 20, 0.5F);
  const Bytes file = *write_exr_texture(*encode_texels(TexelFormat::kRgb32f, 4, 20, rgb, counts));
  const std::string text(reinterpret_cast<const char*>(file.data()), file.size());
  for (const std::string_view attribute :
       {"compression\0compression\0"sv, "dataWindow\0box2i\0"sv, "displayWindow\0box2i\0"sv, "lineOrder\0lineOrder\0"sv,
        "pixelAspectRatio\0float\0"sv, "screenWindowCenter\0v2f\0"sv, "screenWindowWidth\0float\0"sv}) {
    const std::size_t size = text.find(attribute) + attribute.size();
    for (const std::int32_t number : {0, 2, 17}) {
      const Error error = error_with(file, size, number, read_exr);
      EXPECT_EQ(error.code, ErrorCode::kInvalidFile) << attribute;
      EXPECT_THAT(error.message, HasSubstr("another type or size")) << attribute;
    }
  }
}

TEST(ExrTexture, AsksBeforeItUnpacksMuch) {
  TexelCounts counts;
  const std::vector<float> rgb(3 * 4 * 20, 0.5F);
  const Bytes file = *write_exr_texture(*encode_texels(TexelFormat::kRgb32f, 4, 20, rgb, counts));
  const auto refused = read_exr_texture(std::make_shared<MemorySource>(file), {.bytes = 1000});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
}

TEST(TextureFiles, RefuseFormatsThatTheyDoNotHold) {
  const auto refused = [](const Result<Bytes>& file, const char* text) {
    ASSERT_FALSE(file.ok());
    EXPECT_EQ(file.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(file.error().message, HasSubstr(text));
  };
  refused(write_ktx2(texture_of(TexelFormat::kRgb32f)), "rgba32f");
  refused(write_dds(texture_of(TexelFormat::kRgb32f)), "rgba32f");
  refused(write_dds(texture_of(TexelFormat::kRgba16f)), "half floats");
  for (const TexelFormat format : {TexelFormat::kE5b9g9r9, TexelFormat::kBc6hUnsigned, TexelFormat::kBc6hSigned}) {
    refused(write_exr_texture(texture_of(format)), "can be written");
  }
}

TEST(TextureFiles, RefuseTexturesOfTheWrongSize) {
  Texture texture = texture_of(TexelFormat::kRgba32f);
  texture.bytes.pop_back();
  for (const auto& file : {write_ktx2(texture), write_dds(texture), write_exr_texture(texture)}) {
    ASSERT_FALSE(file.ok());
    EXPECT_EQ(file.error().code, ErrorCode::kUsage);
  }
}

}  // namespace
}  // namespace sbrdf::internal
