#include "codec/file/encoder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codec/coding/value_scaling.h"
#include "codec/file/index.h"
#include "formats/sbrdf/container.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

using testing::StartsWith;

using Bytes = std::vector<std::byte>;
using Random = std::mt19937_64;
using ValueOf = std::function<float(Random&)>;

constexpr float kDenormal = 1e-40F;
const EncodeOptions kLossless = {};
const EncodeOptions kTenthPercent = {0.001};

/// What every halving adds: the middle of a gap that begins at `left`, and perhaps those of its halves.
void halve(std::vector<SamplePosition>& places, std::uint32_t interval, std::uint32_t left, int depth, double chance,
           Random& random) {
  if (depth > 16 || std::uniform_real_distribution<double>()(random) >= chance) return;
  const std::uint32_t middle = left + (SamplePosition::kOne >> static_cast<unsigned>(depth));
  halve(places, interval, left, depth + 1, 0.9 * chance, random);
  places.push_back({interval, middle});
  halve(places, interval, middle, depth + 1, 0.9 * chance, random);
}

struct Example {
  Lattice lattice;
  SlicedBrdf sliced;
};

/// Samples anywhere that halving leads to, with values of any kind.
Example random_example(const FrameSpec& frame, DomainKind domain, std::size_t channels, double chance,
                       const ValueOf& value, std::uint64_t seed = 1) {
  Random random(seed);
  Example made;
  made.lattice = build_lattice(frame).value();
  SlicedBrdf& sliced = made.sliced;
  sliced.frame = frame;
  sliced.domain.kind = domain;
  if (domain == DomainKind::kLog) {
    sliced.domain.reference.assign(channels, 0.25F);
    sliced.domain.floor_halvings = 8;
  }
  sliced.channels = channel_names(channels);
  for (const Slice& slice : made.lattice.slices) {
    const std::size_t before = sliced.positions.size();
    for (std::uint32_t k = 0; k < slice.interval_count(); ++k) halve(sliced.positions, k, 0, 1, chance, random);
    sliced.sample_counts.push_back(static_cast<std::uint32_t>(sliced.positions.size() - before));
  }
  sliced.crossing_values.resize(made.lattice.crossings.size() * channels);
  sliced.sample_values.resize(sliced.positions.size() * channels);
  for (auto* values : {&sliced.crossing_values, &sliced.sample_values}) {
    std::generate(values->begin(), values->end(), [&] { return value(random); });
  }
  sliced.metadata = R"({"source": {"format": "a test"}})";
  return made;
}

float from_exponents(Random& random, double least, double greatest) {
  return static_cast<float>(std::pow(10.0, std::uniform_real_distribution<double>(least, greatest)(random)));
}

/// Zeros, both signs, five orders of magnitude.
float ordinary_value(Random& random) {
  if (random() % 16 == 0) return random() % 2 == 0 ? 0.0F : -0.0F;
  const float magnitude = from_exponents(random, -4, 1);
  return random() % 8 == 0 ? -magnitude : magnitude;
}

/// Any bits that are a number.
float any_value(Random& random) {
  const auto v = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  return std::isfinite(v) ? v : 1.0F;
}

/// Profiles over theta_h with values of any size that a guide may have.
void add_guide(Example& example, double ratio, double chance) {
  Random random(17);
  Guide guide;
  guide.ratio = ratio;
  const auto nodes = static_cast<std::uint32_t>(example.lattice.nodes[kVertical].size());
  for (std::uint32_t k = 0; k < nodes; ++k) {
    guide.places.push_back({k, 0});
    if (k + 1 < nodes) halve(guide.places, k, 0, 1, chance, random);
  }
  for (std::size_t k = 0; k < guide.places.size() * example.sliced.channel_count(); ++k) {
    guide.values.push_back(std::uniform_real_distribution<float>(-5, 5)(random));
  }
  example.sliced.guide = std::move(guide);
}

FrameSpec small_half_difference(const Symmetries& symmetries = {}) {
  const std::vector<double> phi_h = symmetries.isotropic ? std::vector{0.0} : std::vector{0.0, 90.0, 180.0, 270.0};
  return half_difference_frame({0, 10, 80}, {0, 40, 80}, phi_h, {0, 45, 90, 135}, symmetries);
}

FrameSpec small_elevation(const Symmetries& symmetries = {}) { return elevation_frame(40, 180, symmetries).value(); }

