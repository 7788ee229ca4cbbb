#include "tests/gpu/barycentric/barycentric.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "converters/baselines/scheme_samples.h"
#include "formats/core/half.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kCubeFaces = 6;
constexpr std::size_t kSampleColumns = 128;  // of their texture
/// So near to the border of a texel [texels] a direction belongs to both sides: which one a driver reads is rounding.
constexpr double kBorder = 1e-3;

/// Of the faces in the order +x, -x, +y, -y, +z, -z: the vectors along columns and rows, and to the middle.
struct Face {
  glm::dvec3 columns, rows, middle;
};
const std::array<Face, kCubeFaces> kCube = {{{{0, 0, -1}, {0, -1, 0}, {1, 0, 0}},
                                             {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}},
                                             {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                             {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
                                             {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},
                                             {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}}};

glm::dvec3 direction_of(std::size_t face, double column, double row, std::size_t side) {
  const double half = static_cast<double>(side) / 2;
  return glm::normalize(kCube[face].middle + (column / half - 1) * kCube[face].columns +
                        (row / half - 1) * kCube[face].rows);
}

template <class T>
std::vector<std::byte> bytes_of(const std::vector<T>& values) {
  std::vector<std::byte> bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

}  // namespace

CubePlace cube_place(const glm::dvec3& w, std::size_t side) {
  const glm::dvec3 size = glm::abs(w);
  std::size_t axis = 2;
  if (size.x >= size.y && size.x >= size.z) {
    axis = 0;
  } else if (size.y >= size.z) {
    axis = 1;
  }
  const auto number = static_cast<glm::length_t>(axis);
  const std::size_t face = 2 * axis + (w[number] < 0 ? 1 : 0);
  const double half = static_cast<double>(side) / 2;
  return {face,
          half * (glm::dvec2(glm::dot(w, kCube[face].columns), glm::dot(w, kCube[face].rows)) / size[number] + 1.0)};
}

Barycentric::Barycentric(const BrdfSource& source, const UniformScheme& scheme)
    : directions_(scheme_directions(scheme)), samples_(sample_scheme(source, scheme).value().values) {
  const Triangulation triangulation = Triangulation::make(scheme).value();
  texels_.resize(kCubeFaces * kFaceSide * kFaceSide);
  for (std::size_t face = 0; face < kCubeFaces; ++face) fill_face(face, triangulation);
  keep_directions();
}

void Barycentric::fill_face(std::size_t face, const Triangulation& triangulation) {
  for (std::size_t row = 0; row < kFaceSide; ++row) {
    for (std::size_t column = 0; column < kFaceSide; ++column) {
      const glm::dvec3 w =
          direction_of(face, static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5, kFaceSide);
      if (w.z < -0.01) continue;  // nobody asks, but for texels across the horizon
      const Place place = triangulation.place_of(w);
      Texel& texel = texels_[(face * kFaceSide + row) * kFaceSide + column];
      for (std::size_t k = 0; k < 3; ++k) {
        texel.vertices[k] = static_cast<std::uint8_t>(place.triangle[k]);
        texel.weights[k] = half_from_float(static_cast<float>(place.weights[k]));
      }
    }
  }
}

// The texels that hold a sampled direction have it whole, so that its value comes back.
void Barycentric::keep_directions() {
  for (std::size_t number = 0; number < directions_.size(); ++number) {
    const CubePlace place = cube_place(directions_[number], kFaceSide);
    for (const double x : {std::max(place.at.x - kBorder, 0.0), place.at.x + kBorder}) {
      for (const double y : {std::max(place.at.y - kBorder, 0.0), place.at.y + kBorder}) {
        const auto column = static_cast<std::size_t>(x);
        const auto row = static_cast<std::size_t>(y);
        if (column >= kFaceSide || row >= kFaceSide) continue;
        const auto same = static_cast<std::uint8_t>(number);
        texels_[(place.face * kFaceSide + row) * kFaceSide + column] = {{same, same, same, 0},
                                                                        {half_from_float(1), 0, 0, 0}};
      }
    }
  }
}

std::array<float, 3> Barycentric::evaluate(const glm::vec3& w_i, const glm::vec3& w_v) const {
  std::array<float, 3> value{};
  if (w_i.z < 0 || w_v.z < 0) return value;
  const auto texel_of = [&](const glm::vec3& w) {
    const CubePlace place = cube_place(glm::dvec3(w), kFaceSide);
    const auto column = std::min(static_cast<std::size_t>(place.at.x), kFaceSide - 1);
    const auto row = std::min(static_cast<std::size_t>(place.at.y), kFaceSide - 1);
    return texels_[(place.face * kFaceSide + row) * kFaceSide + column];
  };
  const Texel i = texel_of(w_i);
  const Texel v = texel_of(w_v);
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      const float weight = float_from_half(i.weights[a]) * float_from_half(v.weights[b]);
      const float* sample = samples_.data() + 3 * pair_number(i.vertices[a], v.vertices[b]);
      for (std::size_t c = 0; c < 3; ++c) value[c] += weight * sample[c];
    }
  }
  return value;
}

