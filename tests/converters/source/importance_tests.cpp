// Drawing from analytic and measured materials; tests/benchmarks/importance_benchmark.cpp does the same for all of
// them.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "codec/search/random_pairs.h"
#include "converters/files/rgl/rgl.h"
#include "converters/judge/albedo.h"
#include "converters/models/analytic.h"
#include "converters/source/vector_brdf.h"
#include "tests/support/hemisphere_bins.h"
#include "tests/support/test_data.h"

namespace sbrdf::internal {
namespace {

/// Of a million directions that were drawn.
struct Drawn {
  double chance = 0;         ///< of a larger chi-square
  double integral = 0;       ///< of the density
  std::vector<double> mean;  ///< of f_r cos / pdf, channel by channel
  std::vector<double> error;
  double variance = 0;  ///< of the mean of the channels
  double cosine_variance = 0;
};

Drawn draw(const BrdfSource& source, const ImportanceTable& table, const Direction& light) {
  constexpr std::size_t kCount = 1'000'000;
  const glm::vec3 w_i(vector_from_direction(light));
  const auto density = [&](const glm::dvec3& w) { return static_cast<double>(table.pdf(w_i, glm::vec3(w))); };
  const HemisphereBins bins(density, {-w_i.x, -w_i.y, w_i.z}, 1.0 / 128, 4e-6);
  std::vector<glm::vec3> w_v;
  std::vector<double> pdf;
  std::vector<double> counts(bins.masses().size());
  std::mt19937_64 random(1);
  for (std::size_t k = 0; k < kCount; ++k) {
    const double u = draw_uniform(random, 1);
    const DrawnDirection one = table.sample(w_i, {u, draw_uniform(random, 1)});
    ++counts[bins.find(glm::dvec3(one.w_v))];
    w_v.push_back(one.w_v);
    pdf.push_back(static_cast<double>(one.pdf));
  }
  const std::size_t channels = source.channel_count();
  std::vector<float> values(kCount * channels);
  vector_brdf_of(source).evaluate(std::vector<glm::vec3>(kCount, w_i), w_v, values);

  Drawn drawn = {chi_square_chance(bins.masses(), counts), bins.total(), {}, {}, 0, 0};
  std::vector<double> sums(channels + 1);
  std::vector<double> squares(channels + 1);
  double cosine_squares = 0;
  for (std::size_t k = 0; k < kCount; ++k) {
    const double scale = static_cast<double>(w_v[k].z) / pdf[k];
    double all = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      const double weight = static_cast<double>(values[k * channels + c]) * scale;
      all += weight / static_cast<double>(channels);
      sums[c] += weight;
      squares[c] += weight * weight;
    }
    sums[channels] += all;
    squares[channels] += all * all;
    cosine_squares += all * all / scale * kPi;  // of f_r pi with the density cos / pi
  }
  const auto variance = [&](double sum, double square) { return square / kCount - sum / kCount * sum / kCount; };
  for (std::size_t c = 0; c < channels; ++c) {
    drawn.mean.push_back(sums[c] / kCount);
    drawn.error.push_back(std::sqrt(variance(sums[c], squares[c]) / kCount));
  }
  drawn.variance = variance(sums[channels], squares[channels]);
  drawn.cosine_variance = variance(sums[channels], cosine_squares);
  return drawn;
}

void check(const BrdfSource& source, const std::string& name) {
  const ImportanceTable table = make_importance_table(vector_brdf_of(source));
  for (const double theta_deg : {30.0, 85.0}) {
    SCOPED_TRACE(name + " at " + std::to_string(theta_deg));
    const Direction light = direction_from_degrees(theta_deg, 20);
    const Drawn drawn = draw(source, table, light);
    EXPECT_GT(drawn.chance, 1e-4);
    EXPECT_NEAR(drawn.integral, 1, 0.001);
    EXPECT_LT(drawn.variance, 0.1 * drawn.cosine_variance);
    const Albedo albedo = directional_albedo(source, light, {1e-4, 4'000'000});
    for (std::size_t c = 0; c < drawn.mean.size(); ++c) {
      EXPECT_LT(albedo.error[c], 1e-3) << "channel " << c;
      EXPECT_NEAR(drawn.mean[c], albedo.total(c), 5 * drawn.error[c] + albedo.error[c]) << "channel " << c;
    }
  }
}

TEST(ImportanceOfSources, DrawsAnalyticMaterialsAsTheyShine) {
  for (const char* const name : {"brushed alum", "fabric135"}) {
    check(*make_analytic_source(kurt_material(name).value()), name);
  }
}

TEST(ImportanceOfSources, DrawsMeasuredMaterialsAsTheyShine) {
  for (const char* const name : {"rgl/chm_orange_rgb.bsdf", "rgl/cc_green_malachite_rgb.bsdf"}) {
    SBRDF_FIND_TEST_DATA(file, name);
    const auto source = load_rgl(read_bytes(file));
    ASSERT_TRUE(source.ok());
    check(*source.value(), name);
  }
}

}  // namespace
}  // namespace sbrdf::internal
