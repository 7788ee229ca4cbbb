#include "converters/scene/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#define TINYOBJLOADER_IMPLEMENTATION
#define TINYOBJLOADER_USE_DOUBLE
#include <tiny_obj_loader.h>

#include "formats/core/text_lines.h"

namespace sbrdf::internal {
namespace {

using Numbers = std::vector<tinyobj::real_t>;
using Corners = std::array<tinyobj::index_t, 3>;

/// Fields of "v", and of "vn" and "vt", that a line needs at least.
std::size_t least_numbers(std::string_view keyword) { return keyword == "vt" ? 1 : 3; }

Status check_numbers(std::span<const std::string_view> fields) {
  if (fields.size() < least_numbers(fields[0]) + 1) return invalid_file("has too few numbers");
  for (const std::string_view field : fields.subspan(1)) {
    const FieldNumber number = read_field(field);
    if (number.kind != FieldNumber::Kind::kFinite) {
      return invalid_file(fmt::format("'{}' is no finite number", field_text(field)));
    }
    if (std::abs(number.value) > kFarthest) return invalid_file(fmt::format("'{}' is too far", field_text(field)));
  }
  return ok_status();
}

/// A corner "v", "v/vt", "v//vn" or "v/vt/vn" of indices that are not 0 and fit 32 bits.
bool is_corner(std::string_view field) {
  for (std::size_t part = 0; part < 3; ++part) {
    const std::size_t end = std::min(field.find('/'), field.size());
    const std::string_view number = field.substr(0, end);
    std::int32_t index = 0;
    const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), index);
    const bool is_index = error == std::errc() && stop == number.data() + number.size() && index != 0;
    if (!is_index && (part == 0 || !number.empty())) return false;
    if (end == field.size()) return is_index;
    field.remove_prefix(end + 1);
  }
  return false;
}

Status check_corners(std::span<const std::string_view> fields) {
  for (const std::string_view field : fields.subspan(1)) {
    if (!is_corner(field)) return invalid_file(fmt::format("'{}' is no corner of a face", field_text(field)));
  }
  return ok_status();
}

/// The reader takes what is no number for 0, and wraps indices; comments behind numbers it does not know.
Result<std::string> checked(std::string_view text) {
  std::string kept;
  kept.reserve(text.size() + 1);
  LineWalker lines(text);
  std::vector<std::string_view> fields;
  while (const std::optional<TextLine> line = lines.next()) {
    const std::string_view content = line->text.substr(0, line->text.find('#'));
    split_fields(content, Separator::kBlanks, fields);
    const std::string_view keyword = fields.empty() ? std::string_view() : fields[0];
    Status sound = ok_status();
    if (keyword == "v" || keyword == "vn" || keyword == "vt") sound = check_numbers(fields);
    if (keyword == "f") sound = check_corners(fields);
    if (!sound) return invalid_file(fmt::format("line {}: {}", line->number, sound.error().message));
    kept.append(content).push_back('\n');
  }
  return kept;
}

/// `size` numbers of a list; nothing where the index is of none, or one is not finite.
std::optional<glm::dvec3> entry(const Numbers& numbers, int index, std::size_t size) {
  const std::size_t first = static_cast<std::size_t>(index) * size;
  if (index < 0 || first + size > numbers.size()) return std::nullopt;
  glm::dvec3 v{0, 0, 0};
  for (std::size_t k = 0; k < size; ++k) v[static_cast<int>(k)] = numbers[first + k];
  if (!std::isfinite(v.x + v.y + v.z)) return std::nullopt;
  return v;
}

/// Along which u grows, where all corners have texture coordinates.
std::optional<glm::dvec3> tangent_of(const tinyobj::attrib_t& attributes, const Corners& corners,
                                     const std::array<glm::dvec3, 3>& points) {
  std::array<glm::dvec3, 3> uv;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<glm::dvec3> given = entry(attributes.texcoords, corners[k].texcoord_index, 2);
    if (!given) return std::nullopt;
    uv[k] = *given;
  }
  const glm::dvec3 a = uv[1] - uv[0];
  const glm::dvec3 b = uv[2] - uv[0];
  const double area = a.x * b.y - a.y * b.x;
  if (area == 0) return std::nullopt;
  return ((points[1] - points[0]) * b.y - (points[2] - points[0]) * a.y) / area;
}

/// Nothing for a triangle without area.
Result<std::optional<Patch>> triangle(const tinyobj::attrib_t& attributes, const Corners& corners) {
  Patch patch;
  patch.kind = Patch::Kind::kTriangle;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<glm::dvec3> point = entry(attributes.vertices, corners[k].vertex_index, 3);
    if (!point) return invalid_file("a face has a vertex that is not there, or is not finite");
    patch.points[k] = *point;
  }
  const glm::dvec3 normal = glm::cross(patch.points[1] - patch.points[0], patch.points[2] - patch.points[0]);
  if (!(glm::length(normal) > 0)) return std::optional<Patch>();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<glm::dvec3> given = entry(attributes.normals, corners[k].normal_index, 3);
    if (corners[k].normal_index >= 0 && !given) return invalid_file("a face has a normal that is not there");
    patch.normals[k] = unit_or(given.value_or(normal), unit_or(normal, {0, 0, 1}));
  }
  patch.tangent = tangent_of(attributes, corners, patch.points).value_or(glm::dvec3(1, 0, 0));
  return std::optional<Patch>(patch);
}

/// A fan of triangles for each polygon, as the file lists its corners.
Status add_polygons(const tinyobj::attrib_t& attributes, const tinyobj::mesh_t& mesh, std::vector<Patch>& patches) {
  const std::size_t corners =
      std::accumulate(mesh.num_face_vertices.begin(), mesh.num_face_vertices.end(), std::size_t{0});
  if (corners != mesh.indices.size()) return unsupported("a polygon with more than 255 corners");
  std::size_t first = 0;
  for (const std::size_t count : mesh.num_face_vertices) {
    for (std::size_t k = first + 1; k + 1 < first + count; ++k) {
      Result<std::optional<Patch>> patch =
          triangle(attributes, {mesh.indices[first], mesh.indices[k], mesh.indices[k + 1]});
      if (!patch) return patch.error();
      if (*patch) patches.push_back(**patch);
    }
    first += count;
  }
  return ok_status();
}

}  // namespace

Result<std::vector<Patch>> read_obj(std::string_view text) {
  Result<std::string> sound = checked(text);
  if (!sound) return sound.error();
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warnings;
  std::string errors;
  std::istringstream stream{*std::move(sound)};
  constexpr bool kTriangulate = false;
  if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warnings, &errors, &stream, nullptr, kTriangulate, false)) {
    return invalid_file("no Wavefront OBJ: " + errors.substr(0, errors.find('\n')));
  }
  std::vector<Patch> patches;
  for (const tinyobj::shape_t& shape : shapes) {
    if (Status added = add_polygons(attributes, shape.mesh, patches); !added) return added.error();
  }
  if (patches.empty()) return invalid_file("a Wavefront OBJ without any triangle");
  return patches;
}

}  // namespace sbrdf::internal
