#include "converters/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "converters/json/members.h"
#include "converters/scene/mesh.h"
#include "formats/core/directions.h"
#include "formats/texture/exr_texture.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kLongestFile = std::uint64_t{1} << 24U;
constexpr std::uint64_t kLongestMesh = std::uint64_t{1} << 30U;
constexpr std::size_t kMostEntries = 4096;
constexpr std::uint32_t kCellsAround = 120;  // of an environment: 3 degrees

glm::dvec3 vector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

class SceneReader {
 public:
  explicit SceneReader(const ByteSource& file) : file_(file) {}

  Result<Scene> read(const Json& json) {
    Scene scene;
    members_.only(json, {"cameras", "lights", "objects", "environment"});
    const auto enter = [&](const char* name, std::size_t number) {
      members_.enter(fmt::format("{}[{}]", name, number));
    };
    for (const Json& camera : list(json, "cameras")) {
      enter("cameras", scene.cameras.size());
      scene.cameras.push_back(read_camera(camera));
    }
    members_.enter("");
    if (has(json, "lights")) {
      for (const Json& light : list(json, "lights")) {
        enter("lights", scene.lights.size());
        scene.lights.push_back(read_light(light));
      }
      members_.enter("");
    }
    std::size_t objects = 0;
    for (const Json& object : list(json, "objects")) {
      enter("objects", objects++);
      if (Status added = add_object(object, scene.patches); !added) return added.error();
    }
    members_.enter("");
    if (has(json, "environment")) {
      Result<Environment> environment = read_environment(json.at("environment"));
      if (!environment) return environment.error();
      scene.environment = *std::move(environment);
    }
    if (scene.cameras.empty()) members_.refuse("cameras", "is empty: nobody looks");
    if (scene.patches.empty()) members_.refuse("objects", "has no object of the material");
    if (scene.lights.empty() && !scene.environment)
      members_.refuse("lights", "is empty, and there is no 'environment'");
    if (members_.error()) return invalid_file("scene: " + *members_.error());
    return scene;
  }

 private:
  static bool has(const Json& json, const char* name) { return json.is_object() && json.contains(name); }
  const Json& list(const Json& json, const char* name) { return members_.list(json, name, kMostEntries); }

  glm::dvec3 place(const Json& json, const char* name) {
    const glm::dvec3 v = vector(members_.three(json, name));
    if (!(glm::length(v) <= kFarthest)) members_.refuse(name, "is too far away");
    return v;
  }

  glm::dvec3 direction(const Json& json, const char* name) {
    const glm::dvec3 v = vector(members_.three(json, name));
    if (!(glm::length(v) > 1e-12)) members_.refuse(name, "is no direction");
    return unit_or(v, {0, 0, 1});
  }

  SceneCamera read_camera(const Json& json) {
    SceneCamera camera;
    members_.only(json, {"name", "position", "target", "up", "fov_deg", "aspect"});
    camera.position = place(json, "position");
    const glm::dvec3 way = place(json, "target") - camera.position;
    if (!(glm::length(way) > 1e-9)) members_.refuse("target", "is where the camera is");
    camera.forward = unit_or(way, {0, 0, -1});
    const glm::dvec3 up = has(json, "up") ? direction(json, "up") : glm::dvec3(0, 1, 0);
    camera.up = across(camera.forward, up);
    camera.right = glm::cross(camera.forward, camera.up);
    const double half = radians_from_degrees(members_.number(json, "fov_deg", 0.01, 179) / 2);
    camera.tan_half_height = std::tan(half);
    camera.tan_half_width =
        camera.tan_half_height * (has(json, "aspect") ? members_.number(json, "aspect", 0.001, 1000) : 1);
    return camera;
  }

  SceneLight read_light(const Json& json) {
    members_.only(json, {"name", "direction", "position"});
    if (has(json, "direction")) {
      if (has(json, "position")) members_.refuse("position", "stands beside 'direction': a light has one of them");
      return {true, direction(json, "direction")};
    }
    return {false, place(json, "position")};
  }

  Status add_object(const Json& json, std::vector<Patch>& patches) {
    if (has(json, "material") && !members_.flag(json, "material")) return ok_status();
    const std::string shape = members_.text(json, "shape");
    std::vector<Patch> more;
    if (shape == "plane") {
      members_.only(json, {"name", "material", "shape", "center", "normal", "tangent", "width", "height"});
      more = plane_patches(place(json, "center"), direction(json, "normal"),
                           has(json, "tangent") ? direction(json, "tangent") : glm::dvec3(1, 0, 0),
                           members_.number(json, "width", 1e-6, kFarthest),
                           members_.number(json, "height", 1e-6, kFarthest));
    } else if (shape == "sphere") {
      members_.only(json, {"name", "material", "shape", "center", "radius", "axis"});
      more = sphere_patches(place(json, "center"), members_.number(json, "radius", 1e-6, kFarthest),
                            has(json, "axis") ? direction(json, "axis") : glm::dvec3(0, 1, 0));
    } else if (shape == "mesh") {
      members_.only(json, {"name", "material", "shape", "file"});
      Result<std::vector<Patch>> mesh = read_mesh(members_.file_name(json, "file"));
      if (!mesh) return mesh.error();
      more = *std::move(mesh);
    } else {
      members_.refuse("shape", "is neither plane, sphere nor mesh");
    }
    patches.insert(patches.end(), more.begin(), more.end());
    return ok_status();
  }

