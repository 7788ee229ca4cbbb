// The shaders of atlases, run by a real driver, against the evaluator of the same atlas.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "codec/atlas/atlas_evaluator.h"
#include "codec/atlas/shader.h"
#include "codec/file/encoder.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/files/by_name.h"
#include "converters/models/kurt.h"
#include "converters/slicing/slicing.h"
#include "tests/gpu/gl_harness.h"
#include "tests/gpu/shader_checks.h"
#include "tests/support/test_data.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPairs = 100'000;

struct Pairs {
  std::vector<glm::vec3> i, v;
};

glm::vec3 unit(double theta_deg, double phi_deg) {
  const double theta = radians_from_degrees(theta_deg);
  const double phi = radians_from_degrees(phi_deg);
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// A third anywhere, a third about the mirror direction, a third with one direction near a pole, at the horizon, or on
/// a plane of symmetry.
Pairs draw_pairs() {
  std::mt19937 random(5);
  const auto share = [&] { return static_cast<double>(random()) / 4294967296.0; };
  Pairs pairs;
  for (std::size_t k = 0; k < kPairs; ++k) {
    double theta_i = 90 * share();
    const double phi_i = 360 * share();
    double theta_v = 90 * share();
    double phi_v = 360 * share();
    if (k % 3 == 1) {
      const double spread = 20 * share() * share() * share();
      theta_v = std::clamp(theta_i + spread * (share() - 0.5), 0.0, 90.0);
      phi_v = phi_i + 180 + spread * (share() - 0.5);
    } else if (k % 3 == 2) {
      const std::size_t where = k / 3 % 4;
      if (where == 0) theta_i = share() * share() * share();
      if (where == 1) theta_v = 90 - share() * share();
      if (where == 2) phi_v = phi_i + 90 * static_cast<double>(random() % 4);
      if (where == 3) theta_v = theta_i;
    }
    pairs.i.push_back(unit(theta_i, phi_i));
    pairs.v.push_back(unit(theta_v, phi_v));
  }
  return pairs;
}

GlTexture texture_of(const Texture& texture) {
  GlTexture gl;
  gl.name = "sbrdf_atlas";
  switch (texture.format) {
    case TexelFormat::kRgb32f:
      gl.format = GlFormat::kRgb32f;
      break;
    case TexelFormat::kRgba32f:
      gl.format = GlFormat::kRgba32f;
      break;
    case TexelFormat::kRgba16f:
      gl.format = GlFormat::kRgba16f;
      break;
    case TexelFormat::kE5b9g9r9:
      gl.format = GlFormat::kRgb9E5;
      break;
    case TexelFormat::kBc6hUnsigned:
      gl.format = GlFormat::kBc6hUnsigned;
      break;
    case TexelFormat::kBc6hSigned:
      gl.format = GlFormat::kBc6hSigned;
      break;
  }
  gl.width = static_cast<int>(texture.width);
  gl.height = static_cast<int>(texture.height);
  gl.bytes.resize(texture.bytes.size());
  std::memcpy(gl.bytes.data(), texture.bytes.data(), texture.bytes.size());
  return gl;
}

std::vector<float> run_shader(GlContext& context, const MadeAtlas& made, const Pairs& pairs) {
  std::vector<float> inputs;
  inputs.reserve(8 * pairs.i.size());
  for (std::size_t k = 0; k < pairs.i.size(); ++k) {
    for (const glm::vec3& w : {pairs.i[k], pairs.v[k]}) inputs.insert(inputs.end(), {w.x, w.y, w.z, 0.0F});
  }
  const std::string shader = atlas_shader(made.atlas) + "\nvec3 run(vec3 a, vec3 b) { return sbrdf_eval(a, b); }\n";
  const GlTexture texture = texture_of(made.texture);
  const Result<std::vector<float>> values = context.evaluate(shader, std::span(&texture, 1), inputs);
  EXPECT_TRUE(values) << values.error().message;
  return values ? *values : std::vector<float>(3 * pairs.i.size(), NAN);
}

struct Difference {
  double largest = 0;  ///< of a channel to the evaluator's largest there, or 1e-3 of the material's mean
  std::size_t at = 0;
  double mean = 0;
};

Difference difference(const MadeAtlas& made, const Pairs& pairs, const std::vector<float>& values) {
  const AtlasEvaluator evaluator(made.atlas);
  std::vector<float> expected(values.size());
  double mean = 0;
  for (std::size_t k = 0; k < pairs.i.size(); ++k) {
    const DirectionPair pair = {direction_from_vector(glm::dvec3(pairs.i[k])),
                                direction_from_vector(glm::dvec3(pairs.v[k]))};
    evaluator.evaluate(pair, std::span<float, 3>(expected.data() + 3 * k, 3));
    for (std::size_t c = 0; c < 3; ++c)
      mean += std::abs(double{expected[3 * k + c]}) / static_cast<double>(values.size());
  }
  Difference found;
  for (std::size_t k = 0; k < pairs.i.size(); ++k) {
    double scale = 1e-3 * mean;
    double error = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      scale = std::max(scale, std::abs(double{expected[3 * k + c]}));
      error = std::max(error, std::abs(double{values[3 * k + c]} - double{expected[3 * k + c]}));
    }
    // Where both lie on the horizon, opposite each other, the half vector is what rounding makes of it.
    const bool opposite = glm::length(pairs.i[k] + pairs.v[k]) < 0.01F;
    const double relative = std::isfinite(error) ? error / scale * (opposite ? 0.1 : 1) : 1e9;
    found.mean += relative / static_cast<double>(pairs.i.size());
    if (relative <= found.largest) continue;
    found.largest = relative;
    found.at = k;
  }
  return found;
}

