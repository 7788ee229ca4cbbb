#include "codec/series/series.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "codec/entropy/range_coder.h"
#include "codec/frame/frame.h"
#include "codec/series/coefficient_coder.h"
#include "codec/series/series_file.h"
#include "codec/series/series_table.h"
#include "formats/core/byte_source.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kMemory = std::uint64_t{64} << 20U;

TEST(RangeCoder, GivesBackDecisionsOfAnyProbability) {
  std::mt19937 random(3);
  for (const unsigned chance : {1U, 40U, 128U, 255U}) {
    std::vector<bool> decisions;
    RangeEncoder out;
    DecisionCounts counts;
    for (int k = 0; k < 5000; ++k) {
      decisions.push_back(random() % 256 < chance);
      if (k % 7 == 0) {
        out.put_plain(decisions.back());
      } else {
        out.put(decisions.back(), counts);
      }
    }
    const std::vector<std::byte> stream = out.finish();
    // Near to the entropy, and a plain bit for each seventh.
    const double share = chance / 256.0;
    const double entropy = -share * std::log2(share) - (1 - share) * std::log2(1 - share);
    EXPECT_LE(static_cast<double>(stream.size()), 5000 * (6 * entropy + 1) / 7 / 8 * 1.05 + 16) << chance;
    RangeDecoder in(stream);
    DecisionCounts again;
    for (std::size_t k = 0; k < decisions.size(); ++k) {
      ASSERT_EQ(k % 7 == 0 ? in.take_plain() : in.take(again), decisions[k]) << chance << ", " << k;
    }
  }
}

TEST(RangeCoder, CarriesRunThroughBytesOf255) {
  // Many unlikely decisions of the upper part: low creeps to the end of a byte and beyond.
  for (int length = 1; length < 400; ++length) {
    RangeEncoder out;
    DecisionCounts counts{1, 8000};
    for (int k = 0; k < length; ++k) out.put(k % 50 == 49, counts);
    const std::vector<std::byte> stream = out.finish();
    EXPECT_TRUE(stream.empty() || stream.back() != std::byte{0});
    RangeDecoder in(stream);
    DecisionCounts again{1, 8000};
    for (int k = 0; k < length; ++k) ASSERT_EQ(in.take(again), k % 50 == 49) << length;
  }
}

SeriesBasis basis_of(const SeriesShape& shape, const Symmetries& symmetries) {
  Result<SeriesBasis> basis = make_basis(shape, symmetries);
  EXPECT_TRUE(basis) << basis.error().message;
  return *std::move(basis);
}

// All functions of a basis at a pair of directions.
std::vector<double> functions_at(const SeriesBasis& basis, const DirectionPair& pair) {
  BasisFactors factors;
  evaluate_factors(basis, Warp{80, 40, 5}, geometry(FrameId::kHalfDifference).coordinates(pair), factors);
  std::vector<double> values;
  for (const SeriesTerm& t : basis.terms) {
    values.push_back(factors.theta_h[t.a] * factors.theta_d[t.b] * factors.harmonics[t.harmonic]);
  }
  return values;
}

DirectionPair mirrored(const DirectionPair& pair, double end) {
  return {{pair.i.theta, end - pair.i.phi}, {pair.v.theta, end - pair.v.phi}};
}

TEST(SeriesBasis, EveryFunctionHasTheSymmetriesOfTheMaterial) {
  std::mt19937 random(7);
  const auto angle = [&](double most) { return most * static_cast<double>(random()) / 4294967296.0; };
  for (int bits = 0; bits < 8; ++bits) {
    const Symmetries symmetries = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
    const SeriesShape shape = {4, 3, symmetries.isotropic ? 1U : 5U, 4};
    const SeriesBasis basis = basis_of(shape, symmetries);
    for (int k = 0; k < 50; ++k) {
      const DirectionPair pair = {{angle(1.3), angle(2 * kPi)}, {angle(1.3), angle(2 * kPi)}};
      const std::vector<double> there = functions_at(basis, pair);
      std::vector<DirectionPair> images = {{pair.v, pair.i}};
      if (symmetries.mirror_x) images.push_back(mirrored(pair, 2 * kPi));
      if (symmetries.mirror_y) images.push_back(mirrored(pair, kPi));
      if (symmetries.isotropic) {
        images.push_back({{pair.i.theta, pair.i.phi + 1}, {pair.v.theta, pair.v.phi + 1}});
      }
      for (const DirectionPair& image : images) {
        const std::vector<double> values = functions_at(basis, image);
        for (std::size_t n = 0; n < values.size(); ++n) ASSERT_NEAR(values[n], there[n], 1e-9) << bits << ", " << n;
      }
    }
  }
}

