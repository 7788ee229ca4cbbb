// Sources asked by vectors: the values of the angles, however long the vectors are.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "converters/files/merl/merl_census.h"
#include "converters/files/merl/merl_source.h"
#include "converters/files/sliced/sliced.h"
#include "converters/models/analytic.h"
#include "converters/source/atan2_each.h"
#include "converters/source/reciprocity.h"
#include "tests/support/function_source.h"
#include "tests/support/rgl_small_material.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPairs = 3000;

struct Vectors {
  std::vector<glm::vec3> i;
  std::vector<glm::vec3> v;
  std::vector<DirectionPair> angles;

  void add(const glm::dvec3& to_i, const glm::dvec3& to_v) {
    i.emplace_back(to_i);
    v.emplace_back(to_v);
    angles.push_back({direction_from_vector(glm::dvec3(i.back())), direction_from_vector(glm::dvec3(v.back()))});
  }
};

/// Of lengths from 1/8 to 8, some close to each other, some mirrored, some along the axes, none below the horizon.
/// `on_normal`: also such whose half vector is the normal, which has no azimuth.
Vectors some_vectors(bool on_normal) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto direction = [&] {
    const double length = std::exp2(3 * unit(random));
    return length * glm::dvec3(unit(random), unit(random), std::abs(unit(random)));
  };
  Vectors vectors;
  for (std::size_t k = 0; k < kPairs; ++k) {
    const glm::dvec3 i = direction();
    const double tiny = std::exp2(-20 * std::abs(unit(random)));
    switch (k % 4) {
      case 0:
        vectors.add(i, 2.0 * i + tiny * direction());
        break;
      case 1:
        vectors.add(i, glm::dvec3(-i.x, -i.y, i.z) + tiny * direction());
        break;
      default:
        vectors.add(i, direction());
    }
  }
  for (const glm::dvec3& i : {glm::dvec3(0, 0, 2), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 1)}) {
    for (const glm::dvec3& v : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, -1, 1)}) {
      const glm::dvec3 h = i / glm::length(i) + v / glm::length(v);
      if (h.z > 0 && (on_normal || h.x != 0 || h.y != 0)) vectors.add(i, v);
    }
  }
  return vectors;
}

std::vector<float> by_vectors(const BrdfSource& source, const Vectors& vectors) {
  std::vector<float> values(vectors.i.size() * source.channel_count());
  source.evaluate_vectors(vectors.i, vectors.v, values);
  return values;
}

/// `tolerance` relative to the value or to a thousandth of the largest.
void expect_values_of_angles(const BrdfSource& source, double tolerance, bool on_normal = true) {
  const Vectors vectors = some_vectors(on_normal);
  const std::vector<float> values = by_vectors(source, vectors);
  std::vector<float> expected(values.size());
  source.evaluate(vectors.angles, expected);
  const float largest = *std::max_element(expected.begin(), expected.end());
  ASSERT_GT(largest, 0);
  for (std::size_t k = 0; k < values.size(); ++k) {
    ASSERT_NEAR(values[k], expected[k], tolerance * std::max(std::abs(expected[k]), largest / 1000)) << k;
  }
  const std::size_t channels = source.channel_count();
  std::vector<float> one(channels);
  for (std::size_t k = 0; k < vectors.i.size(); ++k) {
    source.evaluate_vectors(std::span(&vectors.i[k], 1), std::span(&vectors.v[k], 1), one);
    ASSERT_TRUE(std::equal(one.begin(), one.end(), values.begin() + static_cast<std::ptrdiff_t>(k * channels))) << k;
  }
}

void expect_nothing_below_the_horizon(const BrdfSource& source) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const glm::vec3 above = {0.3F, 0.2F, 0.8F};
  const std::vector<glm::vec3> wrong = {{0.3F, 0.2F, -0.01F}, {0, 0, -1},        {0, 0, 0},
                                        {kNaN, 0, 1},         {0, kInfinity, 1}, {0, 0, kInfinity}};
  for (const glm::vec3& w : wrong) {
    for (const bool as_light : {true, false}) {
      const std::vector<glm::vec3> i = {above, as_light ? w : above, above};
      const std::vector<glm::vec3> v = {above, as_light ? above : w, above};
      std::vector<float> values(3 * source.channel_count(), -1);
      source.evaluate_vectors(i, v, values);
      const std::size_t channels = source.channel_count();
      for (std::size_t c = 0; c < channels; ++c) {
        EXPECT_EQ(values[channels + c], 0);
        EXPECT_GT(values[c], 0);
        EXPECT_EQ(values[c], values[2 * channels + c]);
      }
    }
  }
}

