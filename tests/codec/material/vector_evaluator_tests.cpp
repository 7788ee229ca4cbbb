#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <glm/geometric.hpp>

#include "codec/evaluation/evaluator.h"
#include "codec/evaluation/lazy_evaluator.h"
#include "codec/evaluation/vector_evaluator.h"
#include "tests/support/analytic_brdf.h"
#include "tests/support/sampled_brdf.h"

namespace sbrdf::internal {
namespace {

struct Vectors {
  std::vector<glm::vec3> i;
  std::vector<glm::vec3> v;

  void add(const glm::vec3& w_i, const glm::vec3& w_v) {
    i.push_back(w_i);
    v.push_back(w_v);
  }
};

glm::vec3 vector_at(double theta_deg, double phi_deg) {
  return glm::vec3(vector_from_direction(direction_from_degrees(theta_deg, phi_deg)));
}

std::vector<float> evaluate(const VectorEvaluator& evaluator, const Vectors& pairs) {
  std::vector<float> values(pairs.i.size() * evaluator.channel_count());
  evaluator.evaluate(pairs.i, pairs.v, values);
  return values;
}

/// Anywhere above the horizon, and where formulas for angles are prone to fail: at the pole, on the horizon, both
/// directions the same, opposite, mirrored, and close to all of these.
Vectors many_pairs(std::size_t count) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> share(0, 1);
  Vectors pairs;
  for (std::size_t k = 0; k < count; ++k) {
    double theta_i = 90 * share(random);
    double theta_v = 90 * share(random);
    const double phi_i = 360 * share(random);
    double phi_v = 360 * share(random);
    const double close = std::pow(10, -6 * share(random));
    if (k % 7 == 1) theta_i = 0;
    if (k % 7 == 2) theta_v = theta_i + close, phi_v = phi_i + close;
    if (k % 7 == 3) theta_v = theta_i, phi_v = phi_i + 180;
    if (k % 7 == 4) theta_i = close;
    if (k % 7 == 5) theta_v = std::min(90.0, theta_i + close), phi_v = phi_i + 180 + close;
    pairs.add(vector_at(theta_i, phi_i), vector_at(std::min(theta_v, 90.0), phi_v));
  }
  for (glm::vec3& w : pairs.v) w.z = std::max(w.z, 0.0F);
  return pairs;
}

struct Material {
  Lattice lattice;
  SlicedBrdf sliced;
  VectorEvaluator evaluator;