TEST(SeriesBasis, IsWhatTheSumOfOrdersAllowsOrderedByLevel) {
  const SeriesBasis basis = basis_of({6, 4, 3, 3}, {false, false, false});
  std::size_t expected = 0;
  for (int j = 0; j < 3; ++j) {
    for (int k = j == 0 ? 0 : -2; k <= 2; ++k) {
      for (int b = 0; b < 4; ++b) {
        for (int a = 0; a < 6; ++a) {
          // In twelfths, so without rounding.
          if (2 * a + 3 * b + 4 * j + 4 * std::abs(k) < 12) expected += j == 0 && k == 0 ? 1 : 2;
        }
      }
    }
  }
  EXPECT_EQ(basis.terms.size(), expected);
  for (std::size_t n = 1; n < basis.terms.size(); ++n) EXPECT_LE(basis.terms[n - 1].level, basis.terms[n].level);
  for (std::uint32_t n = 0; n < basis.terms.size(); ++n) {
    EXPECT_EQ(basis.number(basis.terms[n].harmonic, basis.terms[n].b, basis.terms[n].a), n);
  }
}

TEST(SeriesBasis, RefusesWhatIsTooLarge) {
  for (const SeriesShape& shape :
       {SeriesShape{65, 4, 1, 2}, {4, 0, 1, 2}, {4, 4, 1, 33}, {64, 64, 32, 32}, {40, 40, 32, 32}}) {
    EXPECT_EQ(make_basis(shape, {}).error().code, ErrorCode::kUnsupported);
  }
}

/// A series of drawn coefficients that fall with the level.
SeriesBrdf drawn(const Symmetries& symmetries, std::vector<std::string> channels, unsigned seed) {
  std::mt19937 random(seed);
  SeriesBrdf brdf;
  brdf.symmetries = symmetries;
  brdf.channels = std::move(channels);
  brdf.shape = {7, 4, symmetries.isotropic ? 1U : 3U, 3};
  brdf.warp = {seed % 2 == 0 ? 80 : 71.5, static_cast<std::uint8_t>(40 + seed % 30), 5};
  brdf.reference_step = -20;
  brdf.most_step = 30;
  brdf.negative = seed % 3 == 0;
  brdf.fineness = 4;
  brdf.coefficient_step = 20;
  const std::size_t count = brdf.channels.size();
  brdf.mean_colour.assign(count, 32);
  if (count > 1) {
    brdf.mean_colour[0] = 40;
    brdf.mean_colour[1] = 24;
    brdf.component_count = count == 3 ? 2 : 1;
    brdf.colour_turn = count == 3 ? 77 : 0;
    if (count != 3) brdf.components.emplace_back(count, static_cast<std::int8_t>(-90));
  }
  const SeriesBasis basis = basis_of(brdf.shape, symmetries);
  for (std::size_t f = 0; f < brdf.field_count(); ++f) {
    std::vector<std::int32_t>& field = brdf.coefficients.emplace_back();
    for (const SeriesTerm& t : basis.terms) {
      const auto most = static_cast<std::uint32_t>(f == 0 ? 12 : 3) / (1 + t.level);
      field.push_back(static_cast<std::int32_t>(random() % (2 * most + 1)) - static_cast<std::int32_t>(most));
    }
  }
  brdf.coefficients[0][0] = -9;
  brdf.metadata = seed % 4 == 1 ? "" : R"({"source":{"format":"kurt"}})";
  return brdf;
}

std::vector<SeriesBrdf> all_kinds() {
  std::vector<SeriesBrdf> kinds;
  unsigned seed = 0;
  for (int bits = 0; bits < 8; ++bits) {
    const Symmetries symmetries = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
    kinds.push_back(drawn(symmetries, {"R", "G", "B"}, seed++));
    kinds.push_back(drawn(symmetries, {"Y"}, seed++));
    kinds.push_back(drawn(symmetries, {"400", "450", "500", "550", "600"}, seed++));
  }
  return kinds;
}

