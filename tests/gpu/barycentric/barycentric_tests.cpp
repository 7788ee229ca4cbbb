// The baseline's shader, run by a real driver.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "converters/models/analytic.h"
#include "tests/gpu/barycentric/barycentric.h"
#include "tests/gpu/gl_harness.h"
#include "tests/gpu/shader_checks.h"

namespace sbrdf::internal {
namespace {

const char* const kRun = "\nvec3 run(vec3 a, vec3 b) { return barycentric_eval(a, b); }\n";

std::vector<float> run_shader(GlContext& context, const Barycentric& barycentric, const std::vector<glm::vec3>& i,
                              const std::vector<glm::vec3>& v) {
  std::vector<float> inputs;
  for (std::size_t k = 0; k < i.size(); ++k) {
    for (const glm::vec3& w : {i[k], v[k]}) inputs.insert(inputs.end(), {w.x, w.y, w.z, 0.0F});
  }
  const std::vector<GlTexture> textures = barycentric.textures();
  const auto values = context.evaluate(Barycentric::shader() + kRun, textures, inputs);
  EXPECT_TRUE(values) << values.error().message;
  return values ? *values : std::vector<float>(3 * i.size(), NAN);
}

/// Anywhere but near the borders of texels, where rounding decides which of two is read.
glm::vec3 draw_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  while (true) {
    const glm::vec3 w = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    const glm::dvec2 at = cube_place(glm::dvec3(w), BarycentricCube::kFaceSide).at;
    const glm::dvec2 off = glm::abs(at - glm::round(at));
    if (w.z > -0.2F && std::min(off.x, off.y) > 0.01) return w;
  }
}

double worst_relative(const std::vector<float>& values, const std::vector<float>& expected) {
  double worst = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double error = std::abs(double{values[k]} - double{expected[k]});
    worst = std::max(worst, std::isfinite(error) ? error / std::max(std::abs(double{expected[k]}), 1e-6) : 1e9);
  }
  return worst;
}

TEST(BarycentricShader, AgreesWithTheProcessor) {
  SBRDF_MAKE_GL_CONTEXT(context, GlApi::kCore45);
  const auto source = make_analytic_source(kurt_material("fabric112").value());
  const Barycentric barycentric(*source, paper_scheme("14").value());
  std::mt19937 random(4);
  std::vector<glm::vec3> i, v;
  std::vector<float> expected;
  for (int trial = 0; trial < 20'000; ++trial) {
    i.push_back(draw_direction(random));
    v.push_back(draw_direction(random));
    const std::array<float, 3> value = barycentric.evaluate(i.back(), v.back());
    expected.insert(expected.end(), value.begin(), value.end());
  }
  EXPECT_LE(worst_relative(run_shader(context, barycentric, i, v), expected), 1e-5);
}

TEST(BarycentricShader, GivesBackWhatWasSampled) {
  SBRDF_MAKE_GL_CONTEXT(context, GlApi::kCore45);
  const auto source = make_analytic_source(kurt_material("Yellow satin").value());
  const Barycentric barycentric(*source, paper_scheme("14").value());
  std::vector<glm::vec3> i, v;
  std::vector<DirectionPair> pairs;
  for (const glm::dvec3& a : barycentric.directions()) {
    for (const glm::dvec3& b : barycentric.directions()) {
      i.emplace_back(a);
      v.emplace_back(b);
      pairs.push_back({direction_from_vector(a), direction_from_vector(b)});
    }
  }
  std::vector<float> expected(3 * pairs.size());
  source->evaluate(pairs, expected);
  EXPECT_LE(worst_relative(run_shader(context, barycentric, i, v), expected), 1e-5);
}

TEST(BarycentricShader, TakesTheBytesOfTable5) {
  const auto source = make_analytic_source(kurt_material("wood01").value());
  EXPECT_EQ(Barycentric(*source, paper_scheme("14").value()).table_5_bytes(), 3'645'876U);  // 3.5 MB
}

TEST(BarycentricShader, CompilesForVulkan) {
  SBRDF_NEED_SHADER_PROGRAMS();
  const ShaderCheck check = check_glsl(ShaderStage::kFragment,
                                       "#version 450\n" + Barycentric::shader() +
                                           "in vec3 w_i;\nin vec3 w_v;\nout vec4 colour;\n"
                                           "void main() { colour = vec4(barycentric_eval(w_i, w_v), 1.0); }\n",
                                       ShaderTarget::kVulkan);
  EXPECT_EQ(check.exit_code, 0) << check.output;
}

}  // namespace
}  // namespace sbrdf::internal
