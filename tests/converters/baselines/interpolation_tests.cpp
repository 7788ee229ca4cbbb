// Uniform samples, interpolated in both ways.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "converters/baselines/rbf.h"
#include "converters/baselines/scheme_samples.h"
#include "converters/baselines/triangulation.h"
#include "converters/models/analytic.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

const std::vector<Interpolation> kEach = {{Interpolation::Kind::kBarycentric},
                                          {Interpolation::Kind::kRbf, RbfKernel::kLinear},
                                          {Interpolation::Kind::kRbf, RbfKernel::kCubic},
                                          {Interpolation::Kind::kRbf, RbfKernel::kThinPlate},
                                          {Interpolation::Kind::kRbf, RbfKernel::kInverseMultiquadric}};

std::unique_ptr<BrdfSource> satin() { return make_analytic_source(kurt_material("Purple satin").value()); }

UniformScheme small_scheme() { return {"small", {{0, 1}, {35, 5}, {80, 8}}}; }

std::unique_ptr<SchemeSource> interpolated(const UniformScheme& scheme, const Interpolation& how) {
  return SchemeSource::make(sample_scheme(*satin(), scheme).value(), how).value();
}

glm::dvec3 anywhere_above(std::mt19937& random) {
  std::uniform_real_distribution<double> theta(0, 80);
  std::uniform_real_distribution<double> phi(0, 360);
  const double first = theta(random);
  return vector_from_direction(direction_from_degrees(first, phi(random)));
}

std::vector<float> value_of_pair(const BrdfSource& source, const glm::dvec3& i, const glm::dvec3& v) {
  std::vector<float> values(source.channel_count());
  const DirectionPair pair = {direction_from_vector(i), direction_from_vector(v)};
  source.evaluate(std::span(&pair, 1), values);
  return values;
}

TEST(UniformSamples, AreThoseOfTheSource) {
  const auto source = satin();
  const UniformScheme scheme = paper_scheme("2").value();
  const SchemeSamples samples = sample_scheme(*source, scheme).value();
  const std::vector<glm::dvec3> w = scheme_directions(scheme);
  ASSERT_EQ(samples.values.size(), 3 * 703U);
  for (const auto& [a, b] :
       std::vector<std::pair<std::size_t, std::size_t>>{{0, 0}, {3, 1}, {1, 3}, {36, 36}, {20, 7}}) {
    const std::vector<float> expected = value_of_pair(*source, w[a], w[b]);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(samples.values[3 * pair_number(a, b) + c], expected[c], 1e-6);
  }
}

TEST(UniformSamples, ComeBackFromEveryInterpolation) {
  for (const Interpolation& how : kEach) {
    for (const UniformScheme& scheme : {small_scheme(), paper_scheme("2").value()}) {
      const auto source = interpolated(scheme, how);
      const std::vector<glm::dvec3> w = scheme_directions(scheme);
      for (std::size_t a = 0; a < w.size(); ++a) {
        for (std::size_t b = 0; b < w.size(); ++b) {
          const std::vector<float> values = value_of_pair(*source, w[a], w[b]);
          for (std::size_t c = 0; c < 3; ++c) {
            const float sample = source->samples().values[3 * pair_number(a, b) + c];
            ASSERT_NEAR(values[c], sample, 2e-6 * std::max(1.0F, std::abs(sample)))
                << source->traits().description << ' ' << a << ' ' << b;
          }
        }
      }
    }
  }
}

