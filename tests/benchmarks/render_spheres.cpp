// Spheres drawn by the shaders of atlases, beside spheres of what they were made from.
//
// usage: render_spheres SAMPLES TEXEL OUT.ppm MATERIAL...
//   SAMPLES   directions that a material is sampled at; slices are searched for as `sbrdf atlas` does
//   TEXEL     rgba16f, bc6h, ...
//   OUT.ppm   the picture: for each material, three spheres: the shader's, the reference, ten times the difference
//   MATERIAL  kurt:NAME or a file
//
// Prints rows of a Markdown table. The light: one lamp, and a sky of weak ones all around.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "codec/atlas/shader.h"
#include "converters/files/by_name.h"
#include "formats/core/named.h"
#include "tests/benchmarks/take.h"
#include "tests/gpu/atlas_checks.h"
#include "tests/gpu/gl_harness.h"

namespace sbrdf::internal {
namespace {

constexpr std::size_t kSide = 128;   // of a sphere [pixels]
constexpr std::size_t kAcross = 2;   // materials beside each other
constexpr std::size_t kSpheres = 3;  // of a material
constexpr std::size_t kSkyLamps = 16;
constexpr float kDifferenceScale = 10;

struct Lamp {
  glm::vec3 direction{}, radiance{};
};

/// A lamp at the upper left; the sky is blue above, brown below, and spread by the golden angle.
std::vector<Lamp> lamps() {
  std::vector<Lamp> all = {{glm::normalize(glm::vec3(-0.5F, 0.6F, 0.7F)), glm::vec3(2.5F)}};
  for (std::size_t k = 0; k < kSkyLamps; ++k) {
    const double y = 1 - 2 * (static_cast<double>(k) + 0.5) / kSkyLamps;
    const double turn = 2.399963229728653 * static_cast<double>(k);
    const double across = std::sqrt(1 - y * y);
    const auto up = static_cast<float>((y + 1) / 2);
    const glm::vec3 colour = up * glm::vec3(0.5F, 0.7F, 1.0F) + (1 - up) * glm::vec3(0.35F, 0.25F, 0.2F);
    all.push_back({glm::vec3(glm::dvec3(across * std::cos(turn), y, across * std::sin(turn))),
                   colour * (4.0F / static_cast<float>(kSkyLamps))});
  }
  return all;
}

/// The surface at a pixel: rows are the tangent (around the axis of the sphere), the bitangent and the normal.
struct Point {
  bool hit = false;
  std::array<glm::vec3, 3> frame{};

  [[nodiscard]] glm::vec3 local(const glm::vec3& w) const {
    return {glm::dot(w, frame[0]), glm::dot(w, frame[1]), glm::dot(w, frame[2])};
  }
};

Point point_at(std::size_t column, std::size_t row) {
  const auto at = [](std::size_t k) { return (2 * static_cast<float>(k) + 1) / static_cast<float>(kSide) - 1; };
  const glm::vec2 p = glm::vec2(at(column), -at(row)) / 0.96F;
  const float squared = glm::dot(p, p);
  if (squared >= 1) return {};
  const glm::vec3 n(p, std::sqrt(1 - squared));
  const glm::vec3 t = glm::normalize(glm::vec3(n.z, 0, -n.x));
  return {true, {t, glm::cross(n, t), n}};
}

/// Every pixel of the sphere under every lamp that reaches it.
struct Scene {
  Pairs pairs;
  std::vector<std::size_t> pixels;   // of each pair
  std::vector<glm::vec3> radiances;  // of each pair: the lamp's, times the cosine

  Scene() {
    const std::vector<Lamp> all = lamps();
    for (std::size_t pixel = 0; pixel < kSide * kSide; ++pixel) {
      const Point point = point_at(pixel % kSide, pixel / kSide);
      if (!point.hit) continue;
      for (const Lamp& lamp : all) {
        const glm::vec3 light = point.local(lamp.direction);
        if (light.z <= 0) continue;
        pairs.i.push_back(light);
        pairs.v.push_back(point.local({0, 0, 1}));
        pixels.push_back(pixel);
        radiances.push_back(lamp.radiance * light.z);
      }
    }
  }

  [[nodiscard]] std::vector<glm::vec3> picture(const std::vector<float>& values) const {
    std::vector<glm::vec3> sums(kSide * kSide, glm::vec3(0));
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      sums[pixels[k]] += radiances[k] * glm::vec3(values[3 * k], values[3 * k + 1], values[3 * k + 2]);
    }
    return sums;
  }
};

class Sheet {
 public:
  explicit Sheet(std::size_t materials)
      : width_(kAcross * kSpheres * kSide), height_((materials + kAcross - 1) / kAcross * kSide) {
    bytes_.assign(3 * width_ * height_, 24);
  }