/// Both frames, all boundaries, one to five channels, node lists of all three forms, with and without guides.
std::vector<Example> all_kinds(const ValueOf& value) {
  std::vector<Example> examples;
  std::uint64_t seed = 100;
  for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
    for (const Symmetries& symmetries :
         {Symmetries{}, Symmetries{.isotropic = true, .mirror_x = true}, Symmetries{.isotropic = true},
          Symmetries{.mirror_y = true}, Symmetries{.mirror_x = true, .mirror_y = true}}) {
      examples.push_back(random_example(small_elevation(symmetries), domain, 1 + seed % 5, 0.4, value, seed));
      ++seed;
      examples.push_back(random_example(small_half_difference(symmetries), domain, 1 + seed % 5, 0.3, value, seed));
      ++seed;
    }
    const std::vector<double> thirds = {0, 100.0 / 3, 200.0 / 3};
    examples.push_back(
        random_example(elevation_frame_from_nodes(thirds, {0}, {0, 120.25, 180, 239.75}, {.isotropic = true}), domain,
                       2, 0.4, value, 7));
  }
  for (const auto& [ratio, isotropic] : {std::pair{1.0, false}, {1.7, false}, {1.0, true}}) {
    examples.push_back(random_example(small_half_difference({.isotropic = isotropic}), DomainKind::kLog,
                                      isotropic ? 3 : 2, 0.3, value, 9));
    add_guide(examples.back(), ratio, 0.7);
  }
  // Another theta_max, and a mask of either frame.
  for (const MaskFrame frame : {MaskFrame::kAngles, MaskFrame::kHalfDifference}) {
    FrameSpec spec = small_half_difference();
    spec.theta_max_deg = frame == MaskFrame::kAngles ? 72.25 : 90;
    examples.push_back(random_example(spec, DomainKind::kLinear, 1, 0.3, value, 11));
    DirectionMask mask = {{frame, {3, 4, 5, 6}}, {}};
    for (std::size_t cell = 0; cell < 360; ++cell) mask.unmeasured.push_back(cell * cell % 11 < 4);
    examples.back().sliced.mask = std::make_shared<const DirectionMask>(std::move(mask));
  }
  return examples;
}

/// From a heap block of exactly that size, so that the sanitizer sees a read beyond it.
Result<DecodedSliced> decode_exactly(std::span<const std::byte> bytes) {
  const auto copy = std::make_unique<std::byte[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), copy.get());
  return decode_sliced({copy.get(), bytes.size()});
}

/// What a file gives back, which must be something that may be written.
DecodedSliced through_a_file(const Example& example, const EncodeOptions& options) {
  EXPECT_TRUE(check_sliced(example.sliced, example.lattice));
  Result<DecodedSliced> decoded = decode_exactly(encode_sliced(example.sliced, example.lattice, options));
  if (!decoded) {
    ADD_FAILURE() << decoded.error().message;
    return {};
  }
  EXPECT_EQ(decoded->version, "1.0");
  EXPECT_TRUE(check_sliced(decoded->sliced, decoded->lattice));
  return *std::move(decoded);
}

std::vector<std::uint32_t> bits_of(const std::vector<float>& values) {
  std::vector<std::uint32_t> bits;
  for (const float v : values) bits.push_back(v == 0 ? 0 : std::bit_cast<std::uint32_t>(v));
  return bits;
}

void expect_all_but_values(const SlicedBrdf& back, const SlicedBrdf& sliced) {
  EXPECT_EQ(back.frame, sliced.frame);
  EXPECT_EQ(back.domain.kind, sliced.domain.kind);
  EXPECT_EQ(back.domain.floor_halvings, sliced.domain.floor_halvings);
  EXPECT_EQ(back.channels, sliced.channels);
  EXPECT_EQ(back.sample_counts, sliced.sample_counts);
  EXPECT_EQ(back.positions, sliced.positions);
  EXPECT_EQ(back.metadata, sliced.metadata);
  EXPECT_TRUE(back.whole_ranges.empty());
  ASSERT_EQ(back.mask != nullptr, sliced.mask != nullptr);
  if (sliced.mask) {
    EXPECT_EQ(*back.mask, *sliced.mask);
  }
  ASSERT_EQ(back.guide.has_value(), sliced.guide.has_value());
  if (sliced.guide) {
    EXPECT_EQ(back.guide->ratio, sliced.guide->ratio);
    EXPECT_EQ(back.guide->places, sliced.guide->places);
  }
}

void expect_every_bit(const SlicedBrdf& back, const SlicedBrdf& sliced) {
  expect_all_but_values(back, sliced);
  EXPECT_EQ(back.domain, sliced.domain);
  for (const auto& [a, b] :
       {std::pair{&back.crossing_values, &sliced.crossing_values}, {&back.sample_values, &sliced.sample_values}}) {
    std::vector<std::uint32_t> bits;
    for (const float v : *a) bits.push_back(std::bit_cast<std::uint32_t>(v));
    EXPECT_EQ(bits, bits_of(*b));
  }
  if (!sliced.guide) return;
  EXPECT_EQ(bits_of(back.guide->values), bits_of(sliced.guide->values));
}

void expect_within(const SlicedBrdf& back, const SlicedBrdf& sliced, double bound) {
  expect_all_but_values(back, sliced);
  for (const auto& [a, b] : {std::pair{&back.crossing_values, &sliced.crossing_values},
                             {&back.sample_values, &sliced.sample_values},
                             {&back.domain.reference, &sliced.domain.reference}}) {
    ASSERT_EQ(a->size(), b->size());
    for (std::size_t k = 0; k < a->size(); ++k) {
      const double before = (*b)[k];
      const double after = (*a)[k];
      ASSERT_LE(std::abs(after - before), bound * std::abs(before)) << before << " within " << bound;
      ASSERT_FALSE(before == 0 && std::signbit((*a)[k]));
    }
  }
  if (!sliced.guide) return;
  ASSERT_EQ(back.guide->values.size(), sliced.guide->values.size());
  for (std::size_t k = 0; k < back.guide->values.size(); ++k) {
    // Less than a step of the samples.
    EXPECT_NEAR(back.guide->values[k], sliced.guide->values[k], bound + 1e-6);
  }
}

