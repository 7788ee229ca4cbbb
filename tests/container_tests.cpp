#include "formats/sbrdf/container.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sbrdf {
namespace {

using testing::HasSubstr;

using Bytes = std::vector<std::byte>;

constexpr std::size_t kEntries = 16;
constexpr std::size_t kEntrySize = 40;

Bytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

/// One chunk that is stored raw, one that is compressed, and an empty one.
std::vector<Chunk> valid_chunks() {
  return {{"ABCD", bytes_of("raw, too short to pack")}, {"ZERO", Bytes(5000)}, {"EMPT", {}}};
}

Bytes valid_file() { return emit_container(valid_chunks()); }

/// From a heap block of exactly that size, so that the sanitizer sees a read beyond it.
Result<Container> parse_exactly(std::span<const std::byte> bytes) {
  const auto copy = std::make_unique<std::byte[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), copy.get());
  return parse_container({copy.get(), bytes.size()});
}

template <class T>
T number_at(const Bytes& file, std::size_t offset) {
  T value;
  std::memcpy(&value, file.data() + offset, sizeof(T));
  return value;
}

template <class T>
void put(Bytes& file, std::size_t offset, T value) {
  std::memcpy(file.data() + offset, &value, sizeof(T));
}

/// Makes the checksum of the table fit again after it was changed.
void seal(Bytes& file) {
  const std::size_t end = kEntries + number_at<std::uint32_t>(file, 12) * kEntrySize;
  put(file, end, static_cast<std::uint64_t>(XXH3_64bits(file.data(), end)));
}

void expect_refused(const Bytes& file, const std::string& what, ErrorCode code = ErrorCode::kInvalidFile) {
  const Result<Container> result = parse_exactly(file);
  ASSERT_FALSE(result) << what;
  EXPECT_EQ(result.error().code, code) << what;
  EXPECT_THAT(result.error().message, HasSubstr(what));
}

TEST(Container, GivesBackItsChunksInOrder) {
  const Result<Container> container = parse_exactly(valid_file());
  ASSERT_TRUE(container);
  EXPECT_EQ(container->major, kContainerMajor);
  EXPECT_EQ(container->minor, kContainerMinor);
  const std::vector<Chunk> expected = valid_chunks();
  ASSERT_EQ(container->chunks.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(container->chunks[k].name, expected[k].name);
    EXPECT_EQ(container->chunks[k].bytes, expected[k].bytes);
    EXPECT_TRUE(container->has(expected[k].name));
    EXPECT_EQ(container->find(expected[k].name).size(), expected[k].bytes.size());
  }
  EXPECT_FALSE(container->has("NONE"));
  EXPECT_TRUE(container->find("NONE").empty());
}

TEST(Container, MayHoldNoChunkAtAll) {
  const Result<Container> container = parse_exactly(emit_container({}));
  ASSERT_TRUE(container);
  EXPECT_TRUE(container->chunks.empty());
}

TEST(Container, IsLaidOutAsTheSpecificationSays) {
  const Bytes file = valid_file();
  const std::array<unsigned char, 8> magic = {0x89, 'S', 'B', 'R', 'D', 'F', '\r', '\n'};
  EXPECT_EQ(std::memcmp(file.data(), magic.data(), 8), 0);
  EXPECT_EQ(number_at<std::uint16_t>(file, 8), 0);
  EXPECT_EQ(number_at<std::uint16_t>(file, 10), 1);
  EXPECT_EQ(number_at<std::uint32_t>(file, 12), 3U);
  std::uint64_t offset = kEntries + 3 * kEntrySize + 8;
  EXPECT_EQ(number_at<std::uint64_t>(file, offset - 8), XXH3_64bits(file.data(), offset - 8));
  const std::vector<Chunk> chunks = valid_chunks();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t entry = kEntries + k * kEntrySize;
    const auto stored = number_at<std::uint64_t>(file, entry + 16);
    EXPECT_EQ(std::memcmp(file.data() + entry, chunks[k].name.data(), 4), 0);
    EXPECT_EQ(number_at<std::uint32_t>(file, entry + 4), chunks[k].name == "ZERO" ? 1U : 0U);
    EXPECT_EQ(number_at<std::uint64_t>(file, entry + 8), offset);
    EXPECT_EQ(number_at<std::uint64_t>(file, entry + 24), chunks[k].bytes.size());
    EXPECT_EQ(number_at<std::uint64_t>(file, entry + 32), XXH3_64bits(file.data() + offset, stored));
    offset += stored;
  }
  EXPECT_EQ(offset, file.size());
}

TEST(Container, HasTheSameBytesEveryTime) { EXPECT_EQ(valid_file(), valid_file()); }

TEST(Container, PacksAChunkOnlyWhereThatMakesItSmaller) { EXPECT_LT(valid_file().size(), 250U); }

TEST(ParseContainer, RefusesEveryTruncatedPrefix) {
  const Bytes file = valid_file();
  for (std::size_t size = 0; size < file.size(); ++size) {
    EXPECT_FALSE(parse_exactly(std::span(file).first(size))) << size << " of " << file.size() << " bytes";
  }
}

