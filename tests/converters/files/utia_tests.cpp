#include "converters/files/utia/utia.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "converters/files/format_table.h"
#include "converters/files/utia/srgb.h"
#include "formats/merl/merl.h"
#include "tests/support/function_source.h"
#include "tests/support/small_files.h"
#include "tests/support/source_values.h"

namespace sbrdf::internal {
namespace {

using small_files::Bytes;
using small_files::source_of;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// Enough to tell all axes apart.
constexpr UtiaShape kSmall = {3, 4, 25, 90};

/// A number of four indices and a channel.
using Closed = std::function<double(std::uint32_t ti, std::uint32_t pi, std::uint32_t tv, std::uint32_t pv, int c)>;

// Written from specs/utia.md.
std::vector<double> numbers_of(const UtiaShape& shape, const Closed& closed) {
  std::vector<double> numbers;
  const std::uint32_t directions = shape.theta_count * shape.phi_count;
  for (int c = 0; c < 3; ++c) {
    for (std::uint32_t i = 0; i < directions; ++i) {
      for (std::uint32_t v = 0; v < directions; ++v) {
        numbers.push_back(
            closed(i / shape.phi_count, i % shape.phi_count, v / shape.phi_count, v % shape.phi_count, c));
      }
    }
  }
  return numbers;
}

/// Different at each node, and not the same with light and viewer exchanged.
double distinct(std::uint32_t ti, std::uint32_t pi, std::uint32_t tv, std::uint32_t pv, int c) {
  return 0.25 + ti + 10.0 * pi + 100.0 * tv + 1000.0 * pv + 0.125 * c;
}

Bytes bytes_of(const std::vector<double>& numbers) {
  Bytes bytes(numbers.size() * sizeof(double));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

std::vector<double> numbers_in(const Bytes& bytes) {
  std::vector<double> numbers(bytes.size() / sizeof(double));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

std::unique_ptr<BrdfSource> open(const std::vector<double>& numbers, const UtiaConventions& conventions = {},
                                 const ValuePolicy& policy = {Negatives::kKeep, NonFinite::kUnmeasured}) {
  auto source = make_utia_source(source_of(bytes_of(numbers)), kSmall, conventions, policy);
  if (!source) throw std::runtime_error(source.error().message);
  return std::move(source).value();
}

struct Saved {
  Bytes bytes;
  Report report;
};

Result<Saved> write(const BrdfSource& source, const Options& options = {}, const UtiaShape& shape = kSmall) {
  MemorySink sink;
  Saved saved;
  if (Status done = write_utia(source, shape, sink, options, saved.report, {}); !done) return done.error();
  saved.bytes = std::move(sink).take();
  return saved;
}

Result<Saved> save(const BrdfSource& source, const Options& options = {}) {
  MemorySink sink;
  Saved saved;
  if (Status done = save_source(**find_writer(".bin"), source, sink, options, saved.report); !done) return done.error();
  saved.bytes = std::move(sink).take();
  return saved;
}

TEST(UtiaShape, HasThePublishedSizes) {
  EXPECT_EQ(utia_file_size(kUtiaStandard), 1990656U);
  EXPECT_EQ(utia_file_size(kUtiaDense), 1505433600U);
  EXPECT_EQ(utia_index(kUtiaStandard, 2, 5, 47, 5, 47), 3U * 288 * 288 - 1);
  // No MERL table has them: 12 + 24 N is 12 more than a multiple of 24.
  for (const UtiaShape& shape : {kUtiaStandard, kUtiaDense}) EXPECT_EQ(utia_file_size(shape) % 24, 0U);
}

TEST(UtiaRecognise, WantsTheSizeAndNumbersThatMakeSense) {
  Bytes file = small_files::utia();
  EXPECT_EQ((*recognise(MemorySource(file)))->name, "utia");
  std::mt19937_64 random(3);
  for (int times = 0; times < 100; ++times) {
    for (std::size_t k = 0; k < 512; k += 8) {
      const std::uint64_t bits = random();
      std::memcpy(file.data() + k, &bits, 8);
    }
    EXPECT_FALSE(recognises_utia(file, file.size()));
  }
  EXPECT_THAT(open_source(source_of(file)).error().message,
              HasSubstr("the size of a UTIA table, but its first numbers"));
  const Bytes text(file.size(), std::byte{'8'});
  EXPECT_THAT(open_source(source_of(text)).error().message, HasSubstr("its first numbers"));
}

TEST(UtiaRecognise, LeavesOtherFormatsOfItsSizeAlone) {
  Bytes file = small_files::utia();
  const std::array<std::int32_t, 16> ngan = {1, 1, 1, 497648, 0, 0,
                                             1, 0, 0, 0,      1};  // float32 that follow could be right
  std::memcpy(file.data(), ngan.data(), sizeof ngan);
  EXPECT_FALSE(recognises_utia(file, file.size()));
  using namespace std::string_literals;
  const std::string npy = "\x93NUMPY\1\0v\0{'descr': '<f8', 'fortran_order': False, 'shape': (6, 48), }"s;
  file = small_files::utia();
  std::memcpy(file.data(), npy.data(), npy.size());
  EXPECT_FALSE(recognises_utia(file, file.size()));
}

TEST(UtiaOpen, RefusesOtherSizes) {
  const Bytes file = small_files::utia();
  ASSERT_TRUE(open_source(source_of(file)).ok());
  for (const std::size_t size : {std::size_t{0}, std::size_t{8}, std::size_t{512}, file.size() - 8, file.size() - 1}) {
    EXPECT_FALSE(open_source(std::make_shared<MemorySource>(std::span(file).first(size))).ok()) << size;
  }
  Bytes longer = file;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(open_source(source_of(longer)).ok());
  const Bytes small = bytes_of(numbers_of(kSmall, distinct));
  for (std::size_t size = 0; size < small.size(); ++size) {
    const auto prefix = std::make_unique<std::byte[]>(size);
    std::copy_n(small.begin(), size, prefix.get());
    const auto bytes = std::make_shared<MemorySource>(std::span(prefix.get(), size));
    EXPECT_FALSE(make_utia_source(bytes, kSmall, {}, {}).ok()) << size;
  }
}

TEST(UtiaSource, HasItsNumbersAtItsDirections) {
  const auto source = open(numbers_of(kSmall, distinct));
  EXPECT_EQ(source->traits().theta_max_deg, 50);
  for (const auto& [ti, pi, tv, pv] :
       std::vector<std::array<std::uint32_t, 4>>{{0, 0, 0, 0}, {2, 1, 0, 3}, {1, 3, 2, 2}}) {
    const auto values = value(*source, 25.0 * ti, 90.0 * pi, 25.0 * tv, 90.0 * pv);
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(values[c], static_cast<float>(distinct(ti, pi, tv, pv, c)));
  }
  const double between = distinct(0, 0, 0, 0, 0) + 0.5 * 1 + 0.25 * 10 + 0.75 * 100 + 0.1 * 1000;
  EXPECT_NEAR(value(*source, 12.5, 22.5, 18.75, 9)[0], between, 1e-3);
}

TEST(UtiaSource, HoldsTheLastThetaOrGoesOnInAStraightLine) {
  const std::vector<double> falling = numbers_of(kSmall, [](auto, auto, auto tv, auto, auto) { return 3.0 - tv; });
  EXPECT_FLOAT_EQ(value(*open(falling), 10, 0, 65, 0)[0], 1);
  const auto source = open(falling, {.extrapolated = true});
  EXPECT_FLOAT_EQ(value(*source, 10, 0, 65, 0)[0], 1 - 15.0f / 25);
  EXPECT_EQ(value(*source, 10, 0, 88, 0)[0], 0) << "not negative";
  EXPECT_THAT(source->traits().beyond_theta_max, HasSubstr("straight line"));
}

TEST(UtiaSource, StaysFiniteInAStraightLineThroughLargeValues) {
  const auto rising = [](double last) {
    return open(numbers_of(kSmall, [=](auto ti, auto, auto tv, auto, auto) { return ti + tv == 4 ? last : 1; }),
                {.extrapolated = true});
  };
  EXPECT_EQ(value(*rising(1e38), 89, 0, 89, 0)[0], 1e38f);
  EXPECT_EQ(value(*rising(-1e38), 89, 0, 89, 0)[0], -1e38f);
}

TEST(UtiaSource, DecodesBeforeOrAfterInterpolating) {
  const std::vector<double> numbers = numbers_of(kSmall, [](auto, auto, auto tv, auto, auto) { return 70.0 * tv; });
  const auto decoded = [](double x) { return std::pow((x + 0.055) / 1.055, 2.4); };
  UtiaConventions conventions = {.scale = 100, .white = 140};
  const auto at = [&](UtiaGamma gamma) {
    conventions.gamma = gamma;
    const auto source = open(numbers, conventions);
    EXPECT_EQ(source->stored("utia"), nullptr);
    EXPECT_NEAR(value(*source, 0, 0, 50, 0)[0], 100, 1e-4);
    return value(*source, 0, 0, 37.5, 0)[0];
  };
  EXPECT_NEAR(at(UtiaGamma::kNone), 75, 1e-4);
  EXPECT_NEAR(at(UtiaGamma::kSrgbBefore), 100 * (decoded(0.5) + 1) / 2, 1e-4);
  EXPECT_NEAR(at(UtiaGamma::kSrgbAfter), 100 * decoded(0.75), 1e-4);
}

TEST(UtiaSource, DecodesWhatThePolicyLeaves) {
  std::vector<double> numbers = numbers_of(kSmall, [](auto...) { return 0.5; });
  numbers[0] = -1;
  numbers[1] = kNaN;
  for (const UtiaGamma gamma : {UtiaGamma::kSrgbBefore, UtiaGamma::kSrgbAfter}) {
    EXPECT_NEAR(value(*open(numbers, {.gamma = gamma}), 0, 0, 0, 0)[0], -1 / 12.92, 1e-6);
    const auto clamped = open(numbers, {.gamma = gamma}, {Negatives::kClamp, NonFinite::kUnmeasured});
    EXPECT_EQ(value(*clamped, 0, 0, 0, 0)[0], 0);
    EXPECT_FALSE(is_measured(*clamped, 0, 0, 0, 90));
    EXPECT_TRUE(is_measured(*clamped, 0, 0, 0, 180));
  }
}

TEST(UtiaSource, TakesNanForUnmeasuredAndCountsNegatives) {
  std::vector<double> numbers = numbers_of(kSmall, distinct);
  numbers[5] = kNaN;
  numbers[7] = -3;
  numbers[9] = kInfinite;
  const auto source = open(numbers);
  ASSERT_EQ(source->traits().findings.size(), 3U);
  EXPECT_FALSE(is_measured(*source, 0, 0, 25, 90));
  EXPECT_FALSE(is_measured(*source, 0, 0, 50, 90));
  EXPECT_EQ(value(*source, 0, 0, 25, 270)[0], -3);
  EXPECT_FALSE(make_utia_source(source_of(bytes_of(numbers)), kSmall, {}, {Negatives::kKeep, NonFinite::kRefuse}).ok());
}

TEST(UtiaCopy, KeepsEveryBit) {
  std::vector<double> numbers = numbers_in(small_files::utia());
  const std::vector<double> special = {-1, -0.0, 5e-324, 1e12, kNaN, -0.25};
  std::copy(special.begin(), special.end(), numbers.begin() + 100);
  const std::uint64_t payload = 0x7FF8000012345678;
  std::memcpy(&numbers[3], &payload, 8);
  const Bytes file = bytes_of(numbers);
  const auto source = open_source(source_of(file)).value();
  const auto copy = save(*source);
  EXPECT_EQ(copy->bytes, file);
  EXPECT_EQ(copy->report.remarks[0].key, "copied");
  EXPECT_EQ(save(*source, Options().set("utia-grid", "standard"))->bytes, file);
  const auto again = save(*source, Options().set("utia-scale", "2"));
  EXPECT_TRUE(has_remark(again->report, "same_nodes"));
  EXPECT_EQ(numbers_in(again->bytes)[103], 5e11);
}

TEST(UtiaCopy, WithOtherConventionsKeepsEveryNumberButForRounding) {
  const std::vector<double> numbers = numbers_in(small_files::utia());
  for (const char* gamma : {"none", "srgb-before", "srgb-after"}) {
    const Options options = Options().set("utia-gamma", gamma).set("utia-white", "140").set("utia-scale", "100");
    const Options reading = Options(options).set("utia-beyond", "extrapolated");
    const auto source = open_source(source_of(bytes_of(numbers)), reading).value();
    const auto saved = save(*source, options);
    ASSERT_TRUE(saved.ok()) << saved.error().message;
    EXPECT_TRUE(has_remark(saved->report, "same_nodes"));
    const std::vector<double> again = numbers_in(saved->bytes);
    for (std::size_t n = 0; n < numbers.size(); ++n) ASSERT_NEAR(again[n], numbers[n], 1e-11 * numbers[n]) << n;
  }
}

/// Anisotropic, not reciprocal, without any mirror plane.
double skew(const DirectionPair& p, std::size_t channel) {
  const auto c = static_cast<double>(channel);
  return 2 + c + std::sin(p.i.phi) * p.i.theta + 0.5 * std::cos(2 * p.v.phi + 0.3) * p.v.theta;
}

TEST(UtiaWrite, HoldsTheSourceAtEachDirection) {
  const auto saved = write(FunctionSource(skew));
  ASSERT_TRUE(saved.ok()) << saved.error().message;
  const std::vector<double> expected = numbers_of(kSmall, [](auto ti, auto pi, auto tv, auto pv, auto c) {
    return skew({direction_from_degrees(25.0 * ti, 90.0 * pi), direction_from_degrees(25.0 * tv, 90.0 * pv)},
                static_cast<std::size_t>(c));
  });
  const std::vector<double> numbers = numbers_in(saved->bytes);
  ASSERT_EQ(numbers.size(), expected.size());
  for (std::size_t n = 0; n < numbers.size(); ++n) ASSERT_NEAR(numbers[n], expected[n], 1e-6) << n;
  EXPECT_TRUE(has_remark(saved->report, "resampling_mre_percent"));
  EXPECT_TRUE(has_remark(saved->report, "theta_last_deg")) << "the source goes to 90 degrees, the table to 50";
}

TEST(UtiaWrite, EncodesWhatReadingDecodes) {
  for (const char* gamma : {"srgb-before", "srgb-after"}) {
    const Options options = Options().set("utia-gamma", gamma).set("utia-scale", "0.5");
    const auto saved = write(FunctionSource(skew), options);
    ASSERT_TRUE(saved.ok());
    const auto source = open(numbers_in(saved->bytes), utia_conventions(options));
    const DirectionPair pair = {direction_from_degrees(50, 90), direction_from_degrees(25, 270)};
    EXPECT_NEAR(value(*source, 50, 90, 25, 270)[1], skew(pair, 1), 1e-5);
    EXPECT_GT(numbers_in(saved->bytes)[0], 1.5);
  }
}

TEST(UtiaWrite, RepeatsTheOnlyChannelAndRefusesOtherCounts) {
  const auto constant = [](std::size_t channels) {
    return FunctionSource([](const DirectionPair&, std::size_t) { return 0.5; },
                          {true, true, std::vector<std::string>(channels, "c")});
  };
  const auto saved = write(constant(1));
  EXPECT_EQ(numbers_in(saved->bytes), std::vector<double>(3 * 144, 0.5));
  EXPECT_TRUE(has_remark(saved->report, "channel_repeated"));
  EXPECT_EQ(write(constant(2)).error().code, ErrorCode::kUnsupported);
}

TEST(UtiaWrite, DoesAsAskedWithWhatWasNotMeasured) {
  std::vector<double> numbers = numbers_of(kSmall, distinct);
  numbers[6] = numbers[6 + 144] = numbers[6 + 288] = kNaN;
  const auto source = open(numbers);
  EXPECT_TRUE(std::isnan(numbers_in(write(*source)->bytes)[6 + 144]));
  const auto zero = write(*source, Options().set("utia-unmeasured", "zero"));
  EXPECT_EQ(numbers_in(zero->bytes)[6 + 144], 0);
  EXPECT_TRUE(has_remark(zero->report, "unmeasured_nodes"));
  const auto refused = write(*source, Options().set("utia-unmeasured", "refuse"));
  EXPECT_THAT(refused.error().message, HasSubstr("no value at theta_i 0, phi_i 0, theta_v 25, phi_v 180 degrees"));
}

TEST(UtiaWrite, MakesNoFileThatIsNotRecognised) {
  const auto table = [](double number) {
    return open(numbers_of(kSmall, [=](auto, auto, auto, auto, auto) { return number; }));
  };
  EXPECT_EQ(save(*table(1e-300)).error().message.substr(0, 4), "no v") << "0 as a float";
  std::vector<double> tiny = numbers_in(small_files::utia());
  std::fill_n(tiny.begin(), 64, 1.0);
  const auto source = open_source(source_of(bytes_of(tiny))).value();
  EXPECT_TRUE(save(*source, Options().set("utia-scale", "3")).ok());
  std::fill_n(tiny.begin() + 8, 30, 1e-300);
  const auto dim = open_source(source_of(bytes_of(tiny)));
  EXPECT_FALSE(dim.ok()) << "too few numbers make sense";
}

TEST(UtiaWrite, SaysWhatNegativeValuesBecome) {
  const FunctionSource source([](const DirectionPair& p, std::size_t) { return p.v.theta - 0.1; });
  EXPECT_FLOAT_EQ(static_cast<float>(numbers_in(write(source)->bytes)[0]), -0.1f);
  EXPECT_EQ(numbers_in(write(source, Options().set("negatives", "clamp"))->bytes)[0], 0);
  EXPECT_TRUE(has_remark(write(source)->report, "all_negative_nodes"));
}

TEST(Srgb, IsTheCurveOfTheStandardAndItsInverse) {
  EXPECT_NEAR(srgb_decoded(1), 1, 1e-12);
  EXPECT_NEAR(srgb_decoded(0.5), 0.21404114048223255, 1e-12);
  EXPECT_NEAR(srgb_decoded(0.04), 0.04 / 12.92, 1e-15);
  for (const double x : {-3.0, -1e-3, 0.0, 1e-5, 0.0031, 0.0032, 0.04, 0.5, 1.0, 20.0}) {
    EXPECT_NEAR(srgb_encoded(srgb_decoded(x)), x, 1e-12 * std::abs(x)) << x;
  }
}

}  // namespace
}  // namespace sbrdf::internal
