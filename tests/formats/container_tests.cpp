#include "formats/sbrdf/container.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

using Bytes = std::vector<std::byte>;

Bytes content_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

/// Bit by bit, from the polynomial.
std::uint32_t slow_checksum(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::byte b : bytes) {
    crc ^= static_cast<std::uint32_t>(b);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

/// The lowest byte first, `size` of them.
void append_number(Bytes& bytes, std::uint64_t value, int size) {
  for (int k = 0; k < size; ++k) bytes.push_back(static_cast<std::byte>(value >> (8 * k)));
}

const Bytes kIndex = content_of("an index");
const std::array<Bytes, 2> kPayloads = {content_of("first"), content_of("the second chunk")};

Bytes chunks() {
  Bytes all;
  for (const Bytes& payload : kPayloads) append_chunk(all, payload);
  return all;
}
Bytes valid_file() { return emit_container(kIndex, chunks()); }

constexpr std::size_t kHeadSize = 4 + 2 + 1 + 8 + 4;  // of valid_file()

struct Content {
  ContainerHead head;
  std::vector<Bytes> payloads;
};

/// Everything, from a heap block of exactly that size, so that the sanitizer sees a read beyond it.
Result<Content> read_exactly(std::span<const std::byte> bytes) {
  const auto copy = std::make_unique<std::byte[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), copy.get());
  const MemorySource source({copy.get(), bytes.size()});
  Result<ContainerHead> head = read_head(source);
  if (!head) return head.error();
  Content content = {*head, {}};
  std::uint64_t offset = head->chunks_offset();
  for (const Bytes& payload : kPayloads) {
    const std::uint64_t size = payload.size() + kChecksumSize;
    Result<Bytes> chunk = read_chunk(source, offset, size);
    if (!chunk) return chunk.error();
    content.payloads.push_back(*std::move(chunk));
    offset += size;
  }
  return content;
}

void expect_refused(std::span<const std::byte> file, const std::string& clause,
                    ErrorCode code = ErrorCode::kInvalidFile, const std::string& what = "") {
  const Result<Content> result = read_exactly(file);
  ASSERT_FALSE(result) << clause << ' ' << what;
  EXPECT_EQ(result.error().code, code) << what;
  EXPECT_THAT(result.error().message, StartsWith("[" + clause + "]")) << what;
}

TEST(Checksum, IsTheCrc32OfZlibAndPng) {
  EXPECT_EQ(checksum(content_of("123456789")), 0xCBF43926U);
  EXPECT_EQ(checksum({}), 0U);
  EXPECT_EQ(checksum(content_of("IEND")), 0xAE426082U);  // ends every PNG file
  std::mt19937 random(1);
  for (std::size_t size = 1; size < 300; size += 7) {
    Bytes bytes(size);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random());
    EXPECT_EQ(checksum(bytes), slow_checksum(bytes));
  }
}

TEST(EmitContainer, LaysOutEveryByteAsTheSpecificationSays) {
  Bytes expected = content_of("\x89SBF");
  append_number(expected, 1, 1);
  append_number(expected, 0, 1);
  append_number(expected, 8, 1);  // "an index"
  expected.insert(expected.end(), kIndex.begin(), kIndex.end());
  append_number(expected, slow_checksum(expected), 4);
  ASSERT_EQ(expected.size(), kHeadSize);
  for (const Bytes& payload : kPayloads) {
    expected.insert(expected.end(), payload.begin(), payload.end());
    append_number(expected, slow_checksum(payload), 4);
  }
  EXPECT_EQ(valid_file(), expected);
}

TEST(EmitContainer, WritesTheVersionAskedFor) {
  const Bytes file = emit_container(kIndex, chunks(), 0x12, 0x34);
  EXPECT_EQ((Bytes{file.begin() + 4, file.begin() + 6}), content_of("\x12\x34"));
}

TEST(AppendChunk, LeavesOutAChunkWithoutPayload) {
  Bytes file = content_of("before");
  append_chunk(file, {});
  EXPECT_EQ(file, content_of("before"));
  append_chunk(file, content_of("x"));
  EXPECT_EQ(file.size(), 6U + 1U + 4U);
}