/// A file in parts that can be changed one by one; sizes and checksums follow.
struct Parts {
  SlicedIndex index;
  std::vector<Bytes> payloads;
};
Parts take_apart(const Bytes& file) {
  const MemorySource source(file);
  const ContainerHead head = read_head(source).value();
  Parts parts = {parse_index(head.index, false).value(), {}};
  std::uint64_t offset = head.chunks_offset();
  for (const std::uint32_t size : parts.index.chunk_sizes) {
    parts.payloads.push_back(size == 0 ? Bytes() : read_chunk(source, offset, size).value());
    offset += size;
  }
  return parts;
}
Bytes put_together(Parts parts) {
  Bytes chunks;
  for (std::size_t k = 0; k < parts.payloads.size(); ++k) {
    const std::size_t before = chunks.size();
    append_chunk(chunks, parts.payloads[k]);
    parts.index.chunk_sizes[k] = static_cast<std::uint32_t>(chunks.size() - before);
  }
  return emit_container(emit_index(parts.index), chunks);
}

Example refused_example() { return random_example(small_elevation(), DomainKind::kLog, 2, 0.15, ordinary_value); }
Bytes valid_file(const EncodeOptions& options) {
  const Example example = refused_example();
  return encode_sliced(example.sliced, example.lattice, options);
}

void expect_refused(std::span<const std::byte> file, const std::string& clause) {
  const auto result = decode_exactly(file);
  ASSERT_FALSE(result) << clause;
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidFile) << result.error().message;
  EXPECT_THAT(result.error().message, StartsWith("[" + clause));
}

TEST(LosslessFile, GivesBackEveryBit) {
  for (const Example& example : all_kinds(any_value)) {
    for (const ChunkSize chunks : {ChunkSize::kWhole, ChunkSize::kSplit}) {
      const DecodedSliced decoded = through_a_file(example, {0, chunks});
      expect_every_bit(decoded.sliced, example.sliced);
      EXPECT_EQ(decoded.precision, 0);
      EXPECT_EQ(decoded.lattice.crossings, example.lattice.crossings);
    }
  }
}

TEST(LosslessFile, GivesBackExtremeFloatsAndNamesWithTheirBits) {
  Example example = random_example(small_elevation(), DomainKind::kLinear, 2, 0.3, ordinary_value);
  example.sliced.channels = {"", "wavelength 550 nm, \xc2\xb1 5"};
  const float most = std::numeric_limits<float>::max();
  const std::vector<float> extremes = {std::numeric_limits<float>::denorm_min(), -most, most, kDenormal, 1e12F, -0.0F};
  std::copy(extremes.begin(), extremes.end(), example.sliced.crossing_values.begin());
  std::copy(extremes.begin(), extremes.end(), example.sliced.sample_values.end() - 6);
  expect_every_bit(through_a_file(example, kLossless).sliced, example.sliced);
}

TEST(SlicedFile, MayHaveNoSampleBesideTheCrossings) {
  for (const FrameSpec& frame : {small_elevation(), small_half_difference({.isotropic = true})}) {
    for (const ChunkSize chunks : {ChunkSize::kWhole, ChunkSize::kSplit}) {
      const Example example = random_example(frame, DomainKind::kLinear, 3, 0, ordinary_value);
      ASSERT_EQ(example.sliced.adaptive_count(), 0U);
      expect_every_bit(through_a_file(example, {0, chunks}).sliced, example.sliced);
      expect_within(through_a_file(example, {0.01, chunks}).sliced, example.sliced, 0.01);
    }
  }
}

TEST(SlicedFile, HoldsSamplesOfAllLevels) {
  for (const FrameSpec& frame : {small_elevation(), small_half_difference()}) {
    Example example = random_example(frame, DomainKind::kLinear, 1, 0, ordinary_value);
    SlicedBrdf& sliced = example.sliced;
    Random random(3);
    // Towards either end of the first and the last interval of every slice.
    for (std::size_t k = 0; k < example.lattice.slices.size(); ++k) {
      const std::uint32_t last = example.lattice.slices[k].interval_count() - 1;
      const std::size_t before = sliced.positions.size();
      for (unsigned bit = 0; bit < 16; ++bit) sliced.positions.push_back({0, 1U << bit});
      const std::uint32_t there = last == 0 ? 0 : last;
      for (unsigned bit = 16; bit-- > 0;) {
        if (there != 0 || bit != 15) sliced.positions.push_back({there, SamplePosition::kOne - (1U << bit)});
      }
      sliced.sample_counts[k] = static_cast<std::uint32_t>(sliced.positions.size() - before);
    }
    sliced.sample_values.resize(sliced.positions.size());
    std::generate(sliced.sample_values.begin(), sliced.sample_values.end(), [&] { return ordinary_value(random); });
    for (const ChunkSize chunks : {ChunkSize::kWhole, ChunkSize::kSplit}) {
      expect_every_bit(through_a_file(example, {0, chunks}).sliced, sliced);
      expect_within(through_a_file(example, {0.001, chunks}).sliced, sliced, 0.001);
    }
  }
}

TEST(BoundedFile, KeepsItsBoundForEverySampleAndZerosAsTheyAre) {
  for (const Example& example : all_kinds(ordinary_value)) {
    for (const double bound : {1e-5, 0.001, 0.01, 0.5}) {
      for (const ChunkSize chunks : {ChunkSize::kWhole, ChunkSize::kSplit}) {
        const DecodedSliced decoded = through_a_file(example, {bound, chunks});
        EXPECT_EQ(decoded.precision, bound);
        expect_within(decoded.sliced, example.sliced, bound);
      }
    }
  }
}

