#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "converters/files/rgl/rgl.h"
#include "converters/files/rgl/rgl_writer.h"
#include "formats/core/directions.h"
#include "tests/support/function_source.h"
#include "tests/support/test_data.h"

namespace sbrdf::internal {
namespace {

std::unique_ptr<BrdfSource> write_and_read(const BrdfSource& source, const Options& options) {
  MemorySink sink;
  Report report;
  const Status saved = save_rgl(source, sink, options, report);
  EXPECT_TRUE(saved.ok()) << saved.error().message;
  return load_rgl(std::move(sink).take()).value();
}

/// A bounded lobe, `a` wide along the tangent and `b` across it, on a diffuse base; smooth up to the horizon.
FunctionSource smooth(double a, double b) {
  return FunctionSource(
      [=](const DirectionPair& pair, std::size_t channel) {
        const glm::dvec3 i = vector_from_direction(pair.i);
        const glm::dvec3 v = vector_from_direction(pair.v);
        const glm::dvec3 h = {i.x + v.x, i.y + v.y, i.z + v.z};
        const double stretched =
            (h.x * h.x / (a * a) + h.y * h.y / (b * b) + h.z * h.z) / (h.x * h.x + h.y * h.y + h.z * h.z);
        return 0.1 * double(1 + channel) + 1 / (a * b * stretched * stretched * (0.3 + i.z) * (0.3 + v.z));
      },
      {a == b, true, {"R", "G", "B"}});
}

DirectionPair pair_of(double theta_i, double phi_i, double theta_v, double phi_v) {
  return {{radians_from_degrees(theta_i), radians_from_degrees(phi_i)},
          {radians_from_degrees(theta_v), radians_from_degrees(phi_v)}};
}

/// Least and largest of what came back over the source, of random pairs with these theta_v and theta_i up to 80
/// degrees.
struct Ratios {
  double least = 1e30;
  double largest = -1e30;
};
Ratios ratios(const BrdfSource& source, const BrdfSource& back, double theta_from, double theta_to) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> theta_v(theta_from, theta_to);
  std::uniform_real_distribution<double> theta_i(0, 80);
  std::uniform_real_distribution<double> phi(0, 360);
  Ratios result;
  for (int n = 0; n < 30000; ++n) {
    const DirectionPair pair = pair_of(theta_i(random), phi(random), theta_v(random), phi(random));
    std::array<float, 3> expected{};
    std::array<float, 3> found{};
    source.evaluate(std::span(&pair, 1), expected);
    back.evaluate(std::span(&pair, 1), found);
    for (std::size_t c = 0; c < 3; ++c) {
      result.least = std::min<double>(result.least, found[c] / expected[c]);
      result.largest = std::max<double>(result.largest, found[c] / expected[c]);
    }
  }
  return result;
}

TEST(RglGrazing, ASmoothIsotropicMaterialComesBackUpToTheHorizon) {
  const FunctionSource source = smooth(0.3, 0.3);
  const auto back = write_and_read(source, {});
  const Ratios measured = ratios(source, *back, 60, 80);
  EXPECT_GT(measured.least, 0.97);
  EXPECT_LT(measured.largest, 1.03);
  const Ratios beyond = ratios(source, *back, 80, 89);
  EXPECT_GT(beyond.least, 0.5);
  EXPECT_LT(beyond.largest, 1.5);
}

TEST(RglGrazing, ASmoothAnisotropicMaterialComesBackUpToTheHorizon) {
  const FunctionSource source = smooth(0.5, 0.35);
  const auto back = write_and_read(source, {});
  const Ratios measured = ratios(source, *back, 60, 80);
  EXPECT_GT(measured.least, 0.95);
  EXPECT_LT(measured.largest, 1.05);
  const Ratios beyond = ratios(source, *back, 80, 89);
  EXPECT_GT(beyond.least, 0.0);
  EXPECT_LT(beyond.largest, 2.0);
}

TEST(RglGrazing, PeaksHalfADegreeWideComeBackAtTheNormalToo) {
  SBRDF_FIND_TEST_DATA(path, "rgl/chm_orange_rgb.bsdf");
  const auto source = load_rgl(read_bytes(path)).value();
  const auto back = write_and_read(*source, Options().set("rgl-theta", "24"));
  std::vector<DirectionPair> grid;  // with the peaks among its nodes
  for (int n = 0; n < 21 * 21 * 18; ++n) grid.push_back(pair_of(n / 378 * 4, 0, n / 18 % 21 * 4, n % 18 * 20));
  std::vector<float> expected(3 * grid.size());
  std::vector<float> found(expected.size());
  source->evaluate(grid, expected);
  back->evaluate(grid, found);
  double difference = 0;
  double sum = 0;
  for (std::size_t n = 0; n < expected.size(); ++n) {
    difference += std::abs(expected[n] - found[n]);
    sum += std::abs(expected[n]);
  }
  EXPECT_LT(difference, 0.01 * sum);
}

}  // namespace
}  // namespace sbrdf::internal