void expect_equal(const SeriesBrdf& a, const SeriesBrdf& b) {
  EXPECT_EQ(a.symmetries, b.symmetries);
  EXPECT_EQ(a.channels, b.channels);
  EXPECT_EQ(a.shape, b.shape);
  EXPECT_EQ(a.warp, b.warp);
  EXPECT_EQ(a.reference_step, b.reference_step);
  EXPECT_EQ(a.most_step, b.most_step);
  EXPECT_EQ(a.negative, b.negative);
  EXPECT_EQ(a.fineness, b.fineness);
  EXPECT_EQ(a.mean_colour, b.mean_colour);
  EXPECT_EQ(a.colour_turn, b.colour_turn);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.coefficient_step, b.coefficient_step);
  EXPECT_EQ(a.coefficients, b.coefficients);
  EXPECT_EQ(a.metadata, b.metadata);
}

TEST(SeriesFile, ComesBackAsItWasWritten) {
  for (const SeriesBrdf& brdf : all_kinds()) {
    const std::vector<std::byte> file = encode_series(brdf);
    const MemorySource source(file);
    EXPECT_TRUE(is_series_file(source));
    const Result<SeriesBrdf> read = decode_series(source);
    ASSERT_TRUE(read) << read.error().message;
    expect_equal(*read, brdf);
    EXPECT_EQ(encode_series(*read), file);
  }
}

TEST(SeriesFile, CoefficientsOfAnySizeComeBack) {
  const SeriesBasis basis = basis_of({6, 3, 1, 2}, {true, true, false});
  std::vector<std::vector<std::int32_t>> fields(1, std::vector<std::int32_t>(basis.terms.size()));
  std::int32_t size = 1;
  for (std::size_t n = 0; n < fields[0].size(); ++n) {
    fields[0][n] = n % 2 == 0 ? size : -size;
    size = std::min((size * 5 + 2) / 2, kCoefficientEnd - 1);
  }
  const std::vector<std::uint32_t> counts = {coded_terms(fields[0])};
  const auto read = decode_coefficients(basis, code_coefficients(basis, fields), counts);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(*read, fields);
}

TEST(SeriesFile, EveryTruncationAndEveryFlippedBitIsRefused) {
  const std::vector<std::byte> file = encode_series(drawn({true, true, false}, {"R", "G", "B"}, 2));
  for (std::size_t size = 0; size < file.size(); ++size) {
    EXPECT_FALSE(
        decode_series(MemorySource(std::vector(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size)))));
  }
  std::vector<std::byte> longer = file;
  longer.push_back(std::byte{0});
  EXPECT_NE(decode_series(MemorySource(longer)).error().message.find("[SD-7]"), std::string::npos);
  for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
    std::vector<std::byte> flipped = file;
    flipped[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    EXPECT_FALSE(decode_series(MemorySource(flipped))) << bit;
  }
}

// The series itself, written down once more.
std::vector<double> series_at(const SeriesBrdf& brdf, const Coordinates& x) {
  const SeriesBasis basis = basis_of(brdf.shape, brdf.symmetries);
  const double w = std::exp2(brdf.warp.width_step / 8.0 - 6);
  const double end = brdf.warp.theta_max_deg;
  const double u = std::log(1 + x[3] * x[3] / w / w) / std::log(1 + end * end / w / w);
  const double v = std::pow(x[2] / end, (brdf.warp.power_step + 1) / 8.0);
  std::vector<double> fields;
  for (const auto& field : brdf.coefficients) {
    double sum = 0;
    for (std::size_t n = 0; n < field.size(); ++n) {
      const SeriesTerm& t = basis.terms[n];
      const Harmonic& h = basis.harmonics[t.harmonic];
      const double angle = (h.j * x[0] + 2 * h.k * x[1]) * kPi / 180;
      double each = std::cos(t.a * std::acos(2 * u - 1)) * std::cos(t.b * std::acos(2 * v - 1));
      each *= h.sine ? std::sin(angle) : std::cos(angle);
      if (h.j != 2 * h.k) each *= std::sqrt(std::sin(x[3] * kPi / 180));
      if (h.k != 0) each *= std::sqrt(std::sin(x[2] * kPi / 180));
      sum += field[n] * std::exp2(-brdf.coefficient_step / 8.0) * each;
    }
    fields.push_back(sum);
  }
  const double reference = std::exp2(brdf.reference_step / 8.0);
  const double zero = std::log(1.0 / 8) - 1;
  const double most = brdf.most_step / 8.0;
  const double log = std::min(std::max(fields[0], brdf.negative ? 2 * zero - most : zero), most);
  double mean = reference * std::exp(log);
  if (log < zero + 1) mean = reference / 8 * (log - zero);
  if (log < zero - 1) mean = -reference / 8 * std::exp(zero - 1 - log);
  std::vector<double> values;
  for (std::size_t c = 0; c < brdf.channel_count(); ++c) {
    double colour = brdf.mean_colour[c] / 32.0;
    for (std::size_t j = 1; j < fields.size(); ++j) colour += fields[j] * brdf.component(j - 1, c);
    values.push_back(brdf.negative ? mean * colour : std::max(0.0, mean * colour));
  }
  return values;
}