std::string place(const Pairs& pairs, std::size_t k) {
  const auto text = [](const glm::vec3& w) {
    const Direction d = direction_from_vector(glm::dvec3(w));
    return std::to_string(degrees_from_radians(d.theta)) + ", " + std::to_string(degrees_from_radians(d.phi));
  };
  return "theta, phi [degrees] of i " + text(pairs.i[k]) + ", of v " + text(pairs.v[k]);
}

DecodedSliced sliced_of(const BrdfSource& source, const SliceOptions& options) {
  Result<Slicing> slicing = slice_source(source, options);
  if (!slicing) throw std::runtime_error(slicing.error().message);
  DecodedSliced decoded;
  decoded.sliced = std::move(slicing->sliced);
  decoded.lattice = std::move(slicing->lattice);
  return decoded;
}

void expect_shader_agrees(GlContext& context, const std::string& name, const DecodedSliced& sliced,
                          const BrdfSource& source, TexelFormat texel) {
  static const Pairs kDrawn = draw_pairs();
  AtlasOptions options;
  options.texel = texel;
  options.max_error_percent = 1;
  const Result<MadeAtlas> made = make_atlas(sliced, source, options);
  ASSERT_TRUE(made) << made.error().message;
  const std::vector<float> values = run_shader(context, *made, kDrawn);
  const Difference found = difference(*made, kDrawn, values);
  EXPECT_LE(found.largest, 2e-3) << name << " at " << place(kDrawn, found.at);
  EXPECT_LE(found.mean, 5e-5) << name;
}

const std::vector<std::string> kKurt = {"Brushed alum", "Purple satin", "Red velvet", "Yellow satin", "fabric002",
                                        "fabric041",    "fabric112",    "fabric135",  "fabric139",    "wood01"};

SliceOptions elevation_options() {
  SliceOptions options;
  options.stop = SampleCount{8911};
  options.structure = Placement{14, 36};
  options.domain = DomainKind::kLog;
  options.fit_values = false;
  options.precision = 0.001;
  return options;
}

class ShaderOfAtlas : public testing::TestWithParam<GlApi> {};
INSTANTIATE_TEST_SUITE_P(Languages, ShaderOfAtlas, testing::Values(GlApi::kCore45, GlApi::kEs30));

