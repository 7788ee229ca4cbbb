// Scenes: what is read, and that every pair of directions under which a place is seen and lit is reached.
#include "converters/scene/scene.h"

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "codec/atlas/bake.h"
#include "codec/frame/lattice.h"
#include "converters/scene/mesh.h"
#include "converters/scene/scene_reach.h"
#include "formats/texture/exr_texture.h"
#include "tests/converters/in_folder.h"

namespace sbrdf::internal {
namespace {

using testing::HasSubstr;

const char* const kCamera =
    R"("cameras": [{"position": [0, 2, 5], "target": [0, 0, 0], "fov_deg": 30, "aspect": 1.5}])";
const char* const kFloor =
    R"({"shape": "plane", "center": [0, 0, 0], "normal": [0, 1, 0], "tangent": [1, 0, 0], "width": 8, "height": 6})";
const char* const kSphere = R"({"shape": "sphere", "center": [0, 1, 0], "radius": 1})";

std::string scene_text(const std::string& objects, const std::string& light) {
  return "{" + std::string(kCamera) + ", \"objects\": [" + objects + "], " + light + "}";
}

Scene scene_of(const std::string& text) {
  const InFolder folder(text);
  Result<Scene> scene = read_scene(folder);
  if (!scene) throw std::runtime_error(scene.error().message);
  return *std::move(scene);
}

Scene scene_of_parts(const std::string& objects, const std::string& light) {
  return scene_of(scene_text(objects, light));
}

std::vector<AtlasLayout> some_axes() {
  std::vector<AtlasLayout> axes;
  for (const FrameSpec& spec : {elevation_frame(14, 36, {}, 90).value(),
                                elevation_frame(14, 36, {.isotropic = true, .mirror_x = true}, 90).value(),
                                half_difference_frame({0, 2, 6, 20, 50}, {0, 15, 30, 45, 60, 75},
                                                      {0, 45, 90, 135, 180, 225, 270, 315}, {0, 45, 90, 135}, {}, 90),
                                half_difference_frame({0, 2, 6, 20, 50}, {0, 15, 30, 45, 60, 75}, {0}, {0, 45, 90, 135},
                                                      {.isotropic = true, .mirror_x = true}, 90)}) {
    axes.push_back(atlas_axes(build_lattice(spec).value()));
  }
  return axes;
}

bool is_reached(const AtlasCells& cells, const AtlasLayout& axes, const SurfacePoint& point,
                const glm::dvec3& to_camera, const glm::dvec3& to_light) {
  const glm::dvec3 w_v = point.local(glm::normalize(to_camera));
  const glm::dvec3 w_i = point.local(glm::normalize(to_light));
  if (w_v.z < 0 || w_i.z < 0) return true;  // not seen, or not lit
  const DirectionPair pair = {direction_from_vector(w_i), direction_from_vector(w_v)};
  return cells.has(cell_of(axes, pair));
}

/// The place that a pixel of the camera sees; false where it sees nothing.
using Hit = std::function<bool(const glm::dvec3& from, const glm::dvec3& way, SurfacePoint& point)>;

bool hit_floor(const glm::dvec3& from, const glm::dvec3& way, SurfacePoint& point) {
  if (way.y >= 0) return false;
  point.position = from - from.y / way.y * way;
  point.normal = {0, 1, 0};
  point.tangent = {1, 0, 0};
  return std::abs(point.position.x) <= 4 && std::abs(point.position.z) <= 3;
}

bool hit_sphere(const glm::dvec3& from, const glm::dvec3& way, SurfacePoint& point) {
  const glm::dvec3 center = {0, 1, 0};
  const double along = glm::dot(center - from, way);
  const double apart = glm::dot(center - from, center - from) - along * along;
  if (apart >= 1) return false;
  point.position = from + (along - std::sqrt(1 - apart)) * way;
  point.normal = point.position - center;
  point.tangent = across(point.normal, glm::cross({0, 1, 0}, point.normal));
  return true;
}

void expect_all_pixels_reached(const Scene& scene, const Hit& hit, const std::vector<glm::dvec3>& lights, bool far) {
  const SceneCamera& camera = scene.cameras.front();
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> share(-1, 1);
  for (const AtlasLayout& axes : some_axes()) {
    const Result<AtlasCells> cells = reach_of_scene(scene, axes);
    ASSERT_TRUE(cells) << cells.error().message;
    int seen = 0;
    for (int k = 0; k < 4000; ++k) {
      const glm::dvec3 way = glm::normalize(camera.forward + share(random) * camera.tan_half_width * camera.right +
                                            share(random) * camera.tan_half_height * camera.up);
      SurfacePoint point;
      if (!hit(camera.position, way, point)) continue;
      ++seen;
      for (const glm::dvec3& light : lights) {
        ASSERT_TRUE(is_reached(*cells, axes, point, -way, far ? light : light - point.position));
      }
    }
    EXPECT_GT(seen, 500);
  }
}

TEST(SceneReach, HasWhatAFloorUnderALampNeeds) {
  expect_all_pixels_reached(scene_of_parts(kFloor, R"("lights": [{"position": [1, 3, -1]}, {"position": [-2, 1, 2]}])"),
                            hit_floor, {{1, 3, -1}, {-2, 1, 2}}, false);
}

TEST(SceneReach, HasWhatASphereInTheSunNeeds) {
  expect_all_pixels_reached(
      scene_of_parts(kSphere, R"("lights": [{"direction": [3, 2, 1]}, {"direction": [-1, 0.2, 2]}])"), hit_sphere,
      {{3, 2, 1}, {-1, 0.2, 2}}, true);
}

std::vector<glm::dvec3> sky_directions(const std::function<bool(const glm::dvec3&)>& lit) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<glm::dvec3> directions;
  while (directions.size() < 40) {
    const glm::dvec3 way = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    if (lit(way)) directions.push_back(way);
  }
  return directions;
}

TEST(SceneReach, HasWhatAFloorUnderTheWholeSkyNeeds) {
  expect_all_pixels_reached(scene_of_parts(kFloor, R"("environment": true)"), hit_floor,
                            sky_directions([](const glm::dvec3&) { return true; }), true);
}

/// 32 x 16 texels, black but for some columns left of the middle: about -x, in the upper half.
std::vector<std::byte> window_exr() {
  std::vector<float> rgb(std::size_t{32} * 16 * 3);
  for (std::size_t y = 2; y < 7; ++y) {
    for (std::size_t x = 0; x < 4; ++x) rgb[(y * 32 + x) * 3 + 1] = 5;
  }
  TexelCounts counts;
  return write_exr_texture(encode_texels(TexelFormat::kRgb32f, 32, 16, rgb, counts).value()).value();
}

/// Whether a direction leads into the lit texels, by the formula of specs/atlas.md.
bool through_window(const glm::dvec3& way) {
  const double u = 0.5 + std::atan2(way.z, way.x) / (2 * kPi);
  const double v = std::acos(way.y) / kPi;
  return u * 32 < 4 && v * 16 >= 2 && v * 16 < 7;
}

TEST(SceneReach, KnowsWhereAnEnvironmentIsDark) {
  InFolder folder(scene_text(kFloor, R"("environment": "window.exr")"));
  folder.files["window.exr"] = window_exr();
  const Scene scene = read_scene(folder).value();
  const Scene whole = scene_of(scene_text(kFloor, R"("environment": true)"));
  for (const AtlasLayout& axes : some_axes()) {
    const AtlasCells part = reach_of_scene(scene, axes).value();
    EXPECT_LT(part.size(), reach_of_scene(whole, axes).value().size());
    const SceneCamera& camera = scene.cameras.front();
    for (const glm::dvec3& light : sky_directions(through_window)) {
      SurfacePoint point;
      ASSERT_TRUE(hit_floor(camera.position, camera.forward, point));
      ASSERT_TRUE(is_reached(part, axes, point, -camera.forward, light));
    }
  }
}

TEST(SceneReach, LeavesOutMostOfWhatAFloorInTheSunDoesNotNeed) {
  const Scene scene = scene_of(scene_text(kFloor, R"("lights": [{"direction": [1, 2, 1]}])"));
  for (const AtlasLayout& axes : some_axes()) {
    const AtlasCells cells = reach_of_scene(scene, axes).value();
    EXPECT_LE(static_cast<double>(cells.size()), 0.3 * static_cast<double>(cells.flags().size()));
  }
}

TEST(SceneReach, OfAMeshIsThatOfTheSameRectangle) {
  InFolder folder(scene_text(R"({"shape": "mesh", "file": "floor.obj"})", R"("lights": [{"position": [1, 3, -1]}])"));
  const std::string obj =
      "v -4 0 3\nv 4 0 3\nv 4 0 -3\nv -4 0 -3\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 1 0\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
  const auto* const bytes = reinterpret_cast<const std::byte*>(obj.data());
  folder.files["floor.obj"] = {bytes, bytes + obj.size()};
  const Scene mesh = read_scene(folder).value();
  ASSERT_EQ(mesh.patches.size(), 2U);
  EXPECT_NEAR(glm::length(mesh.patches[1].at(0.3, 0.6).tangent - glm::dvec3(1, 0, 0)), 0, 1e-12);
  const Scene plane = scene_of(scene_text(kFloor, R"("lights": [{"position": [1, 3, -1]}])"));
  for (const AtlasLayout& axes : some_axes()) {
    const AtlasCells of_mesh = reach_of_scene(mesh, axes).value();
    const AtlasCells of_plane = reach_of_scene(plane, axes).value();
    // It is cut into other pieces, of which more lie across cells.
    EXPECT_LE(of_mesh.size(), 2 * of_plane.size());
  }
  expect_all_pixels_reached(mesh, hit_floor, {{1, 3, -1}}, false);
}

TEST(SceneReach, IsTheSameForAnyNumberOfThreadsAndCanBeStopped) {
  const Scene scene = scene_of(scene_text(kSphere, R"("lights": [{"direction": [3, 2, 1]}])"));
  const AtlasLayout axes = some_axes()[0];
  EXPECT_EQ(reach_of_scene(scene, axes).value(), reach_of_scene(scene, axes).value());
  const Result<AtlasCells> stopped = reach_of_scene(scene, axes, {[](double) { return false; }});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, interrupted_error().code);
}

