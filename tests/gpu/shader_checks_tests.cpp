#include "tests/gpu/shader_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

std::string fragment_shader(const std::string& version, const std::string& expression) {
  return version +
         "precision highp float;\nuniform sampler2D atlas;\nin vec2 uv;\nout vec4 colour;\nvoid main() { colour = " +
         expression + "; }\n";
}

TEST(ShaderChecks, AcceptAGoodShader) {
  SBRDF_NEED_SHADER_PROGRAMS();
  for (const ShaderTarget target : {ShaderTarget::kLanguage, ShaderTarget::kOpenGl, ShaderTarget::kVulkan}) {
    const ShaderCheck check =
        check_glsl(ShaderStage::kFragment, fragment_shader("#version 450 core\n", "texture(atlas, uv)"), target);
    EXPECT_EQ(check.exit_code, 0) << check.output;
  }
  const ShaderCheck es = check_glsl(ShaderStage::kFragment, fragment_shader("#version 300 es\n", "texture(atlas, uv)"),
                                    ShaderTarget::kLanguage);
  EXPECT_EQ(es.exit_code, 0) << es.output;
}

TEST(ShaderChecks, RefuseABadShaderAndNameItsLine) {
  SBRDF_NEED_SHADER_PROGRAMS();
  for (const ShaderTarget target : {ShaderTarget::kLanguage, ShaderTarget::kOpenGl, ShaderTarget::kVulkan}) {
    const ShaderCheck check = check_glsl(
        ShaderStage::kFragment, fragment_shader("#version 450 core\n", "texture(undeclared_name, uv)"), target);
    EXPECT_NE(check.exit_code, 0);
    EXPECT_THAT(check.output, HasSubstr(":6: 'undeclared_name'"));
  }
}

TEST(ShaderChecks, KnowWhatALanguageLacks) {
  SBRDF_NEED_SHADER_PROGRAMS();
  // fma came with OpenGL ES 3.2; the numbers of ES have no precision unless they are given one.
  const ShaderCheck fma =
      check_glsl(ShaderStage::kFragment, fragment_shader("#version 300 es\n", "fma(vec4(1), vec4(2), vec4(3))"),
                 ShaderTarget::kLanguage);
  EXPECT_NE(fma.exit_code, 0);
  const ShaderCheck precision =
      check_glsl(ShaderStage::kFragment, "#version 300 es\nout vec4 colour;\nvoid main() { colour = vec4(1.0); }\n",
                 ShaderTarget::kLanguage);
  EXPECT_NE(precision.exit_code, 0);
  EXPECT_THAT(precision.output, HasSubstr("precision"));
}

TEST(ShaderChecks, CountWhatIsLeftOfAShader) {
  SBRDF_NEED_SHADER_PROGRAMS();
  const auto counts = [](const std::string& expression) {
    const Result<ShaderCounts> found = count_instructions(fragment_shader("#version 450 core\n", expression));
    EXPECT_TRUE(found) << found.error().message;
    return found ? *found : ShaderCounts{};
  };
  // Load the place and the texture, read, store, return.
  const ShaderCounts one = counts("texture(atlas, uv)");
  EXPECT_EQ(one.instructions, 5U);
  EXPECT_EQ(one.fetches, 1U);
  const ShaderCounts two = counts("texture(atlas, uv) * 2.0 + texelFetch(atlas, ivec2(uv), 0) * (3.0 - 1.0)");
  EXPECT_EQ(two.fetches, 2U);
  EXPECT_GT(two.instructions, one.instructions + 3);
  EXPECT_FALSE(count_instructions("#version 450 core\nvoid main() { undeclared_name; }\n"));
}

TEST(ShaderChecks, OtherStagesAreChecked) {
  SBRDF_NEED_SHADER_PROGRAMS();
  const ShaderCheck vertex =
      check_glsl(ShaderStage::kVertex, "#version 450\nvoid main() { gl_Position = vec4(1); }\n", ShaderTarget::kVulkan);
  EXPECT_EQ(vertex.exit_code, 0) << vertex.output;
  const ShaderCheck compute = check_glsl(
      ShaderStage::kCompute, "#version 450\nlayout(local_size_x = 64) in;\nvoid main() {}\n", ShaderTarget::kOpenGl);
  EXPECT_EQ(compute.exit_code, 0) << compute.output;
}

TEST(ShaderChecks, HlslOfAShaderIsHlsl) {
  SBRDF_NEED_SHADER_PROGRAMS();
  const auto hlsl =
      glsl_to_hlsl(ShaderStage::kFragment, fragment_shader("#version 450 core\n", "textureLod(atlas, uv, 0.0)"));
  ASSERT_TRUE(hlsl.ok()) << hlsl.error().message;
  EXPECT_THAT(*hlsl, HasSubstr("SampleLevel"));
  const ShaderCheck check = check_hlsl(ShaderStage::kFragment, *hlsl);
  EXPECT_EQ(check.exit_code, 0) << check.output;
  EXPECT_FALSE(glsl_to_hlsl(ShaderStage::kFragment, "#version 450\nvoid main() { none(); }\n").ok());
}

TEST(ShaderChecks, RefuseBadHlsl) {
  SBRDF_NEED_SHADER_PROGRAMS();
  const ShaderCheck good = check_hlsl(ShaderStage::kFragment,
                                      "float4 shade(float4 uv : TEXCOORD0) : SV_Target { return uv.zwxy; }\n", "shade");
  EXPECT_EQ(good.exit_code, 0) << good.output;
  const ShaderCheck bad = check_hlsl(ShaderStage::kFragment, "float4 main() : SV_Target { return vec4(1); }\n");
  EXPECT_NE(bad.exit_code, 0);
}

}  // namespace
}  // namespace sbrdf::internal
