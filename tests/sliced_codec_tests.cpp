#include "codec/sliced_codec.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/core/byte_reader.h"
#include "formats/sbrdf/container.h"
#include "tests/analytic_brdf.h"
#include "tests/sampled_brdf.h"

namespace sbrdf {
namespace {

using testing::HasSubstr;

using Bytes = std::vector<std::byte>;

SampledBrdf sampled_example(DomainKind domain = DomainKind::kLog, const Symmetries& symmetries = {}) {
  SampledBrdf made = sample_function(
      elevation_frame(40, 180, symmetries).value(), 60, domain,
      [&](const DirectionPair& pair, std::size_t c) {
        return analytic_brdf(pair, symmetries) * static_cast<double>(c + 1) - (pair.i.theta == 0 ? 5 : 0);
      },
      2);
  made.sliced.metadata = R"({"source": "a test"})";
  return made;
}

Bytes valid_file() { return encode_sliced(sampled_example().sliced); }

/// From a heap block of exactly that size, so that the sanitizer sees a read beyond it.
Result<DecodedSliced> decode_exactly(std::span<const std::byte> bytes) {
  const auto copy = std::make_unique<std::byte[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), copy.get());
  return decode_sliced({copy.get(), bytes.size()});
}

Bytes changed(const char* name, const std::function<void(Bytes&)>& change) {
  Container container = parse_container(valid_file()).value();
  for (Chunk& chunk : container.chunks) {
    if (chunk.name == name) change(chunk.bytes);
  }
  return emit_container(container.chunks);
}

template <class T>
void put(Bytes& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

void expect_refused(const Bytes& file, const std::string& what, ErrorCode code = ErrorCode::kInvalidFile) {
  const auto result = decode_exactly(file);
  ASSERT_FALSE(result) << what;
  EXPECT_EQ(result.error().code, code) << result.error().message;
  EXPECT_THAT(result.error().message, HasSubstr(what));
}

TEST(SlicedCodec, GivesBackEveryBit) {
  for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
    for (const Symmetries& symmetries : {Symmetries{}, Symmetries{.isotropic = true}, Symmetries{.mirror_y = true}}) {
      const auto [lattice, sliced] = sampled_example(domain, symmetries);
      const auto decoded = decode_exactly(encode_sliced(sliced));
      ASSERT_TRUE(decoded);
      const SlicedBrdf& back = decoded->sliced;
      EXPECT_EQ(back.frame, sliced.frame);
      EXPECT_EQ(back.domain, sliced.domain);
      EXPECT_EQ(back.channels, sliced.channels);
      EXPECT_EQ(back.crossing_values, sliced.crossing_values);
      EXPECT_EQ(back.sample_counts, sliced.sample_counts);
      EXPECT_EQ(back.positions, sliced.positions);
      EXPECT_EQ(back.sample_values, sliced.sample_values);
      EXPECT_EQ(back.metadata, sliced.metadata);
      EXPECT_EQ(decoded->lattice.crossings, lattice.crossings);
      EXPECT_EQ(encode_sliced(back), encode_sliced(sliced));
    }
  }
}

TEST(SlicedCodec, GivesBackExtremeFloatsAndNamesWithTheirBits) {
  SlicedBrdf sliced = sampled_example(DomainKind::kLinear).sliced;
  sliced.channels = {"", "wavelength 550 nm, \xc2\xb1 5"};
  sliced.crossing_values[0] = -0.0F;
  sliced.crossing_values[1] = std::numeric_limits<float>::denorm_min();
  sliced.sample_values[0] = 1e12F;
  const auto decoded = decode_exactly(encode_sliced(sliced));
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->sliced.channels, sliced.channels);
  EXPECT_TRUE(std::signbit(decoded->sliced.crossing_values[0]));
  EXPECT_EQ(decoded->sliced.crossing_values[1], std::numeric_limits<float>::denorm_min());
  EXPECT_EQ(decoded->sliced.sample_values[0], 1e12F);
}