template <class T>
std::shared_ptr<const ByteSource> merl_file(const MerlShape& shape, bool full) {
  const auto header = emit_merl_header(shape);
  std::vector<std::byte> bytes(header.begin(), header.end());
  const std::uint64_t count = merl_cell_count(shape);
  const MerlConvention convention = {MerlPosition::kCentre, full ? MerlTurn::kFull : MerlTurn::kHalf};
  for (std::size_t c = 0; c < kMerlChannelCount; ++c) {
    for (std::uint64_t cell = 0; cell < count; ++cell) {
      const HalfDifference at = merl_cell_angles(shape, convention, cell);
      const bool mark = !(merl_cell_pair(shape, convention, cell).i.theta < 1.7);
      const auto value = static_cast<T>(
          mark ? -1 : 100 * std::exp(-3 * at.theta_h) * (2 + std::cos(at.theta_d) + std::cos(2 * at.phi_d) / 2));
      const auto of_value = std::as_bytes(std::span(&value, 1));
      bytes.insert(bytes.end(), of_value.begin(), of_value.end());
    }
  }
  return std::make_shared<OwnedMemorySource>(std::move(bytes));
}

SlicedSource sliced_source(const FrameSpec& spec) {
  const SampledBrdf made = sample_function(spec, 400, DomainKind::kLog, [](const DirectionPair& pair, std::size_t) {
    const HalfDifference at = half_difference_from_pair(pair);
    return 0.1 + std::exp(-4 * at.theta_h);
  });
  return SlicedSource({made.sliced, made.lattice, {}, 0});
}

}  // namespace

TEST(Atan2Each, GivesTheLibrarysAnglesForAnyNumber) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-300, 300);
  std::vector<double> y = {0, 0, 0, 1, -1, 1, -1, 1, -1, 0.0, 1e-310};
  std::vector<double> x = {0, 1, -1, 0, 0, 1, 1, -1, -1, -0.0, 1};
  for (int k = 0; k < 2000; ++k) {
    y.push_back((k % 2 == 0 ? 1 : -1) * std::pow(10, exponent(random)));
    x.push_back((k % 3 == 0 ? 1 : -1) * std::abs(y.back()) * std::pow(10, exponent(random) / 30));
  }
  std::vector<double> angles(y.size());
  atan2_each(y, x, angles);
  EXPECT_EQ(angles[0], 0);
  for (std::size_t k = 1; k < y.size(); ++k) {
    if (y[k] == 0 && x[k] == 0) continue;  // the sign of a zero does not count
    const double expected = std::atan2(y[k], x[k]);
    EXPECT_NEAR(angles[k], expected, 4 * std::numeric_limits<double>::epsilon() * std::abs(expected)) << y[k] << x[k];
  }
  for (std::size_t count = 1; count < 10; ++count) {
    for (std::size_t first = 0; first < 5; ++first) {
      std::vector<double> some(y.begin() + static_cast<std::ptrdiff_t>(first),
                               y.begin() + static_cast<std::ptrdiff_t>(first + count));
      atan2_each(some, std::span(x).subspan(first, count), some);
      EXPECT_TRUE(std::equal(some.begin(), some.end(), angles.begin() + static_cast<std::ptrdiff_t>(first)));
    }
  }
}

TEST(EvaluateVectors, OfAnySourceGoThroughItsAngles) {
  const FunctionSource source([](const DirectionPair& pair, std::size_t c) {
    return above_horizon(pair) ? 1 + std::cos(pair.i.theta) + std::sin(pair.v.phi) / (2 + static_cast<double>(c)) : 0;
  });
  expect_values_of_angles(source, 1e-6);
  expect_nothing_below_the_horizon(source);
  const SymmetrisedSource symmetrised(source);
  expect_values_of_angles(symmetrised, 1e-6);
}

TEST(EvaluateVectors, OfKurtModelsAgreeWithAngles) {
  const auto source = make_analytic_source(kurt_material("fabric135").value());
  expect_values_of_angles(*source, 1e-6);
  expect_nothing_below_the_horizon(*source);
}

TEST(EvaluateVectors, OfMerlTablesAgreeWithAngles) {
  for (const MerlLookup lookup : {MerlLookup::kLinear, MerlLookup::kNearest}) {
    for (const MerlPosition position : {MerlPosition::kCentre, MerlPosition::kEdge}) {
      for (const bool full : {false, true}) {
        MerlConvention convention = {position, full ? MerlTurn::kFull : MerlTurn::kHalf, lookup};
        const auto source = MerlSource::make(merl_file<double>({30, 20, 40}, full), {}, convention).value();
        // Of the nearest cells, the one or the other where a place is on the edge.
        if (lookup == MerlLookup::kLinear) expect_values_of_angles(*source, 1e-5);
        expect_nothing_below_the_horizon(*source);
        convention.value_size = sizeof(float);
        const auto narrow = MerlSource::make(merl_file<float>({30, 20, 40}, full), {}, convention).value();
        if (lookup == MerlLookup::kLinear) expect_values_of_angles(*narrow, 1e-5);
      }
    }
  }
}