  void put(std::size_t material, std::size_t sphere, const std::vector<glm::vec3>& picture, float exposure) {
    const std::size_t left = (material % kAcross * kSpheres + sphere) * kSide;
    const std::size_t top = material / kAcross * kSide;
    for (std::size_t pixel = 0; pixel < picture.size(); ++pixel) {
      if (!point_at(pixel % kSide, pixel / kSide).hit) continue;
      const std::size_t at = 3 * ((top + pixel / kSide) * width_ + left + pixel % kSide);
      for (glm::length_t c = 0; c < 3; ++c)
        bytes_[at + static_cast<std::size_t>(c)] = code(exposure * picture[pixel][c]);
    }
  }

  void save(const std::string& path) const {
    std::ofstream file(path, std::ios::binary);
    file << "P6\n" << width_ << ' ' << height_ << "\n255\n";
    file.write(reinterpret_cast<const char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
    if (!file.flush()) fail("cannot write " + path);
  }

 private:
  // sRGB
  static unsigned char code(float value) {
    const float linear = std::clamp(value, 0.0F, 1.0F);
    const float coded = linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
    return static_cast<unsigned char>(std::lround(255 * coded));
  }

  std::size_t width_, height_;
  std::vector<unsigned char> bytes_;
};

struct PictureDifference {
  double mean = 0;       // of the mean of the reference
  double largest = 0;    // of the largest of the reference
  double reference = 0;  // mean
};

PictureDifference compare(const std::vector<glm::vec3>& shader, const std::vector<glm::vec3>& reference) {
  PictureDifference found;
  double sum = 0, most = 0;
  for (std::size_t pixel = 0; pixel < shader.size(); ++pixel) {
    for (glm::length_t c = 0; c < 3; ++c) {
      const double off = std::abs(double{shader[pixel][c]} - double{reference[pixel][c]});
      found.mean += off;
      found.largest = std::max(found.largest, off);
      sum += std::abs(double{reference[pixel][c]});
      most = std::max(most, std::abs(double{reference[pixel][c]}));
    }
  }
  found.mean /= sum;
  found.largest /= most;
  std::size_t hit = 0;
  for (std::size_t pixel = 0; pixel < shader.size(); ++pixel) hit += point_at(pixel % kSide, pixel / kSide).hit ? 1 : 0;
  found.reference = sum / static_cast<double>(3 * hit);
  return found;
}

void render(GlContext& context, const Scene& scene, const std::string& name, const SliceOptions& slice_options,
            const AtlasOptions& atlas_options, std::size_t number, Sheet& sheet) {
  const OpenedSource opened = take(open_source(name));
  const BrdfSource& source = *opened.source;
  const MadeAtlas made = take(make_atlas(take(sliced_of(source, slice_options)), source, atlas_options));
  const GlTexture texture = texture_of(made.texture);
  const auto drawn = scene.picture(
      take(run_shader(context, atlas_shader(made.atlas), "sbrdf_eval", std::span(&texture, 1), scene.pairs)));
  std::vector<float> values(3 * scene.pairs.i.size());
  evaluate_in_parallel(source, scene.pairs.i, scene.pairs.v, values);
  const auto reference = scene.picture(values);
  const PictureDifference found = compare(drawn, reference);
  const float exposure = 0.25F / static_cast<float>(found.reference);
  std::vector<glm::vec3> difference(drawn.size());
  for (std::size_t k = 0; k < drawn.size(); ++k) difference[k] = kDifferenceScale * glm::abs(drawn[k] - reference[k]);
  sheet.put(number, 0, drawn, exposure);
  sheet.put(number, 1, reference, exposure);
  sheet.put(number, 2, difference, exposure);
  const std::string short_name = name.substr(name.find_last_of(":/") + 1);
  std::cout << fmt::format("| {} | {} | {:.3f} | {:.2f} |\n", short_name.substr(0, short_name.find('.')),
                           made.texture.bytes.size(), 100 * found.mean, 100 * found.largest)
            << std::flush;
}

int run(int samples, const std::string& texel, const std::string& out, const std::vector<std::string>& materials) {
  GlContext context = take(GlContext::make());
  SliceOptions slice_options;
  slice_options.stop = SampleCount{static_cast<std::uint64_t>(samples)};
  AtlasOptions atlas_options;
  const auto format = value_of(kTexelFormatNames, texel);
  if (!format) fail("no texels are called " + texel);
  atlas_options.texel = *format;
  const Scene scene;
  Sheet sheet(materials.size());
  std::cout << "| material | bytes of texels | mean difference % | largest difference % |\n|---|---|---|---|\n";
  for (std::size_t k = 0; k < materials.size(); ++k) {
    render(context, scene, materials[k], slice_options, atlas_options, k, sheet);
  }
  sheet.save(out);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace sbrdf::internal

int main(int argument_count, char** arguments) {
  if (argument_count < 5) sbrdf::internal::fail("usage: render_spheres SAMPLES TEXEL OUT.ppm MATERIAL...");
  return sbrdf::internal::run(std::atoi(arguments[1]), arguments[2], arguments[3],
                              std::vector<std::string>(arguments + 4, arguments + argument_count));
}