TEST(SceneReach, CanBeStoppedWhileSurfacesAreCutUp) {
  std::string lights;
  for (int k = 0; k < 64; ++k) {
    lights +=
        fmt::format(R"({}{{"position": [{}, 0.001, {}]}})", k == 0 ? "" : ", ", k % 8 * 0.4 - 1.5, k / 8 * 0.3 - 1);
  }
  const Scene scene = scene_of(scene_text(kFloor, R"("lights": [)" + lights + "]"));
  double last = 0;
  const Result<AtlasCells> stopped = reach_of_scene(scene, some_axes()[0], {[&](double fraction) {
                                                      last = fraction;
                                                      return false;
                                                    }});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, interrupted_error().code);
  EXPECT_LT(last, 0.01);
}

TEST(SceneReach, IsRefusedWhereNothingIsSeenOrLit) {
  for (const std::string light :
       {R"("lights": [{"direction": [0, -1, 0]}])", R"("lights": [{"position": [0, -2, 0]}])"}) {
    const Result<AtlasCells> cells = reach_of_scene(scene_of(scene_text(kFloor, light)), some_axes()[0]);
    ASSERT_FALSE(cells) << light;
    EXPECT_THAT(cells.error().message, HasSubstr("no place that a camera sees"));
  }
}

std::string error_of(const std::string& text) {
  const InFolder folder(text);
  const Result<Scene> scene = read_scene(folder);
  return scene ? "" : scene.error().message;
}

