// A scene drawn by the shader of an atlas that holds only what the scene needs, and by that of the whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "codec/atlas/atlas_evaluator.h"
#include "codec/atlas/bake.h"
#include "codec/atlas/shader.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/models/analytic.h"
#include "converters/scene/scene.h"
#include "converters/scene/scene_reach.h"
#include "converters/slicing/slicing.h"
#include "formats/core/byte_source.h"
#include "tests/gpu/atlas_checks.h"
#include "tests/gpu/gl_harness.h"

namespace sbrdf::internal {
namespace {

constexpr int kWidth = 90;
constexpr int kHeight = 60;
constexpr int kSkyDirections = 24;  // that each place is lit from

/// A camera over a floor with a sphere, under a sky; the floor is of the material.
const char* const kScene = R"({
  "cameras": [{"position": [0, 2, 6], "target": [0, 0.4, 0], "fov_deg": 32, "aspect": 1.5}],
  "environment": true,
  "objects": [
    {"shape": "plane", "center": [0, 0, 0], "normal": [0, 1, 0], "tangent": [1, 0, 0], "width": 8, "height": 8},
    {"shape": "sphere", "center": [0, 1, 0], "radius": 1, "material": false}]})";

/// What is evaluated for a picture: pairs of directions, kSkyDirections for each pixel that sees the floor.
struct Picture {
  Pairs pairs;
  std::size_t pixels = 0;
};

bool hits_sphere(const glm::dvec3& from, const glm::dvec3& way) {
  const glm::dvec3 center = {0, 1, 0};
  const double along = glm::dot(center - from, way);
  return along > 0 && glm::dot(center - from, center - from) - along * along < 1;
}

Picture picture_of(const SceneCamera& camera) {
  const Environment sky{18, 9, std::vector<bool>(162, true)};
  Picture picture;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const glm::dvec3 way =
          glm::normalize(camera.forward + (2 * (x + 0.5) / kWidth - 1) * camera.tan_half_width * camera.right +
                         (2 * (y + 0.5) / kHeight - 1) * camera.tan_half_height * camera.up);
      const glm::dvec3 place = camera.position - camera.position.y / way.y * way;
      const bool on_floor = way.y < 0 && std::abs(place.x) <= 4 && std::abs(place.z) <= 4;
      if (!on_floor || hits_sphere(camera.position, way)) continue;
      SurfacePoint point;
      point.normal = {0, 1, 0};
      const glm::dvec3 w_v = point.local(-way);
      ++picture.pixels;
      for (int k = 0; k < kSkyDirections; ++k) {
        const int cell = (k * 37 + x * 11 + y * 5) % 81;
        const glm::dvec3 w_i =
            point.local(sky.direction(static_cast<std::uint32_t>(cell % 18), static_cast<std::uint32_t>(cell / 18)));
        picture.pairs.i.emplace_back(w_i);
        picture.pairs.v.emplace_back(w_v);
      }
    }
  }
  return picture;
}

std::vector<float> draw(GlContext& context, const MadeAtlas& made, const Picture& picture) {
  const GlTexture texture = texture_of(made.texture);
  const std::string shader = "#define SBRDF_DEBUG\n" + atlas_shader(made.atlas);
  const Result<std::vector<float>> values =
      run_shader(context, shader, "sbrdf_eval", std::span(&texture, 1), picture.pairs);
  EXPECT_TRUE(values) << values.error().message;
  return values ? *values : std::vector<float>();
}

std::vector<float> evaluate(const MadeAtlas& made, const Picture& picture) {
  const AtlasEvaluator evaluator(made.atlas);
  std::vector<float> values(picture.pairs.i.size() * 3);
  for (std::size_t k = 0; k < picture.pairs.i.size(); ++k) {
    const DirectionPair pair = {direction_from_vector(glm::dvec3(picture.pairs.i[k])),
                                direction_from_vector(glm::dvec3(picture.pairs.v[k]))};
    evaluator.evaluate(pair, std::span<float, 3>(values.data() + 3 * k, 3));
  }
  return values;
}

/// Light from all of a pixel's directions, as 8 bits of a square root.
std::vector<int> bytes_of_pixels(const std::vector<float>& values, std::size_t pixels) {
  std::vector<int> bytes;
  for (std::size_t k = 0; k < pixels * 3; ++k) {
    double sum = 0;
    for (std::size_t n = 0; n < kSkyDirections; ++n) sum += values[(k / 3 * kSkyDirections + n) * 3 + k % 3];
    bytes.push_back(static_cast<int>(std::lround(255 * std::sqrt(std::clamp(sum / 20, 0.0, 1.0)))));
  }
  return bytes;
}