TEST(UniformSamples, AreReciprocalTheSameInBatchesAndZeroBelowTheHorizon) {
  std::mt19937 random(7);
  for (const Interpolation& how : kEach) {
    const auto source = interpolated(paper_scheme("4").value(), how);
    EXPECT_TRUE(source->traits().reciprocal);
    std::vector<glm::vec3> i;
    std::vector<glm::vec3> v;
    for (int k = 0; k < 700; ++k) {
      i.emplace_back(k % 3 == 0 && k > 0 ? glm::dvec3(i.back()) : anywhere_above(random));  // runs of the same light
      v.emplace_back(anywhere_above(random));
      if (k % 11 == 5) v.back().z = -v.back().z - 0.01F;
    }
    std::vector<float> together(3 * i.size());
    source->evaluate_vectors(i, v, together);
    for (std::size_t k = 0; k < i.size(); ++k) {
      std::array<float, 3> alone{};
      std::array<float, 3> back{};
      source->evaluate_vectors(std::span(&i[k], 1), std::span(&v[k], 1), alone);
      source->evaluate_vectors(std::span(&v[k], 1), std::span(&i[k], 1), back);
      for (std::size_t c = 0; c < 3; ++c) {
        if (v[k].z < 0) {
          ASSERT_EQ(alone[c], 0);
          ASSERT_EQ(together[3 * k + c], 0);
        }
        ASSERT_EQ(together[3 * k + c], alone[c]) << source->traits().description;
        ASSERT_NEAR(back[c], alone[c], 1e-5 * std::abs(alone[c]) + 1e-7);
      }
    }
  }
}

// The sum over three times three samples, from all triangles tried one by one.
TEST(Barycentric, IsTheMeanOfNineSamples) {
  std::mt19937 random(8);
  const UniformScheme scheme = small_scheme();
  const auto source = interpolated(scheme, kEach[0]);
  const Triangulation triangulation = Triangulation::make(scheme).value();
  const auto w = triangulation.directions();
  const auto weights_of = [&](const glm::dvec3& asked) {
    std::vector<double> weights(w.size(), 0.0);
    for (const Triangle& t : triangulation.triangles()) {
      const glm::dvec3 in = {glm::dot(asked, glm::cross(w[t[1]], w[t[2]])),
                             glm::dot(asked, glm::cross(w[t[2]], w[t[0]])),
                             glm::dot(asked, glm::cross(w[t[0]], w[t[1]]))};
      if (std::min({in.x, in.y, in.z}) < 0) continue;
      const double sum = in.x + in.y + in.z;
      weights[t[0]] = in.x / sum;
      weights[t[1]] = in.y / sum;
      weights[t[2]] = in.z / sum;
      return weights;
    }
    return std::vector<double>();
  };
  int compared = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const glm::dvec3 i = anywhere_above(random);
    const glm::dvec3 v = anywhere_above(random);
    const std::vector<double> a = weights_of(i);
    const std::vector<double> b = weights_of(v);
    if (a.empty() || b.empty()) continue;  // between the last ring and its polygon
    ++compared;
    const std::vector<float> values = value_of_pair(*source, i, v);
    for (std::size_t c = 0; c < 3; ++c) {
      double expected = 0;
      for (std::size_t j = 0; j < w.size(); ++j) {
        for (std::size_t k = 0; k < w.size(); ++k) {
          expected += a[j] * b[k] * source->samples().values[3 * pair_number(j, k) + c];
        }
      }
      ASSERT_NEAR(values[c], expected, 1e-5 * std::abs(expected));
    }
  }
  EXPECT_GT(compared, 500);
}

/// Solves A x = b in long double by elimination.
std::vector<long double> eliminated(std::vector<std::vector<long double>> a, std::vector<long double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t r = k; r < n; ++r) pivot = std::abs(a[r][k]) > std::abs(a[pivot][k]) ? r : pivot;
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t r = k + 1; r < n; ++r) {
      const long double factor = a[r][k] / a[k][k];
      for (std::size_t c = k; c < n; ++c) a[r][c] -= factor * a[k][c];
      b[r] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t c = k + 1; c < n; ++c) b[k] -= a[k][c] * b[c];
    b[k] /= a[k][k];
  }
  return b;
}

