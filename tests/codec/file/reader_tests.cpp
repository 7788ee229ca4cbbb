#include "codec/file/reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

using testing::StartsWith;

using Bytes = std::vector<std::byte>;
using Random = std::mt19937_64;

/// A file and what is in it, read in one go.
struct FileExample {
  std::string name;
  Bytes file;
  DecodedSliced whole;
};

SampledBrdf sampled(const FrameSpec& frame, std::uint64_t extra, DomainKind domain, std::size_t channels,
                    std::optional<double> guide_ratio = {}) {
  SampledBrdf made;
  made.lattice = build_lattice(frame).value();
  SamplingOptions options;
  options.sample_count = made.lattice.crossings.size() + extra;
  options.domain = domain;
  options.minimum_gap_deg = 0.1;
  options.guide_ratio = guide_ratio;
  if (guide_ratio) options.refinement = Refinement::kBySource;
  const TestFunction function = [&frame](const DirectionPair& pair, std::size_t c) {
    const auto [ix, iy, iz, vx, vy, vz] = vectors_of(pair);
    const double half = (iz + vz) / std::sqrt((ix + vx) * (ix + vx) + (iy + vy) * (iy + vy) + (iz + vz) * (iz + vz));
    return analytic_brdf(pair, frame.symmetries) + static_cast<double>(c + 1) * std::exp(40 * (half - 1));
  };
  made.sliced = sample_slices(made.lattice, channel_names(channels), measure_of(function, channels), options).value();
  made.sliced.metadata = R"({"source": {"format": "a test"}})";
  return made;
}

FileExample example_of(std::string name, const SampledBrdf& sampled, const EncodeOptions& options) {
  FileExample made = {std::move(name), encode_sliced(sampled.sliced, sampled.lattice, options), {}};
  made.whole = decode_sliced(made.file).value();
  return made;
}

/// Both frames, with and without symmetries and guides, in small chunks and in few.
const std::vector<FileExample>& file_examples() {
  static const std::vector<FileExample> kExamples = [] {
    const Symmetries mirrored = {.isotropic = true, .mirror_x = true};
    const SampledBrdf elevation = sampled(elevation_frame(20, 60, {}).value(), 1500, DomainKind::kLog, 3);
    const SampledBrdf isotropic = sampled(elevation_frame(10, 30, mirrored).value(), 900, DomainKind::kLinear, 1);
    const SampledBrdf half_difference =
        sampled(half_difference_frame({0, 5, 20, 80}, {0, 30, 80}, {0, 60, 120, 180, 240, 300}, {0, 60, 120}, {}), 800,
                DomainKind::kLog, 2);
    const SampledBrdf guided =
        sampled(half_difference_frame({0, 10, 30, 80}, {0, 40, 80}, {0}, {0, 45, 90, 135}, mirrored), 400,
                DomainKind::kLog, 3, 1);
    std::vector<FileExample> made;
    made.push_back(example_of("elevation", elevation, {0, ChunkSize::kSplit}));
    made.push_back(example_of("elevation, bounded", elevation, {0.001, ChunkSize::kSplit}));
    made.push_back(example_of("elevation, whole", elevation, {0.001, ChunkSize::kWhole}));
    made.push_back(example_of("isotropic", isotropic, {0.001, ChunkSize::kSplit}));
    made.push_back(example_of("half/difference", half_difference, {0.01, ChunkSize::kSplit}));
    made.push_back(example_of("half/difference, whole", half_difference, {0, ChunkSize::kWhole}));
    made.push_back(example_of("guide", guided, {0.001, ChunkSize::kSplit}));
    made.push_back(example_of("guide, lossless", guided, {0, ChunkSize::kSplit}));
    return made;
  }();
  return kExamples;
}

