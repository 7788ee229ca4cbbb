#include "formats/sbrdf/bundle.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/file/encoder.h"
#include "codec/file/reader.h"
#include "formats/core/byte_reader.h"
#include "formats/sbrdf/container.h"
#include "formats/sbrdf/head_packing.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using Bytes = std::vector<std::byte>;

struct File {
  std::string name;
  Bytes bytes;
};

/// A small valid file, another one for each number.
File sliced_file(const std::string& name, int number, const FrameSpec& frame, bool with_metadata = true) {
  SampledBrdf made = sample_function(
      frame, 20, DomainKind::kLog,
      [&](const DirectionPair& pair, std::size_t c) {
        return analytic_brdf(pair, frame.symmetries) + 0.1 * number + 0.2 * static_cast<double>(c);
      },
      3);
  if (with_metadata) {
    made.sliced.metadata = R"({"source":{"format":"test","description":"number )" + std::to_string(number) + R"("}})";
  }
  return {name, encode_sliced(made.sliced, made.lattice, {0.001, ChunkSize::kWhole})};
}

FrameSpec small_frame() { return elevation_frame(40, 180, {.isotropic = true}).value(); }

std::vector<File> some_files() {
  return {sliced_file("wood", 1, small_frame()), sliced_file("fabric", 2, small_frame()),
          sliced_file("velvet", 3, elevation_frame(40, 120, {}).value()),
          sliced_file("paint", 4, half_difference_frame({0, 10, 80}, {0, 40, 80}, {0}, {0, 90}, {.isotropic = true}),
                      false)};
}

BundleInput input_of(const File& file) { return {file.name, file.bytes}; }

Bytes bundle_of(const std::vector<File>& files) {
  std::vector<BundleInput> inputs;
  inputs.reserve(files.size());
  for (const File& file : files) inputs.push_back(input_of(file));
  return emit_bundle(inputs).value();
}

Bytes read_whole(const ByteSource& source) { return read_range(source, 0, source.size()).value(); }

/// From a heap block of exactly that size, so that the sanitizer sees a read beyond it. The first failure of anything
/// that a reader can ask of a bundle.
Status read_all(std::span<const std::byte> bytes) {
  const auto copy = std::make_unique<std::byte[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), copy.get());
  const MemorySource source({copy.get(), bytes.size()});
  const Result<BundleReader> reader = BundleReader::open(source);
  if (!reader) return reader.error();
  for (const BundleEntry& entry : reader->entries()) {
    const Result<std::unique_ptr<ByteSource>> material = reader->material(entry);
    if (!material) return material.error();
    if (const auto decoded = decode_sliced(read_whole(**material)); !decoded) return decoded.error();
  }
  return ok_status();
}

/// Something with the header and the index of a file, which is all that a bundle looks at.
Bytes container_of(std::size_t index_size, std::size_t payload_size, std::size_t body_size) {
  Bytes chunks;
  append_chunk(chunks, Bytes(payload_size, std::byte{7}));
  chunks.resize(chunks.size() + body_size, std::byte{9});
  return emit_container(Bytes(index_size, std::byte{5}), chunks);
}

struct Entry {
  std::string name = "a";
  std::uint64_t index_size = 1, stored_size = 3, body_size = 0;
};

Bytes index_of(const std::vector<Entry>& entries, std::uint64_t dictionary_size = 0) {
  ByteWriter out;
  out.count(entries.size());
  out.count(dictionary_size);
  for (const Entry& entry : entries) {
    out.count(entry.name.size());
    out.text(entry.name);
    for (const std::uint64_t size : {entry.index_size, entry.stored_size, entry.body_size}) {
      out.count(size);
    }
  }
  return std::move(out).take();
}

struct Header {
  std::uint16_t major = 1, minor = 0;
  std::int64_t more_index = 0, more_file = 0;  ///< what the sizes say beyond the truth
};

/// A bundle with this index and content, whatever they are; all checksums fit.
Bytes sealed(const Bytes& index, const Bytes& content, const Header& header = {}) {
  ByteWriter out;
  out.bytes(std::as_bytes(std::span(kBundleMagic)));
  out.number(header.major);
  out.number(header.minor);
  out.number(static_cast<std::uint32_t>(static_cast<std::int64_t>(index.size()) + header.more_index));
  out.number(static_cast<std::uint64_t>(kBundleHeaderSize + index.size() + content.size() + header.more_file));
  out.number(checksum(index));
  Bytes file;
  append_chunk(file, std::move(out).take());
  file.insert(file.end(), index.begin(), index.end());
  file.insert(file.end(), content.begin(), content.end());
  return file;
}