TEST(BoundedFile, HoldsFortyOrdersOfMagnitude) {
  const auto vast = [](Random& random) { return from_exponents(random, -30, 12); };
  for (const std::size_t channels : {1U, 3U}) {
    const Example example = random_example(small_elevation(), DomainKind::kLog, channels, 0.4, vast);
    for (const double bound : {1e-6, 0.001, 0.5}) {
      const DecodedSliced decoded = through_a_file(example, {bound});
      EXPECT_EQ(decoded.precision, bound);
      expect_within(decoded.sliced, example.sliced, bound);
    }
    expect_every_bit(through_a_file(example, kLossless).sliced, example.sliced);
  }
}

/// Among values of a few hundred of the least that there is are some with no step near enough.
Example tiny_example() {
  Example example = refused_example();
  for (std::size_t k = 0; k < example.sliced.sample_values.size(); ++k) {
    example.sliced.sample_values[k] = static_cast<float>(600 + k) * std::numeric_limits<float>::denorm_min();
  }
  return example;
}

TEST(BoundedFile, IsLosslessWhereValuesAreTooSmallForItsBound) {
  const Example tiny = tiny_example();
  const DecodedSliced decoded = through_a_file(tiny, kTenthPercent);
  EXPECT_EQ(decoded.precision, 0);
  expect_every_bit(decoded.sliced, tiny.sliced);
}

TEST(BoundedFile, KeepsItsBoundOrIsLosslessBelowTheNormalFloats) {
  Example example = refused_example();
  for (const float units : {1.0F, 3.0F, 37.0F, 500.0F, 1001.0F, 1e5F, 8388607.0F, 8388608.0F}) {
    example.sliced.sample_values.back() = units * std::numeric_limits<float>::denorm_min();
    for (const double bound : {1e-5, 0.001, 0.01, 0.5}) {
      const DecodedSliced decoded = through_a_file(example, {bound});
      EXPECT_TRUE(decoded.precision == 0 || decoded.precision == bound);
      expect_within(decoded.sliced, example.sliced, decoded.precision);
      if (units == 8388608.0F) {  // 2^-126
        EXPECT_EQ(decoded.precision, bound);
      }
      const Bytes file = encode_sliced(example.sliced, example.lattice, {bound});
      EXPECT_EQ(encode_sliced(decoded.sliced, decoded.lattice, {bound}), file) << units << ", " << bound;
    }
  }
}

TEST(BoundedFile, KeepsItsBoundForTheLargestValues) {
  Example example = refused_example();
  for (const float large : {1e38F, std::numeric_limits<float>::max(), -std::numeric_limits<float>::max()}) {
    example.sliced.crossing_values[1] = large;
    for (const double bound : {1e-6, 0.001, 0.01, 0.1, 0.5}) {
      const DecodedSliced decoded = through_a_file(example, {bound});
      EXPECT_LE(decoded.precision, bound);
      expect_within(decoded.sliced, example.sliced, bound);
    }
  }
}