TEST(ParseContainer, RefusesEveryTrailingByte) {
  for (int value = 0; value < 256; ++value) {
    Bytes file = valid_file();
    file.push_back(static_cast<std::byte>(value));
    EXPECT_FALSE(parse_exactly(file)) << value;
  }
}

TEST(ParseContainer, RefusesEverySingleFlippedBit) {
  Bytes file = valid_file();
  for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    file[bit / 8] ^= mask;
    EXPECT_FALSE(parse_exactly(file)) << "byte " << bit / 8 << ", bit " << bit % 8;
    file[bit / 8] ^= mask;
  }
}

TEST(ParseContainer, RefusesANewerMajorVersionAsUnsupported) {
  Bytes file = valid_file();
  put<std::uint16_t>(file, 8, kContainerMajor + 1);
  seal(file);
  expect_refused(file, "newer", ErrorCode::kUnsupported);
}

TEST(ParseContainer, TakesANewerMinorVersion) {
  Bytes file = valid_file();
  put<std::uint16_t>(file, 10, 999);
  seal(file);
  const Result<Container> container = parse_exactly(file);
  ASSERT_TRUE(container);
  EXPECT_EQ(container->minor, 999);
}

TEST(ParseContainer, RefusesWhatIsNoContainer) {
  expect_refused({}, "magic");
  expect_refused(bytes_of("\x89SBRDF\n\n and more, that was mangled by a text transfer"), "magic");
  expect_refused(bytes_of("a text file"), "magic");
}

TEST(ParseContainer, RefusesAbsurdCountsBeforeItReadsThem) {
  for (const std::uint32_t count : {4U, 4097U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
    Bytes file = valid_file();
    put(file, 12, count);
    EXPECT_FALSE(parse_exactly(file)) << count;
  }
}

TEST(ParseContainer, RefusesAbsurdSizesBeforeItAllocatesThem) {
  constexpr std::size_t kPacked = kEntries + kEntrySize;
  for (const std::uint64_t size : {1ULL << 30U, (1ULL << 30U) + 1, 1ULL << 62U, ~0ULL}) {
    for (const std::size_t field : {16U, 24U}) {
      Bytes file = valid_file();
      put(file, kPacked + field, size);
      seal(file);
      EXPECT_FALSE(parse_exactly(file)) << size << " in field " << field;
    }
  }
}

TEST(ParseContainer, RefusesAChunkWhoseDecodedSizeIsNotThatOfItsFrame) {
  Bytes file = valid_file();
  put<std::uint64_t>(file, kEntries + kEntrySize + 24, 5001);
  seal(file);
  expect_refused(file, "zstd frame");
}

TEST(ParseContainer, RefusesARawChunkOfTwoSizes) {
  Bytes file = valid_file();
  put<std::uint64_t>(file, kEntries + 24, 21);
  seal(file);
  expect_refused(file, "sizes differ");
}

TEST(ParseContainer, RefusesAnUnknownCodingAsUnsupported) {
  Bytes file = valid_file();
  put<std::uint32_t>(file, kEntries + 4, 2);
  seal(file);
  expect_refused(file, "coding", ErrorCode::kUnsupported);
}

TEST(ParseContainer, RefusesChunksThatOverlapOrLeaveAGap) {
  for (const int shift : {-1, 1, 1000}) {
    Bytes file = valid_file();
    const std::size_t field = kEntries + kEntrySize + 8;
    put(file, field, number_at<std::uint64_t>(file, field) + static_cast<std::uint64_t>(shift));
    seal(file);
    expect_refused(file, "not where the last one ends");
  }
}

TEST(ParseContainer, NamesTheDamagedChunk) {
  Bytes file = valid_file();
  file[kEntries + 3 * kEntrySize + 8] ^= std::byte{1};
  expect_refused(file, "chunk ABCD: checksum");
}

TEST(ParseContainer, RefusesAPackedChunkThatIsNoZstdFrame) {
  Bytes file = emit_container(std::vector<Chunk>{{"RAWS", bytes_of("12345678901234567890")}});
  put<std::uint32_t>(file, kEntries + 4, 1);
  put<std::uint64_t>(file, kEntries + 24, 4000);
  seal(file);
  expect_refused(file, "zstd frame");
}

TEST(ParseContainer, RefusesNamesThatAreNotFourVisibleCharacters) {
  for (const char* name : {"A\nBC", "A\x1b[2", "\0\0\0\0", "AB\xc3\xa9"}) {
    Bytes file = valid_file();
    std::memcpy(file.data() + kEntries, name, 4);
    seal(file);
    EXPECT_FALSE(parse_exactly(file));
  }
}

TEST(ParseContainer, RefusesTwoChunksOfOneName) {
  Bytes file = valid_file();
  std::memcpy(file.data() + kEntries + 2 * kEntrySize, "ABCD", 4);
  seal(file);
  EXPECT_FALSE(parse_exactly(file));
}

TEST(IsContainer, LooksAtTheMagicOnly) {
  Bytes file = valid_file();
  file.resize(8);
  EXPECT_TRUE(is_container(file));
  file.resize(7);
  EXPECT_FALSE(is_container(file));
}

}  // namespace
}  // namespace sbrdf
