#include "codec/curves/slope_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/curves/spline.h"
#include "formats/core/directions.h"
#include "tests/support/dense_spline.h"
#include "tests/support/limited_curve.h"

namespace sbrdf::internal {
namespace {

struct Case {
  std::string name;
  Boundary boundary = Boundary::kBounded;
  double length = 0;
  std::vector<double> positions;
  std::vector<double> values;

  [[nodiscard]] std::size_t size() const { return positions.size(); }
  [[nodiscard]] std::size_t gap_count() const { return boundary == Boundary::kPeriodic ? size() : size() - 1; }
  [[nodiscard]] double end(std::size_t k) const { return k + 1 < size() ? positions[k + 1] : positions[0] + length; }
  [[nodiscard]] double next(std::size_t k) const { return values[(k + 1) % size()]; }
  [[nodiscard]] double width(std::size_t k) const { return end(k) - positions[k]; }
  [[nodiscard]] double line(std::size_t k) const { return (next(k) - values[k]) / width(k); }
};

/// The same samples with an even gap; the end of a periodic slice is not a sample.
template <class Function>
Case sampled(std::string name, Boundary boundary, double length, int gaps, const Function& f) {
  Case made = {std::move(name), boundary, length, {}, {}};
  for (int k = 0; k < gaps + (boundary == Boundary::kPeriodic ? 0 : 1); ++k) {
    made.positions.push_back(length * k / gaps);
    made.values.push_back(f(made.positions.back()));
  }
  return made;
}

std::vector<double> limited_slopes(const Case& given) {
  std::vector<double> slopes(given.size(), -77);
  SplineSolver<double>().solve(given.boundary, given.length, given.positions, given.values.data(), slopes.data(), 1);
  slopes_within_limits(given.boundary, given.length, given.positions, given.values.data(), slopes.data(), 1);
  return slopes;
}

DenseSpline dense(const Case& given) {
  return {given.boundary,
          given.length,
          {given.positions.begin(), given.positions.end()},
          {given.values.begin(), given.values.end()}};
}

std::vector<double> spline_slopes(const Case& given) {
  const DenseSpline spline = dense(given);
  std::vector<double> slopes;
  for (const double x : given.positions) slopes.push_back(static_cast<double>(spline(x, 1)));
  return slopes;
}

/// The straight lines in the gaps before and behind a gap, and the widths of these.
struct Beside {
  double before, behind, width_before, width_behind;