TEST(SlicedCodec, WritesTheChunksOfTheSpecificationInItsOrder) {
  const Container container = parse_container(valid_file()).value();
  std::vector<std::string> names;
  for (const Chunk& chunk : container.chunks) names.push_back(chunk.name);
  EXPECT_THAT(names, testing::ElementsAre("FRAM", "VALU", "META", "CROS", "CNTS", "POSI", "SAMP"));
}

TEST(SlicedCodec, WritesTheFrameAsTheSpecificationSays) {
  const Container container = parse_container(valid_file()).value();
  ByteReader in(container.find("FRAM"));
  EXPECT_EQ(in.u8(), 1);
  EXPECT_EQ(in.u8(), 0);
  for (const auto& nodes :
       {std::vector{0.0, 180.0}, std::vector{0.0, 180.0}, std::vector{0.0, 40.0, 80.0}, std::vector{0.0, 40.0, 80.0}}) {
    EXPECT_EQ(in.u16(), nodes.size());
    for (const double node : nodes) EXPECT_EQ(in.f64(), node);
  }
  EXPECT_TRUE(in.ok());
  EXPECT_EQ(in.remaining(), 0U);
}

TEST(SlicedCodec, WritesTheValueDomainAndPositionsAsTheSpecificationSays) {
  const SlicedBrdf sliced = sampled_example().sliced;
  const Container container = parse_container(encode_sliced(sliced)).value();
  ByteReader in(container.find("VALU"));
  EXPECT_EQ(in.u8(), 2);
  EXPECT_EQ(in.u16(), 2);
  for (const char* name : {"channel 0", "channel 1"}) EXPECT_EQ(in.text(in.u16()), name);
  for (const float reference : sliced.domain.reference) EXPECT_EQ(in.number<float>(), reference);
  for (const float floor : sliced.domain.floor) EXPECT_EQ(in.number<float>(), floor);
  EXPECT_EQ(in.remaining(), 0U);
  ByteReader positions(container.find("POSI"));
  for (const SamplePosition& position : sliced.positions) EXPECT_EQ(positions.u16(), position.interval);
  for (const SamplePosition& position : sliced.positions) EXPECT_EQ(positions.u16(), position.fraction);
  EXPECT_EQ(positions.remaining(), 0U);
}

TEST(DecodeSliced, RefusesEveryTruncatedPrefixAndTrailingByte) {
  Bytes file = valid_file();
  for (std::size_t size = 0; size < file.size(); ++size) {
    ASSERT_FALSE(decode_exactly(std::span(file).first(size))) << size << " of " << file.size() << " bytes";
  }
  file.push_back(std::byte{0});
  EXPECT_FALSE(decode_exactly(file));
}

TEST(DecodeSliced, RefusesEverySingleFlippedBit) {
  Bytes file = valid_file();
  for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    file[bit / 8] ^= mask;
    ASSERT_FALSE(decode_exactly(file)) << "byte " << bit / 8 << ", bit " << bit % 8;
    file[bit / 8] ^= mask;
  }
}

TEST(DecodeSliced, RefusesEveryTruncatedAndLengthenedChunk) {
  const Container container = parse_container(valid_file()).value();
  for (const Chunk& chunk : container.chunks) {
    if (chunk.name == "META") continue;
    for (std::size_t size = 0; size < chunk.bytes.size(); ++size) {
      ASSERT_FALSE(decode_exactly(changed(chunk.name.c_str(), [&](Bytes& bytes) { bytes.resize(size); })))
          << chunk.name << " of " << size << " bytes";
    }
    for (std::size_t more = 1; more <= 8; ++more) {
      ASSERT_FALSE(
          decode_exactly(changed(chunk.name.c_str(), [&](Bytes& bytes) { bytes.resize(bytes.size() + more); })))
          << chunk.name << ", " << more << " bytes more";
    }
  }
}

TEST(DecodeSliced, RefusesAMissingChunkAndIgnoresAnUnknownOne) {
  const Container container = parse_container(valid_file()).value();
  for (std::size_t k = 0; k < container.chunks.size(); ++k) {
    std::vector<Chunk> chunks = container.chunks;
    chunks.erase(chunks.begin() + static_cast<std::ptrdiff_t>(k));
    expect_refused(emit_container(chunks), container.chunks[k].name);
  }
  std::vector<Chunk> chunks = container.chunks;
  chunks.push_back({"LATR", Bytes(10)});
  EXPECT_TRUE(decode_exactly(emit_container(chunks)));
}