  /// A file beside the scene.
  Result<std::shared_ptr<const ByteSource>> neighbour(const std::string& name) {
    if (members_.error()) return invalid_file("scene: " + *members_.error());
    Result<std::shared_ptr<const ByteSource>> bytes = file_.neighbour(name);
    if (bytes && *bytes == nullptr)
      return io_error("scene: the file that it names, " + name + ", is not in its folder");
    return bytes;
  }

  static Error of_file(const std::string& name, const Error& error) {
    Error named = error;
    named.message = "scene: " + name + ": " + error.message;
    return named;
  }

  Result<std::vector<Patch>> read_mesh(const std::string& name) {
    const Result<std::shared_ptr<const ByteSource>> bytes = neighbour(name);
    if (!bytes) return bytes.error();
    if ((*bytes)->size() > kLongestMesh) return of_file(name, unsupported("a mesh of more than 1 GB"));
    const Result<std::vector<std::byte>> text = read_range(**bytes, 0, (*bytes)->size());
    if (!text) return of_file(name, text.error());
    Result<std::vector<Patch>> patches = read_obj({reinterpret_cast<const char*>(text->data()), text->size()});
    if (!patches) return of_file(name, patches.error());
    return patches;
  }

  Result<Environment> read_environment(const Json& json) {
    Environment environment{kCellsAround, kCellsAround / 2, std::vector<bool>(kCellsAround * kCellsAround / 2, true)};
    if (json.is_boolean() && json.get<bool>()) return environment;
    if (!json.is_string()) members_.refuse("environment", "is neither true nor the name of an EXR file");
    const std::string name = members_.file_name(Json{{"environment", json}}, "environment");
    const Result<std::shared_ptr<const ByteSource>> bytes = neighbour(name);
    if (!bytes) return bytes.error();
    const Result<Texture> texture = read_exr_texture(*bytes);
    if (!texture) return of_file(name, texture.error());
    const Result<std::vector<float>> texels = decode_texels(*texture);
    if (!texels) return of_file(name, texels.error());
    std::fill(environment.lit.begin(), environment.lit.end(), false);
    light(environment, *texture, *texels);
    return environment;
  }

  // A cell is lit where any texel is that overlaps it.
  static void light(Environment& environment, const Texture& texture, const std::vector<float>& texels) {
    const auto cells = [](std::uint32_t texel, std::uint32_t count, std::uint32_t all) {
      const auto first = static_cast<std::uint32_t>(std::uint64_t{texel} * all / count);
      const auto end = static_cast<std::uint32_t>((std::uint64_t{texel + 1} * all + count - 1) / count);
      return std::pair(first, std::max(end, first + 1));
    };
    for (std::uint32_t y = 0; y < texture.height; ++y) {
      for (std::uint32_t x = 0; x < texture.width; ++x) {
        const float* const texel = texels.data() + (std::size_t{y} * texture.width + x) * 3;
        if (texel[0] == 0 && texel[1] == 0 && texel[2] == 0) continue;
        const auto [left, right] = cells(x, texture.width, environment.width);
        const auto [top, bottom] = cells(y, texture.height, environment.height);
        for (std::uint32_t row = top; row < bottom; ++row) {
          for (std::uint32_t column = left; column < right; ++column)
            environment.lit[row * environment.width + column] = true;
        }
      }
    }
  }

  const ByteSource& file_;
  MemberReader members_;
};

}  // namespace

bool Environment::everywhere() const {
  return std::all_of(lit.begin(), lit.end(), [](bool cell) { return cell; });
}

glm::dvec3 Environment::direction(std::uint32_t column, std::uint32_t row) const {
  const double phi = 2 * kPi * ((column + 0.5) / width - 0.5);
  const double theta = kPi * (row + 0.5) / height;
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

Result<Scene> read_scene(const ByteSource& bytes) {
  if (bytes.size() > kLongestFile) return unsupported("scene: longer than 16 MB");
  const Result<std::vector<std::byte>> text = read_range(bytes, 0, bytes.size());
  if (!text) return text.error();
  const Result<Json> json = parse_small_json({reinterpret_cast<const char*>(text->data()), text->size()});
  if (!json) {
    Error error = json.error();
    error.message = "scene: " + error.message;
    return error;
  }
  return SceneReader(bytes).read(*json);
}

}  // namespace sbrdf::internal
