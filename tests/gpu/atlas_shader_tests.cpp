// The shaders of atlases, run by a real driver, against the evaluator of the same atlas.
#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "codec/atlas/shader.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/files/by_name.h"
#include "converters/models/analytic.h"
#include "tests/gpu/atlas_checks.h"
#include "tests/gpu/gl_harness.h"
#include "tests/gpu/shader_checks.h"
#include "tests/support/test_data.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kPairs = 100'000;

std::string place(const Pairs& pairs, std::size_t k) {
  const auto text = [](const glm::vec3& w) {
    const Direction d = direction_from_vector(glm::dvec3(w));
    return std::to_string(degrees_from_radians(d.theta)) + ", " + std::to_string(degrees_from_radians(d.phi));
  };
  return "theta, phi [degrees] of i " + text(pairs.i[k]) + ", of v " + text(pairs.v[k]);
}

DecodedSliced slices_or_throw(const BrdfSource& source, const SliceOptions& options) {
  Result<DecodedSliced> sliced = sliced_of(source, options);
  if (!sliced) throw std::runtime_error(sliced.error().message);
  return *std::move(sliced);
}

using Contexts = std::vector<GlContext*>;

void expect_shader_agrees(const Contexts& contexts, const std::string& name, const DecodedSliced& sliced,
                          const BrdfSource& source, TexelFormat texel) {
  static const Pairs kDrawn = draw_pairs(kPairs);
  AtlasOptions options;
  options.texel = texel;
  options.max_error_percent = 1;
  const Result<MadeAtlas> made = make_atlas(sliced, source, options);
  ASSERT_TRUE(made) << made.error().message;
  const GlTexture texture = texture_of(made->texture);
  for (GlContext* context : contexts) {
    const auto values = run_shader(*context, atlas_shader(made->atlas), "sbrdf_eval", std::span(&texture, 1), kDrawn);
    ASSERT_TRUE(values) << values.error().message;
    const ShaderDifference found = difference(made->atlas, kDrawn, *values);
    EXPECT_LE(found.largest, 2e-3) << name << " at " << place(kDrawn, found.at) << " by " << context->driver();
    EXPECT_LE(found.mean, 5e-5) << name << " by " << context->driver();
  }
}

const std::vector<std::string> kKurt = {"Brushed alum", "Purple satin", "Red velvet", "Yellow satin", "fabric002",
                                        "fabric041",    "fabric112",    "fabric135",  "fabric139",    "wood01"};

// In both languages.
#define SBRDF_MAKE_GL_CONTEXTS(variable)                \
  SBRDF_MAKE_GL_CONTEXT(variable##_45, GlApi::kCore45); \
  SBRDF_MAKE_GL_CONTEXT(variable##_es, GlApi::kEs30);   \
  const Contexts variable = {&variable##_45, &variable##_es}

TEST(ShaderOfAtlas, AgreesInTheElevationFrame) {
  SBRDF_MAKE_GL_CONTEXTS(contexts);
  for (std::size_t k = 0; k < kKurt.size(); ++k) {
    const auto source = make_analytic_source(kurt_material(kKurt[k]).value());
    // One scale for all tiles, and one for each.
    const TexelFormat texel = k % 2 == 0 ? TexelFormat::kRgb32f : TexelFormat::kE5b9g9r9;
    expect_shader_agrees(contexts, kKurt[k], slices_or_throw(*source, paper_options()), *source, texel);
  }
}

TEST(ShaderOfAtlas, AgreesInTheHalfDifferenceFrame) {
  SBRDF_MAKE_GL_CONTEXTS(contexts);
  SliceOptions options;
  options.stop = SampleCount{1500};
  options.structure = SearchedStructure{.frame = FrameId::kHalfDifference, .evaluations = 20};
  for (const bool mirrors : {true, false}) {
    std::get<SearchedStructure>(options.structure).use_mirrors = mirrors;
    for (const char* name : {"Brushed alum", "fabric112"}) {
      const auto source = make_analytic_source(kurt_material(name).value());
      expect_shader_agrees(contexts, name, slices_or_throw(*source, options), *source, TexelFormat::kRgb32f);
    }
  }
}

TEST(ShaderOfAtlas, AgreesOnMeasuredMaterials) {
  SBRDF_MAKE_GL_CONTEXTS(contexts);
  SliceOptions options;
  options.stop = SampleCount{1500};
  for (const char* name : {"chm_mint_rgb.bsdf", "cc_green_malachite_rgb.bsdf"}) {
    SBRDF_FIND_TEST_DATA(path, std::string("rgl/") + name);
    const Result<OpenedSource> opened = open_source(path.string());
    ASSERT_TRUE(opened);
    const DecodedSliced sliced = slices_or_throw(*opened->source, options);
    for (const TexelFormat texel : {TexelFormat::kRgb32f, TexelFormat::kRgba16f, TexelFormat::kE5b9g9r9}) {
      expect_shader_agrees(contexts, name, sliced, *opened->source, texel);
    }
  }
}

TEST(ShaderText, CompilesInAllLanguages) {
  SBRDF_NEED_SHADER_PROGRAMS();
  SliceOptions half;
  half.stop = SampleCount{1000};
  half.structure = SearchedStructure{.frame = FrameId::kHalfDifference, .evaluations = 20};
  const auto source = make_analytic_source(kurt_material("fabric112").value());
  for (const SliceOptions& options : {paper_options(), half}) {
    const DecodedSliced sliced = slices_or_throw(*source, options);
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