  Beside(const Case& given, std::size_t k) {
    const std::size_t last = given.gap_count() - 1;
    const bool periodic = given.boundary == Boundary::kPeriodic;
    const double beyond_an_end = given.boundary == Boundary::kMirrored ? -given.line(k) : given.line(k);
    const std::size_t left = k > 0 ? k - 1 : periodic ? last : k;
    const std::size_t right = k < last ? k + 1 : periodic ? 0 : k;
    before = k > 0 || periodic ? given.line(left) : beyond_an_end;
    behind = k < last || periodic ? given.line(right) : beyond_an_end;
    width_before = given.width(left);
    width_behind = given.width(right);
  }
};

// The definition in specs/conventions.md, written for one point of a gap.
struct Allowed {
  double low = 0;
  double high = 0;
};
Allowed allowed(const Case& given, std::size_t k, double x) {
  const auto [before, behind, width_before, width_behind] = Beside(given, k);
  const double y0 = given.values[k];
  const double y1 = given.next(k);
  const auto [least, most] = std::minmax({y0 - before * width_before, y0, y1, y1 + behind * width_behind});
  const double from_left = y0 + before * (x - given.positions[k]);
  const double from_right = y1 - behind * (given.end(k) - x);
  return {std::min({y0, y1, std::max(from_left, from_right)}) - 0.1 * (most - least),
          std::max({y0, y1, std::min(from_left, from_right)}) + 0.1 * (most - least)};
}

/// By how much the curve of a gap is above the highest or below the lowest that is allowed anywhere in it.
double excess_of_gap(const Case& given, std::size_t k, double slope0, double slope1) {
  const Beside beside(given, k);
  // Where the lines on both sides meet they allow most.
  const double w = given.width(k);
  const double meet = (given.next(k) - given.values[k] - beside.behind * w) / (beside.before - beside.behind);
  Allowed most = allowed(given, k, given.positions[k]);
  if (meet > 0 && meet < w) {
    const auto [low, high] = allowed(given, k, given.positions[k] + meet);
    most = {std::min(most.low, low), std::max(most.high, high)};
  }
  double excess = -1e9;
  for (int step = 1; step < 100; ++step) {
    const double y = evaluate_cubic(step / 100.0, w, given.values[k], given.next(k), slope0, slope1);
    excess = std::max({excess, y - most.high, most.low - y});
  }
  return excess;
}

/// By how much a curve leaves what is allowed, at most, over 1,000 places of the slice; 0 or less where it does not.
template <class Curve>
double excess(const Case& given, const Curve& curve) {
  double worst = -1e9;
  for (int step = 0; step < 1000; ++step) {
    const double total = given.end(given.gap_count() - 1) - given.positions[0];
    const double x = given.positions[0] + total * (step + 0.5) / 1000;
    std::size_t k = given.gap_count() - 1;
    while (given.positions[k] > x) --k;
    const auto [low, high] = allowed(given, k, x);
    const double y = curve(k, x);
    worst = std::max({worst, y - high, low - y});
  }
  return worst;
}

double excess_with(const Case& given, const std::vector<double>& slopes) {
  return excess(given, [&](std::size_t k, double x) {
    const double t = (x - given.positions[k]) / given.width(k);
    return evaluate_cubic(t, given.width(k), given.values[k], given.next(k), slopes[k], slopes[(k + 1) % given.size()]);
  });
}

/// Plateaus beside steep flanks, one for each way in which a slice ends; the flanks also at the ends.
std::vector<Case> plateaus() {
  const std::vector<double> even = {0, 10, 20, 30, 40, 50, 60, 70, 80};
  return {
      {"bounded", Boundary::kBounded, 80, even, {0, 0, 0, 0, 10, 10, 10, 10, 10}},
      {"bounded, uneven", Boundary::kBounded, 80, {0, 1, 30, 32, 40, 80}, {0, 0.1, 0.2, 8, 8.1, 9}},
      {"bounded, a plateau that is a slight crest",
       Boundary::kBounded,
       80,
       {0, 1, 30, 32, 40, 80},
       {0, 0.1, 0.2, 8, 8.1, 8}},
      {"bounded, a plateau that is a slight trough",
       Boundary::kBounded,
       80,
       {0, 40, 48, 50, 79, 80},
       {8, 7.9, 8, 15, 16, 17}},
      {"bounded, steep at the end", Boundary::kBounded, 80, even, {9, 0, 0, 0, 0, 0, 0, 0, -7}},
      {"mirrored", Boundary::kMirrored, 80, even, {0, 0, 0, 9, 9, 9, 1, 1, 1}},
      {"mirrored, steep at the end", Boundary::kMirrored, 80, even, {9, 0, 0, 0, 0, 0, 0, 0, 6}},
      {"mirrored, beside its mirror image", Boundary::kMirrored, 80, even, {5, 0, 8, -57, -57, -57, -57, -57, -57}},
      {"periodic", Boundary::kPeriodic, 90, even, {0, 0, 0, 10, 10, 10, 10, 0, 0}},
      {"periodic, steep across the period", Boundary::kPeriodic, 90, even, {10, 10, 10, 10, 10, 0, 0, 0, 0}},
  };
}

TEST(SlopeLimits, KeepACurveNearASteepFlankWhereItsSplineSwingsOut) {
  for (const Case& given : plateaus()) {
    SCOPED_TRACE(given.name);
    const DenseSpline spline = dense(given);
    EXPECT_GT(excess(given, [&](std::size_t, double x) { return static_cast<double>(spline(x)); }), 0.01);
    EXPECT_GT(excess_with(given, spline_slopes(given)), 0.01);
    EXPECT_LE(excess_with(given, limited_slopes(given)), 1e-12);
  }
}

TEST(SlopeLimits, LeaveASmoothCurveItsSpline) {
  const auto parabola = [](double x) { return 3 - 0.002 * (x - 37) * (x - 37); };
  const auto wave = [](double x) { return std::sin(radians_from_degrees(x) * 4 + 0.3); };
  const auto even_wave = [](double x) { return std::cos(radians_from_degrees(x) * 4); };
  const std::array cases = {
      sampled("parabola, bounded", Boundary::kBounded, 80, 80, parabola),
      sampled("sine, bounded", Boundary::kBounded, 80, 160, wave),
      sampled("sine, periodic", Boundary::kPeriodic, 360, 360, wave),
      sampled("cosine, mirrored", Boundary::kMirrored, 90, 90, even_wave),
  };
  for (const Case& given : cases) {
    SCOPED_TRACE(given.name);
    const std::vector<double> expected = spline_slopes(given);
    const std::vector<double> slopes = limited_slopes(given);
    for (std::size_t k = 0; k < given.size(); ++k) EXPECT_NEAR(slopes[k], expected[k], 1e-12) << k;
  }
}

TEST(SlopeLimits, CutWhatSwingsOutToWhatReachesTheSlack) {
  const Case given = plateaus().front();
  const std::vector<double> slopes = limited_slopes(given);
  for (std::size_t k = 2; k < 6; ++k) {  // beside the flank; farther out the spline hardly swings
    EXPECT_LT(std::abs(slopes[k]), std::abs(spline_slopes(given)[k])) << k;
  }
  // The flank rises by 10, and on the plateaus beside it 4 tenths of 10 over a gap of 10 are a tenth of 10.
  EXPECT_DOUBLE_EQ(slopes[3], 0.4);
  EXPECT_DOUBLE_EQ(slopes[4], 0.4);
}

/// Six samples with gaps from a tenth of a degree to 40 degrees; what lies between neighbours varies as much.
Case random_samples(std::mt19937_64& generator, Boundary boundary) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(generator);
  };
  const bool often_turns = uniform(0, 1) < 0.5;
  Case made = {"random", boundary, 0, {}, {}};
  double value = 0;
  for (int k = 0; k < 6; ++k) {
    made.positions.push_back(made.length);
    made.values.push_back(value);
    made.length += std::exp(uniform(std::log(0.1), std::log(40)));
    value += std::exp(uniform(-7, 2)) * (uniform(0, 1) < (often_turns ? 0.5 : 0.2) ? -1 : 1);
  }
  return made;
}

