#include "codec/evaluation/evaluator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/literal_evaluator.h"

namespace sbrdf::internal {
namespace {

constexpr std::array kDomains = {DomainKind::kLinear, DomainKind::kLog};

TestFunction analytic(const Symmetries& symmetries) {
  return [symmetries](const DirectionPair& pair, std::size_t channel) {
    return std::pow(analytic_brdf(pair, symmetries), 1.0 + 0.5 * static_cast<double>(channel));
  };
}

/// Lists of each kind that a frame can have; all within the reach of the slow evaluator.
std::vector<FrameSpec> various_frames() {
  return {
      elevation_frame(40, 180, {}).value(),
      elevation_frame(80, 72, {}).value(),
      elevation_frame(28, 90, {.isotropic = true}).value(),
      elevation_frame(40, 180, {.mirror_x = true}).value(),
      elevation_frame(40, 180, {.mirror_x = true, .mirror_y = true}).value(),
      elevation_frame(28, 90, {.isotropic = true, .mirror_x = true}).value(),
      elevation_frame_from_nodes({0, 15, 80}, {0, 50, 200}, {0, 30, 330}, {}),
      half_difference_frame({0, 15, 40}, {0, 20, 40}, {0, 90, 180, 270}, {0, 60, 120}, {}),
      half_difference_frame({0, 10, 40}, {0, 40}, {0, 180}, {0, 90}, {.mirror_x = true}),
      half_difference_frame({0, 5, 40}, {0, 15, 40}, {0}, {0, 50, 90, 130}, {.isotropic = true, .mirror_x = true}),
  };
}

DirectionPair random_pair(std::mt19937_64& random, double theta_max = 80) {
  std::uniform_real_distribution<double> theta(0, theta_max);
  std::uniform_real_distribution<double> phi(0, 360);
  return {direction_from_degrees(theta(random), phi(random)), direction_from_degrees(theta(random), phi(random))};
}

template <class Real>
std::vector<Real> evaluate(const BasicEvaluator<Real>& evaluator, const DirectionPair& pair) {
  std::vector<Real> values(evaluator.channel_count());
  evaluator.evaluate(pair, values);
  return values;
}

template <class Real>
std::vector<Real> evaluate_at(const BasicEvaluator<Real>& evaluator, const Coordinates& x) {
  std::vector<Real> values(evaluator.channel_count());
  evaluator.evaluate_at(x, values);
  return values;
}

float largest(const SlicedBrdf& sliced) {
  float most = 0;
  for (const float v : sliced.crossing_values) most = std::max(most, std::abs(v));
  for (const float v : sliced.sample_values) most = std::max(most, std::abs(v));
  return most;
}

TEST(Evaluator, AgreesWithALiteralReadingOfTheEquations) {
  for (const FrameSpec& spec : various_frames()) {
    for (const DomainKind domain : kDomains) {
      const auto [lattice, sliced] = sample_function(spec, 120, domain, analytic(spec.symmetries), 2);
      LiteralEvaluator literal(sliced, lattice);
      const BasicEvaluator<long double> exact(sliced, lattice);
      const Evaluator rounded(sliced, lattice);
      std::mt19937_64 random(1);
      for (int k = 0; k < 60; ++k) {
        const DirectionPair pair = random_pair(random);
        for (std::size_t c = 0; c < 2; ++c) {
          const auto expected = static_cast<double>(literal(plain_coordinates(pair, lattice.spec.id), c).value);
          ASSERT_NEAR(static_cast<double>(evaluate(exact, pair)[c]), expected, 1e-11 * std::abs(expected));
          const double bound = domain == DomainKind::kLog ? 2e-5 * expected : 1e-5 * largest(sliced);
          ASSERT_NEAR(evaluate(rounded, pair)[c], expected, bound);
        }
      }
    }
  }
}

TEST(Evaluator, AgreesWithALiteralReadingWhereTheSumLeavesTheRangeOfTheSlices) {
  for (const DomainKind domain : kDomains) {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> share(0, 1);
    // Deep valleys in a level plain and a few hills.
    const auto rough = [&](const auto&, std::size_t) {
      const double drawn = share(random);
      return drawn < 0.4 ? 1.0 + drawn : drawn < 0.8 ? 0.001 * drawn : 20 * drawn;
    };
    const FrameSpec spec = elevation_frame(40, 180, {}).value();
    const auto [lattice, sliced] = sample_function(spec, 60, domain, rough);
    LiteralEvaluator literal(sliced, lattice);
    const BasicEvaluator<long double> exact(sliced, lattice);
    int below = 0;
    int above = 0;
    for (int k = 0; k < 600; ++k) {
      const DirectionPair pair = random_pair(random);
      const auto [expected, clamped] = literal(plain_coordinates(pair, lattice.spec.id), 0);
      below += clamped < 0 ? 1 : 0;
      above += clamped > 0 ? 1 : 0;
      ASSERT_NEAR(static_cast<double>(evaluate(exact, pair)[0] - expected), 0, 1e-9);
    }
    EXPECT_GT(below, 5);
    EXPECT_TRUE(above > 5 || domain == DomainKind::kLinear) << above;
  }
}

/// Each stored sample with coordinates where it lies on the padded lattice, up to the first failure.
template <class Visit>
void for_each_sample(const SampledBrdf& sampled, const Visit& visit_any) {
  const auto visit = [&](const Coordinates& x, const float* values) {
    // Seen from the pole, crossings of uneven lists lie between the nodes of s.
    int between = 0;
    for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
      const auto& nodes = sampled.lattice.nodes[axis];
      between += std::find(nodes.begin(), nodes.end(), x[axis]) == nodes.end() ? 1 : 0;
    }
    if (between <= 1 && !testing::Test::HasFatalFailure()) visit_any(x, values);
  };
  const auto& [lattice, sliced] = sampled;
  const std::size_t channels = sliced.channel_count();
  for (std::size_t k = 0; k < lattice.crossings.size(); ++k) {
    visit(lattice.crossings[k], sliced.crossing_values.data() + k * channels);
  }
  std::size_t next = 0;
  for (std::size_t s = 0; s < lattice.slices.size(); ++s) {
    for (std::uint32_t k = 0; k < sliced.sample_counts[s]; ++k, ++next) {
      const Slice& slice = lattice.slices[s];
      Coordinates x = coordinates_on(slice, place_in_degrees(lattice, slice, sliced.positions[next]));
      if (x[kDiagonal] > 360) {
        x[kDiagonal] -= 360;
        x[kAxial] += x[kAxial] >= 360 ? -360 : 360;
      }
      visit(x, sliced.sample_values.data() + next * channels);
    }
  }
}

TEST(Evaluator, GivesBackEverySampleToTheLastBitInLinearValues) {
  for (const FrameSpec& spec : various_frames()) {
    const SampledBrdf sampled = sample_function(spec, 200, DomainKind::kLinear, analytic(spec.symmetries), 2);
    const Evaluator rounded(sampled.sliced, sampled.lattice);
    const BasicEvaluator<long double> exact(sampled.sliced, sampled.lattice);
    for_each_sample(sampled, [&](const Coordinates& x, const float* values) {
      for (std::size_t c = 0; c < 2; ++c) {
        ASSERT_EQ(static_cast<float>(evaluate_at(exact, x)[c]), values[c]) << testing::PrintToString(x);
        ASSERT_EQ(evaluate_at(rounded, x)[c], values[c]) << testing::PrintToString(x);
      }
    });
  }
}

TEST(Evaluator, GivesBackEverySampleInLogValues) {
  for (const FrameSpec& spec : various_frames()) {
    const SampledBrdf sampled = sample_function(spec, 200, DomainKind::kLog, analytic(spec.symmetries), 2);
    const Evaluator rounded(sampled.sliced, sampled.lattice);
    const BasicEvaluator<long double> exact(sampled.sliced, sampled.lattice);
    for_each_sample(sampled, [&](const Coordinates& x, const float* values) {
      for (std::size_t c = 0; c < 2; ++c) {
        ASSERT_EQ(static_cast<float>(evaluate_at(exact, x)[c]), values[c]) << testing::PrintToString(x);
        ASSERT_NEAR(evaluate_at(rounded, x)[c], values[c], 2e-6 * values[c]) << testing::PrintToString(x);
      }
    });
  }
}

/// Zero on scattered samples and wherever both directions are low.
double with_zeros(const DirectionPair& pair) {
  const double f = analytic_brdf(pair, {});
  return pair.i.theta + pair.v.theta > 1.8 || std::fmod(f * 1000, 1) < 0.2 ? 0 : f;
}

TEST(Evaluator, GivesExactlyZeroAtSamplesThatAreZero) {
  for (const DomainKind domain : kDomains) {
    const FrameSpec spec = elevation_frame(28, 90, {}).value();
    const SampledBrdf sampled =
        sample_function(spec, 500, domain, [](const DirectionPair& pair, std::size_t) { return with_zeros(pair); });
    const Evaluator evaluator(sampled.sliced, sampled.lattice);
    int zeros = 0;
    for_each_sample(sampled, [&](const Coordinates& x, const float* value) {
      if (*value != 0) return;
      ++zeros;
      ASSERT_EQ(evaluate_at(evaluator, x)[0], 0) << testing::PrintToString(x);
    });
    EXPECT_GT(zeros, 60);
  }
}

TEST(Evaluator, IsContinuousWhereTheElevationsChangePlaces) {
  std::mt19937_64 random(11);
  for (const FrameSpec& spec : various_frames()) {
    const auto [lattice, sliced] = sample_function(spec, 200, DomainKind::kLog, analytic(spec.symmetries));
    const BasicEvaluator<long double> evaluator(sliced, lattice);
    for (int k = 0; k < 500; ++k) {
      DirectionPair pair = random_pair(random);
      pair.v.theta = pair.i.theta + 1e-9;
      const long double above = evaluate(evaluator, pair)[0];
      std::swap(pair.i.theta, pair.v.theta);
      ASSERT_NEAR(static_cast<double>(evaluate(evaluator, pair)[0] / above), 1, 1e-5);
    }
  }
}

TEST(Evaluator, ReproducesConstantsToTheLastBit) {
  std::mt19937_64 random(4);
  for (const FrameSpec& spec : various_frames()) {
    for (const DomainKind domain : kDomains) {
      const std::array<float, 5> constants = {0.1F, 1e-30F, 1e12F, 0, 0.7182818F};
      const auto [lattice, sliced] = sample_function(
          spec, 100, domain, [&](const auto&, std::size_t c) { return constants[c]; }, 5);
      const Evaluator evaluator(sliced, lattice);
      for (int k = 0; k < 200; ++k) {
        const auto values = evaluate(evaluator, random_pair(random, 90));
        for (std::size_t c = 0; c < 5; ++c) ASSERT_EQ(values[c], constants[c]);
      }
    }
  }
}

TEST(Evaluator, ReproducesFunctionsThatAreLinearInEachElevation) {
  const auto linear = [](const DirectionPair& pair, std::size_t) {
    const double i = degrees_from_radians(pair.i.theta);
    const double v = degrees_from_radians(pair.v.theta);
    return 1 + 0.01 * (i + v) + 0.0003 * i * v;
  };
  const auto [lattice, sliced] = sample_function(elevation_frame(28, 90, {}).value(), 200, DomainKind::kLinear, linear);
  const BasicEvaluator<long double> exact(sliced, lattice);
  const Evaluator rounded(sliced, lattice);
  std::mt19937_64 random(5);
  for (int k = 0; k < 1000; ++k) {
    const DirectionPair pair = random_pair(random);
    const double expected = linear(pair, 0);
    // Samples are floats.
    ASSERT_NEAR(static_cast<double>(evaluate(exact, pair)[0]), expected, 5e-7);
    ASSERT_NEAR(evaluate(rounded, pair)[0], expected, 3e-6);
  }
}

void expect_same(const std::vector<float>& a, const std::vector<float>& b, float largest_value) {
  for (std::size_t c = 0; c < a.size() && !testing::Test::HasFatalFailure(); ++c) {
    ASSERT_NEAR(a[c], b[c], 2e-5 * std::abs(a[c]) + 2e-6 * largest_value);
  }
}

class SampledMaterials : public testing::Test {
 protected:
  template <class Test>
  static void for_each(const Test& test) {
    for (const FrameSpec& spec : various_frames()) {
      for (const DomainKind domain : kDomains) {
        const auto [lattice, sliced] = sample_function(spec, 200, domain, analytic(spec.symmetries), 3);
        test(Evaluator(sliced, lattice), lattice, largest(sliced));
        if (HasFatalFailure()) return;
      }
    }
  }
};

TEST_F(SampledMaterials, AreReciprocalToTheLastBit) {
  for_each([](const Evaluator& evaluator, const Lattice&, float) {
    std::mt19937_64 random(6);
    for (int k = 0; k < 2000; ++k) {
      DirectionPair pair = random_pair(random, 90);
      if (k % 3 == 0) pair.v.theta = pair.i.theta;
      if (k % 5 == 0) pair.i.theta = 0;
      ASSERT_EQ(evaluate(evaluator, pair), evaluate(evaluator, {pair.v, pair.i}));
    }
  });
}

TEST_F(SampledMaterials, AreTheSameToTheLastBitAfterWholeTurns) {
  for_each([](const Evaluator& evaluator, const Lattice&, float) {
    std::mt19937_64 random(7);
    std::uniform_int_distribution<int> phi(0, 360 * 64 - 1);
    std::uniform_int_distribution<int> turns(-1000, 1000);
    std::uniform_real_distribution<double> theta(0, 90);
    for (int k = 0; k < 1000; ++k) {
      const double theta_i = theta(random), theta_v = theta(random);
      const double phi_i = phi(random) / 64.0, phi_v = phi(random) / 64.0;
      const DirectionPair pair = {direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)};
      const DirectionPair turned = {direction_from_degrees(theta_i, phi_i + 360.0 * turns(random)),
                                    direction_from_degrees(theta_v, phi_v + 360.0 * turns(random))};
      ASSERT_EQ(evaluate(evaluator, pair), evaluate(evaluator, turned));
    }
  });
}