TEST(SceneFile, IsRefusedWithTheMemberThatIsWrong) {
  const std::string sun = R"("lights": [{"direction": [0, 1, 0]}])";
  EXPECT_EQ(error_of(scene_text(kFloor, sun)), "");
  EXPECT_THAT(error_of("no json"), HasSubstr("JSON"));
  EXPECT_THAT(error_of("[]"), HasSubstr("'cameras'"));
  EXPECT_THAT(error_of("{}"), HasSubstr("'cameras' is missing"));
  EXPECT_THAT(error_of(scene_text(kFloor, R"("lights": [])")), HasSubstr("'lights' is empty"));
  EXPECT_THAT(error_of(scene_text("", sun)), HasSubstr("'objects'"));
  EXPECT_THAT(error_of(scene_text(kFloor, R"("lights": [{"direction": [0, 0, 0]}])")),
              HasSubstr("'direction' is no direction"));
  EXPECT_THAT(error_of(scene_text(kFloor, R"("lights": [{"direction": [0, 0, 1e39]}])")), HasSubstr("'direction'"));
  EXPECT_THAT(error_of(scene_text(kFloor, R"("lights": [{"position": [0, 0]}])")), HasSubstr("'position'"));
  EXPECT_THAT(error_of(scene_text(R"({"shape": "cube"})", sun)), HasSubstr("'shape' is neither"));
  EXPECT_THAT(error_of(scene_text(R"({"shape": "sphere", "center": [0, 0, 0], "radius": -1})", sun)),
              HasSubstr("'radius'"));
  EXPECT_THAT(error_of(scene_text(R"({"shape": "mesh", "file": "../x.obj"})", sun)),
              HasSubstr("'file' is no plain file name"));
  EXPECT_THAT(error_of(scene_text(R"({"shape": "mesh", "file": "x.obj"})", sun)),
              HasSubstr("x.obj, is not in its folder"));
  EXPECT_THAT(error_of(scene_text(kFloor, R"("environment": "sky.exr")")), HasSubstr("sky.exr, is not in its folder"));
  EXPECT_THAT(error_of(scene_text(kFloor, R"("environment": false)")), HasSubstr("'environment'"));
  EXPECT_THAT(error_of(scene_text(std::string(R"({"material": false, )") + (kFloor + 1), sun)),
              HasSubstr("no object of the material"));
  EXPECT_THAT(error_of(R"({"cameras": [{"position": [1, 2, 3], "target": [1, 2, 3], "fov_deg": 30}], "objects": [)" +
                       std::string(kFloor) + "], " + sun + "}"),
              HasSubstr("'target' is where the camera is"));
}