TEST(SeriesTable, IsTheSeriesAtItsNodes) {
  std::mt19937 random(5);
  for (const SeriesBrdf& brdf : all_kinds()) {
    const Result<VectorEvaluator> table = make_table(brdf, kMemory);
    ASSERT_TRUE(table) << table.error().message;
    const auto nodes = table_nodes(brdf);
    std::vector<float> values(brdf.channel_count());
    for (int k = 0; k < 60; ++k) {
      Coordinates x;
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) x[axis] = nodes[axis][random() % nodes[axis].size()];
      table->evaluate_at(x, values);
      const std::vector<double> expected = series_at(brdf, x);
      for (std::size_t c = 0; c < values.size(); ++c) {
        // A node may lie in the cell before it, by a few millionths of a degree.
        EXPECT_NEAR(values[c], expected[c], 2e-4 * std::abs(expected[c]) + 1e-5);
      }
    }
  }
}

TEST(SeriesTable, IsFinerWithFineness) {
  SeriesBrdf brdf = drawn({true, true, false}, {"Y"}, 1);
  brdf.coefficients[0].assign(brdf.coefficients[0].size(), 0);
  brdf.coefficients[0][0] = 3;
  brdf.coefficients[0].back() = 9;
  double before = 1e9;
  for (const std::uint8_t fineness : std::array<std::uint8_t, 3>{2, 4, 8}) {
    brdf.fineness = fineness;
    const Result<VectorEvaluator> table = make_table(brdf, kMemory);
    std::mt19937 random(11);
    double most = 0;
    for (int k = 0; k < 2000; ++k) {
      const auto share = [&] { return static_cast<double>(random()) / 4294967296.0; };
      const Coordinates x = {0, 180 * share(), 0.5 + 60 * share(), 0.5 + 60 * share()};
      std::array<float, 1> value{};
      table->evaluate_at(x, value);
      most = std::max(most, std::abs(value[0] / series_at(brdf, x)[0] - 1));
    }
    EXPECT_LT(most, before / 2.5) << int{fineness};
    before = most;
  }
}

TEST(SeriesTable, TakesNoMoreMemoryThanAllowed) {
  SeriesBrdf brdf = drawn({false, false, false}, {"R", "G", "B"}, 0);
  EXPECT_EQ(make_table(brdf, table_bytes(brdf) - 1).error().code, ErrorCode::kUnsupported);
  EXPECT_TRUE(make_table(brdf, table_bytes(brdf)));
}

TEST(SeriesTable, ACoarserLevelLeavesTermsOut) {
  const SeriesBrdf brdf = drawn({true, true, false}, {"R", "G", "B"}, 2);
  const SeriesBasis basis = basis_of(brdf.shape, brdf.symmetries);
  const std::vector<std::byte> file = encode_series(brdf);
  const MemorySource source(file);
  for (std::uint32_t level = 0; level <= kSeriesLevels; ++level) {
    const Result<SeriesBrdf> part = decode_series(source, level);
    ASSERT_TRUE(part);
    for (std::size_t n = 0; n < basis.terms.size(); ++n) {
      EXPECT_EQ(part->coefficients[0][n], basis.terms[n].level > level ? 0 : brdf.coefficients[0][n]);
    }
  }
}

}  // namespace
}  // namespace sbrdf::internal