TEST(EvaluateVectors, OfMerlTablesAgreeWithAnglesWhateverNegativesMean) {
  MerlTable table = {{6, 5, 8}, std::vector<double>(3 * 240, 3)};
  for (std::size_t k = 0; k < table.values.size(); k += 5) table.values[k] = -1;
  for (const Negatives negatives : {Negatives::kKeep, Negatives::kClamp, Negatives::kUnmeasured}) {
    const auto source =
        MerlSource::make(std::make_shared<OwnedMemorySource>(emit_merl(table)), {negatives, NonFinite::kRefuse})
            .value();
    expect_values_of_angles(*source, 1e-4);
  }
}

TEST(EvaluateVectors, OfRglMaterialsAgreeWithAngles) {
  rgl_testing::SmallMaterial material;
  material.jacobian = 1;
  material.vndf = [](std::size_t slice, std::size_t x, std::size_t y) {
    return 1.0F + static_cast<float>((slice + 2 * x + 3 * y) % 5);
  };
  material.rgb = [](std::size_t slice, std::size_t channel, std::size_t x, std::size_t y) {
    return 1.0F + static_cast<float>((slice + channel + 2 * x + y) % 4);
  };
  const std::vector<std::vector<float>> turns = {
      {0}, {-3.1415927F, -1, 1, 3.1415927F}, {-3.1415927F, -2, -1, 0}, {-3.1415927F, -2.5F, -2, -1.5707964F}};
  for (const std::vector<float>& phi_i : turns) {
    material.phi_i = phi_i;
    const auto source = rgl_testing::load(material.fields());
    ASSERT_EQ(source->traits().isotropic, phi_i.size() == 1);
    expect_values_of_angles(*source, 2e-5, false);
    expect_nothing_below_the_horizon(*source);
  }
}

TEST(EvaluateVectors, OfSlicedFilesAgreeWithAngles) {
  const Symmetries isotropic = {.isotropic = true};
  const SlicedSource elevation = sliced_source(elevation_frame(20, 60, isotropic).value());
  expect_values_of_angles(elevation, 1e-4);
  expect_nothing_below_the_horizon(elevation);
  const SlicedSource halves =
      sliced_source(half_difference_frame({0, 5, 20, 45, 90}, {0, 30, 60, 90}, {0}, {0, 60, 120}, isotropic));
  expect_values_of_angles(halves, 1e-4);
  expect_nothing_below_the_horizon(halves);
}

TEST(MerlCensus, TellsMarksAboveTheHorizonAsTheirPairsDo) {
  for (const MerlShape& shape :
       {MerlShape{90, 90, 180}, MerlShape{7, 5, 9}, MerlShape{1, 1, 1}, MerlShape{30, 80, 4}}) {
    for (const MerlPosition position : {MerlPosition::kCentre, MerlPosition::kEdge}) {
      for (const MerlTurn turn : {MerlTurn::kHalf, MerlTurn::kFull}) {
        const MerlConvention convention = {position, turn};
        const std::vector<std::byte> file = emit_merl({shape, std::vector<double>(3 * merl_cell_count(shape), -1)});
        const MerlCells cells({shape, sizeof(double)}, file.data());
        std::uint64_t above = 0;
        for (std::uint64_t cell = 0; cell < cells.count(); ++cell) {
          above += above_horizon(merl_cell_pair(shape, convention, cell)) ? 1 : 0;
        }
        const MerlCensus census = take_merl_census(cells, convention, {});
        EXPECT_EQ(census.marks, cells.count());
        EXPECT_EQ(census.marks_above, above);
      }
    }
  }
}

TEST(MerlSource, LooksAtTheWholeFileOnlyForItsFindings) {
  MerlTable table = {{2, 2, 3}, std::vector<double>(36, 1)};
  for (const std::size_t channel : {0, 1, 2}) table.values[12 * channel + 5] = -1;
  const auto source = MerlSource::make(std::make_shared<OwnedMemorySource>(emit_merl(table)),
                                       {Negatives::kKeep, NonFinite::kUnmeasured})
                          .value();
  EXPECT_TRUE(source->traits().findings.empty());
  EXPECT_FALSE(source->findings().empty());
  EXPECT_EQ(source->reported_traits().findings.size(), source->findings().size());
}

}  // namespace sbrdf::internal