TEST(DecodeSliced, RefusesUnknownFramesSymmetriesAndDomainsAsUnsupported) {
  for (const int id : {0, 77, 255}) {
    expect_refused(changed("FRAM", [&](Bytes& bytes) { bytes[0] = static_cast<std::byte>(id); }), "frame",
                   ErrorCode::kUnsupported);
  }
  expect_refused(changed("FRAM", [](Bytes& bytes) { bytes[1] = std::byte{8}; }), "symmetry", ErrorCode::kUnsupported);
  expect_refused(changed("VALU",
                         [](Bytes& bytes) {
                           bytes[0] = std::byte{9};
                           bytes.erase(bytes.end() - 16, bytes.end());
                         }),
                 "value domain", ErrorCode::kUnsupported);
}

TEST(DecodeSliced, RefusesNodesThatBreakTheRulesOfTheirAxis) {
  constexpr std::size_t kSecondS = 2 + 2 + 8;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double node : {nan, -nan, std::numeric_limits<double>::infinity(), 0.0, -1.0, 360.0, 1e300, 5e-324}) {
    EXPECT_FALSE(decode_exactly(changed("FRAM", [&](Bytes& bytes) { put(bytes, kSecondS, node); }))) << node;
  }
}

Bytes file_with_frame(const std::vector<std::vector<double>>& axes) {
  return changed("FRAM", [&](Bytes& bytes) {
    ByteWriter out;
    out.number<std::uint8_t>(1);
    out.number<std::uint8_t>(0);
    for (const auto& nodes : axes) {
      out.number(static_cast<std::uint16_t>(nodes.size()));
      for (const double node : nodes) out.number(node);
    }
    bytes = std::move(out).take();
  });
}

TEST(DecodeSliced, RefusesFramesThatDoNotFitTheValues) {
  EXPECT_FALSE(decode_exactly(file_with_frame({{0, 180}, {0, 180}, {0, 40}, {0, 40}})));
  EXPECT_FALSE(decode_exactly(file_with_frame({{0}, {0}, {0}, {0}})));
  EXPECT_FALSE(decode_exactly(file_with_frame({{}, {}, {}, {}})));
  EXPECT_FALSE(decode_exactly(file_with_frame({{0, 180}, {0, 180}, {0, 40, 80}, {0, 80}})));
}

TEST(DecodeSliced, RefusesNodesTooCloseToBeToldApart) {
  EXPECT_FALSE(decode_exactly(file_with_frame({{0, 180}, {0, 180}, {0, 1e-8}, {0, 1e-8}})));
  EXPECT_FALSE(decode_exactly(file_with_frame({{0, 180}, {0, 180}, {0, 5e-324}, {0, 5e-324}})));
  EXPECT_FALSE(decode_exactly(file_with_frame({{0, 180}, {0, 180}, {0, 80, 80 + 1e-9}, {0, 80, 80 + 1e-9}})));
}

TEST(DecodeSliced, RefusesFramesWithFarMoreCrossingsThanValuesBeforeBuildingThem) {
  std::vector<double> azimuths;
  for (int k = 0; k < 300; ++k) azimuths.push_back(1.2 * k);
  std::vector<double> elevations;
  for (int k = 0; k < 90; ++k) elevations.push_back(k);
  expect_refused(file_with_frame({azimuths, azimuths, elevations, elevations}),
                 "fewer values than the frame has crossings");
  const auto built = build_lattice(elevation_frame_from_nodes(elevations, azimuths, azimuths, {}));
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().code, ErrorCode::kUnsupported);
}