TEST_F(SampledMaterials, StayTheSameUnderTheirSymmetries) {
  for_each([](const Evaluator& evaluator, const Lattice& lattice, float most) {
    std::mt19937_64 random(8);
    std::uniform_real_distribution<double> turn(0, 2 * kPi);
    const auto expect_same_at = [&](const DirectionPair& a, const DirectionPair& b) {
      expect_same(evaluate(evaluator, a), evaluate(evaluator, b), most);
    };
    for (int k = 0; k < 300; ++k) {
      const auto [i, v] = random_pair(random);
      const Symmetries& symmetries = lattice.spec.symmetries;
      const double angle = turn(random);
      if (symmetries.isotropic) expect_same_at({i, v}, {{i.theta, i.phi + angle}, {v.theta, v.phi + angle}});
      if (symmetries.mirror_x) expect_same_at({i, v}, {{i.theta, -i.phi}, {v.theta, -v.phi}});
      if (symmetries.mirror_y) expect_same_at({i, v}, {{i.theta, kPi - i.phi}, {v.theta, kPi - v.phi}});
    }
  });
}

TEST_F(SampledMaterials, KeepTheValueAtTheLargestElevationBeyondIt) {
  for_each([](const Evaluator& evaluator, const Lattice& lattice, float most) {
    if (lattice.spec.id != FrameId::kElevation) return;
    std::mt19937_64 random(9);
    for (int k = 0; k < 200; ++k) {
      DirectionPair pair = random_pair(random);
      pair.v.theta = radians_from_degrees(80);
      const auto at_80 = evaluate(evaluator, pair);
      for (const double theta : {80.0 + 1e-9, 85.0, 89.9, 90.0}) {
        pair.v.theta = radians_from_degrees(theta);
        expect_same(evaluate(evaluator, pair), at_80, most);
      }
    }
  });
}