DirectionPair random_pair(Random& random) {
  std::uniform_real_distribution<double> theta(0, 1.45);
  std::uniform_real_distribution<double> phi(-7, 14);
  DirectionPair pair = {{theta(random), phi(random)}, {theta(random), phi(random)}};
  if (random() % 10 == 0) pair.i.theta = 0;
  if (random() % 10 == 0) pair.v = pair.i;
  return pair;
}

std::vector<std::uint32_t> bit_patterns(std::span<const float> values) {
  std::vector<std::uint32_t> bits;
  for (const float v : values) bits.push_back(std::bit_cast<std::uint32_t>(v));
  return bits;
}

std::vector<std::uint32_t> evaluated(const Evaluator& evaluator, const DirectionPair& pair) {
  std::vector<float> values(evaluator.channel_count());
  evaluator.evaluate(pair, values);
  return bit_patterns(values);
}

std::vector<std::uint32_t> evaluated(const PartialSliced& partial, const DirectionPair& pair) {
  std::vector<float> values(partial.sliced().channel_count());
  if (const Status status = partial.evaluate(pair, values); !status) ADD_FAILURE() << status.error().message;
  return bit_patterns(values);
}

/// Counts how often each byte is read.
class CountingSource {
 public:
  explicit CountingSource(const Bytes& file)
      : reads_(file.size(), 0), source_(file.size(), [this, &file](std::uint64_t offset, std::span<std::byte> target) {
          for (std::size_t k = 0; k < target.size(); ++k) ++reads_[offset + k];
          return MemorySource(file).read(offset, target);
        }) {}
  [[nodiscard]] const ByteSource& source() const { return source_; }
  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const unsigned reads : reads_) sum += reads;
    return sum;
  }
  [[nodiscard]] const std::vector<unsigned>& reads() const { return reads_; }
  void reset() { std::fill(reads_.begin(), reads_.end(), 0U); }

 private:
  std::vector<unsigned> reads_;
  CallbackSource source_;
};

TEST(SlicedReader, EvaluatesCellsByThemselvesAsTheWholeFileDoes) {
  Random random(1);
  for (const FileExample& example : file_examples()) {
    const Evaluator whole(example.whole.sliced, example.whole.lattice);
    const MemorySource source(example.file);
    const Result<SlicedReader> reader = SlicedReader::open(source);
    ASSERT_TRUE(reader) << example.name;
    for (int trial = 0; trial < 40; ++trial) {
      std::vector<DirectionPair> pairs;
      for (int k = 0; k <= trial % 4; ++k) pairs.push_back(random_pair(random));
      const Result<PartialSliced> partial = reader->load(cells_of(reader->lattice(), pairs));
      ASSERT_TRUE(partial) << example.name;
      for (const DirectionPair& pair : pairs) {
        EXPECT_TRUE(partial->covers(pair));
        ASSERT_EQ(evaluated(*partial, pair), evaluated(whole, pair)) << example.name;
        const DirectionPair exchanged = {pair.v, pair.i};
        ASSERT_EQ(evaluated(*partial, exchanged), evaluated(whole, exchanged)) << example.name;
      }
    }
  }
}

TEST(SlicedReader, EvaluatesAllOfOneCellAndRefusesWhatLiesOutside) {
  Random random(2);
  for (const FileExample& example : file_examples()) {
    const Evaluator whole(example.whole.sliced, example.whole.lattice);
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    std::vector<DirectionPair> pairs(400);
    for (DirectionPair& pair : pairs) pair = random_pair(random);
    CellSet cells(reader.lattice());
    for (std::size_t k = 0; k < 5; ++k) cells.add(cell_of(reader.lattice(), pairs[k]));
    const Result<PartialSliced> partial = reader.load(cells);
    ASSERT_TRUE(partial);
    int inside = 0;
    for (const DirectionPair& pair : pairs) {
      const bool expected = cells.contains(cell_of(reader.lattice(), pair));
      ASSERT_EQ(partial->covers(pair), expected);
      inside += expected ? 1 : 0;
      if (expected) {
        ASSERT_EQ(evaluated(*partial, pair), evaluated(whole, pair)) << example.name;
        continue;
      }
      std::vector<float> values(reader.index().channels.size(), 7.0F);
      const Status status = partial->evaluate(pair, values);
      ASSERT_FALSE(status);
      EXPECT_EQ(status.error().code, ErrorCode::kUsage);
      EXPECT_EQ(values, std::vector<float>(values.size(), 7.0F));
    }
    EXPECT_GT(inside, 4);
    EXPECT_LT(inside, 400);
  }
}