/// The content of a bundle with the one entry {}.
Bytes smallest_content() {
  Bytes content;
  append_chunk(content, Bytes(3));
  return content;
}

void expect_refused(const Bytes& bytes, const std::string& clause, ErrorCode code = ErrorCode::kInvalidFile) {
  const Status status = read_all(bytes);
  ASSERT_FALSE(status) << clause;
  EXPECT_THAT(status.error().message, HasSubstr("[" + clause + "]"));
  EXPECT_EQ(status.error().code, code) << status.error().message;
}

std::string refusal_of_name(const std::string& name) {
  const Status status = check_material_name(name);
  return status ? "" : status.error().message;
}

TEST(Bundle, GivesBackEveryFileBitForBit) {
  const std::vector<File> files = some_files();
  const Bytes bundle = bundle_of(files);
  const MemorySource source(bundle);
  const BundleReader reader = BundleReader::open(source).value();
  EXPECT_EQ(reader.version(), "1.0");
  EXPECT_EQ(reader.entries().size(), files.size());
  for (const File& file : files) {
    const auto material = reader.material(file.name);
    ASSERT_TRUE(material);
    EXPECT_EQ(read_whole(**material), file.bytes) << file.name;
    EXPECT_EQ(reader.find(file.name).value()->file_size(), file.bytes.size());
  }
}

TEST(Bundle, GivesBackAnyRangeOfAFile) {
  const File file = sliced_file("a", 1, small_frame());
  const Bytes bundle = bundle_of({file});
  const MemorySource source(bundle);
  const auto material = BundleReader::open(source).value().material("a").value();
  for (std::size_t from = 0; from <= file.bytes.size(); from += 7) {
    for (std::size_t to = from; to <= file.bytes.size(); to += 13) {
      const Bytes expected(file.bytes.begin() + static_cast<std::ptrdiff_t>(from),
                           file.bytes.begin() + static_cast<std::ptrdiff_t>(to));
      ASSERT_EQ(read_range(*material, from, to - from).value(), expected);
    }
  }
}

TEST(Bundle, ReadsAMaterialInPartWithTheReaderOfSlicedFiles) {
  const std::vector<File> files = some_files();
  const Bytes bundle = bundle_of(files);
  const MemorySource source(bundle);
  const auto material = BundleReader::open(source).value().material("wood").value();
  const auto reader = SlicedReader::open(*material);
  ASSERT_TRUE(reader);
  EXPECT_THAT(reader->metadata().value(), HasSubstr("number 1"));
  EXPECT_EQ(reader->load_all().value().sample_values, decode_sliced(files[0].bytes).value().sliced.sample_values);
}

TEST(Bundle, OpeningOneMaterialReadsNothingOfTheOthers) {
  const std::vector<File> files = some_files();
  const Bytes bundle = bundle_of(files);
  std::vector<bool> touched(bundle.size(), false);
  const CallbackSource source(bundle.size(), [&](std::uint64_t offset, std::span<std::byte> target) {
    std::fill_n(touched.begin() + static_cast<std::ptrdiff_t>(offset), target.size(), true);
    return MemorySource(bundle).read(offset, target);
  });
  const BundleReader reader = BundleReader::open(source).value();
  const auto count = [&] { return static_cast<std::size_t>(std::count(touched.begin(), touched.end(), true)); };
  EXPECT_EQ(count(), kBundleHeaderSize + reader.index_size());
  const BundleEntry& entry = *reader.find("velvet").value();
  ASSERT_TRUE(decode_sliced(read_whole(*reader.material(entry).value())));
  for (std::size_t at = reader.entries().front().offset; at < bundle.size(); ++at) {
    EXPECT_EQ(touched[at], at >= entry.offset && at < entry.offset + entry.bundled_size()) << at;
  }
}

TEST(Bundle, KeepsTwoHundredMaterialsWithADictionary) {
  std::vector<File> files;
  std::size_t bytes = 0;
  for (int k = 0; k < 200; ++k) {
    files.push_back(sliced_file("material " + std::to_string(k), k, small_frame()));
    bytes += files.back().bytes.size();
  }
  const Bytes bundle = bundle_of(files);
  EXPECT_LT(bundle.size(), bytes * 8 / 10);
  const MemorySource source(bundle);
  const BundleReader reader = BundleReader::open(source).value();
  EXPECT_GT(reader.dictionary_size(), 0U);
  for (const File& file : files) EXPECT_EQ(read_whole(*reader.material(file.name).value()), file.bytes) << file.name;
}