TEST(Container, GivesBackIndexAndChunks) {
  const Result<Content> content = read_exactly(valid_file());
  ASSERT_TRUE(content);
  EXPECT_EQ(content->head.index, kIndex);
  EXPECT_EQ(content->head.version(), "1.0");
  EXPECT_EQ(content->head.chunks_offset(), kHeadSize);
  EXPECT_EQ(content->payloads, (std::vector<Bytes>{kPayloads.begin(), kPayloads.end()}));
}

TEST(Container, MayHaveAnEmptyIndexAndNoChunk) {
  const Bytes file = emit_container({}, {});
  EXPECT_EQ(file.size(), 11U);
  const Result<ContainerHead> head = read_head(MemorySource(file));
  ASSERT_TRUE(head);
  EXPECT_TRUE(head->index.empty());
}

TEST(ReadHead, RefusesEveryPrefixThatIsTruncatedWithinTheHead) {
  const Bytes file = valid_file();
  for (std::size_t size = 0; size < kHeadSize; ++size) {
    expect_refused(std::span(file).first(size), size < 4 ? "SB-1-1" : "SB-1-4", ErrorCode::kInvalidFile,
                   std::to_string(size) + " bytes");
  }
}

TEST(Container, RefusesEverySingleFlippedBitWithTheClauseOfItsPlace) {
  Bytes file = valid_file();
  for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
    const std::size_t byte = bit / 8;
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    file[byte] ^= mask;
    const std::string where = "byte " + std::to_string(byte) + ", bit " + std::to_string(bit % 8);
    // A size with a flipped bit is one of another place for the checksum. The 8 grows to 24, which the file has, or by
    // 32 and more, which it has not; the highest bit takes the next byte into the size.
    const bool major = byte == 4;
    const std::string clause = byte < 4 ? "SB-1-1" : major ? "SB-1-3" : byte < kHeadSize ? "SB-1-6" : "SB-1-7";
    const bool beyond_end = byte == 6 && bit % 8 >= 5;
    expect_refused(file, beyond_end ? "SB-1-4" : clause, major ? ErrorCode::kUnsupported : ErrorCode::kInvalidFile,
                   where);
    file[byte] ^= mask;
  }
}

TEST(ReadHead, RefusesWhatIsNoContainer) {
  expect_refused({}, "SB-1-1");
  expect_refused(content_of("\x89SBR and more"), "SB-1-1");
  expect_refused(content_of("a text file"), "SB-1-1");
}

TEST(ReadHead, RefusesOtherMajorVersionsAsUnsupportedAndNamesThem) {
  for (const int number : {0, 2, 3, 0xFF}) {
    const auto major = static_cast<std::uint8_t>(number);
    const Bytes file = emit_container(kIndex, chunks(), major, 5);
    expect_refused(file, "SB-1-3", ErrorCode::kUnsupported);
    EXPECT_THAT(read_head(MemorySource(file)).error().message, HasSubstr(std::to_string(major) + ".5"));
  }
}

TEST(ReadHead, TakesEveryMinorVersion) {
  for (const int number : {0, 1, 0xFF}) {
    const auto minor = static_cast<std::uint8_t>(number);
    const Result<Content> content = read_exactly(emit_container(kIndex, chunks(), 1, minor));
    ASSERT_TRUE(content);
    EXPECT_EQ(content->head.minor, minor);
    EXPECT_EQ(content->head.version(), "1." + std::to_string(minor));
  }
}

TEST(ReadHead, RefusesAnIndexThatDoesNotFitBeforeItAllocatesIt) {
  const auto with_size = [](const std::string& size) {
    return content_of(std::string("\x89SBF\1\0", 6) + size + "index");
  };
  expect_refused(with_size("\x7f"), "SB-1-4");
  expect_refused(with_size("\x80\x80\x80\x10"), "SB-1-4");  // 2^25
  expect_refused(with_size("\x81\x80\x80\x10"), "SB-1-5");
  expect_refused(with_size("\xff\xff\xff\x7f"), "SB-1-5");
  expect_refused(with_size("\xff\xff\xff\xff\x01"), "SB-1-5");
  expect_refused(with_size(std::string("\x81\0", 2)), "SB-1-5");  // a needless byte
}

