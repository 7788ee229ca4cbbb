#include "tests/gpu/atlas_checks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "codec/atlas/atlas_evaluator.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

glm::vec3 unit(double theta_deg, double phi_deg) {
  const double theta = radians_from_degrees(theta_deg);
  const double phi = radians_from_degrees(phi_deg);
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

}  // namespace

Pairs draw_pairs(std::size_t count) {
  std::mt19937 random(5);
  const auto share = [&] { return static_cast<double>(random()) / 4294967296.0; };
  Pairs pairs;
  for (std::size_t k = 0; k < count; ++k) {
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

SliceOptions paper_options() {
  SliceOptions options;
  options.stop = SampleCount{8911};
  options.structure = Placement{14, 36};
  options.domain = DomainKind::kLog;
  options.fit_values = false;
  options.precision = 0.001;
  return options;
}

Result<DecodedSliced> sliced_of(const BrdfSource& source, const SliceOptions& options) {
  Result<Slicing> slicing = slice_source(source, options);
  if (!slicing) return slicing.error();
  DecodedSliced decoded;
  decoded.sliced = std::move(slicing->sliced);
  decoded.lattice = std::move(slicing->lattice);
  return decoded;
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

Result<std::vector<float>> run_shader(GlContext& context, const std::string& shader, const std::string& function,
                                      std::span<const GlTexture> textures, const Pairs& pairs) {
  std::vector<float> inputs;
  inputs.reserve(8 * pairs.i.size());
  for (std::size_t k = 0; k < pairs.i.size(); ++k) {
    for (const glm::vec3& w : {pairs.i[k], pairs.v[k]}) inputs.insert(inputs.end(), {w.x, w.y, w.z, 0.0F});
  }
  const std::string run = fmt::format("\nvec3 run(vec3 a, vec3 b) {{ return {}(a, b); }}\n", function);
  return context.evaluate(shader + run, textures, inputs);
}

ShaderDifference difference(const Atlas& atlas, const Pairs& pairs, std::span<const float> values) {
  const AtlasEvaluator evaluator(atlas);
  std::vector<float> expected(values.size());
  double mean = 0;
  for (std::size_t k = 0; k < pairs.i.size(); ++k) {
    const DirectionPair pair = {direction_from_vector(glm::dvec3(pairs.i[k])),
                                direction_from_vector(glm::dvec3(pairs.v[k]))};
    evaluator.evaluate(pair, std::span<float, 3>(expected.data() + 3 * k, 3));
    for (std::size_t c = 0; c < 3; ++c)
      mean += std::abs(double{expected[3 * k + c]}) / static_cast<double>(values.size());
  }
  ShaderDifference found;
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

}  // namespace sbrdf::internal
