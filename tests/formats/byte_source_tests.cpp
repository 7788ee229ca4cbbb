#include "formats/core/byte_source.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

namespace sbrdf::internal {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::string_view text) {
  Bytes bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

TEST(ByteSource, GivesAViewWhereBytesHaveAnAddress) {
  const Bytes bytes = bytes_of("abcdef");
  const MemorySource borrowed(bytes);
  EXPECT_EQ(borrowed.view()->data(), bytes.data());
  const OwnedMemorySource owned(bytes, "some/file");
  EXPECT_NE(owned.view()->data(), bytes.data());
  EXPECT_EQ(owned.size(), 6U);
  EXPECT_EQ(owned.path(), "some/file");
  EXPECT_EQ(borrowed.path(), "");
  EXPECT_EQ(read_range(owned, 2, 3).value(), bytes_of("cde"));
  const CallbackSource called(6, [](std::uint64_t, std::span<std::byte>) { return ok_status(); });
  EXPECT_EQ(called.view(), std::nullopt);
}

TEST(ReadStart, EndsWhereTheSourceDoes) {
  const Bytes bytes = bytes_of("abcdef");
  EXPECT_EQ(read_start(MemorySource(bytes), 2).value(), bytes_of("ab"));
  EXPECT_EQ(read_start(MemorySource(bytes), 100).value(), bytes);
  EXPECT_TRUE(read_start(MemorySource({}), 100)->empty());
}

TEST(WithView, CopiesOnlyWhatHasNone) {
  const auto owned = std::make_shared<OwnedMemorySource>(bytes_of("abcdef"));
  EXPECT_EQ(with_view(owned).value(), owned);
  int reads = 0;
  const auto called = std::make_shared<CallbackSource>(6, [&](std::uint64_t offset, std::span<std::byte> target) {
    ++reads;
    return owned->read(offset, target);
  });
  const auto viewed = with_view(called).value();
  EXPECT_EQ(reads, 1);
  EXPECT_TRUE(std::equal(viewed->view()->begin(), viewed->view()->end(), owned->view()->begin(), owned->view()->end()));
}

TEST(WithView, PassesOnThatReadingFailed) {
  const auto broken = std::make_shared<CallbackSource>(
      6, [](std::uint64_t, std::span<std::byte>) -> Status { return io_error("gone"); });
  EXPECT_EQ(with_view(broken).error().message, "gone");
}

}  // namespace
}  // namespace sbrdf::internal