// Where the evaluator took another cell than cell_of, it would find samples missing.
TEST(SlicedReader, LoadsTheCellThatEvaluationUsesAtNodesBesideThemAndAtPoles) {
  Random random(8);
  for (const FileExample& example : file_examples()) {
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    const Lattice& lattice = example.whole.lattice;
    const Evaluator whole(example.whole.sliced, lattice);
    for (int k = 0; k < 80; ++k) {
      Coordinates x{};
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const std::vector<double>& nodes = lattice.nodes[axis];
        x[axis] = k % 8 < 2 && axis >= kHorizontal ? 0 : nodes[random() % nodes.size()];
        if (k % 4 == 1) x[axis] = std::nextafter(x[axis], random() % 2 == 0 ? 1e3 : -1e3);
      }
      const DirectionPair pair = directions_at(lattice.spec, x);
      const auto partial = reader.load(cells_of(lattice, std::array{pair}));
      ASSERT_TRUE(partial);
      ASSERT_EQ(evaluated(*partial, pair), evaluated(whole, pair)) << example.name << testing::PrintToString(x);
    }
  }
}

TEST(SlicedReader, EvaluatesToZeroBelowTheHorizonWhateverWasLoaded) {
  const double just_below = std::nextafter(kPi / 2, 2.0);
  for (const FileExample& example : file_examples()) {
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    const Lattice& lattice = example.whole.lattice;
    const Evaluator whole(example.whole.sliced, lattice);
    const DirectionPair at_horizon = {{0.3, 0.2}, {kPi / 2, 4}};
    const auto partial = reader.load(cells_of(lattice, std::array{at_horizon}));
    const auto nothing = reader.load(CellSet(lattice));
    ASSERT_TRUE(partial && nothing) << example.name;
    EXPECT_EQ(evaluated(*partial, at_horizon), evaluated(whole, at_horizon)) << example.name;
    std::vector<float> values(example.whole.sliced.channel_count());
    EXPECT_FALSE(nothing->evaluate(at_horizon, values)) << example.name;
    for (const double theta : {just_below, 1.7, kPi}) {
      for (const DirectionPair& pair : {DirectionPair{{theta, 1}, {0.5, 0}}, DirectionPair{{0.3, 0.2}, {theta, 4}}}) {
        for (const PartialSliced* part : {&*partial, &*nothing}) {
          values.assign(values.size(), 1);
          ASSERT_TRUE(part->evaluate(pair, values)) << example.name;
          EXPECT_THAT(values, testing::Each(0.0F)) << example.name;
        }
      }
    }
  }
}

TEST(SlicedReader, LoadsAllCellsAsTheWholeFile) {
  for (const FileExample& example : file_examples()) {
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    CellSet all(reader.lattice());
    all.add_all();
    const Result<PartialSliced> partial = reader.load(all);
    ASSERT_TRUE(partial);
    EXPECT_EQ(partial->sliced().crossing_values, example.whole.sliced.crossing_values);
    EXPECT_EQ(partial->sliced().sample_counts, example.whole.sliced.sample_counts);
    EXPECT_EQ(partial->sliced().positions, example.whole.sliced.positions);
    EXPECT_EQ(partial->sliced().sample_values, example.whole.sliced.sample_values);
    EXPECT_EQ(partial->sliced().guide, example.whole.sliced.guide);
  }
}