TEST(SlicedFile, HoldsAConstantMaterialInNextToNothing) {
  for (const float value : {0.0F, 0.318F, -2.0F}) {
    const Example example = random_example(elevation_frame(20, 60, {}).value(), DomainKind::kLinear, 40, 0.3,
                                           [&](Random&) { return value; });
    ASSERT_GT(example.sliced.sample_count() * 40, 65'536U);  // more values than any small file may have
    for (const double precision : {0.0, 0.001}) {
      const DecodedSliced decoded = through_a_file(example, {precision});
      expect_within(decoded.sliced, example.sliced, precision);
      EXPECT_LT(encode_sliced(example.sliced, example.lattice, {precision}).size(), 2500U);
    }
  }
}

TEST(EncodeSliced, GivesTheSameBytesAgainAndFromWhatItsFileGivesBack) {
  for (const Example& example : all_kinds(ordinary_value)) {
    for (const double precision : {0.0, 0.001, 0.1}) {
      for (const ChunkSize chunks : {ChunkSize::kWhole, ChunkSize::kSplit}) {
        const Bytes file = encode_sliced(example.sliced, example.lattice, {precision, chunks});
        EXPECT_EQ(encode_sliced(example.sliced, example.lattice, {precision, chunks}), file);
        const Result<DecodedSliced> decoded = decode_sliced(file);
        ASSERT_TRUE(decoded);
        EXPECT_EQ(encode_sliced(decoded->sliced, decoded->lattice, {precision, chunks}), file);
      }
    }
  }
}

/// Takes away the deepest samples, which no other sample needs, until `count` are left.
void thin_out(Example& example, std::size_t count) {
  SlicedBrdf& sliced = example.sliced;
  std::vector<std::size_t> deepest_first(sliced.positions.size());
  std::iota(deepest_first.begin(), deepest_first.end(), std::size_t{0});
  std::stable_sort(deepest_first.begin(), deepest_first.end(), [&](std::size_t a, std::size_t b) {
    return std::countr_zero(sliced.positions[a].fraction) < std::countr_zero(sliced.positions[b].fraction);
  });
  std::vector<bool> gone(sliced.positions.size(), false);
  for (std::size_t k = 0; k + count < sliced.sample_count(); ++k) gone[deepest_first[k]] = true;
  SlicedBrdf left = sliced;
  left.positions.clear();
  std::size_t next = 0;
  for (std::uint32_t& slice_count : left.sample_counts) {
    const std::size_t end = next + slice_count;
    for (slice_count = 0; next < end; ++next) {
      if (gone[next]) continue;
      left.positions.push_back(sliced.positions[next]);
      ++slice_count;
    }
  }
  left.sample_values.resize(left.positions.size() * sliced.channel_count());
  sliced = std::move(left);
}

TEST(EncodeSliced, SplitsByItselfFromAsManySamplesAsTheHeaderSays) {
  const Example dense =
      random_example(elevation_frame(20, 60, {}).value(), DomainKind::kLinear, 1, 0.98, [](Random&) { return 1.0F; });
  ASSERT_GT(dense.sliced.sample_count(), kSplitFrom);
  for (const bool many : {false, true}) {
    Example example = dense;
    thin_out(example, many ? kSplitFrom : kSplitFrom - 1);
    ASSERT_EQ(example.sliced.sample_count(), many ? kSplitFrom : kSplitFrom - 1);
    ASSERT_TRUE(check_sliced(example.sliced, example.lattice));
    const Bytes file = encode_sliced(example.sliced, example.lattice, kTenthPercent);
    const auto as = [&](ChunkSize chunks) { return encode_sliced(example.sliced, example.lattice, {0.001, chunks}); };
    EXPECT_EQ(file, as(many ? ChunkSize::kSplit : ChunkSize::kWhole));
    EXPECT_NE(file, as(many ? ChunkSize::kWhole : ChunkSize::kSplit));
  }
}

TEST(RoundToPrecision, GivesWhatAFileGivesBack) {
  for (const Example& example : all_kinds(ordinary_value)) {
    for (const double precision : {0.0, 0.001, 0.3}) {
      SlicedBrdf rounded = example.sliced;
      round_to_precision(rounded, precision);
      const SlicedBrdf back = through_a_file(example, {precision}).sliced;
      expect_every_bit(back, rounded);
      EXPECT_EQ(back.guide, rounded.guide);
    }
  }
  const Example tiny = tiny_example();
  SlicedBrdf rounded = tiny.sliced;
  round_to_precision(rounded, kTenthPercent.precision);
  expect_every_bit(rounded, tiny.sliced);
}

SampledBrdf smooth_example() {
  return sample_function(
      elevation_frame(20, 60, {}).value(), 1000, DomainKind::kLog,
      [](const DirectionPair& pair, std::size_t c) {
        return analytic_brdf(pair, {}) * (1 + 0.1 * static_cast<double>(c) * pair.i.theta * pair.v.theta);
      },
      3);
}

TEST(SlicedFile, GetsSmallerWithLessPrecision) {
  const SampledBrdf smooth = smooth_example();
  std::size_t last = std::numeric_limits<std::size_t>::max();
  for (const double precision : {0.0, 1e-6, 1e-5, 1e-4, 0.001, 0.01, 0.1, 0.5}) {
    const std::size_t size = encode_sliced(smooth.sliced, smooth.lattice, {precision}).size();
    EXPECT_LT(size, last) << precision;
    last = size;
  }
}

TEST(SlicedFile, IsMuchSmallerThanItsFloatsWhereValuesAreSmooth) {
  const SampledBrdf smooth = smooth_example();
  const double floats = 12.0 * static_cast<double>(smooth.sliced.sample_count());
  EXPECT_LT(static_cast<double>(encode_sliced(smooth.sliced, smooth.lattice, kLossless).size()), 0.75 * floats);
  EXPECT_LT(static_cast<double>(encode_sliced(smooth.sliced, smooth.lattice, kTenthPercent).size()), 0.3 * floats);
}

TEST(CodingCost, CountsTheStreamsOfTheFileAndIsCloseToTheirEntropy) {
  const SampledBrdf smooth = smooth_example();
  for (const ChunkSize chunks : {ChunkSize::kWhole, ChunkSize::kSplit}) {
    for (const double precision : {0.0, 0.001, 0.01}) {
      const CodingCost cost = coding_cost(smooth.sliced, smooth.lattice, {precision, chunks});
      std::uint64_t bytes = 0;
      std::uint64_t count = 0;
      const Parts parts = take_apart(encode_sliced(smooth.sliced, smooth.lattice, {precision, chunks}));
      for (std::size_t k = 0; k < parts.payloads.size(); ++k) {
        bytes += parts.payloads[k].size();
        count += parts.payloads[k].empty() ? 0 : 1;
      }
      EXPECT_EQ(cost.stream_bytes, bytes);
      EXPECT_GT(static_cast<double>(bytes), cost.entropy_bytes);
      EXPECT_LT(static_cast<double>(bytes), 1.1 * cost.entropy_bytes + 6.0 * static_cast<double>(count));
    }
  }
}

TEST(SlicedFile, HoldsMetadataOfAnySizeAndBytes) {
  Random random(5);
  std::string large(1U << 20U, ' ');
  for (char& c : large) c = static_cast<char>(random());
  std::string all_bytes;
  for (int c = 0; c < 256; ++c) all_bytes.push_back(static_cast<char>(c));
  for (const std::string& metadata : {std::string(), std::string("{}"), std::string(1, '\0'), all_bytes,
                                      std::string("\xff\xfe\x80 no UTF-8"), std::string(1U << 20U, 'x'), large}) {
    Example example = refused_example();
    example.sliced.metadata = metadata;
    EXPECT_EQ(through_a_file(example, kLossless).sliced.metadata, metadata);
    EXPECT_EQ(through_a_file(example, {0.01, ChunkSize::kSplit}).sliced.metadata, metadata);
  }
}

TEST(SlicedFile, HasOneChunkAndNoByteOfMetadataWhereNoneAreAskedFor) {
  Example example = refused_example();
  example.sliced.metadata.clear();
  const Parts whole = take_apart(encode_sliced(example.sliced, example.lattice, kLossless));
  EXPECT_EQ(whole.payloads.size(), 1U);
  EXPECT_TRUE(whole.index.metadata.empty());
  const Parts split = take_apart(encode_sliced(example.sliced, example.lattice, {0, ChunkSize::kSplit}));
  EXPECT_EQ(split.index.chunk_sizes[ChunkOrder::kGuide], 0U);
}

// What is said in few bytes on most axes must be said somehow on all.
TEST(SlicedFile, GivesBackNodesOfAnyForm) {
  const std::vector<std::vector<double>> lists = {
      {0},           {0, 80},           {0, 10, 20, 30},           {0, 5.5, 80},        {0, 46.65625, 64},
      {0, 0.01, 75}, {0, 33.33, 66.66}, {0, 100.0 / 3, 200.0 / 3}, {0, 0x1p-20 + 1, 2}, {0, 12.3, 80}};
  for (const std::vector<double>& theta_h : lists) {
    for (const std::vector<double>& theta_d : lists) {
      const Example example =
          random_example(half_difference_frame(theta_h, theta_d, {0, 180.0 / 7, 359}, {0, 60, 120}, {}),
                         DomainKind::kLinear, 1, 0, ordinary_value);
      ASSERT_EQ(through_a_file(example, kLossless).sliced.frame, example.sliced.frame);
    }
  }
}

TEST(SlicedFile, TakesFewBytesBesideItsSamples) {
  Example example = random_example(elevation_frame(20, 60, {.isotropic = true}).value(), DomainKind::kLog, 3, 0.2,
                                   [](Random& random) { return from_exponents(random, -1, 0); });
  example.sliced.channels = {"R", "G", "B"};
  example.sliced.metadata.clear();
  const Bytes file = encode_sliced(example.sliced, example.lattice, {0.02});
  const CodingCost cost = coding_cost(example.sliced, example.lattice, {0.02});
  EXPECT_LT(file.size() - cost.stream_bytes, 100U);
}

TEST(SlicedFile, HasAGuideWhoseLevelsCancelOut) {
  Example example = random_example(small_half_difference(), DomainKind::kLog, 2, 0.3, any_value);
  add_guide(example, 1, 0.5);
  for (float& v : example.sliced.guide->values) v *= 1e30F;  // far beyond what any step is
  expect_every_bit(through_a_file(example, kLossless).sliced, example.sliced);
  example = random_example(small_half_difference(), DomainKind::kLog, 2, 0.3, ordinary_value);
  add_guide(example, 1, 0.5);
  for (float& v : example.sliced.guide->values) v *= 1000;
  expect_within(through_a_file(example, kTenthPercent).sliced, example.sliced, 0.001);
}

// -(2^31) is no step; less the guide's, this one value would be it.
TEST(SlicedFile, HoldsTheValueThatTheGuideTakesToTheEndOfTheLevels) {
  Example example =
      random_example(small_half_difference(), DomainKind::kLog, 1, 0.3, [](Random&) { return -0x1.5p127F; });
  add_guide(example, 1, 0);
  std::fill(example.sliced.guide->values.begin(), example.sliced.guide->values.end(), 1.0F);
  const auto guide_steps = static_cast<std::uint32_t>(std::floor(8388608 * 1.4426950408889634 + 0.5));
  const float value = -std::bit_cast<float>(0x80000000U - guide_steps);
  ASSERT_TRUE(std::isfinite(value));
  example.sliced.crossing_values[0] = value;
  expect_every_bit(through_a_file(example, kLossless).sliced, example.sliced);
}

TEST(CheckSliced, RefusesPositionsThatAreNotHalvings) {
  Example example = random_example(small_elevation(), DomainKind::kLinear, 1, 0, ordinary_value);
  const auto check = [&](std::vector<SamplePosition> places) {
    SlicedBrdf sliced = example.sliced;
    sliced.sample_counts[0] = static_cast<std::uint32_t>(places.size());
    sliced.sample_values.assign(places.size(), 1.0F);
    sliced.positions = std::move(places);
    return check_sliced(sliced, example.lattice).ok();
  };
  EXPECT_TRUE(check({{0, 0x8000}}));
  EXPECT_TRUE(check({{0, 0x4000}, {0, 0x8000}}));
  EXPECT_TRUE(check({{0, 0x8000}, {0, 0xC000}}));
  EXPECT_TRUE(check({{0, 0x4000}, {0, 0x6000}, {0, 0x8000}}));
  EXPECT_FALSE(check({{0, 0x4000}}));
  EXPECT_FALSE(check({{0, 0xC000}}));
  EXPECT_FALSE(check({{0, 1}}));
  EXPECT_FALSE(check({{0, 0x5555}, {0, 0x8000}}));
  EXPECT_FALSE(check({{0, 0x6000}, {0, 0x8000}}));
  EXPECT_FALSE(check({{0, 0x8000}, {1, 0x4000}}));
  EXPECT_FALSE(check({{0, 0x8000}, {0, 0x8000}}));
  EXPECT_FALSE(check({{0, 0x8000}, {0, 0x4000}}));
  EXPECT_FALSE(check({{0, 0}}));
  EXPECT_FALSE(check({{0, 0x10000}}));
  EXPECT_FALSE(check({{example.lattice.slices[0].interval_count(), 0x8000}}));
}

TEST(CheckSliced, RefusesGuidesWhosePositionsAreNotHalvingsOrMissANode) {
  Example example = random_example(small_half_difference(), DomainKind::kLog, 1, 0, ordinary_value);
  const auto check = [&](std::vector<SamplePosition> places) {
    SlicedBrdf sliced = example.sliced;
    sliced.guide.emplace();
    sliced.guide->values.assign(places.size(), 1.0F);
    sliced.guide->places = std::move(places);
    return check_sliced(sliced, example.lattice).ok();
  };
  EXPECT_TRUE(check({{0, 0}, {1, 0}, {2, 0}}));
  EXPECT_TRUE(check({{0, 0}, {0, 0x8000}, {1, 0}, {1, 0x8000}, {1, 0xC000}, {2, 0}}));
  EXPECT_FALSE(check({{0, 0}, {1, 0}}));
  EXPECT_FALSE(check({{0, 0}, {0, 0x4000}, {1, 0}, {2, 0}}));
  EXPECT_FALSE(check({{0, 0}, {1, 0}, {2, 0}, {2, 0x8000}}));
  EXPECT_FALSE(check({{0, 0}, {0, 0x8000}, {2, 0}}));
}

TEST(CheckSliced, RefusesALinearDomainWithReferences) {
  Example example = random_example(small_elevation(), DomainKind::kLinear, 1, 0.2, ordinary_value);
  ASSERT_TRUE(check_sliced(example.sliced, example.lattice));
  example.sliced.domain.reference = {1.0F};
  EXPECT_FALSE(check_sliced(example.sliced, example.lattice));
}

TEST(DecodeSliced, RefusesEveryTruncatedPrefixAndTrailingByte) {
  for (const EncodeOptions& options : {kLossless, kTenthPercent, EncodeOptions{0.001, ChunkSize::kSplit}}) {
    Bytes file = valid_file(options);
    ASSERT_TRUE(decode_exactly(file));
    for (std::size_t size = 0; size < file.size(); ++size) {
      const std::size_t head = read_head(MemorySource(file)).value().chunks_offset();
      expect_refused(std::span(file).first(size), size < 4 ? "SB-1-1]" : size < head ? "SB-1-4]" : "SB-3-2]");
    }
    file.push_back(std::byte{0});
    expect_refused(file, "SB-3-2]");
  }
}

TEST(DecodeSliced, RefusesEverySingleFlippedBit) {
  for (const EncodeOptions& options : {kLossless, kTenthPercent}) {
    Bytes file = valid_file(options);
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
      const auto mask = static_cast<std::byte>(1U << (bit % 8));
      file[bit / 8] ^= mask;
      const auto result = decode_exactly(file);
      ASSERT_FALSE(result) << "byte " << bit / 8 << ", bit " << bit % 8;
      ASSERT_THAT(result.error().message, StartsWith("[SB-1-"));
      file[bit / 8] ^= mask;
    }
  }
}