TEST(DecodeSliced, RefusesCountsThatDoNotFitThePositions) {
  for (const std::uint32_t count : {0xFFFFFFFFU, 0x80000000U, 61U}) {
    expect_refused(changed("CNTS", [&](Bytes& bytes) { put(bytes, 0, count); }), "sample counts");
  }
  for (const std::uint32_t count : {0xFFFFFFFFU, 1000U}) {
    EXPECT_FALSE(decode_exactly(changed("CNTS", [&](Bytes& bytes) { put(bytes, bytes.size() - 4, count); })));
  }
  expect_refused(changed("CNTS", [](Bytes& bytes) { std::fill(bytes.begin(), bytes.end(), std::byte{0}); }),
                 "more samples than");
}

TEST(DecodeSliced, RefusesPositionsOutsideTheirSliceOrOutOfOrder) {
  const SlicedBrdf sliced = sampled_example().sliced;
  const std::size_t count = sliced.positions.size();
  const auto place = [&](std::size_t k, std::uint16_t interval, std::uint16_t fraction) {
    return changed("POSI", [&](Bytes& bytes) {
      put(bytes, 2 * k, interval);
      put(bytes, 2 * (count + k), fraction);
    });
  };
  // The last sample of all has none after it that could be out of order.
  const auto last = static_cast<std::size_t>(
      sliced.sample_counts.rend() -
      std::find_if(sliced.sample_counts.rbegin(), sliced.sample_counts.rend(), [](std::uint32_t n) { return n > 0; }) -
      1);
  const std::uint32_t intervals = sampled_example().lattice.slices[last].interval_count();
  expect_refused(place(count - 1, static_cast<std::uint16_t>(intervals), 0x8000), "position outside");
  expect_refused(place(count - 1, 0xFFFF, 0x8000), "position outside");
  expect_refused(place(0, 0, 0), "position outside");
  const auto crowded =
      std::find_if(sliced.sample_counts.begin(), sliced.sample_counts.end(), [](auto n) { return n > 1; });
  ASSERT_NE(crowded, sliced.sample_counts.end());
  std::size_t first = 0;
  for (auto it = sliced.sample_counts.begin(); it != crowded; ++it) first += *it;
  const auto interval = static_cast<std::uint16_t>(sliced.positions[first].interval);
  const auto fraction = static_cast<std::uint16_t>(sliced.positions[first].fraction);
  expect_refused(place(first + 1, interval, fraction), "out of order");
  expect_refused(place(first + 1, interval, static_cast<std::uint16_t>(fraction - 1)), "out of order");
}

TEST(DecodeSliced, RefusesValuesThatAreNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const char* name : {"CROS", "SAMP"}) {
    for (const float value : {nan, -nan, infinity, -infinity}) {
      expect_refused(changed(name, [&](Bytes& bytes) { put(bytes, 8, value); }), "not finite");
    }
  }
}

TEST(DecodeSliced, RefusesALogDomainWithoutPositiveReferencesAndFloors) {
  for (const float value :
       {0.0F, -1.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    for (std::size_t from_end = 4; from_end <= 16; from_end += 4) {
      expect_refused(changed("VALU", [&](Bytes& bytes) { put(bytes, bytes.size() - from_end, value); }), "log domain");
    }
  }
}

TEST(DecodeSliced, RefusesAbsurdNumbersOfChannels) {
  for (const int channels : {0, 1, 3, 4097, 65535}) {
    EXPECT_FALSE(decode_exactly(changed("VALU", [&](Bytes& bytes) {
      put(bytes, 1, static_cast<std::uint16_t>(channels));
    }))) << channels;
  }
}

TEST(DecodeSliced, SurvivesRandomDamageBelowTheChecksums) {
  const Container container = parse_container(valid_file()).value();
  std::uint64_t state = 1;
  const auto random = [&state](std::uint64_t below) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return (state >> 33U) % below;
  };
  for (int trial = 0; trial < 1500; ++trial) {
    std::vector<Chunk> chunks = container.chunks;
    for (std::uint64_t k = 0; k <= random(3); ++k) {
      Bytes& bytes = chunks[random(chunks.size())].bytes;
      bytes[random(bytes.size())] = static_cast<std::byte>(random(256));
    }
    const auto decoded = decode_exactly(emit_container(chunks));
    EXPECT_TRUE(!decoded || check_sliced(decoded->sliced, decoded->lattice));
  }
}

}  // namespace
}  // namespace sbrdf
