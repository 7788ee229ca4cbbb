#include "converters/bench/timing.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "converters/bench/yardstick.h"

namespace sbrdf::internal {
namespace {

TEST(BenchTiming, TakesTheMedianOfWhatWorkTells) {
  int call = 0;
  const std::array<double, 3> told = {7, 1, 3};  // so long that one call is enough for a repetition
  const TimedWork work = {[&]() -> std::optional<double> { return told.at(static_cast<std::size_t>(call++) % 3); },
                          Clock::kTold};
  EXPECT_EQ(median_seconds(std::span(&work, 1), {3, 1e-3}), std::vector<double>{3});
  EXPECT_EQ(call, 3);
}

TEST(BenchTiming, KeepsTheOrderOfTheWorksHoweverTheyAreMixed) {
  std::vector<TimedWork> works;
  for (int k = 0; k < 12; ++k) {
    works.push_back({[k]() -> std::optional<double> { return 1.0 + k; }, Clock::kTold});
  }
  const std::vector<double> seconds = median_seconds(works, {3, 1e-3});
  ASSERT_EQ(seconds.size(), works.size());
  for (std::size_t k = 0; k < seconds.size(); ++k) EXPECT_EQ(seconds[k], 1.0 + static_cast<double>(k));
}

TEST(BenchTiming, GivesUpWorkThatTellsNothing) {
  int calls = 0;
  const std::array works = {
      TimedWork{[&]() -> std::optional<double> { return ++calls < 3 ? std::optional(1.0) : std::nullopt; },
                Clock::kTold},
      TimedWork{[&]() -> std::optional<double> { return std::nullopt; }, Clock::kTold}};
  const std::vector<double> seconds = median_seconds(works, {5, 10.0});
  EXPECT_LT(calls, 20);
  EXPECT_EQ(seconds, (std::vector<double>{0, 0}));
}

TEST(BenchTiming, TellsWorkFromTenTimesAsMuch) {
  const auto spin = [](int rounds) {
    return TimedWork{[rounds]() -> std::optional<double> {
      volatile double sum = 0;
      for (int k = 0; k < rounds; ++k) sum = sum + std::sqrt(static_cast<double>(k));
      return std::nullopt;
    }};
  };
  const std::array works = {spin(10'000), spin(100'000)};
  const std::vector<double> seconds = median_seconds(works, {5, 1e-3});
  EXPECT_GT(seconds[0], 0);
  EXPECT_GT(seconds[1] / seconds[0], 3);
}

/// Numbers that are a cell's place along one axis, so that a look-up says where it looked [cells].
TrilinearTable<double> places_along(std::size_t axis) {
  using Lookup = TrilinearTable<double>;
  std::vector<double> numbers(3 * Lookup::kCells);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const std::size_t cell = k % Lookup::kCells;
    const std::array<std::size_t, 3> at = {cell / (90 * 180), cell / 180 % 90, cell % 180};
    numbers[k] = static_cast<double>(at.at(axis)) + 1000.0 * static_cast<double>(k / Lookup::kCells);
  }
  return TrilinearTable<double>(std::move(numbers));
}

glm::vec3 vector_at(double theta_deg, double phi_deg) {
  const double theta = theta_deg * 3.14159265358979323846 / 180;
  const double phi = phi_deg * 3.14159265358979323846 / 180;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

TEST(Yardstick, LooksWhereTheAnglesAre) {
  // i and v mirror each other: the half vector is the normal, theta_d is theta. 30 degrees are 30 cells.
  const glm::vec3 mirrored = places_along(1).look_up(vector_at(30, 20), vector_at(30, 200));
  EXPECT_NEAR(mirrored.x, 30, 1e-3);
  EXPECT_NEAR(mirrored.y, 1030, 1e-3);
  EXPECT_NEAR(mirrored.z, 2030, 1e-3);
  // An arc cosine of floats next to 1 is off by 3e-4, of which the table takes the root.
  EXPECT_LT(places_along(0).look_up(vector_at(30, 20), vector_at(30, 200)).x, 2);
  // i = v: theta_h is theta; its cells grow with the square, 90 sqrt(40 / 90).
  EXPECT_NEAR(places_along(0).look_up(vector_at(40, 75), vector_at(40, 75)).x, 60, 1e-2);
  // In the plane of the normal, to both sides of a half vector at 20 degrees: phi_d 0, or half a turn, which is the
  // same.
  const float phi_d = places_along(2).look_up(vector_at(50, 10), vector_at(10, 190)).x;
  EXPECT_NEAR(std::remainder(phi_d, 180.0F), 0, 1.001);
  // Across that plane: phi_d is 90 degrees, 90 cells of 180.
  const glm::vec3 h = vector_at(20, 0);
  const glm::vec3 across(0, 1, 0);
  EXPECT_NEAR(places_along(2).look_up(glm::normalize(h + 0.4F * across), glm::normalize(h - 0.4F * across)).x, 90,
              1e-2);
}

TEST(Yardstick, IsTheSameOfHalfFloatsWhereTheseHoldTheNumbers) {
  std::vector<double> doubles(3 * TrilinearTable<double>::kCells);
  std::vector<HalfNumber> halves;
  for (std::size_t k = 0; k < doubles.size(); ++k) {
    doubles[k] = static_cast<double>(k % 512) / 256;
    halves.push_back({half_from_float(static_cast<float>(doubles[k]))});
  }
  const TrilinearTable<double> wide(doubles);
  const TrilinearTable<HalfNumber> narrow(halves);
  for (const double theta : {5.0, 33.0, 71.0}) {
    const glm::vec3 i = vector_at(theta, 12), v = vector_at(80 - theta, 130);
    EXPECT_EQ(wide.look_up(i, v), narrow.look_up(i, v)) << theta;
  }
}

}  // namespace
}  // namespace sbrdf::internal
