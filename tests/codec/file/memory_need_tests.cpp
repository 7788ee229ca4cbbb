#include "codec/file/memory_need.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/file/encoder.h"
#include "codec/file/reader.h"
#include "tests/support/hostile_files.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

/// The first refusal of anything that reads the whole file.
Status read_with(const std::vector<std::byte>& file, const MemoryLimit& limit) {
  const Result<DecodedSliced> decoded = decode_sliced(file, limit);
  return decoded ? ok_status() : Status(decoded.error());
}

TEST(MemoryLimit, IsAConstantAndAMultipleOfWhatIsStored) {
  EXPECT_EQ(MemoryLimit{}.of(0), std::uint64_t{64} << 20U);
  EXPECT_EQ(MemoryLimit{}.of(1000) - MemoryLimit{}.of(0), 1'024'000U);
  EXPECT_GE(MemoryLimit{}.of(~std::uint64_t{0}), MemoryLimit{}.of(std::uint64_t{1} << 50U));
  EXPECT_EQ(MemoryLimit{7}.of(1000), 7U);
}

TEST(MemoryLimit, IsRefusedWithTheOneThatWouldDo) {
  EXPECT_TRUE(check_memory(1000, 1000).ok());
  const Status refused = check_memory(3.5 * (1 << 20), 2 << 20);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(refused.error().message, HasSubstr("4 MiB of memory, the limit is 2 MiB"));
  EXPECT_THAT(refused.error().message, HasSubstr("--memory-limit 4"));
}

TEST(MemoryNeed, OfHostileFilesIsAboveTheLimitWhateverTheyStateMuchOf) {
  for (const HostileCase& hostile : hostile_cases(0.2)) {
    if (hostile.name.ends_with(".sbrdfz")) continue;
    const Status read = read_with(hostile.bytes, {});
    ASSERT_FALSE(read.ok()) << hostile.name;
    EXPECT_EQ(read.error().code, ErrorCode::kUnsupported) << read.error().message;
  }
}

TEST(MemoryNeed, CountsTheLongestSliceThatIsDecoded) {
  // Few samples in all, but each a row of many channels, all on one slice.
  const FrameSpec frame = elevation_frame_from_nodes({0}, {0}, {0, 180}, {.isotropic = true});
  const FrameSpec few = elevation_frame(40, 180, {.isotropic = true}).value();
  for (const FrameSpec& spec : {frame, few}) {
    const std::vector<std::byte> file = hostile_file({.frame = spec, .channels = 3, .depth = 8});
    const MemorySource source(file);
    const SlicedReader reader = SlicedReader::open(source, {std::uint64_t{1} << 40U}).value();
    const double samples =
        std::max(memory_of_samples(reader.index(), reader.lattice()), memory_of_lattice(reader.index().frame));
    const MemoryLimit tight = {static_cast<std::uint64_t>(samples + memory_of_index(source.size()))};
    const bool halved = reader.index().adaptive_count > 0;
    EXPECT_EQ(read_with(file, tight).ok(), !halved);
    EXPECT_TRUE(read_with(file, {2 * *tight.bytes + 1000}).ok());
  }
}

TEST(MemoryNeed, OfTheMostCompressibleMaterialsIsWellBelowTheLimit) {
  // A constant takes a hundredth of a bit for each value.
  for (const std::size_t channels : {std::size_t{3}, std::size_t{195}}) {
    const std::vector<std::byte> file =
        hostile_file({.frame = elevation_frame(10, 36, {.isotropic = true}).value(), .channels = channels, .depth = 3});
    const Status read = read_with(file, {});
    EXPECT_TRUE(read.ok()) << read.error().message;
  }
}

TEST(MemoryNeed, OfMetadataCountsWhatTheyUnpackTo) {
  const FrameSpec few = elevation_frame(40, 180, {.isotropic = true}).value();
  EXPECT_TRUE(read_with(hostile_file({.frame = few, .metadata = 100'000}), {}).ok());
  EXPECT_FALSE(read_with(hostile_file({.frame = few, .metadata = 8'000'000}), {}).ok());
}

TEST(MemoryNeed, OfAMaskCountsItsRunsAndCells) {
  const FrameSpec few = elevation_frame(40, 180, {.isotropic = true}).value();
  const Status read = read_with(hostile_file({.frame = few, .mask = 1}), {});
  EXPECT_TRUE(read.ok()) << read.error().message;
  EXPECT_FALSE(read_with(hostile_file({.frame = few, .mask = 3}), {}).ok());
}

TEST(BundleReader, UnpacksNoHeadBeyondItsLimit) {
  const FrameSpec few = elevation_frame(40, 180, {.isotropic = true}).value();
  const std::vector<std::byte> bundle = hostile_bundle({.frame = few, .behind_index = kMaxIndexSize - 4096});
  const MemorySource source(bundle);
  const BundleReader refusing = BundleReader::open(source).value();
  const auto refused = refusing.material("a");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  const BundleReader willing = BundleReader::open(source, {std::uint64_t{1} << 30U}).value();
  const auto material = willing.material("a");
  ASSERT_TRUE(material.ok()) << material.error().message;
  EXPECT_FALSE(SlicedReader::open(**material).ok());
  EXPECT_TRUE(SlicedReader::open(**material, {std::uint64_t{1} << 30U}).ok());
}

TEST(BundleReader, LimitsAMaterialByWhatIsStoredOfIt) {
  const FrameSpec few = elevation_frame(40, 180, {.isotropic = true}).value();
  const std::vector<std::byte> bundle = hostile_bundle({.frame = few, .behind_index = 1'000'000});
  const MemorySource source(bundle);
  const BundleReader reader = BundleReader::open(source).value();
  const BundleEntry& entry = reader.entries()[0];
  ASSERT_GT(entry.file_size(), 100 * entry.bundled_size());
  EXPECT_EQ(reader.material(entry).value()->stored_size(), entry.bundled_size());
}

}  // namespace
}  // namespace sbrdf::internal
