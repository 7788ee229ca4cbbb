#include "formats/ngan/ngan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "converters/files/format_table.h"
#include "formats/merl/merl.h"
#include "tests/support/function_source.h"
#include "tests/support/small_files.h"
#include "tests/support/source_values.h"

namespace sbrdf::internal {
namespace {

using small_files::Bytes;
using small_files::source_of;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr std::array<std::uint32_t, 4> kCounts = {3, 4, 6, 4};

using Header = std::array<std::int32_t, 16>;

Header header_of(const std::array<std::uint32_t, 4>& counts, bool half = false, std::int32_t channels = 3) {
  Header header{};
  for (std::size_t axis = 0; axis < 4; ++axis) header[axis] = static_cast<std::int32_t>(counts[axis]);
  header[6] = 1;
  header[9] = half ? 1 : 0;
  header[10] = channels;
  return header;
}

Bytes file_of(const Header& header, const std::vector<float>& numbers) {
  Bytes bytes(sizeof header + numbers.size() * sizeof(float));
  std::memcpy(bytes.data(), header.data(), sizeof header);
  std::memcpy(bytes.data() + sizeof header, numbers.data(), numbers.size() * sizeof(float));
  return bytes;
}

/// A number of four bins and a channel.
using Closed = std::function<double(std::uint32_t ti, std::uint32_t to, std::uint32_t pd, std::uint32_t pi, int c)>;

// Written from specs/ngan.md: planar, phi_in fastest.
std::vector<float> planar(const std::array<std::uint32_t, 4>& n, const Closed& closed, int channels = 3) {
  std::vector<float> numbers;
  for (int c = 0; c < channels; ++c) {
    for (std::uint32_t ti = 0; ti < n[0]; ++ti) {
      for (std::uint32_t to = 0; to < n[1]; ++to) {
        for (std::uint32_t pd = 0; pd < n[2]; ++pd) {
          for (std::uint32_t pi = 0; pi < n[3]; ++pi) {
            numbers.push_back(static_cast<float>(closed(ti, to, pd, pi, c)));
          }
        }
      }
    }
  }
  return numbers;
}

/// Different in each bin, and not the same with light and viewer exchanged.
double distinct(std::uint32_t ti, std::uint32_t to, std::uint32_t pd, std::uint32_t pi, int c) {
  return 0.25 + ti + 10.0 * to + 100.0 * pd + 1000.0 * pi + 0.125 * c;
}

Bytes small_file() { return file_of(header_of(kCounts), planar(kCounts, distinct)); }

std::unique_ptr<BrdfSource> open(const Bytes& bytes, const Options& options = {}) {
  auto source = open_source(source_of(bytes), options);
  if (!source) throw std::runtime_error(source.error().message);
  return std::move(source).value();
}

Error refusal(const Bytes& bytes, const Options& options = {}) {
  const auto source = open_source(source_of(bytes), options);
  return source ? usage_error("it was opened") : source.error();
}

struct Saved {
  Bytes bytes;
  Report report;
};

Result<Saved> save(const BrdfSource& source, const Options& options = {}) {
  MemorySink sink;
  Saved saved;
  if (Status done = save_source(**find_writer(".dat"), source, sink, options, saved.report); !done) return done.error();
  saved.bytes = std::move(sink).take();
  return saved;
}

std::vector<float> numbers_of(const Bytes& bytes) {
  std::vector<float> numbers((bytes.size() - kNganHeaderSize) / sizeof(float));
  std::memcpy(numbers.data(), bytes.data() + kNganHeaderSize, numbers.size() * sizeof(float));
  return numbers;
}

TEST(NganParse, RefusesHeadersThatMakeNoSense) {
  const auto with = [](std::size_t place, std::int32_t number) {
    Header header = header_of(kCounts);
    header[place] = number;
    return parse_ngan_header(std::as_bytes(std::span(header)), small_file().size());
  };
  ASSERT_TRUE(with(4, 77).ok()) << "reserved numbers may be anything";
  for (std::size_t axis = 0; axis < 4; ++axis) {
    for (const std::int32_t count : {0, -1, 4097, 65536, std::numeric_limits<std::int32_t>::min()}) {
      const auto refused = with(axis, count);
      ASSERT_FALSE(refused.ok());
      EXPECT_EQ(refused.error().code, ErrorCode::kInvalidFile);
      EXPECT_EQ(refused.error().offset, 4 * axis);
    }
  }
  for (const std::int32_t channels : {0, -3, 1025}) EXPECT_EQ(with(10, channels).error().offset, 40U);
  for (const std::int32_t half : {-1, 2}) EXPECT_EQ(with(9, half).error().offset, 36U);
  EXPECT_EQ(with(6, 0).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(with(7, 1).error().code, ErrorCode::kUnsupported);
}

// 4096^4 x 1024 numbers: the size fits 64 bits, and no product of counts comes to that of a small file.
TEST(NganParse, RefusesCountsThatOnlyMatchByWrapping) {
  const Header largest = header_of({4096, 4096, 4096, 4096}, false, 1024);
  const auto refused = parse_ngan_header(std::as_bytes(std::span(largest)), 64);
  EXPECT_THAT(refused.error().message, HasSubstr("need 1152921504606847040 bytes, the file has 64"));
}

TEST(NganParse, SaysHowManyBytesATableShouldHave) {
  Bytes file = small_file();
  ASSERT_EQ(file.size(), 64 + 4 * 3 * 3 * 4 * 6 * 4);
  file.pop_back();
  EXPECT_THAT(refusal(file).message, HasSubstr("truncated anisotropic table: 3 x 4 x 6 x 4 bins of 3 channels need "
                                               "3520 bytes, the file has 3519"));
  file.resize(3521);
  EXPECT_THAT(refusal(file).message, HasSubstr("bytes after the end of the anisotropic table"));
}

TEST(NganParse, RefusesEveryTruncatedPrefix) {
  const Bytes file = file_of(header_of({2, 1, 2, 2}), planar({2, 1, 2, 2}, distinct));
  ASSERT_TRUE(open_source(std::make_shared<MemorySource>(file)).ok());
  for (std::size_t size = 0; size < file.size(); ++size) {
    const auto prefix = std::make_unique<std::byte[]>(size);
    std::copy_n(file.begin(), size, prefix.get());
    const auto opened = open_source(std::make_shared<MemorySource>(std::span(prefix.get(), size)));
    ASSERT_FALSE(opened.ok()) << size;
    if (size < 64) continue;
    EXPECT_THAT(opened.error().message, HasSubstr("anisotropic table")) << size;
  }
}

TEST(NganRecognise, TellsATableOfThirteenCellsFromAMerlOneOfTheSameSize) {
  const Bytes ngan = file_of(header_of({13, 1, 1, 5}, false, 1), planar({13, 1, 1, 5}, distinct, 1));
  const Bytes merl = small_files::merl({13, 1, 1});
  ASSERT_EQ(ngan.size(), merl.size());
  ASSERT_TRUE(recognises_merl(ngan, ngan.size()));
  EXPECT_EQ((*recognise(MemorySource(ngan)))->name, "ngan");
  EXPECT_EQ((*recognise(MemorySource(merl)))->name, "merl");
}

TEST(NganRecognise, NamesOtherParameterisations) {
  Header header = header_of(kCounts);
  header[6] = 0;
  EXPECT_EQ(refusal(file_of(header, planar(kCounts, distinct))).code, ErrorCode::kUnsupported);
}

TEST(NganSource, HasItsNumbersAtTheCentresOfBins) {
  const auto source = open(small_file());
  EXPECT_FALSE(source->traits().isotropic);
  EXPECT_FALSE(source->traits().reciprocal);
  for (const auto& [ti, to, pd, pi] :
       std::vector<std::array<std::uint32_t, 4>>{{0, 0, 0, 0}, {2, 1, 5, 3}, {1, 3, 2, 1}}) {
    const double phi_i = 45 + 90.0 * pi;
    const auto values = value(*source, 15 + 30.0 * ti, phi_i, 11.25 + 22.5 * to, phi_i + 30 + 60.0 * pd);
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(values[c], static_cast<float>(distinct(ti, to, pd, pi, c)));
  }
}

TEST(NganSource, OrAtTheirEdges) {
  const auto source = open(small_file(), Options().set("ngan-position", "edge"));
  EXPECT_FLOAT_EQ(value(*source, 60, 270, 22.5, 270 + 300)[1], static_cast<float>(distinct(2, 1, 5, 3, 1)));
  EXPECT_FLOAT_EQ(value(*source, 0, 0, 0, 0)[2], static_cast<float>(distinct(0, 0, 0, 0, 2)));
}

TEST(NganSource, IsLinearBetweenBins) {
  const auto source = open(small_file());
  const double between = distinct(0, 0, 0, 0, 0) + 0.5 * 1 + 0.25 * 10 + 0.75 * 100 + 0.1 * 1000;
  EXPECT_NEAR(value(*source, 30, 54, 11.25 + 0.25 * 22.5, 54 + 30 + 0.75 * 60)[0], between, 1e-3);
}

TEST(NganSource, ReadsInterleavedChannelsWhereAsked) {
  const std::vector<float> numbers = planar(kCounts, distinct);
  std::vector<float> interleaved;
  for (std::size_t bin = 0; bin < numbers.size() / 3; ++bin) {
    for (std::size_t c = 0; c < 3; ++c) interleaved.push_back(numbers[c * numbers.size() / 3 + bin]);
  }
  const Options options = Options().set("ngan-channels", "interleaved").set("ngan-scale", "10");
  const auto source = open(file_of(header_of(kCounts), interleaved), options);
  EXPECT_FLOAT_EQ(value(*source, 75, 135, 78.75, 135 + 90)[2], static_cast<float>(10 * distinct(2, 3, 1, 1, 2)));
  EXPECT_EQ(source->stored("ngan"), nullptr) << "by default these bytes mean something else";
  EXPECT_EQ(numbers_of(save(*source, options)->bytes), interleaved);
  EXPECT_EQ(numbers_of(save(*source, Options().set("ngan-scale", "10"))->bytes), numbers);
}

TEST(NganSource, TakesBinsWithANegativeOrNonFiniteChannelForUnmeasured) {
  for (const float number : {-1.0f, -1e-30f, kNaN, kInfinite, -kInfinite}) {
    std::vector<float> numbers = planar(kCounts, distinct);
    numbers[1 + numbers.size() / 3] = number;  // green of the bin with phi_in 135
    const auto source = open(file_of(header_of(kCounts), numbers));
    EXPECT_FALSE(is_measured(*source, 15, 135, 11.25, 165)) << number;
    EXPECT_TRUE(is_measured(*source, 15, 45, 11.25, 75)) << number;
    EXPECT_EQ(source->traits().findings.back().count, 1U) << number;
    const Error strict = refusal(file_of(header_of(kCounts), numbers), Options().set("non-finite", "refuse"));
    if (std::isfinite(number)) continue;
    EXPECT_EQ(strict.code, ErrorCode::kInvalidFile) << number;
    EXPECT_EQ(strict.offset, 64 + 4 * (1 + numbers.size() / 3)) << number;
  }
}

TEST(NganSource, TakesAMinusZeroForZero) {
  std::vector<float> numbers = planar(kCounts, distinct);
  numbers[0] = -0.0f;
  const auto source = open(file_of(header_of(kCounts), numbers));
  EXPECT_TRUE(source->traits().findings.empty());
  EXPECT_EQ(value(*source, 15, 45, 11.25, 75)[0], 0);
}

TEST(NganSource, OneBinOfPhiInIsIsotropic) {
  const auto source = open(file_of(header_of({2, 2, 4, 1}, false, 1), planar({2, 2, 4, 1}, distinct, 1)));
  EXPECT_TRUE(source->traits().isotropic);
  EXPECT_EQ(source->traits().channels, std::vector<std::string>{"C1"});
  EXPECT_EQ(value(*source, 22.5, 10, 67.5, 145), value(*source, 22.5, 200, 67.5, 335));
}

TEST(NganHalf, IsReadAsTheMirrorImageThatIsAskedFor) {
  const std::array<std::uint32_t, 4> counts = {1, 1, 3, 4};
  const Bytes file = file_of(header_of(counts, true), planar(counts, distinct));
  const auto at = [&](const char* meaning, double phi_i, double difference) {
    const auto source = open(file, Options().set("ngan-other-half", meaning));
    return is_measured(*source, 45, phi_i, 45, phi_i + difference)
               ? value(*source, 45, phi_i, 45, phi_i + difference)[0]
               : -1;
  };
  for (std::uint32_t pi = 0; pi < 4; ++pi) {
    for (std::uint32_t pd = 0; pd < 3; ++pd) {
      const double phi_i = 45 + 90.0 * pi;
      const double difference = 30 + 60.0 * pd;
      const auto stored = static_cast<float>(distinct(0, 0, pd, pi, 0));
      for (const char* meaning : {"tangent", "plane", "unmeasured"}) {
        EXPECT_FLOAT_EQ(at(meaning, phi_i, difference), stored);
      }
      EXPECT_FLOAT_EQ(at("tangent", -phi_i, -difference), stored);
      EXPECT_FLOAT_EQ(at("plane", phi_i, -difference), stored);
      EXPECT_EQ(at("unmeasured", phi_i, -difference), -1);
    }
  }
  EXPECT_THAT(open(file)->traits().findings[0].what, HasSubstr("mirror images about the tangent"));
}

TEST(NganHalf, AtEdgesHasNoNodeOppositeToTheLight) {
  const std::array<std::uint32_t, 4> counts = {1, 1, 3, 4};
  const Bytes file = file_of(header_of(counts, true), planar(counts, distinct));
  const auto source = open(file, Options().set("ngan-position", "edge"));
  const auto stored = [](std::uint32_t pd, std::uint32_t pi) { return static_cast<float>(distinct(0, 0, pd, pi, 0)); };
  EXPECT_FLOAT_EQ(value(*source, 0, 90, 0, 90 + 120)[0], stored(2, 1));
  EXPECT_FLOAT_EQ(value(*source, 0, -90, 0, -90 - 120)[0], stored(2, 1));
  EXPECT_FLOAT_EQ(value(*source, 0, 0, 0, -60)[0], stored(1, 0));
  EXPECT_FLOAT_EQ(value(*source, 0, 180, 0, 180)[0], stored(0, 2));
  EXPECT_FLOAT_EQ(value(*source, 0, 0, 0, 180)[0], stored(2, 0));
}

TEST(NganCopy, KeepsEveryBit) {
  std::vector<float> numbers = planar(kCounts, distinct);
  const std::vector<float> special = {-1, -0.0f, 1e-42f, 1e12f, kNaN, kInfinite, -0.25f};
  std::copy(special.begin(), special.end() - 2, numbers.begin() + 7);
  const std::uint32_t payload = 0x7FC12345;
  std::memcpy(&numbers[3], &payload, 4);
  Header header = header_of(kCounts);
  header[5] = 77;
  const Bytes file = file_of(header, numbers);
  const auto copy = save(*open(file));
  EXPECT_EQ(copy->bytes, file);
  EXPECT_EQ(copy->report.remarks[0].key, "copied");
  EXPECT_EQ(save(*open(file), Options().set("ngan-shape", "3,4,6,4"))->bytes, file);
  EXPECT_NE(save(*open(file), Options().set("ngan-shape", "3,4,6,5"))->bytes, file);
}

TEST(NganCopy, OfHalfDataStaysHalf) {
  const Bytes file = file_of(header_of(kCounts, true), planar(kCounts, distinct));
  EXPECT_EQ(save(*open(file))->bytes, file);
  EXPECT_EQ(save(*open(file), Options().set("ngan-half"))->bytes, file);
  const auto whole = save(*open(file), Options().set("ngan-shape", "3,4,12,4"));
  ASSERT_EQ(whole->bytes.size(), 64 + 2 * (file.size() - 64));
  EXPECT_TRUE(has_remark(whole->report, "same_nodes"));
  const Bytes back = save(*open(whole->bytes), Options().set("ngan-half"))->bytes;
  EXPECT_EQ(back, file);
}

TEST(NganCopy, WithOtherConventionsKeepsEveryNumber) {
  const std::vector<float> numbers = planar(kCounts, distinct);
  const Bytes file = file_of(header_of(kCounts), numbers);
  for (const char* position : {"edge", "centre"}) {
    const Options options = Options().set("ngan-position", position).set("ngan-channels", "interleaved");
    const auto copy = save(*open(file, options), options);
    EXPECT_EQ(copy->bytes, file);
    EXPECT_TRUE(has_remark(copy->report, "same_nodes"));
  }
}

/// Anisotropic, not reciprocal, without any mirror plane.
FunctionSource skew_source() {
  return FunctionSource([](const DirectionPair& p, std::size_t c) {
    return 2 + static_cast<double>(c) + std::sin(p.i.phi) * p.i.theta + 0.5 * std::cos(2 * p.v.phi + 0.3) * p.v.theta;
  });
}

TEST(NganSave, HoldsTheSourceAtEachNode) {
  const FunctionSource source = skew_source();
  for (const char* position : {"centre", "edge"}) {
    const double offset = std::string(position) == "centre" ? 0.5 : 0;
    const auto saved = save(source, Options().set("ngan-shape", "3,4,6,8").set("ngan-position", position));
    ASSERT_TRUE(saved.ok()) << saved.error().message;
    const std::vector<float> expected =
        planar({3, 4, 6, 8}, [&](std::uint32_t ti, std::uint32_t to, std::uint32_t pd, std::uint32_t pi, int c) {
          const double phi_i = (pi + offset) * 45;
          const DirectionPair pair = {direction_from_degrees((ti + offset) * 30, phi_i),
                                      direction_from_degrees((to + offset) * 22.5, phi_i + (pd + offset) * 60)};
          return 2 + static_cast<double>(c) + std::sin(pair.i.phi) * pair.i.theta +
                 0.5 * std::cos(2 * pair.v.phi + 0.3) * pair.v.theta;
        });
    const std::vector<float> numbers = numbers_of(saved->bytes);
    ASSERT_EQ(numbers.size(), expected.size());
    for (std::size_t n = 0; n < numbers.size(); ++n) ASSERT_NEAR(numbers[n], expected[n], 1e-6) << n;
    EXPECT_TRUE(has_remark(saved->report, "resampling_mre_percent"));
  }
}

TEST(NganSave, ShapesByTheSource) {
  const FunctionSource isotropic([](const DirectionPair&, std::size_t) { return 0.5; }, {true, true, {"Y"}});
  const auto saved = save(isotropic);
  ASSERT_TRUE(saved.ok());
  EXPECT_EQ(saved->bytes.size(), 64 + 4 * 45 * 45 * 72);
  EXPECT_EQ(saved->bytes, save(isotropic, Options().set("ngan-shape", "45,45,72,1"))->bytes);
  const auto half = save(isotropic, Options().set("ngan-half"));
  EXPECT_EQ(half->bytes.size(), 64 + 4 * 45 * 45 * 36);
  EXPECT_TRUE(open(half->bytes)->traits().isotropic);
}

TEST(NganSave, SaysWhatNegativeValuesBecome) {
  const FunctionSource source([](const DirectionPair& p, std::size_t c) { return c == 1 ? p.i.theta - 0.5 : 1; });
  const Options shape = Options().set("ngan-shape", "3,1,1,1");
  const auto green = [&](const Options& options) {
    const std::vector<float> numbers = numbers_of(save(source, options)->bytes);
    return std::vector<float>{numbers[0], numbers[3], numbers[4]};  // red at 15 degrees, green at 15 and 45
  };
  const auto value_at = [](double theta) { return static_cast<float>(radians_from_degrees(theta) - 0.5); };
  EXPECT_EQ(green(shape), (std::vector<float>{1, 0, value_at(45)}));
  EXPECT_EQ(green(Options(shape).set("negatives", "keep")), (std::vector<float>{1, value_at(15), value_at(45)}));
  EXPECT_EQ(green(Options(shape).set("negatives", "unmeasured")), (std::vector<float>{-1, -1, value_at(45)}));
  EXPECT_TRUE(has_remark(save(source, Options(shape).set("negatives", "keep"))->report, "read_as_unmeasured"));
  const FunctionSource below([](const DirectionPair&, std::size_t c) { return c == 1 ? -1 : 1; });
  EXPECT_EQ(save(below, Options(shape).set("negatives", "keep")).error().code, ErrorCode::kInvalidFile);
}

TEST(NganSave, MarksWhatTheSourceDidNotMeasureAndReadsItBack) {
  std::vector<float> numbers = planar(kCounts, distinct);
  for (std::size_t c = 0; c < 3; ++c) numbers[5 + c * numbers.size() / 3] = c == 1 ? kNaN : 3.0f;
  const Bytes file = file_of(header_of(kCounts), numbers);
  const Options scaled = Options().set("ngan-scale", "2");
  const auto saved = save(*open(file, scaled), scaled);
  const std::vector<float> written = numbers_of(saved->bytes);
  for (std::size_t n = 0; n < written.size(); ++n) {
    EXPECT_EQ(written[n], n % (numbers.size() / 3) == 5 ? -1 : numbers[n]) << n;
  }
  EXPECT_TRUE(has_remark(saved->report, "unmeasured_nodes"));
  EXPECT_FALSE(is_measured(*open(saved->bytes), 15, 135, 11.25, 135 + 90));
}

TEST(NganSave, StoresHalfOfASymmetricSourceWithoutLoss) {
  const FunctionSource symmetric([](const DirectionPair& p, std::size_t c) {
    return 2 + static_cast<double>(c) + std::cos(p.i.phi) * p.i.theta + 0.5 * std::cos(2 * p.v.phi) * p.v.theta;
  });
  const Options half = Options().set("ngan-shape", "3,3,4,8").set("ngan-half");
  const Options shape = Options().set("ngan-shape", "3,3,8,8");
  const auto whole = open(save(symmetric, shape)->bytes);
  const auto halved = open(save(symmetric, half)->bytes);
  for (double phi_i = 0; phi_i < 360; phi_i += 25) {
    for (double phi_v = 0; phi_v < 360; phi_v += 35) {
      const float expected = value(*whole, 33, phi_i, 50, phi_v)[0];
      EXPECT_NEAR(value(*halved, 33, phi_i, 50, phi_v)[0], expected, 1e-5) << phi_i << " " << phi_v;
    }
  }
  const auto loss = [](const BrdfSource& source, const Options& options) {
    const Report report = save(source, options)->report;
    for (const Remark& remark : report.remarks) {
      if (remark.key == "resampling_rel_l1_percent") return remark.value;
    }
    return -1.0;
  };
  EXPECT_NEAR(loss(symmetric, half), loss(symmetric, shape), 1e-4);
  EXPECT_GT(loss(skew_source(), half), 2 * loss(skew_source(), shape)) << "the other half is not the mirror image";
}

TEST(NganSave, RefusesTablesThatReadersCannotCount) {
  const FunctionSource source = skew_source();
  const auto refused = save(source, Options().set("ngan-shape", "4096,4096,64,1"));
  EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
  const FunctionSource many([](const DirectionPair&, std::size_t) { return 1; },
                            {true, true, std::vector<std::string>(1025, "c")});
  EXPECT_EQ(save(many).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace sbrdf::internal