std::size_t count_left_out(const std::vector<float>& values) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < values.size(); k += 3) {
    count += std::equal(kLeftOutColour.begin(), kLeftOutColour.end(), values.begin() + static_cast<std::ptrdiff_t>(k))
                 ? 1U
                 : 0U;
  }
  return count;
}

void expect_same_picture(GlContext& context, const MadeAtlas& whole, const MadeAtlas& part, const Picture& picture) {
  const std::vector<float> values = draw(context, part, picture);
  EXPECT_EQ(count_left_out(values), 0U);
  const std::vector<int> wanted = bytes_of_pixels(draw(context, whole, picture), picture.pixels);
  const std::vector<int> drawn = bytes_of_pixels(values, picture.pixels);
  // Places on textures of other sizes are rounded otherwise in single precision, and some bytes with them.
  int most = 0;
  std::size_t differ = 0;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    most = std::max(most, std::abs(wanted[k] - drawn[k]));
    differ += wanted[k] != drawn[k] ? 1U : 0U;
  }
  EXPECT_LE(most, 1) << context.driver();
  EXPECT_LE(static_cast<double>(differ), 0.002 * static_cast<double>(wanted.size())) << context.driver();
  EXPECT_GT(*std::max_element(wanted.begin(), wanted.end()), 20) << "the picture shows something";
}

/// From above, where the scene's camera never is.
SceneCamera camera_above(const SceneCamera& of_scene) {
  SceneCamera outside = of_scene;
  outside.position = {0, 8, 0.5};
  outside.forward = glm::normalize(glm::dvec3(0.5, -8, 0.5));
  outside.up = across(outside.forward, {0, 0, -1});
  outside.right = glm::cross(outside.forward, outside.up);
  return outside;
}

TEST(ShaderOfScene, DrawsTheSamePictureAndShowsWhereACameraFromOutsideLooks) {
  SBRDF_MAKE_GL_CONTEXT(core, GlApi::kCore45);
  SBRDF_MAKE_GL_CONTEXT(es, GlApi::kEs30);
  const std::string text = kScene;
  const Scene scene = read_scene(MemorySource(std::as_bytes(std::span(text)))).value();
  const Picture picture = picture_of(scene.cameras.front());
  EXPECT_GT(picture.pixels, 1000U);
  const Picture from_above = picture_of(camera_above(scene.cameras.front()));
  SliceOptions elevation;
  elevation.stop = SampleCount{8911};
  elevation.structure = Placement{14, 36};
  elevation.fit_values = false;
  SliceOptions half;
  half.stop = SampleCount{1500};
  half.structure = SearchedStructure{.frame = FrameId::kHalfDifference, .evaluations = 10};
  half.fit_values = false;
  for (const SliceOptions& options : {elevation, half}) {
    const auto source = make_analytic_source(kurt_material("fabric112").value());
    const DecodedSliced sliced = sliced_of(*source, options).value();
    AtlasOptions atlas_options;
    atlas_options.texel = TexelFormat::kRgb32f;
    atlas_options.container = AtlasContainer::kExr;
    atlas_options.max_error_percent = 10;
    const MadeAtlas whole = make_atlas(sliced, *source, atlas_options).value();
    atlas_options.cells = reach_of_scene(scene, atlas_axes(sliced.lattice)).value();
    const MadeAtlas part = make_atlas(sliced, *source, atlas_options).value();
    ASSERT_EQ(part.tolerance, whole.tolerance) << "else the pictures are not of the same texels";
    EXPECT_LT(part.texture.bytes.size(), whole.texture.bytes.size());
    for (GlContext* context : {&core, &es}) {
      expect_same_picture(*context, whole, part, picture);
      EXPECT_EQ(count_left_out(draw(*context, whole, from_above)), 0U);
      EXPECT_GT(count_left_out(draw(*context, part, from_above)), from_above.pixels);
    }
    // The evaluators, which know places to double precision, draw the same picture.
    EXPECT_EQ(bytes_of_pixels(evaluate(part, picture), picture.pixels),
              bytes_of_pixels(evaluate(whole, picture), picture.pixels));
  }
}

}  // namespace
}  // namespace sbrdf::internal