TEST(DecodeSliced, RefusesAFlippedBitOfTheGuide) {
  Example example =
      random_example(small_half_difference({.isotropic = true}), DomainKind::kLog, 2, 0.2, ordinary_value);
  add_guide(example, 1, 0.5);
  Bytes file = encode_sliced(example.sliced, example.lattice, kTenthPercent);
  ASSERT_TRUE(decode_exactly(file));
  for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
    const auto mask = static_cast<std::byte>(1U << (bit % 8));
    file[bit / 8] ^= mask;
    ASSERT_FALSE(decode_exactly(file)) << "byte " << bit / 8 << ", bit " << bit % 8;
    file[bit / 8] ^= mask;
  }
}

TEST(DecodeSliced, TakesANewerMinorVersionWithMoreInItsIndexAndBehindItsChunks) {
  const Example example = refused_example();
  const Bytes file = encode_sliced(example.sliced, example.lattice, kLossless);
  const ContainerHead head = read_head(MemorySource(file)).value();
  const Bytes chunks(file.begin() + static_cast<std::ptrdiff_t>(head.chunks_offset()), file.end());
  Bytes more_index = head.index;
  more_index.insert(more_index.end(), 5, std::byte{0xA5});
  Bytes more_chunks = chunks;
  more_chunks.insert(more_chunks.end(), 77, std::byte{0x5A});
  for (const Bytes* index : {&head.index, static_cast<const Bytes*>(&more_index)}) {
    for (const Bytes* behind : {&chunks, static_cast<const Bytes*>(&more_chunks)}) {
      const auto newer = decode_exactly(emit_container(*index, *behind, 1, 7));
      ASSERT_TRUE(newer) << newer.error().message;
      EXPECT_EQ(newer->version, "1.7");
      expect_every_bit(newer->sliced, example.sliced);
    }
  }
  expect_refused(emit_container(more_index, chunks), "SB-2-1]");
  expect_refused(emit_container(head.index, more_chunks), "SB-3-2]");
  const Bytes fewer_chunks(file.begin() + static_cast<std::ptrdiff_t>(head.chunks_offset()), file.end() - 1);
  expect_refused(emit_container(head.index, fewer_chunks, 1, 7), "SB-3-2]");
  for (const int major : {0, 2}) {
    const auto other = decode_exactly(emit_container(head.index, chunks, static_cast<std::uint8_t>(major), 0));
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(other.error().message, StartsWith("[SB-1-3]"));
  }
}