TEST_F(SampledMaterials, AreZeroBelowTheHorizonButNotOnIt) {
  for_each([](const Evaluator& evaluator, const Lattice& lattice, float) {
    const double just_below = std::nextafter(kPi / 2, 2.0);
    std::mt19937_64 random(16);
    const std::vector<float> zeros(evaluator.channel_count(), 0.0F);
    for (int k = 0; k < 50; ++k) {
      DirectionPair pair = random_pair(random, 90);
      Direction& moved = k % 2 == 0 ? pair.i : pair.v;
      moved.theta = kPi / 2;
      EXPECT_THAT(evaluate(evaluator, pair), testing::Each(testing::Gt(0.0F)));
      for (const double theta : {just_below, 1.6, kPi, 100.0, std::numeric_limits<double>::quiet_NaN()}) {
        moved.theta = theta;
        EXPECT_EQ(evaluate(evaluator, pair), zeros) << theta;
      }
      // Frame coordinates know nothing of the horizon.
      moved.theta = just_below;
      const Coordinates x = geometry(lattice.spec.id).coordinates(pair);
      EXPECT_THAT(evaluate_at(evaluator, x), testing::Each(testing::Gt(0.0F)));
    }
    EXPECT_EQ(evaluate(evaluator, {{2, 0}, {2, 1}}), zeros);
  });
}