TEST(SlicedReader, GivesItsLatticeAwayAndWhatItLoadedStaysAsItIs) {
  for (const FileExample& example : file_examples()) {
    const MemorySource source(example.file);
    SlicedReader reader = SlicedReader::open(source).value();
    const Lattice expected = reader.lattice();
    const PartialSliced part = reader.load(cells_in(expected, {0, 90}, {0, 90})).value();
    const Lattice shared = std::move(reader).take_lattice();  // the part has it too: a copy
    EXPECT_TRUE(part.covers({{0.2, 0}, {0.3, 1}}));
    const Lattice alone = std::move(*SlicedReader::open(source)).take_lattice();
    for (const Lattice* taken : {&shared, &alone}) {
      EXPECT_EQ(taken->crossings, expected.crossings);
      EXPECT_EQ(taken->corners, expected.corners);
      EXPECT_EQ(taken->slices.size(), expected.slices.size());
    }
  }
}

TEST(SlicedReader, LoadsNoCellWhereNoneIsWanted) {
  const FileExample& example = file_examples().front();
  CountingSource counting(example.file);
  const SlicedReader reader = SlicedReader::open(counting.source()).value();
  counting.reset();
  const Result<PartialSliced> nothing = reader.load(CellSet(reader.lattice()));
  ASSERT_TRUE(nothing);
  EXPECT_EQ(counting.bytes(), 0U);
  EXPECT_FALSE(nothing->covers({{0.5, 1}, {0.7, 2}}));
}

TEST(SlicedReader, ReadsFewBytesForOneCellOfASplitFile) {
  Random random(3);
  for (const FileExample& example : file_examples()) {
    CountingSource counting(example.file);
    const SlicedReader reader = SlicedReader::open(counting.source()).value();
    const bool split = !reader.index().layout.whole;
    double sum = 0;
    constexpr int kTrials = 20;
    for (int trial = 0; trial < kTrials; ++trial) {
      counting.reset();
      const std::vector<DirectionPair> pair = {random_pair(random)};
      ASSERT_TRUE(reader.load(cells_of(reader.lattice(), pair)));
      EXPECT_LT(counting.bytes(), example.file.size()) << example.name;
      for (const unsigned reads : counting.reads()) ASSERT_LE(reads, 1U) << "a byte is read twice";
      sum += static_cast<double>(counting.bytes());
    }
    EXPECT_LT(sum / kTrials, (split ? 0.75 : 1.0) * static_cast<double>(example.file.size())) << example.name;
  }
}

TEST(SlicedReader, OpensWithHeaderAndIndexAlone) {
  for (const FileExample& example : file_examples()) {
    CountingSource counting(example.file);
    const Result<SlicedReader> reader = SlicedReader::open(counting.source());
    ASSERT_TRUE(reader);
    std::uint64_t chunks = 0;
    for (const std::uint32_t size : reader->index().chunk_sizes) chunks += size;
    const std::uint64_t head = example.file.size() - chunks;
    EXPECT_EQ(counting.bytes(), head);
    for (std::size_t k = 0; k < example.file.size(); ++k) EXPECT_EQ(counting.reads()[k], k < head ? 1U : 0U);
    EXPECT_EQ(reader->version(), "1.0");
    EXPECT_EQ(reader->index().channels, example.whole.sliced.channels);
    EXPECT_EQ(reader->index().adaptive_count, example.whole.sliced.adaptive_count());
    EXPECT_EQ(reader->index().value_ranges(), value_ranges(example.whole.sliced));
  }
}

TEST(SlicedReader, KnowsMetadataAsSoonAsItIsOpen) {
  const FileExample& example = file_examples().front();
  CountingSource counting(example.file);
  const SlicedReader reader = SlicedReader::open(counting.source()).value();
  counting.reset();
  const Result<std::string> metadata = reader.metadata();
  ASSERT_TRUE(metadata);
  EXPECT_EQ(*metadata, example.whole.sliced.metadata);
  EXPECT_EQ(counting.bytes(), 0U);
}