TEST(ReadHead, TakesAnIndexUpToTheLargestSize) {
  EXPECT_TRUE(read_head(MemorySource(emit_container(Bytes(kMaxIndexSize), {}))));
  const Result<ContainerHead> larger = read_head(MemorySource(emit_container(Bytes(kMaxIndexSize + 1), {})));
  ASSERT_FALSE(larger);
  EXPECT_THAT(larger.error().message, StartsWith("[SB-1-5]"));
}

TEST(ReadHead, ReadsHeaderAndIndexAndNothingElse) {
  const Bytes file = valid_file();
  std::vector<int> reads(file.size(), 0);
  const CallbackSource source(file.size(), [&](std::uint64_t offset, std::span<std::byte> target) {
    for (std::size_t k = 0; k < target.size(); ++k) {
      ++reads[offset + k];
      target[k] = file[offset + k];
    }
    return ok_status();
  });
  ASSERT_TRUE(read_head(source));
  for (std::size_t k = 0; k < file.size(); ++k) EXPECT_EQ(reads[k], k < kHeadSize ? 1 : 0) << k;
}

TEST(Container, PassesOnTheErrorOfItsSource) {
  const Bytes file = valid_file();
  for (int good = 0; good < 2; ++good) {
    int reads = 0;
    const CallbackSource source(file.size(), [&](std::uint64_t offset, std::span<std::byte> target) -> Status {
      if (reads++ >= good) return Error{ErrorCode::kIo, "the cable is out", {}};
      return MemorySource(file).read(offset, target);
    });
    const Result<ContainerHead> head = read_head(source);
    ASSERT_FALSE(head);
    EXPECT_EQ(head.error().code, ErrorCode::kIo);
    EXPECT_EQ(head.error().message, "the cable is out");
  }
  const CallbackSource broken(file.size(), [](std::uint64_t, std::span<std::byte>) -> Status {
    return Error{ErrorCode::kIo, "the cable is out", {}};
  });
  const Result<Bytes> chunk = read_chunk(broken, kHeadSize, 9);
  ASSERT_FALSE(chunk);
  EXPECT_EQ(chunk.error().code, ErrorCode::kIo);
}

TEST(ReadChunk, RefusesWhatCannotHoldAByteAndAChecksum) {
  const Bytes file = valid_file();
  for (std::uint64_t size = 0; size <= kChecksumSize; ++size) {
    const Result<Bytes> chunk = read_chunk(MemorySource(file), kHeadSize, size);
    ASSERT_FALSE(chunk) << size;
    EXPECT_THAT(chunk.error().message, StartsWith("[SB-1-7]"));
  }
}

TEST(ReadChunk, RefusesRangesBeyondTheSource) {
  const Bytes file = valid_file();
  const std::uint64_t most = ~std::uint64_t{0};
  for (const auto& [offset, size] : {std::pair{std::uint64_t{kHeadSize}, file.size()},
                                     {file.size() + 1, std::uint64_t{5}},
                                     {std::uint64_t{kHeadSize}, most},
                                     {most, std::uint64_t{9}},
                                     {most, most}}) {
    const Result<Bytes> chunk = read_chunk(MemorySource(file), offset, size);
    ASSERT_FALSE(chunk) << offset << ' ' << size;
    EXPECT_EQ(chunk.error().code, ErrorCode::kInvalidFile);
  }
}

TEST(IsContainer, LooksAtTheMagicOnly) {
  Bytes file = valid_file();
  file.resize(4);
  EXPECT_TRUE(is_container(file));
  file.resize(3);
  EXPECT_FALSE(is_container(file));
}

TEST(ByteSource, GivesTheRangeAskedFor) {
  const Bytes bytes = content_of("0123456789");
  const MemorySource memory(bytes);
  EXPECT_EQ(memory.size(), 10U);
  for (std::size_t offset = 0; offset <= 10; ++offset) {
    for (std::size_t size = 0; offset + size <= 10; ++size) {
      const Result<Bytes> range = read_range(memory, offset, size);
      ASSERT_TRUE(range);
      EXPECT_EQ(*range, content_of(std::string("0123456789").substr(offset, size)));
    }
    EXPECT_FALSE(read_range(memory, offset, 11 - offset));
  }
}

}  // namespace
}  // namespace sbrdf::internal