TEST_F(SampledMaterials, DoNotDependOnTheAzimuthOfADirectionAtThePole) {
  for_each([](const Evaluator& evaluator, const Lattice&, float most) {
    std::mt19937_64 random(10);
    for (int k = 0; k < 100; ++k) {
      DirectionPair pair = random_pair(random);
      pair.i.theta = 0;
      if (k % 10 == 0) pair.v.theta = 0;
      DirectionPair turned = pair;
      turned.i.phi = random_pair(random).i.phi;
      expect_same(evaluate(evaluator, turned), evaluate(evaluator, pair), most);
    }
  });
}

TEST_F(SampledMaterials, AreContinuousWhereTheTwoElevationsChangePlaces) {
  for_each([](const Evaluator& evaluator, const Lattice&, float most) {
    std::mt19937_64 random(12);
    for (int k = 0; k < 300; ++k) {
      DirectionPair pair = random_pair(random);
      pair.v.theta = pair.i.theta + 1e-10;
      DirectionPair other = pair;
      other.v.theta = pair.i.theta - 1e-10;
      expect_same(evaluate(evaluator, pair), evaluate(evaluator, other), most);
    }
  });
}

TEST_F(SampledMaterials, AreTheSameFromEveryThread) {
  for_each([](const Evaluator& evaluator, const Lattice&, float) {
    std::vector<std::vector<std::vector<float>>> results(4);
    {
      std::vector<std::jthread> threads;
      for (auto& result : results) {
        threads.emplace_back([&evaluator, &result] {
          std::mt19937_64 random(13);
          for (int k = 0; k < 500; ++k) result.push_back(evaluate(evaluator, random_pair(random)));
        });
      }
    }
    for (const auto& result : results) ASSERT_EQ(result, results[0]);
  });
}