/// Crossings and those samples whose fraction has no more than `depth` binary digits.
SlicedBrdf down_to_depth(const SlicedBrdf& sliced, int depth) {
  SlicedBrdf kept = sliced;
  kept.positions.clear();
  kept.sample_values.clear();
  std::size_t next = 0;
  for (std::uint32_t& count : kept.sample_counts) {
    const std::size_t end = next + count;
    for (count = 0; next < end; ++next) {
      if (sliced.positions[next].fraction % (SamplePosition::kOne >> static_cast<unsigned>(depth)) != 0) continue;
      ++count;
      kept.positions.push_back(sliced.positions[next]);
      for (std::size_t c = 0; c < sliced.channel_count(); ++c) {
        kept.sample_values.push_back(sliced.sample_values[next * sliced.channel_count() + c]);
      }
    }
  }
  return kept;
}

TEST(SlicedReader, LoadsExactlyTheSamplesDownToADepth) {
  for (const FileExample& example : file_examples()) {
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    for (int depth = 0; depth <= kMaxDepth; ++depth) {
      const Result<SlicedBrdf> loaded = reader.load_all(depth);
      ASSERT_TRUE(loaded) << example.name << ", depth " << depth;
      const SlicedBrdf expected = down_to_depth(example.whole.sliced, depth);
      EXPECT_EQ(loaded->crossing_values, expected.crossing_values);
      EXPECT_EQ(loaded->sample_counts, expected.sample_counts);
      EXPECT_EQ(loaded->positions, expected.positions);
      EXPECT_EQ(loaded->sample_values, expected.sample_values);
      EXPECT_EQ(loaded->guide, expected.guide);
      EXPECT_EQ(loaded->metadata, expected.metadata);
      EXPECT_TRUE(check_sliced(*loaded, reader.lattice()));
      EXPECT_EQ(value_ranges(*loaded), value_ranges(example.whole.sliced));
    }
  }
}

TEST(SlicedReader, EvaluatesCellsDownToADepthAsAllCellsUpToIt) {
  Random random(4);
  for (const FileExample& example : file_examples()) {
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    for (const int depth : {0, 1, 2, 4}) {
      const Evaluator all(reader.load_all(depth).value(), reader.lattice());
      for (int trial = 0; trial < 8; ++trial) {
        const std::vector<DirectionPair> pairs = {random_pair(random), random_pair(random)};
        const Result<PartialSliced> partial = reader.load(cells_of(reader.lattice(), pairs), depth);
        ASSERT_TRUE(partial);
        for (const DirectionPair& pair : pairs) ASSERT_EQ(evaluated(*partial, pair), evaluated(all, pair));
      }
    }
  }
}

TEST(SlicedReader, KnowsHowManyBytesADepthTakes) {
  for (const FileExample& example : file_examples()) {
    CountingSource counting(example.file);
    for (int depth = 0; depth <= kMaxDepth; ++depth) {
      counting.reset();
      const SlicedReader reader = SlicedReader::open(counting.source()).value();
      ASSERT_TRUE(reader.load_all(depth));
      EXPECT_EQ(reader.bytes_up_to(depth), counting.bytes()) << example.name << ", depth " << depth;
      for (const unsigned reads : counting.reads()) ASSERT_LE(reads, 1U) << "a byte is read twice";
    }
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    EXPECT_EQ(reader.bytes_up_to(kMaxDepth), example.file.size());
    EXPECT_EQ(reader.bytes_up_to(0) < example.file.size(), !reader.index().layout.whole);
  }
}