TEST(Bundle, ServesManyThreads) {
  const std::vector<File> files = some_files();
  const Bytes bundle = bundle_of(files);
  const MemorySource source(bundle);
  const BundleReader reader = BundleReader::open(source).value();
  std::vector<Bytes> found(8);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < found.size(); ++k) {
    threads.emplace_back([&, k] { found[k] = read_whole(*reader.material(files[k % files.size()].name).value()); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t k = 0; k < found.size(); ++k) EXPECT_EQ(found[k], files[k % files.size()].bytes);
}

TEST(Bundle, IsTheSameHoweverOftenAndInWhateverOrderItIsMade) {
  std::vector<File> files = some_files();
  const Bytes bundle = bundle_of(files);
  EXPECT_EQ(bundle_of(files), bundle);
  std::reverse(files.begin(), files.end());
  EXPECT_EQ(bundle_of(files), bundle);
}

TEST(Bundle, RefusesEveryTruncatedPrefix) {
  const Bytes bundle = bundle_of({sliced_file("a", 1, small_frame()), sliced_file("b", 2, small_frame())});
  ASSERT_TRUE(read_all(bundle));
  for (std::size_t size = 0; size < bundle.size(); ++size) {
    EXPECT_FALSE(read_all(std::span(bundle).first(size))) << size;
  }
}

TEST(Bundle, RefusesATrailingByte) {
  Bytes bundle = bundle_of(some_files());
  bundle.push_back(std::byte{0});
  expect_refused(bundle, "SZ-1-4");
}

TEST(Bundle, RefusesEveryFlippedBit) {
  // With a dictionary, since it is part of what can be damaged.
  Bytes bundle = bundle_of({sliced_file("a", 1, small_frame()), sliced_file("b", 2, small_frame()),
                            sliced_file("c", 3, small_frame()), sliced_file("d", 4, small_frame())});
  const MemorySource source(bundle);
  ASSERT_GT(BundleReader::open(source).value().dictionary_size(), 0U);
  for (std::size_t bit = 0; bit < 8 * bundle.size(); ++bit) {
    std::byte& changed = bundle[bit / 8];
    changed ^= std::byte{1} << (bit % 8);
    EXPECT_FALSE(read_all(bundle)) << "bit " << bit;
    changed ^= std::byte{1} << (bit % 8);
  }
}

TEST(Bundle, AllowsNamesThatAFileCanHave) {
  for (const char* name :
       {"a", "kurt:x", "fabric 112", "...", "..a", "a\\b", "\u00e9", "\u4e2d\u6587", "\U0001F600", "-", "\"'"}) {
    EXPECT_EQ(refusal_of_name(name), "") << name;
  }
  EXPECT_EQ(refusal_of_name(std::string(255, 'a')), "");
}

TEST(Bundle, RefusesNamesThatNoFileCanHaveOrThatAreNoText) {
  EXPECT_THAT(refusal_of_name(""), HasSubstr("empty"));
  EXPECT_THAT(refusal_of_name(std::string(256, 'a')), HasSubstr("256 bytes"));
  for (const char* name : {".", ".."}) EXPECT_THAT(refusal_of_name(name), HasSubstr("'"));
  for (const char* name : {"a/b", "/", "../a"}) EXPECT_THAT(refusal_of_name(name), HasSubstr("'/'"));
  for (const char* name : {"a\n", "\x1b[0m", "\x7f", "\u0080", "\u009f"}) {
    EXPECT_THAT(refusal_of_name(name), HasSubstr("control"));
  }
  EXPECT_THAT(refusal_of_name(std::string("a\0b", 3)), HasSubstr("control"));
  // Cut off, a lone continuation, too long a form, a surrogate, above U+10FFFF, never in UTF-8.
  for (const char* name :
       {"\xc3", "\xe4\xb8", "\xf0\x9f\x98", "\x80", "\xc0\xaf", "\xc1\xbf", "\xe0\x80\xaf", "\xf0\x80\x80\xaf",
        "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff", "\xc3\x28"}) {
    EXPECT_THAT(refusal_of_name(name), HasSubstr("UTF-8"));
  }
}

TEST(Bundle, TellsTheNearestNames) {
  std::vector<BundleInput> inputs;
  const Bytes file = container_of(3, 0, 2);
  for (const char* name : {"fabric112", "fabric135", "red velvet", "wood01", "wood02", "silk", "paint"}) {
    inputs.push_back({name, file});
  }
  const Bytes bundle = emit_bundle(inputs).value();
  const MemorySource source(bundle);
  const BundleReader reader = BundleReader::open(source).value();
  const Error missing = reader.material("fabrik112").error();
  EXPECT_EQ(missing.code, ErrorCode::kUsage);
  EXPECT_THAT(missing.message, HasSubstr("no material 'fabrik112' among the 7 of this bundle, such as fabric112, "));
  const Error unnamed = reader.material("").error();
  EXPECT_EQ(unnamed.code, ErrorCode::kUsage);
  EXPECT_THAT(unnamed.message, HasSubstr("such as fabric112, fabric135, paint, red velvet, silk"));
  EXPECT_THAT(unnamed.message, Not(HasSubstr("wood")));
}

TEST(Bundle, OrdersNamesByTheirBytes) {
  std::vector<BundleInput> inputs;
  const Bytes file = container_of(3, 0, 2);
  for (const char* name : {"\u00e9", "z", "a10", "a", "B", "a2"}) inputs.push_back({name, file});
  const Bytes bundle = emit_bundle(inputs).value();
  const MemorySource source(bundle);
  const BundleReader reader = BundleReader::open(source).value();
  std::vector<std::string> names;
  for (const BundleEntry& entry : reader.entries()) names.push_back(entry.name);
  EXPECT_THAT(names, ElementsAre("B", "a", "a10", "a2", "z", "\u00e9"));
}

TEST(Bundle, IsNotMadeOfNothingOrOfOneNameTwice) {
  EXPECT_EQ(emit_bundle({}).error().code, ErrorCode::kUsage);
  const Bytes file = container_of(3, 0, 2);
  const std::vector<BundleInput> twice = {{"a", file}, {"b", file}, {"a", file}};
  EXPECT_EQ(emit_bundle(twice).error().code, ErrorCode::kUsage);
  EXPECT_THAT(emit_bundle(twice).error().message, HasSubstr("'a'"));
  EXPECT_EQ(emit_bundle(std::vector<BundleInput>{{"a/b", file}}).error().code, ErrorCode::kUsage);
}

TEST(Bundle, IsNotMadeOfDamagedFiles) {
  for (const std::size_t at : {0U, 5U, 7U, 12U}) {  // magic, version, index, checksum
    Bytes file = container_of(4, 6, 2);
    file[at] ^= std::byte{1};
    const Error error = emit_bundle(std::vector<BundleInput>{{"a", file}}).error();
    EXPECT_EQ(error.code, ErrorCode::kInvalidFile) << at;
    EXPECT_THAT(error.message, StartsWith("material 'a': [SB-1-")) << at;
  }
}

TEST(Bundle, KeepsAFileWithoutChunksAndOneWithALargeIndex) {
  const std::vector<File> files = {{"empty", container_of(0, 0, 0)}, {"index", container_of(100'000, 0, 100)}};
  const Bytes bundle = bundle_of(files);
  const MemorySource source(bundle);
  const BundleReader reader = BundleReader::open(source).value();
  for (const File& file : files) EXPECT_EQ(read_whole(*reader.material(file.name).value()), file.bytes) << file.name;
}

TEST(Bundle, RefusesWhatBreaksARule) {
  const Bytes index = index_of({{}});
  const Bytes content = smallest_content();
  const auto open = [](const Bytes& bytes) {
    const MemorySource source(bytes);
    return BundleReader::open(source).ok();
  };
  ASSERT_TRUE(open(sealed(index, content)));

  Bytes damaged = sealed(index, content);
  damaged[1] ^= std::byte{1};
  expect_refused(damaged, "SZ-1-1");
  damaged = sealed(index, content);
  damaged[29] ^= std::byte{1};
  expect_refused(damaged, "SZ-1-2");
  expect_refused(sealed(index, content, {.major = 0}), "SZ-1-3", ErrorCode::kUnsupported);
  expect_refused(sealed(index, content, {.major = 2}), "SZ-1-3", ErrorCode::kUnsupported);
  expect_refused(sealed(index, content, {.more_file = -1}), "SZ-1-4");
  expect_refused(sealed(index, content, {.more_file = 1}), "SZ-1-4");
  expect_refused(sealed(index, content, {.more_index = 10}), "SZ-1-5");
  damaged = sealed(index, content);
  damaged[33] ^= std::byte{1};
  expect_refused(damaged, "SZ-1-6");

  Bytes longer = index;
  longer.push_back(std::byte{0});
  expect_refused(sealed(longer, content), "SZ-2-1");
  expect_refused(sealed({index.begin(), index.end() - 1}, content), "SZ-2-1");
  Bytes padded = index;
  padded.back() = std::byte{0x80};
  padded.push_back(std::byte{0});
  expect_refused(sealed(padded, content), "SZ-2-1");
  Bytes endless = index;
  endless.back() = std::byte{0x80};
  endless.insert(endless.end(), 20, std::byte{0xFF});
  expect_refused(sealed(endless, content), "SZ-2-1");
  expect_refused(sealed(index_of({}), content), "SZ-2-2");
  expect_refused(sealed(index_of({{.name = "a\n"}}), content), "SZ-2-3");
  expect_refused(sealed(index_of({{.name = ""}, {.name = "b"}}), content), "SZ-2-3");
  expect_refused(sealed(index_of({{.name = "b"}, {.name = "a"}}), content), "SZ-2-4");
  expect_refused(sealed(index_of({{.name = "a"}, {.name = "a"}}), content), "SZ-2-4");
  expect_refused(sealed(index_of({{.index_size = 2}}), {content.begin(), content.end() - 1}), "SZ-2-7");
  expect_refused(sealed(index_of({{.body_size = 1}}), content), "SZ-2-7");
  expect_refused(sealed(index_of({{.name = "a"}, {.name = "b"}}), content), "SZ-2-7");
  longer = content;
  longer.push_back(std::byte{0});
  expect_refused(sealed(index, longer), "SZ-2-7");

  Bytes with_dictionary;
  append_chunk(with_dictionary, Bytes(9));
  const std::size_t dictionary_size = with_dictionary.size();
  with_dictionary.insert(with_dictionary.end(), content.begin(), content.end());
  expect_refused(sealed(index_of({{}}, 9), with_dictionary), "SZ-3-3");
  const std::vector<Entry> compressed = {{.index_size = 2}};
  Bytes changed = with_dictionary;
  changed[0] ^= std::byte{1};
  expect_refused(sealed(index_of(compressed, 9), changed), "SZ-3-2");
  changed = with_dictionary;
  changed[dictionary_size] ^= std::byte{1};
  expect_refused(sealed(index_of(compressed, 9), changed), "SZ-4-1");
  expect_refused(sealed(index_of(compressed), content), "SZ-4-2");
}

TEST(Bundle, RefusesFramesThatAreNotOneFrameOfTheSizeInTheIndex) {
  const Bytes head(500, std::byte{1});
  Bytes frame = HeadPacker({}).pack(head);
  EXPECT_EQ(unpack_head(frame, 500, {}), head);
  EXPECT_FALSE(unpack_head(frame, 499, {}));
  EXPECT_FALSE(unpack_head(frame, 501, {}));
  Bytes twice = frame;
  const auto magic = {std::byte{0x28}, std::byte{0xB5}, std::byte{0x2F}, std::byte{0xFD}};
  twice.insert(twice.end(), magic);
  twice.insert(twice.end(), frame.begin(), frame.end());
  EXPECT_FALSE(unpack_head(twice, 1000, {}));
  frame.pop_back();
  EXPECT_FALSE(unpack_head(frame, 500, {}));
  EXPECT_FALSE(unpack_head({}, 500, {}));
}

TEST(Bundle, RefusesHostileSizesBeforeItAllocatesOrReadsThatMuch) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::int64_t>::max();
  constexpr std::uint64_t kHuge = std::uint64_t{1} << 40;
  const auto expect_cheaply_refused = [](const Bytes& bytes, const std::string& clause) {
    std::uint64_t read = 0;
    const CallbackSource source(bytes.size(), [&](std::uint64_t offset, std::span<std::byte> target) {
      read += target.size();
      return MemorySource(bytes).read(offset, target);
    });
    const Result<BundleReader> reader = BundleReader::open(source);
    ASSERT_FALSE(reader) << clause;
    EXPECT_THAT(reader.error().message, HasSubstr("[" + clause + "]"));
    EXPECT_LE(read, bytes.size());
  };
  const Bytes content = smallest_content();
  ByteWriter many;
  many.count(std::uint64_t{1} << 20);
  many.count(0);
  expect_cheaply_refused(sealed(std::move(many).take(), content), "SZ-2-2");
  expect_cheaply_refused(sealed(index_of({{}}), content, {.more_index = 0xFFFFFF}), "SZ-1-5");
  expect_cheaply_refused(sealed(index_of({{}}, (1U << 20U) + 1), content), "SZ-3-1");
  expect_cheaply_refused(sealed(index_of({{}}, kMost), content), "SZ-3-1");
  for (const std::uint64_t size : {std::uint64_t{(1U << 25U) + 1}, kHuge, kMost}) {
    expect_cheaply_refused(sealed(index_of({{.index_size = size, .stored_size = 1}}), content), "SZ-2-5");
    expect_cheaply_refused(sealed(index_of({{.stored_size = size}}), content), "SZ-2-6");
    expect_cheaply_refused(sealed(index_of({{.body_size = size}}), content), "SZ-2-7");
    // Sums that wrap.
    expect_cheaply_refused(sealed(index_of({{.name = "a", .body_size = size},
                                            {.name = "b", .body_size = size},
                                            {.name = "c", .body_size = size}}),
                                  content),
                           "SZ-2-7");
  }
  expect_cheaply_refused(sealed(index_of({{.index_size = 1U << 24U, .stored_size = 4096}}), content), "SZ-2-6");
  expect_cheaply_refused(sealed(index_of({{.index_size = 1U << 24U, .stored_size = 5000}}), content), "SZ-2-7");
  expect_cheaply_refused(sealed(index_of({{.stored_size = 0}}), content), "SZ-2-6");
}

TEST(Bundle, ReadsAGreaterMinorVersionAndIgnoresWhatItDoesNotKnow) {
  Bytes index = index_of({{}});
  index.push_back(std::byte{42});
  Bytes content = smallest_content();
  content.push_back(std::byte{42});
  const Bytes bundle = sealed(index, content, {.minor = 7});
  const MemorySource source(bundle);
  const auto reader = BundleReader::open(source);
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->version(), "1.7");
  EXPECT_TRUE(reader->material("a"));
}

TEST(Bundle, BeginsAsTheExampleOfTheSpecificationSays) {
  const std::vector<std::uint8_t> example = {
      0x89, 0x53, 0x42, 0x52, 0x44, 0x5A, 0x0D, 0x0A, 0x01, 0x00, 0x00, 0x00, 0x13, 0x00, 0x00, 0x00, 0xF5,
      0x1D, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x9F, 0xC0, 0xF7, 0xB8, 0x9F, 0x4F, 0xA5, 0xD7, 0x02, 0x00,
      0x02, 0x61, 0x62, 0xAA, 0x02, 0xAC, 0x02, 0xB8, 0x17, 0x01, 0x62, 0xB4, 0x02, 0xB6, 0x02, 0xA0, 0x1F};
  const auto bytes = std::as_bytes(std::span(example));
  Bytes bundle(bytes.begin(), bytes.end());
  bundle.resize(7669);
  const MemorySource source(bundle);
  const auto reader = BundleReader::open(source);
  ASSERT_TRUE(reader) << reader.error().message;
  const BundleEntry& b = *reader->find("b").value();
  EXPECT_EQ(b.index_size, 308U);
  EXPECT_EQ(b.stored_size, 310U);
  EXPECT_FALSE(b.is_compressed());
  EXPECT_EQ(b.body_size, 4000U);
  EXPECT_EQ(b.offset, 51U + 300 + 4 + 3000);
  EXPECT_EQ(b.file_size(), 8U + 308 + 4 + 4000);
}

TEST(Bundle, TakesTheDictionaryThatMakesItSmallest) {
  std::vector<Bytes> heads;
  for (int k = 0; k < 50; ++k) {
    Bytes head;
    for (int i = 0; i < 300; ++i) head.push_back(static_cast<std::byte>((i * i * 7 + i / 3) ^ (i % 50 == k ? k : 0)));
    heads.push_back(std::move(head));
  }
  const auto size_with = [&](const Bytes& dictionary) {
    HeadPacker packer(dictionary);
    std::size_t size = dictionary.size();
    for (const Bytes& head : heads) size += packer.pack(head).size();
    return size;
  };
  const Bytes dictionary = choose_dictionary(heads);
  EXPECT_LT(size_with(dictionary), size_with({}) / 4);
  EXPECT_LE(size_with(dictionary), size_with(heads[25]) + 4);
  EXPECT_TRUE(choose_dictionary(std::span(heads).first(1)).empty());
  EXPECT_TRUE(choose_dictionary({}).empty());
}

}  // namespace
}  // namespace sbrdf::internal