std::string Barycentric::shader() {
  return R"(
uniform highp samplerCube barycentric_vertices;
uniform highp samplerCube barycentric_weights;
uniform highp sampler2D barycentric_samples;

vec3 barycentric_sample(int i, int v) {
  int high = max(i, v);
  int number = high * (high + 1) / 2 + min(i, v);
  return texelFetch(barycentric_samples, ivec2(number & 127, number >> 7), 0).rgb;
}

vec3 barycentric_side(int i, ivec3 v, vec3 weights) {
  return weights.x * barycentric_sample(i, v.x) + weights.y * barycentric_sample(i, v.y) +
         weights.z * barycentric_sample(i, v.z);
}

vec3 barycentric_eval(vec3 w_i, vec3 w_v) {
  if (w_i.z < 0.0 || w_v.z < 0.0) return vec3(0.0);
  ivec3 i = ivec3(textureLod(barycentric_vertices, w_i, 0.0).rgb * 255.0 + 0.5);
  ivec3 v = ivec3(textureLod(barycentric_vertices, w_v, 0.0).rgb * 255.0 + 0.5);
  vec3 weights_i = textureLod(barycentric_weights, w_i, 0.0).rgb;
  vec3 weights_v = textureLod(barycentric_weights, w_v, 0.0).rgb;
  return weights_i.x * barycentric_side(i.x, v, weights_v) + weights_i.y * barycentric_side(i.y, v, weights_v) +
         weights_i.z * barycentric_side(i.z, v, weights_v);
}
)";
}

std::vector<GlTexture> Barycentric::textures() const {
  constexpr auto kSide = static_cast<int>(kFaceSide);
  std::vector<std::array<std::uint8_t, 4>> vertices;
  std::vector<std::array<std::uint16_t, 4>> weights;
  for (const Texel& texel : texels_) {
    vertices.push_back(texel.vertices);
    weights.push_back(texel.weights);
  }
  std::vector<float> samples = samples_;
  const std::size_t rows = (samples.size() / 3 + kSampleColumns - 1) / kSampleColumns;
  samples.resize(3 * kSampleColumns * rows);
  GlTexture vertex_map = {.name = "barycentric_vertices",
                          .format = GlFormat::kRgba8,
                          .width = kSide,
                          .height = kSide,
                          .bytes = bytes_of(vertices),
                          .filter = GlFilter::kNearest,
                          .cube = true};
  GlTexture weight_map = {.name = "barycentric_weights",
                          .format = GlFormat::kRgba16f,
                          .width = kSide,
                          .height = kSide,
                          .bytes = bytes_of(weights),
                          .filter = GlFilter::kNearest,
                          .cube = true};
  GlTexture values = {.name = "barycentric_samples",
                      .format = GlFormat::kRgb32f,
                      .width = static_cast<int>(kSampleColumns),
                      .height = static_cast<int>(rows),
                      .bytes = bytes_of(samples),
                      .filter = GlFilter::kNearest};
  return {std::move(vertex_map), std::move(weight_map), std::move(values)};
}

std::size_t Barycentric::table_5_bytes() const { return 9 * texels_.size() + 4 * samples_.size(); }

}  // namespace sbrdf::internal