TEST(DecodeSliced, RefusesEveryChunkThatIsShorterLongerOrMissing) {
  Example example = random_example(small_half_difference(), DomainKind::kLog, 2, 0.2, ordinary_value);
  add_guide(example, 1, 0.5);
  const Parts parts = take_apart(encode_sliced(example.sliced, example.lattice, kTenthPercent));
  for (std::size_t k = 0; k < parts.payloads.size(); ++k) {
    if (parts.payloads[k].empty()) continue;
    const auto refuses = [&](std::size_t size, const Bytes& more) {
      Parts changed = parts;
      changed.payloads[k].resize(size);
      changed.payloads[k].insert(changed.payloads[k].end(), more.begin(), more.end());
      return !decode_exactly(put_together(changed));
    };
    const std::size_t size = parts.payloads[k].size();
    EXPECT_TRUE(refuses(0, {})) << "without chunk " << k;
    for (std::size_t less = 1; less < std::min<std::size_t>(size, 40); ++less) {
      EXPECT_TRUE(refuses(size - less, {})) << "chunk " << k << ", " << less << " bytes less";
    }
    for (std::size_t more = 1; more <= 8; ++more) {
      EXPECT_TRUE(refuses(size, Bytes(more))) << "chunk " << k << ", " << more << " bytes more";
    }
  }
}