TEST(SceneFile, ErrorsSayWhichEntryIsWrongAndUnknownMembersAreErrors) {
  const std::string sun = R"("lights": [{"direction": [0, 1, 0]}])";
  const std::string floor = kFloor;
  EXPECT_THAT(error_of(scene_text(floor + R"(, {"shape": "sphere", "radius": 1})", sun)),
              HasSubstr("objects[1]: 'center' is missing"));
  EXPECT_THAT(error_of(scene_text(floor, R"("lights": [{"direction": [0, 1, 0]}, {}])")),
              HasSubstr("lights[1]: 'position' is missing"));
  EXPECT_THAT(error_of(R"({"cameras": [{}], "objects": []})"), HasSubstr("cameras[0]: 'position' is missing"));
  EXPECT_THAT(error_of(scene_text(floor, sun + R"(, "ligths": [])")), HasSubstr("'ligths' is not known"));
  EXPECT_THAT(error_of(scene_text(R"({"radios": 1, )" + std::string(kSphere + 1), sun)),
              HasSubstr("objects[0]: 'radios' is not known"));
  EXPECT_THAT(error_of(scene_text(floor, R"("lights": [{"direction": [0, 1, 0], "position": [0, 1, 0]}])")),
              HasSubstr("lights[0]: 'position' stands beside 'direction'"));
  EXPECT_THAT(error_of(R"({"cameras": [1, 2,]})"), HasSubstr("is no JSON from byte 19 on"));
}

TEST(ObjMesh, SaysWhichLineIsWrong) {
  const std::string triangle = "v 0 0 0 # the origin\nv 1 0 0\nv 0 1 0\n";
  EXPECT_TRUE(read_obj(triangle + "f 1 2 3\n"));
  EXPECT_TRUE(read_obj(triangle + "vn 0 0 1\nf 1//1 2//1 3//-1 # done\n"));
  for (const auto& [line, what] :
       std::vector<std::pair<std::string, std::string>>{{"f 1 4294967299 2", "line 4: '4294967299'"},
                                                        {"f 1 0 2", "line 4: '0'"},
                                                        {"f 1/x 2 3", "line 4: '1/x'"},
                                                        {"f 1/1/1/1 2 3", "line 4: '1/1/1/1'"},
                                                        {"v 0 0", "line 4: has too few numbers"},
                                                        {"v 1e300 0 0", "line 4: '1e300' is too far"},
                                                        {"f 1//9 2//9 3//9", "a normal that is not there"}}) {
    const Result<std::vector<Patch>> patches = read_obj(triangle + line + "\nf 1 2 3\n");
    ASSERT_FALSE(patches) << line;
    EXPECT_THAT(patches.error().message, HasSubstr(what)) << line;
  }
}

TEST(ObjMesh, IsRefusedWhereItIsNone) {
  for (const std::string text : {"", "nothing", "v 0 0 0\nv 1 0 0\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
                                 "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
                                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -9 -8 -7\n", "f 1 2 3\n"}) {
    const Result<std::vector<Patch>> patches = read_obj(text);
    ASSERT_FALSE(patches) << text;
    EXPECT_EQ(patches.error().code, ErrorCode::kInvalidFile) << text;
  }
  const Result<std::vector<Patch>> patches = read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ASSERT_TRUE(patches);
  EXPECT_EQ(patches->front().at(0.5, 0.5).normal, glm::dvec3(0, 0, 1));
}

}  // namespace
}  // namespace sbrdf::internal