TEST(SlopeLimits, KeepEveryGapWithinWhatItMayWhateverTheSamples) {
  std::mt19937_64 generator(3);
  int spline_leaves = 0;
  for (int trial = 0; trial < 30000; ++trial) {
    const Case given = random_samples(generator, static_cast<Boundary>(trial % 3));
    const std::vector<double> spline = spline_slopes(given);
    const std::vector<double> slopes = limited_slopes(given);
    for (std::size_t k = 0; k < given.gap_count(); ++k) {
      const std::size_t next = (k + 1) % given.size();
      spline_leaves += excess_of_gap(given, k, spline[k], spline[next]) > 1e-9 ? 1 : 0;
      ASSERT_LE(excess_of_gap(given, k, slopes[k], slopes[next]), 1e-9) << "trial " << trial << ", gap " << k;
    }
  }
  EXPECT_GT(spline_leaves, 20000);
}

TEST(SlopeLimits, AreThoseOfThePage) {
  std::mt19937_64 generator(4);
  for (int trial = 0; trial < 3000; ++trial) {
    const Case given = random_samples(generator, static_cast<Boundary>(trial % 3));
    const LimitedCurve page(given.boundary, given.length, {given.positions.begin(), given.positions.end()},
                            {given.values.begin(), given.values.end()});
    const std::vector<double> slopes = limited_slopes(given);
    for (std::size_t k = 0; k < given.gap_count(); ++k) {
      for (const double t : {0.03, 0.2, 0.5, 0.9}) {
        const double y = evaluate_cubic(t, given.width(k), given.values[k], given.next(k), slopes[k],
                                        slopes[(k + 1) % given.size()]);
        const double expected = static_cast<double>(page(given.positions[k] + t * given.width(k)));
        ASSERT_NEAR(y, expected, 1e-8) << "trial " << trial << ", gap " << k;
      }
    }
  }
}

TEST(SlopeLimits, OfOneSampleAreZeroAndOfTwoThoseOfTheSpline) {
  for (const Boundary boundary : {Boundary::kPeriodic, Boundary::kMirrored, Boundary::kBounded}) {
    EXPECT_EQ(limited_slopes({"one", boundary, 360, {12}, {5}}), std::vector<double>{0});
    const Case two = {"two", boundary, boundary == Boundary::kPeriodic ? 160.0 : 80.0, {0, 80}, {1, 3}};
    const std::vector<double> expected = spline_slopes(two);
    const std::vector<double> slopes = limited_slopes(two);
    ASSERT_EQ(slopes.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(slopes[k], expected[k], 1e-14) << static_cast<int>(boundary);
  }
  const std::vector<double> line = limited_slopes({"line", Boundary::kBounded, 80, {0, 80}, {1, 3}});
  EXPECT_EQ(line, (std::vector<double>{0.025, 0.025}));
}

TEST(SlopeLimits, ReadAndWriteOneChannelOfInterleavedValues) {
  for (const Case& given : plateaus()) {
    SCOPED_TRACE(given.name);
    const std::size_t n = given.size();
    std::vector<double> values(3 * n, 1e9);
    std::vector<double> second(3 * n, -77);
    for (std::size_t k = 0; k < n; ++k) values[3 * k + 1] = given.values[k];
    SplineSolver<double>().solve(given.boundary, given.length, given.positions, values.data() + 1, second.data() + 1,
                                 3);
    slopes_within_limits(given.boundary, given.length, given.positions, values.data() + 1, second.data() + 1, 3);
    const std::vector<double> expected = limited_slopes(given);
    for (std::size_t k = 0; k < 3 * n; ++k) EXPECT_EQ(second[k], k % 3 == 1 ? expected[k / 3] : -77) << k;
  }
}

TEST(EvaluateCubic, HasTheValuesAndSlopesThatItWasGivenAtItsEnds) {
  const double width = 7;
  const auto y = [&](double t) { return evaluate_cubic(t, width, 2.0, -1.0, 0.4, 3.0); };
  EXPECT_EQ(y(0), 2);
  EXPECT_EQ(y(1), -1);
  const double step = 1e-6;
  EXPECT_NEAR((y(step) - y(0)) / (step * width), 0.4, 1e-5);
  EXPECT_NEAR((y(1) - y(1 - step)) / (step * width), 3.0, 1e-5);
  for (const double t : {0.1, 0.5, 0.9}) EXPECT_EQ(evaluate_cubic(t, width, 0.1, 0.1, 0.0, 0.0), 0.1);
}

}  // namespace
}  // namespace sbrdf::internal
