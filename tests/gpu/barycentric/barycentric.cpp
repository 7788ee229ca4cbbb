#include "tests/gpu/barycentric/barycentric.h"

#include <cstring>

#include "converters/baselines/scheme_samples.h"
#include "formats/core/half.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kSampleColumns = 128;  // of their texture

template <class T>
std::vector<std::byte> bytes_of(const std::vector<T>& values) {
  std::vector<std::byte> bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

}  // namespace

Barycentric::Barycentric(const BrdfSource& source, const UniformScheme& scheme)
    : directions_(scheme_directions(scheme)),
      cube_(BarycentricCube::make(scheme).value()),
      samples_(sample_scheme(source, scheme).value().values) {}

std::array<float, 3> Barycentric::evaluate(const glm::vec3& w_i, const glm::vec3& w_v) const {
  std::array<float, 3> value{};
  if (w_i.z < 0 || w_v.z < 0) return value;
  const BarycentricCube::Texel& i = cube_.at(glm::dvec3(w_i));
  const BarycentricCube::Texel& v = cube_.at(glm::dvec3(w_v));
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
  constexpr auto kSide = static_cast<int>(BarycentricCube::kFaceSide);
  std::vector<std::array<std::uint8_t, 4>> vertices;
  std::vector<std::array<std::uint16_t, 4>> weights;
  for (const auto& [of_three, weights_of_three] : cube_.texels) {
    vertices.push_back({of_three[0], of_three[1], of_three[2], 0});
    weights.push_back({weights_of_three[0], weights_of_three[1], weights_of_three[2], 0});
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

std::size_t Barycentric::table_5_bytes() const { return 9 * cube_.texels.size() + 4 * samples_.size(); }

}  // namespace sbrdf::internal