TEST(DecodeSliced, RefusesAGuideThatTheIndexDoesNotName) {
  const Example example = refused_example();
  Parts changed = take_apart(encode_sliced(example.sliced, example.lattice, {0, ChunkSize::kSplit}));
  changed.payloads[ChunkOrder::kGuide] = Bytes(20);
  Bytes file = put_together(changed);
  expect_refused(file, "SB-8-2]");
  // Every byte of a file is under a checksum.
  file[read_head(MemorySource(file)).value().chunks_offset()] ^= std::byte{1};
  EXPECT_FALSE(decode_exactly(file));
}

TEST(DecodeSliced, RefusesMetadataThatDoNotUnpackToTheirSize) {
  const Parts parts = take_apart(valid_file(kLossless));
  for (const int change : {-1, 1}) {
    Parts changed = parts;
    changed.index.metadata_size = static_cast<std::uint32_t>(static_cast<int>(parts.index.metadata_size) + change);
    expect_refused(put_together(changed), "SB-8-5]");
    changed = parts;
    changed.index.metadata.resize(static_cast<std::size_t>(static_cast<int>(parts.index.metadata.size()) + change));
    expect_refused(put_together(changed), "SB-8-5]");
  }
}

TEST(DecodeSliced, SurvivesRandomDamageBelowTheChecksums) {
  Random random(1);
  for (const EncodeOptions& options : {kLossless, EncodeOptions{0.01, ChunkSize::kSplit}}) {
    Example example = random_example(small_half_difference(), DomainKind::kLog, 2, 0.1, ordinary_value);
    add_guide(example, 1, 0.5);
    const Bytes file = encode_sliced(example.sliced, example.lattice, options);
    const Parts parts = take_apart(file);
    const ContainerHead head = read_head(MemorySource(file)).value();
    const Bytes& index = head.index;
    const Bytes chunks(file.begin() + static_cast<std::ptrdiff_t>(head.chunks_offset()), file.end());
    int survived = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      Bytes damaged;
      if (trial % 2 == 0) {
        Bytes changed = index;
        changed[random() % changed.size()] = static_cast<std::byte>(random());
        damaged = emit_container(changed, chunks);
      } else {
        Parts changed = parts;
        Bytes& payload = changed.payloads[random() % changed.payloads.size()];
        if (payload.empty()) continue;
        payload[random() % payload.size()] = static_cast<std::byte>(random());
        damaged = put_together(changed);
      }
      const auto decoded = decode_exactly(damaged);
      if (!decoded) {
        EXPECT_THAT(decoded.error().message, StartsWith("[SB-"));
        continue;
      }
      ++survived;
      EXPECT_TRUE(check_sliced(decoded->sliced, decoded->lattice));
    }
    EXPECT_LT(survived, 500);
  }
}

TEST(DecodeSliced, GivesBackOnlyWhatMayBeWritten) {
  for (const Example& example : all_kinds(ordinary_value)) {
    const DecodedSliced decoded = through_a_file(example, {0.01, ChunkSize::kSplit});
    EXPECT_TRUE(check_frame(decoded.sliced.frame));
    EXPECT_TRUE(check_sliced(decoded.sliced, build_lattice(decoded.sliced.frame).value()));
  }
}

}  // namespace
}  // namespace sbrdf::internal