TEST(SlicedReader, PassesOnTheErrorOfItsSourceWhicheverReadFails) {
  for (const std::size_t number : {std::size_t{1}, std::size_t{6}}) {
    const Bytes& file = file_examples()[number].file;
    int reads = 0;
    int failing = -1;
    const CallbackSource source(file.size(), [&](std::uint64_t offset, std::span<std::byte> target) -> Status {
      if (reads++ == failing) return Error{ErrorCode::kIo, "the cable is out", {}};
      return MemorySource(file).read(offset, target);
    });
    const auto expect_passed_on = [&](const auto& result) {
      ASSERT_FALSE(result.ok()) << "read " << failing;
      EXPECT_EQ(result.error().code, ErrorCode::kIo);
      EXPECT_EQ(result.error().message, "the cable is out");
    };
    const SlicedReader reader = SlicedReader::open(source).value();
    const int to_open = reads;
    ASSERT_TRUE(reader.load_all());
    const int to_load = reads - to_open;
    ASSERT_GT(to_load, 4);
    for (failing = 0; failing < to_open; ++failing) {
      reads = 0;
      expect_passed_on(SlicedReader::open(source));
    }
    CellSet all(reader.lattice());
    all.add_all();
    for (failing = 0; failing < to_load; ++failing) {
      reads = 0;
      expect_passed_on(reader.load_all());
      reads = 0;
      expect_passed_on(reader.load(all));
    }
  }
}

TEST(SlicedReader, RefusesADamagedChunkOnlyWhereItIsNeeded) {
  FileExample example = file_examples().front();
  example.file.back() ^= std::byte{1};
  const MemorySource source(example.file);
  const Result<SlicedReader> reader = SlicedReader::open(source);
  ASSERT_TRUE(reader);
  EXPECT_TRUE(reader->load_all(0));
  const Result<SlicedBrdf> all = reader->load_all();
  ASSERT_FALSE(all);
  EXPECT_EQ(all.error().code, ErrorCode::kInvalidFile);
  EXPECT_THAT(all.error().message, StartsWith("[SB-1-7]"));
}

TEST(SlicedReader, GivesTheSameFromManyThreads) {
  for (const std::size_t number : {std::size_t{1}, std::size_t{6}}) {
    const FileExample& example = file_examples()[number];
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    const Evaluator whole(example.whole.sliced, example.whole.lattice);
    const auto work = [&](std::uint64_t seed, int& wrong) {
      Random random(seed);
      for (int trial = 0; trial < 10; ++trial) {
        const std::vector<DirectionPair> pairs = {random_pair(random), random_pair(random)};
        const Result<PartialSliced> partial = reader.load(cells_of(reader.lattice(), pairs));
        for (const DirectionPair& pair : pairs) {
          std::vector<float> values(whole.channel_count());
          const bool same =
              partial.ok() && partial->evaluate(pair, values).ok() && bit_patterns(values) == evaluated(whole, pair);
          wrong += same ? 0 : 1;
        }
        const Result<SlicedBrdf> all = reader.load_all(trial % 3 == 0 ? kMaxDepth : trial % 3);
        const Result<std::string> metadata = reader.metadata();
        const bool same = all.ok() && metadata.ok() && *metadata == example.whole.sliced.metadata &&
                          (trial % 3 != 0 || all->sample_values == example.whole.sliced.sample_values);
        wrong += same ? 0 : 1;
      }
    };
    std::array<int, 4> wrong{};
    std::vector<std::thread> threads;
    for (std::size_t k = 0; k < wrong.size(); ++k) {
      threads.emplace_back([&, k] { work(k, wrong[k]); });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong, (std::array<int, 4>{}));
  }
}

/// A direction of a box [degrees] in radians, some whole turns away.
Direction direction_in(const DirectionBox& box, Random& random) {
  std::uniform_real_distribution<double> part(0, 1);
  double length = std::fmod(box.phi_to - box.phi_from, 360);
  if (length <= 0) length += 360;
  const double theta = box.theta_from + part(random) * (box.theta_to - box.theta_from);
  const double phi = box.phi_from + part(random) * length + 360.0 * (static_cast<double>(random() % 5) - 2);
  return {radians_from_degrees(theta), radians_from_degrees(phi)};
}