// The least and the greatest of the slices of a cell jump from cell to cell, so only the sum can be continuous.
TEST(Evaluator, IsContinuousAcrossEveryNodeAndAroundTheTurnWhereTheSumIsNotClamped) {
  constexpr double kStep = 1e-7;
  int compared = 0;
  for (const FrameSpec& spec : various_frames()) {
    const auto [lattice, sliced] = sample_function(spec, 200, DomainKind::kLinear, analytic(spec.symmetries));
    const Evaluator evaluator(sliced, lattice);
    LiteralEvaluator literal(sliced, lattice);
    const float most = largest(sliced);
    const auto expect_same_at = [&](const Coordinates& a, const Coordinates& b) {
      if (literal(a, 0).clamped != 0 || literal(b, 0).clamped != 0) return;
      SCOPED_TRACE(testing::PrintToString(a) + " and " + testing::PrintToString(b));
      expect_same(evaluate_at(evaluator, a), evaluate_at(evaluator, b), most);
      ++compared;
    };
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> share(0, 1);
    for (int k = 0; k < 5; ++k) {
      Coordinates x;
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) x[axis] = share(random) * lattice.nodes[axis].back();
      for (std::size_t axis = 0; axis < kAxisCount; ++axis) {
        const auto& nodes = lattice.nodes[axis];
        for (std::size_t node = 1; node + 1 < nodes.size(); ++node) {
          Coordinates below = x;
          Coordinates above = x;
          below[axis] = nodes[node] - kStep;
          above[axis] = nodes[node] + kStep;
          expect_same_at(below, above);
        }
        if (axis > kDiagonal || nodes.size() == 1) continue;
        Coordinates start = x;
        Coordinates end = x;
        start[axis] = kStep;
        end[axis] = nodes.back() - kStep;
        const bool turns_both = spec.id == FrameId::kElevation && !spec.symmetries.isotropic;
        if (axis == kDiagonal && turns_both) end[kAxial] += end[kAxial] < 360 ? 360 : -360;
        expect_same_at(start, end);
      }
    }
  }
  EXPECT_GT(compared, 150);
}