  explicit Material(const SampledBrdf& sampled)
      : lattice(sampled.lattice), sliced(sampled.sliced), evaluator(sampled.sliced, sampled.lattice) {}
};

/// Both frames, isotropic and not, with and without a guide that is wider one way than the other.
std::vector<Material> materials() {
  const auto analytic = [](const Symmetries& symmetries) {
    return [symmetries](const DirectionPair& pair, std::size_t channel) {
      return std::pow(analytic_brdf(pair, symmetries), 1.0 + 0.5 * static_cast<double>(channel));
    };
  };
  const std::vector<FrameSpec> frames = {
      elevation_frame(20, 90, {}).value(),
      elevation_frame(20, 90, {.isotropic = true}).value(),
      half_difference_frame({0, 15, 40, 80}, {0, 20, 40, 80}, {0, 90, 180, 270}, {0, 60, 120}, {}),
      half_difference_frame({0, 5, 40, 80}, {0, 15, 40, 80}, {0}, {0, 50, 90, 130},
                            {.isotropic = true, .mirror_x = true}),
  };
  std::vector<Material> all;
  for (const FrameSpec& spec : frames) {
    for (const std::size_t channels : {1U, 3U, 6U}) {
      SampledBrdf sampled = sample_function(spec, 300, DomainKind::kLog, analytic(spec.symmetries), channels);
      all.emplace_back(sampled);
      if (spec.id != FrameId::kHalfDifference) continue;
      Guide guide;
      guide.ratio = spec.symmetries.isotropic ? 1 : 1.7;
      for (std::uint32_t k = 0; k < spec.axes[kVertical].nodes_deg.size(); ++k) {
        guide.places.push_back({k, 0});
        for (std::size_t c = 0; c < channels; ++c) guide.values.push_back(0.5F / static_cast<float>(1 + k + c));
      }
      sampled.sliced.guide = guide;
      all.emplace_back(sampled);
    }
  }
  return all;
}

TEST(VectorEvaluator, AgreesWithLongDouble) {
  const Vectors pairs = many_pairs(700);
  for (const Material& material : materials()) {
    const BasicEvaluator<long double> exact(material.sliced, material.lattice);
    const std::vector<float> values = evaluate(material.evaluator, pairs);
    std::vector<long double> expected(exact.channel_count());
    for (std::size_t k = 0; k < pairs.i.size(); ++k) {
      const DirectionPair pair = {direction_from_vector(glm::dvec3(pairs.i[k])),
                                  direction_from_vector(glm::dvec3(pairs.v[k]))};
      exact.evaluate(pair, expected);
      for (std::size_t c = 0; c < expected.size(); ++c) {
        ASSERT_NEAR(values[k * expected.size() + c] / static_cast<double>(expected[c]), 1, 3e-5)
            << material.lattice.spec.axes[0].name << " pair " << k << ' ' << testing::PrintToString(pairs.i[k]) << ' '
            << testing::PrintToString(pairs.v[k]);
      }
    }
  }
}

TEST(VectorEvaluator, GivesTheSameBitsInAnyBatchAndEitherOrder) {
  const Vectors pairs = many_pairs(101);
  for (const Material& material : materials()) {
    const std::size_t channels = material.evaluator.channel_count();
    const std::vector<float> together = evaluate(material.evaluator, pairs);
    for (const std::size_t size : {1U, 2U, 3U, 16U, 17U}) {
      for (std::size_t first = 0; first + size <= pairs.i.size(); first += size) {
        Vectors some;
        for (std::size_t k = first; k < first + size; ++k) some.add(pairs.v[k], pairs.i[k]);  // exchanged
        const std::vector<float> alone = evaluate(material.evaluator, some);
        ASSERT_TRUE(
            std::equal(alone.begin(), alone.end(), together.begin() + static_cast<std::ptrdiff_t>(first * channels)))
            << size << " pairs from " << first;
      }
    }
  }
}

TEST(VectorEvaluator, TakesVectorsOfAnyLength) {
  for (const Material& material : materials()) {
    Vectors unit;
    Vectors other;
    for (const float length : {1e-3F, 0.5F, 3.0F, 1e3F}) {
      unit.add(vector_at(20, 30), vector_at(55, 200));
      other.add(length * unit.i.back(), unit.v.back() / length);
    }
    const std::vector<float> expected = evaluate(material.evaluator, unit);
    const std::vector<float> values = evaluate(material.evaluator, other);
    for (std::size_t k = 0; k < values.size(); ++k) ASSERT_NEAR(values[k], expected[k], 1e-5 * expected[k]);
  }
}

TEST(VectorEvaluator, IsZeroBelowTheHorizonAndForWhatIsNoDirection) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const glm::vec3 up = vector_at(30, 40);
  const std::vector<glm::vec3> wrong = {{0, 0, -1},   {0.6F, 0, -1e-7F}, {0, 0, 0},
                                        {kNan, 0, 1}, {0, 0, kNan},      {0, kInfinity, 1}};
  for (const Material& material : materials()) {
    Vectors pairs;
    for (const glm::vec3& w : wrong) {
      pairs.add(w, up);
      pairs.add(up, w);
    }
    EXPECT_THAT(evaluate(material.evaluator, pairs), testing::Each(0.0F));
    pairs = {};
    pairs.add({1, 0, 0}, {0, 1, 0});  // on the horizon
    EXPECT_THAT(evaluate(material.evaluator, pairs), testing::Each(testing::Gt(0.0F)));
  }
}

// At places of samples, where either is exact, and on values between which slopes are beyond float32.
TEST(VectorEvaluator, IsTheEvaluatorAtCrossingsAndStaysFiniteLikeIt) {
  std::mt19937_64 random(22);
  for (const DomainKind domain : {DomainKind::kLinear, DomainKind::kLog}) {
    for (const auto& [low, high] : {std::pair{-3e38, 3e38}, {0.0, 3.4e38}, {1e-30, 1e12}, {0.25, 4.0}}) {
      const auto wild = [&, low = low, high = high](const DirectionPair&, std::size_t) {
        return random() % 2 == 0 ? low : high;
      };
      const auto [lattice, sliced] = sample_function(elevation_frame(28, 90, {}).value(), 400, domain, wild);
      const Evaluator plain(sliced, lattice);
      const VectorEvaluator fast(sliced, lattice);
      float value = 0;
      float expected = 0;
      for (const Coordinates& x : lattice.crossings) {
        fast.evaluate_at(x, std::span(&value, 1));
        plain.evaluate_at(x, std::span(&expected, 1));
        ASSERT_TRUE(std::isfinite(value));
        if (low > 0) {
          ASSERT_NEAR(value / expected, 1, 2e-6) << testing::PrintToString(x);
        }
      }
      for (const float v : evaluate(fast, many_pairs(2000))) ASSERT_TRUE(std::isfinite(v) && (v >= 0 || low < 0));
    }
  }
}