TEST_P(ShaderOfAtlas, AgreesInTheElevationFrame) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  for (const std::string& name : kKurt) {
    const auto source = make_kurt_source(kurt_material(name).value());
    expect_shader_agrees(context, name, sliced_of(*source, elevation_options()), *source, TexelFormat::kRgb32f);
  }
}

TEST_P(ShaderOfAtlas, AgreesInTheHalfDifferenceFrame) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  SliceOptions options;
  options.stop = SampleCount{1500};
  options.structure = SearchedStructure{.frame = FrameId::kHalfDifference, .evaluations = 20};
  for (const bool mirrors : {true, false}) {
    std::get<SearchedStructure>(options.structure).use_mirrors = mirrors;
    for (const char* name : {"Brushed alum", "fabric112"}) {
      const auto source = make_kurt_source(kurt_material(name).value());
      expect_shader_agrees(context, name, sliced_of(*source, options), *source, TexelFormat::kRgb32f);
    }
  }
}

TEST_P(ShaderOfAtlas, AgreesOnMeasuredMaterials) {
  SBRDF_MAKE_GL_CONTEXT(context, GetParam());
  SliceOptions options;
  options.stop = SampleCount{1500};
  for (const char* name : {"chm_mint_rgb.bsdf", "cc_green_malachite_rgb.bsdf"}) {
    SBRDF_FIND_TEST_DATA(path, std::string("rgl/") + name);
    const Result<OpenedSource> opened = open_source(path.string());
    ASSERT_TRUE(opened);
    const DecodedSliced sliced = sliced_of(*opened->source, options);
    for (const TexelFormat texel : {TexelFormat::kRgb32f, TexelFormat::kRgba16f, TexelFormat::kE5b9g9r9}) {
      expect_shader_agrees(context, name, sliced, *opened->source, texel);
    }
  }
}

TEST(ShaderText, CompilesInAllLanguages) {
  SBRDF_NEED_SHADER_PROGRAMS();
  SliceOptions half;
  half.stop = SampleCount{1000};
  half.structure = SearchedStructure{.frame = FrameId::kHalfDifference, .evaluations = 20};
  const auto source = make_kurt_source(kurt_material("fabric112").value());
  for (const SliceOptions& options : {elevation_options(), half}) {
    const DecodedSliced sliced = sliced_of(*source, options);
    const Result<MadeAtlas> made =
        make_atlas(sliced, *source, {.texel = TexelFormat::kE5b9g9r9, .max_error_percent = 3});
    ASSERT_TRUE(made);
    const std::string shader = atlas_shader(made->atlas);
    const std::string end =
        "\nin vec3 w_i;\nin vec3 w_v;\nout vec4 colour;\nvoid main() { colour = vec4(sbrdf_eval(w_i, w_v), 1.0); }\n";
    const std::string precise = "precision highp float;\nprecision highp int;\n";
    for (const ShaderTarget target : {ShaderTarget::kLanguage, ShaderTarget::kOpenGl, ShaderTarget::kVulkan}) {
      const ShaderCheck check = check_glsl(ShaderStage::kFragment, "#version 450\n" + shader + end, target);
      EXPECT_EQ(check.exit_code, 0) << check.output;
    }
    for (const char* version : {"#version 330\n", "#version 300 es\n"}) {
      const ShaderCheck check =
          check_glsl(ShaderStage::kFragment, version + precise + shader + end, ShaderTarget::kLanguage);
      EXPECT_EQ(check.exit_code, 0) << version << check.output;
    }
    const Result<std::string> hlsl = glsl_to_hlsl(ShaderStage::kFragment, "#version 450\n" + shader + end);
    ASSERT_TRUE(hlsl) << hlsl.error().message;
    const ShaderCheck check = check_hlsl(ShaderStage::kFragment, *hlsl);
    EXPECT_EQ(check.exit_code, 0) << check.output;
  }
}

}  // namespace
}  // namespace sbrdf::internal