DirectionBox random_box(Random& random) {
  std::uniform_real_distribution<double> part(0, 1);
  DirectionBox box;
  box.theta_from = random() % 4 == 0 ? 0 : 80 * part(random);
  box.theta_to = random() % 4 == 0 ? 90 : box.theta_from + (90 - box.theta_from) * part(random) * part(random);
  box.phi_from = random() % 4 == 0 ? 0 : 720 * part(random) - 360;
  switch (random() % 4) {
    case 0:
      box.phi_to = box.phi_from;
      break;
    case 1:  // through 0
      box.phi_from = 360 - 40 * part(random);
      box.phi_to = 40 * part(random);
      break;
    default:
      box.phi_to = box.phi_from + 120 * part(random);
  }
  if (random() % 3 == 0) {  // with its bounds at nodes
    box.theta_from = 20 * std::floor(box.theta_from / 20);
    box.theta_to = box.theta_from + 20;
    box.phi_from = 60 * std::floor(box.phi_from / 60);
    box.phi_to = box.phi_from + 60;
  }
  return box;
}

TEST(CellsIn, HoldEveryPairOfTheirBoxes) {
  Random random(5);
  for (const FileExample& example : file_examples()) {
    const Lattice& lattice = example.whole.lattice;
    for (int trial = 0; trial < 150; ++trial) {
      const DirectionBox i = random_box(random);
      const DirectionBox v = trial % 5 == 0 ? i : random_box(random);
      const CellSet cells = cells_in(lattice, i, v);
      for (int k = 0; k < 60; ++k) {
        const DirectionPair pair = {direction_in(i, random), direction_in(v, random)};
        const std::string where = example.name + ": i [" + std::to_string(i.theta_from) + ", " +
                                  std::to_string(i.theta_to) + ") x [" + std::to_string(i.phi_from) + ", " +
                                  std::to_string(i.phi_to) + ") v [" + std::to_string(v.theta_from) + ", " +
                                  std::to_string(v.theta_to) + ") x [" + std::to_string(v.phi_from) + ", " +
                                  std::to_string(v.phi_to) + ")";
        ASSERT_TRUE(cells.contains(cell_of(lattice, pair))) << where;
        ASSERT_TRUE(cells.contains(cell_of(lattice, {pair.v, pair.i}))) << where;
      }
    }
  }
}

TEST(CellsIn, HoldTheLargestThetaOfTheFrameAndAllBeyond) {
  for (const FileExample& example : file_examples()) {
    const Lattice& lattice = example.whole.lattice;
    for (const double theta : {80.0, 85.0, 90.0}) {
      const DirectionBox box = {.theta_from = 70, .theta_to = std::max(theta, 80.0)};
      const DirectionPair pair = {direction_from_degrees(std::min(theta, 80.0), 30), direction_from_degrees(75, 200)};
      EXPECT_TRUE(cells_in(lattice, box, box).contains(cell_of(lattice, pair))) << example.name;
    }
  }
}

TEST(CellsIn, HoldEveryPairOfBoxesWhoseAzimuthsAreManyTurnsAway) {
  Random random(8);
  const Lattice& lattice = file_examples().front().whole.lattice;
  for (const double turns : {-10.0, -2.0, -1.0, 1.0, 2.0, 10.0}) {
    const DirectionBox near = {.theta_from = 30, .theta_to = 50, .phi_from = 10, .phi_to = 300};
    DirectionBox far = {.theta_from = 20, .theta_to = 70, .phi_from = 100, .phi_to = 120};
    far.phi_from += 360 * turns;
    far.phi_to += 360 * turns;
    const CellSet cells = cells_in(lattice, near, far);
    int missing = 0;
    for (int k = 0; k < 500; ++k) {
      const DirectionPair pair = {direction_in(near, random), direction_in(far, random)};
      missing += cells.contains(cell_of(lattice, pair)) ? 0 : 1;
    }
    EXPECT_EQ(missing, 0) << turns << " turns";
  }
}