TEST(VectorEvaluator, PresampledIsNearTheExactForm) {
  const Vectors pairs = many_pairs(700);
  for (const Material& material : materials()) {
    const std::vector<float> expected = evaluate(material.evaluator, pairs);
    double before = 0;
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
      const VectorEvaluator presampled = material.evaluator.presampled(tolerance);
      const std::vector<float> values = evaluate(presampled, pairs);
      double most = 0;
      for (std::size_t k = 0; k < values.size(); ++k) {
        most = std::max(most, std::abs(values[k] / static_cast<double>(expected[k]) - 1));
      }
      // Up to four means less three times the corners, which are exact; and rounding.
      EXPECT_LT(most, 4 * tolerance + 3e-5);
      if (before > 0) {
        EXPECT_LT(most, before);
      }
      before = most;
    }
  }
}

// A narrow peak, where samples crowd, within a bucket: straight from end to end but for it.
TEST(VectorEvaluator, PresampledKeepsNarrowPeaks) {
  const FrameSpec spec = half_difference_frame({0, 11.72, 30, 80}, {0, 40, 80}, {0}, {0, 90},
                                               {.isotropic = true, .mirror_x = true, .mirror_y = true});
  const auto peak = [](const DirectionPair& pair, std::size_t) {
    const double theta_h = degrees_from_radians(half_difference_from_pair(pair).theta_h);
    return 0.1 + 5 * std::exp(-1000 * (theta_h - 11.72) * (theta_h - 11.72));
  };
  for (const DomainKind domain : {DomainKind::kLog, DomainKind::kLinear}) {
    const auto [lattice, sliced] = sample_function(spec, 400, domain, peak);
    const VectorEvaluator exact(sliced, lattice);
    const VectorEvaluator presampled = exact.presampled(1e-3);
    float value = 0;
    float expected = 0;
    double most = 0;
    for (double theta_h = 0; theta_h <= 80; theta_h += 0.01) {
      const Coordinates x = {0, 17, 20, theta_h};
      exact.evaluate_at(x, std::span(&expected, 1));
      presampled.evaluate_at(x, std::span(&value, 1));
      ASSERT_NEAR(value, expected, 0.006 * expected) << theta_h;
      most = std::max(most, double{value});
    }
    EXPECT_GT(most, 3);
  }
}

TEST(VectorEvaluator, PresampledGivesTheSameBitsInAnyBatch) {
  const Vectors pairs = many_pairs(101);
  for (const Material& material : materials()) {
    const VectorEvaluator presampled = material.evaluator.presampled(1e-2);
    const std::size_t channels = presampled.channel_count();
    const std::vector<float> together = evaluate(presampled, pairs);
    std::vector<float> alone(channels);
    for (std::size_t k = 0; k < pairs.i.size(); ++k) {
      presampled.evaluate(std::span(&pairs.v[k], 1), std::span(&pairs.i[k], 1), alone);
      ASSERT_TRUE(std::equal(alone.begin(), alone.end(), together.begin() + static_cast<std::ptrdiff_t>(k * channels)));
    }
  }
}

TEST(VectorEvaluator, DenseIsNearTheExactFormAndBetterWithMoreRoom) {
  const Vectors pairs = many_pairs(3000);
  for (const Material& material : materials()) {
    if (!material.lattice.spec.symmetries.isotropic) continue;
    const std::vector<float> expected = evaluate(material.evaluator, pairs);
    const auto mean_error = [&](const VectorEvaluator& dense) {
      const std::vector<float> values = evaluate(dense, pairs);
      double sum = 0;
      for (std::size_t k = 0; k < values.size(); ++k) sum += std::abs(values[k] / static_cast<double>(expected[k]) - 1);
      return sum / static_cast<double>(values.size());
    };
    const VectorEvaluator rough = material.evaluator.dense(material.sliced, material.lattice, {0.05, 1U << 20U});
    const VectorEvaluator fine = material.evaluator.dense(material.sliced, material.lattice, {0.002, 8U << 20U});
    EXPECT_LT(rough.bytes(), fine.bytes());
    EXPECT_LT(fine.bytes(), 9U << 20U);
    EXPECT_LT(mean_error(fine), 0.5 * mean_error(rough));
    EXPECT_LT(mean_error(fine), 0.005) << material.lattice.spec.axes[0].name;
  }
}

