#include "formats/merl/merl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;

void append_little_endian(Bytes& bytes, std::uint64_t bits, int size) {
  for (int n = 0; n < size; ++n) bytes.push_back(static_cast<std::byte>((bits >> (8 * n)) & 0xff));
}

Bytes header_of(std::int32_t a, std::int32_t b, std::int32_t c) {
  Bytes bytes;
  for (const std::int32_t count : {a, b, c}) append_little_endian(bytes, static_cast<std::uint32_t>(count), 4);
  return bytes;
}

Bytes file_of(const MerlShape& shape, const std::vector<double>& values) {
  Bytes bytes = header_of(static_cast<std::int32_t>(shape[0]), static_cast<std::int32_t>(shape[1]),
                          static_cast<std::int32_t>(shape[2]));
  for (const double value : values) append_little_endian(bytes, std::bit_cast<std::uint64_t>(value), 8);
  return bytes;
}

// A copy of exactly this size on the heap, so that the sanitizer sees every read past its end.
template <class Use>
auto with_exact_copy(const Bytes& bytes, std::size_t size, const Use& use) {
  const std::unique_ptr<std::byte[]> copy(new std::byte[size]);
  std::copy_n(bytes.begin(), size, copy.get());
  return use(std::span<const std::byte>(copy.get(), size));
}

TEST(MerlLayout, CellIndexIsPhiDFastestThenThetaD) {
  EXPECT_EQ(merl_cell_index(kMerlShape, 0, 0, 1), 1u);
  EXPECT_EQ(merl_cell_index(kMerlShape, 0, 1, 0), 180u);
  EXPECT_EQ(merl_cell_index(kMerlShape, 1, 0, 0), 16200u);
  EXPECT_EQ(merl_cell_index(kMerlShape, 89, 89, 179), 1457999u);
  EXPECT_EQ(merl_cell_index({2, 3, 5}, 1, 2, 4), 29u);
}

TEST(MerlLayout, PublishedFilesHaveTheirSize) { EXPECT_EQ(merl_file_size(kMerlShape), 34992012u); }

TEST(MerlLayout, LargestSizeDoesNotWrap) {
  EXPECT_EQ(merl_file_size({kMerlMaxCount, kMerlMaxCount, kMerlMaxCount}), 12u + 24u * (std::uint64_t{1} << 36));
}

TEST(MerlLayout, CentresAndEdgesOfThetaHGrowWithTheSquare) {
  for (std::uint32_t cell = 0; cell < 90; ++cell) {
    EXPECT_NEAR(degrees_from_radians(merl_theta_h(cell + 0.5, 90)), (cell + 0.5) * (cell + 0.5) / 90, 1e-13);
    EXPECT_NEAR(degrees_from_radians(merl_theta_h(cell, 90)), cell * cell / 90.0, 1e-13);
    EXPECT_NEAR(merl_theta_h_position(merl_theta_h(cell + 0.5, 90), 90), cell + 0.5, 1e-13);
    // The rule of the published reader.
    EXPECT_EQ(static_cast<std::uint32_t>(90 * std::sqrt(merl_theta_h(cell + 0.5, 90) / (kPi / 2))), cell);
  }
  EXPECT_EQ(merl_theta_h(90, 90), kPi / 2);
}

TEST(MerlLayout, ThetaDAndPhiDAreLinear) {
  EXPECT_NEAR(degrees_from_radians(merl_theta_d(30.5, 90)), 30.5, 1e-13);
  EXPECT_NEAR(degrees_from_radians(merl_phi_d(30.5, 180)), 30.5, 1e-13);
  EXPECT_NEAR(degrees_from_radians(merl_phi_d(30.5, 360)), 15.25, 1e-13);
}

TEST(MerlParse, ReadsHandWrittenBytes) {
  const std::vector<double> values = {1, 2, 3, 4, 5, 6};
  const auto table = parse_merl(file_of({1, 2, 1}, values));
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->shape, (MerlShape{1, 2, 1}));
  EXPECT_EQ(table->values, values);
}