TEST(CellsIn, LeaveOutMostOfTheCellsForSmallBoxes) {
  const Lattice& elevation = file_examples().front().whole.lattice;
  CellSet all(elevation);
  all.add_all();
  const DirectionBox small = {.theta_from = 45, .theta_to = 50, .phi_from = 62, .phi_to = 70};
  EXPECT_LT(cells_in(elevation, small, small).size(), all.size() / 20);
  EXPECT_EQ(cells_in(elevation, {}, {}).size(), all.size());
  const Lattice& half_difference = file_examples()[4].whole.lattice;
  CellSet all_of_it(half_difference);
  all_of_it.add_all();
  const DirectionBox steep = {.theta_from = 0, .theta_to = 4};
  EXPECT_LT(cells_in(half_difference, steep, steep).size(), all_of_it.size());
}

TEST(CellsIn, EvaluateEveryPairOfTheirBoxesAsTheWholeFileDoes) {
  Random random(6);
  for (const FileExample& example : file_examples()) {
    const Evaluator whole(example.whole.sliced, example.whole.lattice);
    const MemorySource source(example.file);
    const SlicedReader reader = SlicedReader::open(source).value();
    for (int trial = 0; trial < 5; ++trial) {
      const DirectionBox i = random_box(random);
      const DirectionBox v = random_box(random);
      const Result<PartialSliced> partial = reader.load(cells_in(reader.lattice(), i, v));
      ASSERT_TRUE(partial);
      for (int k = 0; k < 50; ++k) {
        const DirectionPair pair = {direction_in(i, random), direction_in(v, random)};
        ASSERT_EQ(evaluated(*partial, pair), evaluated(whole, pair)) << example.name;
      }
    }
  }
}

TEST(CellSet, HoldsWhatWasAdded) {
  const Lattice& lattice = file_examples().front().whole.lattice;
  CellSet cells(lattice);
  EXPECT_EQ(cells.size(), 0U);
  cells.add({2, 1, 0, 3});
  cells.add({2, 1, 0, 3});
  cells.add({11, 5, 3, 3});
  EXPECT_EQ(cells.size(), 2U);
  EXPECT_TRUE(cells.contains({11, 5, 3, 3}));
  EXPECT_FALSE(cells.contains({1, 2, 0, 3}));
  std::vector<CellSet::Cell> visited;
  cells.for_each([&](const CellSet::Cell& cell) { visited.push_back(cell); });
  EXPECT_EQ(visited, (std::vector<CellSet::Cell>{{2, 1, 0, 3}, {11, 5, 3, 3}}));
  cells.add_all();
  EXPECT_EQ(cells.size(), 12U * 6U * 4U * 4U);
}

TEST(CellOf, IsTheCellBetweenWhoseNodesThePairLies) {
  Random random(7);
  for (const FileExample& example : file_examples()) {
    const Lattice& lattice = example.whole.lattice;
    for (int k = 0; k < 500; ++k) {
      const DirectionPair pair = random_pair(random);
      const Coordinates x = geometry(lattice.spec.id).coordinates(pair);
      const CellSet::Cell cell = cell_of(lattice, pair);
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const std::vector<double>& nodes = lattice.nodes[axis];
        if (nodes.size() < 2) {
          EXPECT_EQ(cell[axis], 0U);
          continue;
        }
        ASSERT_LT(cell[axis] + 1, nodes.size());
        EXPECT_GE(x[axis], nodes[cell[axis]]);
        EXPECT_TRUE(cell[axis] + 2 == nodes.size() || x[axis] < nodes[cell[axis] + 1]);
      }
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