TEST(VectorEvaluator, DenseGivesTheSameBitsInAnyBatchAndHoldsItsNodes) {
  const Vectors pairs = many_pairs(101);
  for (const Material& material : materials()) {
    const VectorEvaluator dense = material.evaluator.dense(material.sliced, material.lattice, {0.1, 1U << 18U});
    const std::size_t channels = dense.channel_count();
    const std::vector<float> together = evaluate(dense, pairs);
    std::vector<float> alone(channels);
    for (std::size_t k = 0; k < pairs.i.size(); ++k) {
      dense.evaluate(std::span(&pairs.v[k], 1), std::span(&pairs.i[k], 1), alone);
      ASSERT_TRUE(std::equal(alone.begin(), alone.end(), together.begin() + static_cast<std::ptrdiff_t>(k * channels)));
    }
    std::vector<float> exact(channels);
    for (const Coordinates& x : material.lattice.crossings) {
      bool on_nodes = true;  // some stand for others on the ring of a pole, where an axis has no node
      for (std::size_t a = 0; a < kAxisCount; ++a) {
        const std::vector<double>& nodes = material.lattice.nodes[a];
        on_nodes = on_nodes && std::find(nodes.begin(), nodes.end(), x[a]) != nodes.end();
      }
      if (!on_nodes) continue;
      dense.evaluate_at(x, alone);
      material.evaluator.evaluate_at(x, exact);
      for (std::size_t c = 0; c < channels; ++c) ASSERT_NEAR(alone[c] / exact[c], 1, 2e-5) << testing::PrintToString(x);
    }
  }
}

// A pair alone has tables of its own, with nothing in them but what it needs: the rings of poles, too.
TEST(LazyEvaluator, GivesTheBitsOfTheWhole) {
  const Vectors pairs = many_pairs(300);
  for (const Material& material : materials()) {
    const std::size_t channels = material.evaluator.channel_count();
    const std::vector<float> expected = evaluate(material.evaluator, pairs);
    std::vector<float> values(channels);
    for (std::size_t k = 0; k < pairs.i.size(); ++k) {
      const LazyEvaluator lazy(material.sliced, material.lattice);
      lazy.evaluate(std::span(&pairs.i[k], 1), std::span(&pairs.v[k], 1), values);
      ASSERT_TRUE(
          std::equal(values.begin(), values.end(), expected.begin() + static_cast<std::ptrdiff_t>(k * channels)))
          << material.lattice.spec.axes[0].name << " pair " << k;
    }
    const LazyEvaluator lazy(material.sliced, material.lattice);
    EXPECT_EQ(lazy.bytes(), 0U);
    for (std::size_t first = 0; first < pairs.i.size(); first += 10) {  // soon all slices are there
      std::vector<float> some(10 * channels);
      lazy.evaluate(std::span(pairs.i).subspan(first, 10), std::span(pairs.v).subspan(first, 10), some);
      ASSERT_TRUE(
          std::equal(some.begin(), some.end(), expected.begin() + static_cast<std::ptrdiff_t>(first * channels)));
    }
    EXPECT_EQ(lazy.bytes(), material.evaluator.bytes());
  }
}

// Every set of instructions that this machine has, and the one that needs none.
TEST(VectorEvaluator, AgreesWithEverySetOfInstructions) {
  const Vectors pairs = many_pairs(300);
  std::vector<VectorEvaluator> all;
  for (const Material& material : materials()) {
    all.push_back(material.evaluator);
    all.push_back(material.evaluator.presampled(1e-2));
    all.push_back(material.evaluator.dense(material.sliced, material.lattice, {0.1, 1U << 18U}));
  }
  std::vector<std::vector<float>> expected;
  for (const VectorEvaluator& evaluator : all) expected.push_back(evaluate(evaluator, pairs));
  int targets = 0;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    hwy::GetChosenTarget().Update(left & -left);
    ++targets;
    for (std::size_t m = 0; m < all.size(); ++m) {
      const std::vector<float> values = evaluate(all[m], pairs);
      for (std::size_t k = 0; k < values.size(); ++k) {
        ASSERT_NEAR(values[k], expected[m][k], 5e-7 * expected[m][k]) << hwy::TargetName(left & -left);
      }
    }
  }
  hwy::GetChosenTarget().DeInit();
  EXPECT_GE(targets, 2);
}

}  // namespace
}  // namespace sbrdf::internal