TEST(MerlParse, ReturnsEveryBitPatternThroughEmit) {
  const double payload = std::bit_cast<double>(std::uint64_t{0xfff4'0000'dead'beef});
  const std::vector<double> values = {
      payload, -1, -0.0, std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::infinity(), 1e12};
  const Bytes file = file_of({1, 1, 2}, values);
  const auto table = parse_merl(file);
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(emit_merl(*table), file);
}

TEST(MerlParse, RejectsEveryTruncatedPrefix) {
  const Bytes file = file_of({2, 2, 2}, std::vector<double>(24, 1));
  ASSERT_TRUE(parse_merl(file).ok());
  for (std::size_t size = 0; size < file.size(); ++size) {
    const auto table = with_exact_copy(file, size, parse_merl);
    ASSERT_FALSE(table.ok()) << size;
    if (size == 12 + 4 * 24) continue;  // the size of float32 values, see MerlRecognition
    EXPECT_EQ(table.error().code, ErrorCode::kInvalidFile);
    EXPECT_NE(table.error().message.find("truncated"), std::string::npos) << table.error().message;
    EXPECT_EQ(table.error().offset, size < 12 ? size / 4 * 4 : size);
  }
}

TEST(MerlParse, RejectsTrailingBytes) {
  Bytes file = file_of({2, 2, 2}, std::vector<double>(24, 1));
  const std::size_t size = file.size();
  for (int extra = 0; extra < 16; ++extra) {
    file.push_back({});
    const auto table = with_exact_copy(file, file.size(), parse_merl);
    ASSERT_FALSE(table.ok());
    EXPECT_EQ(table.error().offset, size);
  }
}

TEST(MerlParse, RejectsEachCountOutsideItsRange) {
  const std::int32_t lowest = std::numeric_limits<std::int32_t>::min();  // 2^31 as unsigned
  for (const std::int32_t bad : {0, -1, -90, 4097, std::numeric_limits<std::int32_t>::max(), lowest}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<std::int32_t, 3> counts = {1, 1, 1};
      counts[axis] = bad;
      Bytes file = header_of(counts[0], counts[1], counts[2]);
      file.resize(12 + 24);
      const auto table = parse_merl(file);
      ASSERT_FALSE(table.ok());
      EXPECT_EQ(table.error().offset, 4 * axis);
      EXPECT_NE(table.error().message.find(std::to_string(bad)), std::string::npos) << table.error().message;
    }
  }
}

TEST(MerlParse, RejectsShapeThatOnlyMatchesInProduct) {
  // Products of 0 and 1 once cut to 32 bits, and -1 x -1 x 1.
  for (const auto& counts : {std::array{65536, 65536, 1}, std::array{65537, 65537, 1}, std::array{-1, -1, 1},
                             std::array{-2147483647 - 1, 2, 1}, std::array{715827883, 3, 1}}) {
    Bytes file = header_of(counts[0], counts[1], counts[2]);
    EXPECT_FALSE(parse_merl(file).ok());
    file.resize(12 + 24);
    EXPECT_FALSE(parse_merl(file).ok());
  }
}

TEST(MerlParse, RefusesTheSizeBeforeAllocating) {
  Bytes file = header_of(4096, 4096, 4096);
  file.resize(100);
  EXPECT_FALSE(parse_merl(file).ok());
}

TEST(MerlRecognition, NeedsTheExactSize) {
  const Bytes head = header_of(90, 90, 180);
  EXPECT_TRUE(recognises_merl(head, 34992012));
  EXPECT_FALSE(recognises_merl(head, 34992011));
  EXPECT_FALSE(recognises_merl(head, 34992013));
  EXPECT_FALSE(recognises_merl(std::span(head).first(11), 34992012));
}

TEST(MerlRecognition, TruncatedFileStillResemblesATable) {
  EXPECT_TRUE(resembles_merl(header_of(90, 90, 180), 5000));
  EXPECT_FALSE(resembles_merl(std::span<const std::byte>{}, 0));
  EXPECT_FALSE(resembles_merl(header_of(90, 0, 180), 5000));
}

TEST(MerlRecognition, NamesFloat32Values) {
  const auto shape = parse_merl_shape(header_of(20, 20, 40), 12 + 3 * 4 * 16'000);
  ASSERT_FALSE(shape.ok());
  EXPECT_EQ(shape.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(shape.error().message, testing::HasSubstr("20 x 20 x 40 cells that has exactly the size of float32"));
  EXPECT_TRUE(resembles_merl(header_of(20, 20, 40), 12 + 3 * 4 * 16'000));
  const auto head = parse_merl_head(header_of(20, 20, 40), 12 + 3 * 4 * 16'000);
  ASSERT_TRUE(head.ok());
  EXPECT_EQ(head->value_size, 4U);
  EXPECT_FALSE(parse_merl_head(header_of(20, 20, 40), 12 + 3 * 4 * 16'000 + 1).ok());
}

TEST(MerlRecognition, NamesBigEndianTables) {
  const Bytes head = header_of(0x14000000, 0x14000000, 0x28000000);
  for (const std::uint64_t value_size : {4, 8}) {
    const std::uint64_t size = 12 + 3 * value_size * 16'000;
    const auto shape = parse_merl_shape(head, size);
    ASSERT_FALSE(shape.ok());
    EXPECT_EQ(shape.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(shape.error().message, testing::HasSubstr("big-endian"));
    EXPECT_TRUE(resembles_merl(head, size));
    // Another size may be anything.
    EXPECT_FALSE(resembles_merl(head, size + 1));
    EXPECT_EQ(parse_merl_shape(head, size + 1).error().code, ErrorCode::kInvalidFile);
  }
}

TEST(MerlRecognition, TextAndOtherFormatsDoNotResembleATable) {
  for (const char* text : {"# a text file\n", "tensor_file\0\1", "SCATFUN\1\0\0\0\1", "\1\0\0\0hello world"}) {
    Bytes head(12);
    std::memcpy(head.data(), text, 12);
    EXPECT_FALSE(resembles_merl(head, 100)) << text;
  }
}

}  // namespace
}  // namespace sbrdf::internal