TEST(Evaluator, TreatsEachChannelAsIfItWereAlone) {
  const FrameSpec spec = elevation_frame(40, 180, {}).value();
  for (const std::size_t channels : {1U, 2U, 4U, 7U}) {
    SampledBrdf many = sample_function(spec, 100, DomainKind::kLog, analytic({}), channels);
    const Evaluator all(many.sliced, many.lattice);
    for (std::size_t c = 0; c < channels; ++c) {
      SlicedBrdf one = many.sliced;
      one.channels = {"one"};
      one.domain.reference = {many.sliced.domain.reference[c]};
      one.crossing_values.clear();
      one.sample_values.clear();
      for (std::size_t k = c; k < many.sliced.crossing_values.size(); k += channels) {
        one.crossing_values.push_back(many.sliced.crossing_values[k]);
      }
      for (std::size_t k = c; k < many.sliced.sample_values.size(); k += channels) {
        one.sample_values.push_back(many.sliced.sample_values[k]);
      }
      const Evaluator alone(one, many.lattice);
      std::mt19937_64 random(14);
      for (int k = 0; k < 100; ++k) {
        const DirectionPair pair = random_pair(random);
        ASSERT_EQ(evaluate(all, pair)[c], evaluate(alone, pair)[0]) << channels << " channels, channel " << c;
      }
    }
  }
}

TEST(Evaluator, StaysFiniteAndAboveZeroOnValuesOverFortyOrders) {
  for (const double low : {1e-30, 1e-3, 1e6}) {
    std::mt19937_64 random(15);
    std::uniform_real_distribution<double> exponent(std::log(1e-30), std::log(1e12));
    std::uniform_int_distribution<int> kind(0, 9);
    // Most values are `low`, so that the reference of the log domain is; the others lie anywhere.
    const auto wild = [&](const DirectionPair&, std::size_t) {
      const int drawn = kind(random);
      return drawn < 6 ? low : drawn == 6 ? 0 : drawn == 7 ? 1e12 : std::exp(exponent(random));
    };
    for (const DomainKind domain : kDomains) {
      const auto [lattice, sliced] = sample_function(elevation_frame(28, 90, {}).value(), 800, domain, wild);
      const Evaluator evaluator(sliced, lattice);
      for (int k = 0; k < 2000; ++k) {
        const float value = evaluate(evaluator, random_pair(random, 90))[0];
        ASSERT_TRUE(std::isfinite(value)) << low << ", domain " << static_cast<int>(domain);
        ASSERT_TRUE(domain == DomainKind::kLinear || value >= 0);
      }
    }
  }
}

// Differences of such values, and slopes between them, are beyond float32.
TEST(Evaluator, StaysFiniteBetweenTheLargestNumbersOfBothSigns) {
  for (const std::vector<float>& extremes : {std::vector<float>{3e38F, -3e38F}, {3.4e38F, 0.0F}}) {
    for (const DomainKind domain : kDomains) {
      std::mt19937_64 random(16);
      const auto wild = [&](const DirectionPair&, std::size_t) { return extremes[random() % 2]; };
      const auto [lattice, sliced] = sample_function(elevation_frame(28, 90, {}).value(), 800, domain, wild);
      const Evaluator evaluator(sliced, lattice);
      for (int k = 0; k < 2000; ++k) {
        const float value = evaluate(evaluator, random_pair(random, 90))[0];
        ASSERT_TRUE(std::isfinite(value)) << extremes[1] << ", domain " << static_cast<int>(domain);
        ASSERT_TRUE(value >= 0 || extremes[1] < 0);
      }
    }
  }
}

TEST(Evaluator, KeepsNegativeValues) {
  const FrameSpec spec = elevation_frame(80, 180, {}).value();
  const auto negative = [](const auto&, std::size_t c) { return c == 0 ? -2.0 : 3.0; };
  for (const DomainKind domain : kDomains) {
    const auto [lattice, sliced] = sample_function(spec, 20, domain, negative, 2);
    const auto values =
        evaluate(Evaluator(sliced, lattice), {direction_from_degrees(10, 20), direction_from_degrees(30, 50)});
    EXPECT_NEAR(values[0], -2, domain == DomainKind::kLinear ? 0 : 4e-6);
    EXPECT_EQ(values[1], 3.0F);
  }
}

}  // namespace
}  // namespace sbrdf::internal