// One direction after the other: for each sampled light an interpolant over the viewer, and one over the lights of
// what these say.
TEST(Rbf, InterpolatesLightAndViewerOneAfterTheOther) {
  const UniformScheme scheme = small_scheme();
  const std::vector<glm::dvec3> w = scheme_directions(scheme);
  std::mt19937 random(9);
  for (std::size_t kind = 1; kind < kEach.size(); ++kind) {
    const auto phi = [&](const glm::dvec3& a, const glm::dvec3& b) -> long double {
      const long double r = glm::length(a - b);
      switch (kEach[kind].kernel) {
        case RbfKernel::kLinear:
          return r;
        case RbfKernel::kCubic:
          return r * r * r;
        case RbfKernel::kThinPlate:
          return r > 0 ? r * r * std::log(r) : 0;
        case RbfKernel::kInverseMultiquadric:
          break;
      }
      return 1 / std::sqrt(r * r + 0.09L);
    };
    const auto polynomial = [&](const glm::dvec3& at) -> std::vector<long double> {
      if (kEach[kind].kernel == RbfKernel::kInverseMultiquadric) return {};
      if (kEach[kind].kernel == RbfKernel::kLinear) return {1};
      return {1, at.x, at.y, at.z};
    };
    const auto interpolate = [&](std::vector<long double> values, const glm::dvec3& at) {
      const std::vector<long double> terms = polynomial(at);
      const std::size_t n = w.size() + terms.size();
      values.resize(n, 0);
      std::vector<std::vector<long double>> a(n, std::vector<long double>(n, 0));
      for (std::size_t j = 0; j < w.size(); ++j) {
        for (std::size_t k = 0; k < w.size(); ++k) a[j][k] = phi(w[j], w[k]);
        for (std::size_t k = 0; k < terms.size(); ++k) a[j][w.size() + k] = a[w.size() + k][j] = polynomial(w[j])[k];
      }
      const std::vector<long double> coefficients = eliminated(a, values);
      long double sum = 0;
      for (std::size_t k = 0; k < w.size(); ++k) sum += coefficients[k] * phi(w[k], at);
      for (std::size_t k = 0; k < terms.size(); ++k) sum += coefficients[w.size() + k] * terms[k];
      return sum;
    };
    const auto source = interpolated(scheme, kEach[kind]);
    for (int trial = 0; trial < 20; ++trial) {
      const glm::dvec3 i = anywhere_above(random);
      const glm::dvec3 v = anywhere_above(random);
      std::vector<long double> over_lights;
      for (std::size_t j = 0; j < w.size(); ++j) {
        std::vector<long double> row;
        for (std::size_t k = 0; k < w.size(); ++k) row.push_back(source->samples().values[3 * pair_number(j, k)]);
        over_lights.push_back(interpolate(row, v));
      }
      const auto expected = static_cast<double>(interpolate(over_lights, i));
      ASSERT_NEAR(value_of_pair(*source, i, v)[0], expected, 1e-5 * std::abs(expected) + 1e-6);
    }
  }
}

TEST(UniformSamples, RefuseWhatWasNotMeasured) {
  /// Measured up to 60 degrees only.
  class Half final : public BrdfSource {
   public:
    Half() {
      traits_.channels = {"Y"};
      traits_.reciprocal = true;
    }
    const SourceTraits& traits() const override { return traits_; }
    void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
      std::fill_n(values.begin(), pairs.size(), 1.0F);
    }
    void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override {
      for (std::size_t k = 0; k < pairs.size(); ++k)
        flags[k] = pairs[k].v.theta < 1.05 && pairs[k].i.theta < 1.05 ? 1 : 0;
    }
    std::optional<MaskGrid> mask_grid() const override { return MaskGrid(); }

   private:
    SourceTraits traits_;
  };
  const Result<SchemeSamples> samples = sample_scheme(Half(), small_scheme());
  ASSERT_FALSE(samples);
  EXPECT_EQ(samples.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(samples.error().message, "84 of the scheme's 105 pairs were not measured");
}

}  // namespace
}  // namespace sbrdf::internal
