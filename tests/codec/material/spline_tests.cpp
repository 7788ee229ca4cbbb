#include "codec/curves/spline.h"

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/dense_spline.h"

namespace sbrdf::internal {
namespace {

struct SplineCase {
  Boundary boundary = Boundary::kBounded;
  double length = 0;
  std::vector<double> positions;
  std::vector<double> values;
};

std::string name(Boundary boundary) {
  switch (boundary) {
    case Boundary::kPeriodic:
      return "periodic";
    case Boundary::kMirrored:
      return "mirrored";
    case Boundary::kBounded:
      break;
  }
  return "bounded";
}

constexpr std::array kBoundaries = {Boundary::kPeriodic, Boundary::kMirrored, Boundary::kBounded};

/// Uneven gaps between 1 and 40.
SplineCase random_case(Boundary boundary, std::size_t n, std::mt19937_64& random) {
  std::uniform_real_distribution<double> gap(1, 40);
  std::uniform_real_distribution<double> value(-2, 3);
  SplineCase made;
  made.boundary = boundary;
  double position = gap(random) - 20;
  for (std::size_t k = 0; k < n; ++k) {
    made.positions.push_back(position);
    made.values.push_back(value(random));
    position += gap(random);
  }
  made.length = (boundary == Boundary::kPeriodic ? position : made.positions.back()) - made.positions.front();
  return made;
}

template <class Real>
std::vector<Real> solve(const SplineCase& given) {
  const std::vector<Real> values(given.values.begin(), given.values.end());
  std::vector<Real> second(values.size(), Real(-77));
  SplineSolver<Real>().solve(given.boundary, given.length, given.positions, values.data(), second.data(), 1);
  return second;
}

DenseSpline dense_spline(const SplineCase& given) {
  return {given.boundary,
          given.length,
          {given.positions.begin(), given.positions.end()},
          {given.values.begin(), given.values.end()}};
}

std::size_t segment_count(const SplineCase& given) {
  return given.boundary == Boundary::kPeriodic ? given.positions.size() : given.positions.size() - 1;
}

double segment_end(const SplineCase& given, std::size_t k) {
  return k + 1 < given.positions.size() ? given.positions[k + 1] : given.positions[0] + given.length;
}

template <class Real>
Real on_segment(const SplineCase& given, const std::vector<Real>& second, std::size_t k, Real t) {
  const std::size_t next = (k + 1) % given.positions.size();
  const Real width = static_cast<Real>(segment_end(given, k)) - static_cast<Real>(given.positions[k]);
  return evaluate_segment(t, width * width / 6, static_cast<Real>(given.values[k]),
                          static_cast<Real>(given.values[next]), second[k], second[next]);
}

TEST(Spline, AgreesWithDenseEliminationForEveryBoundaryAndCount) {
  std::mt19937_64 random(1);
  for (const Boundary boundary : kBoundaries) {
    for (std::size_t n = 1; n <= 12; ++n) {
      SCOPED_TRACE(name(boundary) + ", " + std::to_string(n) + " samples");
      const SplineCase given = random_case(boundary, n, random);
      const DenseSpline expected = dense_spline(given);
      const auto exact = solve<long double>(given);
      const auto rounded = solve<double>(given);
      for (std::size_t k = 0; k < segment_count(given); ++k) {
        const long double width = static_cast<long double>(segment_end(given, k)) - given.positions[k];
        for (int step = 0; step <= 16; ++step) {
          const long double t = step / 16.0L;
          const long double at = given.positions[k] + t * width;
          ASSERT_NEAR(static_cast<double>(on_segment<long double>(given, exact, k, t) - expected(at)), 0, 1e-14);
          ASSERT_NEAR(on_segment<double>(given, rounded, k, static_cast<double>(t)), static_cast<double>(expected(at)),
                      1e-11);
        }
      }
    }
  }
}

TEST(Spline, KeepsValueSlopeAndCurvatureContinuousAtSamples) {
  std::mt19937_64 random(2);
  for (const Boundary boundary : kBoundaries) {
    for (const std::size_t n : {3U, 4U, 9U}) {
      SCOPED_TRACE(name(boundary) + ", " + std::to_string(n) + " samples");
      const SplineCase given = random_case(boundary, n, random);
      const auto second = solve<long double>(given);
      // A cubic is known from its values at 0, 1/3, 2/3 and 1.
      const auto ends = [&](std::size_t k) {
        const long double h = static_cast<long double>(segment_end(given, k)) - given.positions[k];
        std::array<long double, 4> f{};
        for (std::size_t j = 0; j < 4; ++j) f[j] = on_segment<long double>(given, second, k, j / 3.0L);
        return std::array<long double, 6>{f[0],
                                          f[3],
                                          (-11 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]) / (2 * h),
                                          (-2 * f[0] + 9 * f[1] - 18 * f[2] + 11 * f[3]) / (2 * h),
                                          (18 * f[0] - 45 * f[1] + 36 * f[2] - 9 * f[3]) / (h * h),
                                          (-9 * f[0] + 36 * f[1] - 45 * f[2] + 18 * f[3]) / (h * h)};
      };
      const std::size_t segments = segment_count(given);
      const std::size_t joints = boundary == Boundary::kPeriodic ? segments : segments - 1;
      for (std::size_t k = 0; k < joints; ++k) {
        const auto left = ends(k);
        const auto right = ends((k + 1) % segments);
        for (const std::size_t order : {0U, 2U, 4U}) {
          EXPECT_NEAR(static_cast<double>(left[order + 1] - right[order]), 0, 1e-14) << "derivative " << order / 2;
        }
      }
      if (boundary == Boundary::kMirrored) {
        EXPECT_NEAR(static_cast<double>(ends(0)[2]), 0, 1e-14);
        EXPECT_NEAR(static_cast<double>(ends(segments - 1)[3]), 0, 1e-14);
      }
      if (boundary == Boundary::kBounded) {
        EXPECT_NEAR(static_cast<double>(ends(0)[4] - ends(0)[5]), 0, 1e-14);
        EXPECT_NEAR(static_cast<double>(ends(segments - 1)[4] - ends(segments - 1)[5]), 0, 1e-14);
      }
    }
  }
}

TEST(Spline, ReproducesConstantsToTheLastBit) {
  std::mt19937_64 random(3);
  for (const Boundary boundary : kBoundaries) {
    for (std::size_t n = 1; n <= 9; ++n) {
      SplineCase given = random_case(boundary, n, random);
      given.values.assign(n, 0.1);
      const auto second = solve<double>(given);
      for (std::size_t k = 0; k < n; ++k) EXPECT_EQ(second[k], 0);
      for (std::size_t k = 0; k < segment_count(given); ++k) {
        for (const double t : {0.0, 0.1, 0.37, 0.5, 0.99, 1.0}) EXPECT_EQ(on_segment(given, second, k, t), 0.1);
      }
    }
  }
}

TEST(Spline, ReproducesStraightLinesAndParabolasOnABoundedSlice) {
  std::mt19937_64 random(4);
  const std::array<std::array<double, 3>, 2> polynomials = {{{0.7, -0.03, 0}, {0.2, 0.05, -0.004}}};
  for (const auto& [a, b, c] : polynomials) {
    const auto f = [a = a, b = b, c = c](double x) { return a + x * (b + x * c); };
    for (std::size_t n = c == 0 ? 2 : 3; n <= 10; ++n) {
      SplineCase given = random_case(Boundary::kBounded, n, random);
      for (std::size_t k = 0; k < n; ++k) given.values[k] = f(given.positions[k]);
      const auto second = solve<double>(given);
      for (std::size_t k = 0; k + 1 < n; ++k) {
        EXPECT_NEAR(second[k], 2 * c, 1e-12);
        const double middle = given.positions[k] + 0.3 * (given.positions[k + 1] - given.positions[k]);
        EXPECT_NEAR(on_segment(given, second, k, 0.3), f(middle), 1e-11) << n << " samples, segment " << k;
      }
    }
  }
}

TEST(Spline, OfOneSampleIsConstantAndOfTwoBoundedOnesIsALine) {
  const SplineCase one = {Boundary::kPeriodic, 360, {12}, {5}};
  EXPECT_EQ(solve<double>(one), std::vector<double>{0});
  const SplineCase two = {Boundary::kBounded, 80, {0, 80}, {1, 3}};
  EXPECT_EQ(solve<double>(two), (std::vector<double>{0, 0}));
}

TEST(Spline, ReadsAndWritesOneChannelOfInterleavedValues) {
  std::mt19937_64 random(5);
  for (const Boundary boundary : kBoundaries) {
    const SplineCase given = random_case(boundary, 7, random);
    const auto expected = solve<double>(given);
    std::vector<double> values(21, 1e9);
    std::vector<double> second(21, -77);
    for (std::size_t k = 0; k < 7; ++k) values[3 * k + 1] = given.values[k];
    SplineSolver<double>().solve(boundary, given.length, given.positions, values.data() + 1, second.data() + 1, 3);
    for (std::size_t k = 0; k < 21; ++k) EXPECT_EQ(second[k], k % 3 == 1 ? expected[k / 3] : -77) << k;
  }
}

TEST(Spline, GivesTheSameAnswerFromASolverThatWasUsedBefore) {
  std::mt19937_64 random(6);
  SplineSolver<double> reused;
  for (const std::size_t n : {9U, 2U, 5U, 1U, 7U}) {
    for (const Boundary boundary : kBoundaries) {
      const SplineCase given = random_case(boundary, n, random);
      std::vector<double> second(n);
      reused.solve(boundary, given.length, given.positions, given.values.data(), second.data(), 1);
      EXPECT_EQ(second, solve<double>(given));
    }
  }
}

TEST(Spline, StaysFiniteAndAccurateOnASpikeOfSixOrdersBesideNarrowGaps) {
  for (const Boundary boundary : kBoundaries) {
    const SplineCase given = {boundary,
                              boundary == Boundary::kPeriodic ? 360.0 : 180.0,
                              {0, 60, 61, 61.5, 62, 120, 180},
                              {1, 1, 1e3, 1e6, 1e3, 1, 1}};
    const auto second = solve<double>(given);
    const DenseSpline expected = dense_spline(given);
    for (std::size_t k = 0; k < segment_count(given); ++k) {
      const double width = segment_end(given, k) - given.positions[k];
      for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        EXPECT_NEAR(on_segment(given, second, k, t), static_cast<double>(expected(given.positions[k] + t * width)),
                    1e-6);
      }
    }
  }
}

TEST(SplineSegment, IsExactAtBothEndsHoweverFarApartTheValues) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<float> exponent(-30, 30);
  for (int k = 0; k < 1000; ++k) {
    const float a = std::exp(exponent(random));
    const float b = std::exp(exponent(random));
    ASSERT_EQ(evaluate_segment(0.0F, 3.0F, a, b, 0.5F, -2.0F), a);
    ASSERT_EQ(evaluate_segment(1.0F, 3.0F, a, b, 0.5F, -2.0F), b);
  }
}

}  // namespace
}  // namespace sbrdf::internal
