// Speed of the shaders of atlases beside that of barycentric interpolation (section 8 of the paper), on one device.
//
// usage: shader_benchmark [FRAMES [FILE]]
//   FRAMES  of each shader, 800 x 800 pixels each (default 50); the two shaders of a row take turns
//   FILE    a measured isotropic material, sliced as well
//
// Prints rows of a Markdown table. Each shader is first compared with its own evaluation on the processor.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "codec/atlas/shader.h"
#include "converters/files/by_name.h"
#include "converters/models/analytic.h"
#include "converters/slicing/slicing.h"
#include "tests/benchmarks/take.h"
#include "tests/gpu/atlas_checks.h"
#include "tests/gpu/barycentric/barycentric.h"
#include "tests/gpu/gl_harness.h"
#include "tests/gpu/shader_checks.h"

namespace sbrdf::internal {
namespace {

constexpr int kSide = 800;  // pixels
constexpr int kTurns = 10;  // of the two shaders
constexpr std::size_t kPairs = 60'000;

/// A dome that fills the picture, lit and seen at every pixel.
std::string shade(const std::string& function) {
  return fmt::format(R"(
vec4 shade(vec2 uv) {{
  vec3 n = normalize(vec3(1.4 * uv - 0.7, 1.0));
  vec3 t = normalize(vec3(n.z, 0.0, -n.x));
  mat3 surface = mat3(t, cross(n, t), n);
  vec3 light = normalize(vec3(0.5, 0.5, 0.8));
  return vec4({}(light * surface, vec3(0.0, 0.0, 1.0) * surface) * dot(n, light), 1.0);
}}
)",
                     function);
}

struct Shader {
  std::string text, function;
  std::vector<GlTexture> textures;

  [[nodiscard]] std::string drawing() const { return text + shade(function); }
};

ShaderCounts counts_of(const Shader& shader) {
  const std::string whole = "#version 450\n" + shader.text +
                            "\nlayout(location = 0) in vec3 w_i;\nlayout(location = 1) in vec3 w_v;\n"
                            "layout(location = 0) out vec4 colour;\nvoid main() { colour = vec4(" +
                            shader.function + "(w_i, w_v), 1.0); }\n";
  return take(count_instructions(whole));
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

struct Times {
  std::vector<double> frames, processor;  // [s]

  void add(const GlTiming& timing) {
    frames.insert(frames.end(), timing.frames.begin(), timing.frames.end());
    processor.insert(processor.end(), timing.processor.begin(), timing.processor.end());
  }
};

/// The third of the pairs that lies anywhere: on planes of symmetry and where both are equally inclined, rounding
/// chooses between places that hold the same value, but for the errors of compressed blocks.
Pairs drawn_pairs() {
  const Pairs all = draw_pairs(kPairs);
  Pairs kept;
  for (std::size_t k = 0; k < all.i.size(); ++k) {
    if (k % 3 != 0) continue;
    kept.i.push_back(all.i[k]);
    kept.v.push_back(all.v[k]);
  }
  return kept;
}

class Benchmark {
 public:
  Benchmark(GlContext& context, int frames) : context_(context), frames_(frames) {
    const auto source = make_analytic_source(kurt_material("fabric112").value());
    const Barycentric barycentric(*source, paper_scheme("14").value());
    baseline_ = {Barycentric::shader(), "barycentric_eval", barycentric.textures()};
    check_baseline(barycentric);
    const ShaderCounts counts = counts_of(baseline_);
    std::cout << "barycentric: " << counts.fetches << " fetches, " << counts.instructions << " instructions\n\n"
              << "| material | texels | fetches | instructions | largest difference | barycentric ms | this ms | ratio "
                 "| barycentric processor ms | this | ratio |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  }

  void run(const std::string& name, const BrdfSource& source, const SliceOptions& options,
           const std::vector<TexelFormat>& texels) {
    const DecodedSliced sliced = take(sliced_of(source, options));
    for (const TexelFormat texel : texels) {
      AtlasOptions atlas_options;
      atlas_options.texel = texel;
      atlas_options.max_error_percent = 1;
      atlas_options.fast = true;
      time(name, take(make_atlas(sliced, source, atlas_options)));
    }
  }

 private:
  void check_baseline(const Barycentric& barycentric) {
    const std::vector<float> values =
        take(run_shader(context_, baseline_.text, baseline_.function, baseline_.textures, pairs_));
    std::size_t off = 0;
    for (std::size_t k = 0; k < pairs_.i.size(); ++k) {
      const std::array<float, 3> expected = barycentric.evaluate(pairs_.i[k], pairs_.v[k]);
      double error = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        error = std::max(error, std::abs(double{values[3 * k + c]} / double{expected[c]} - 1));
      }
      if (!(error <= 1e-4)) ++off;
    }
    // On the border of two texels rounding decides which one is read.
    if (off > pairs_.i.size() / 500) fail(fmt::format("the baseline is wrong for {} pairs", off));
  }

  void time(const std::string& name, const MadeAtlas& made) {
    const Shader shader = {atlas_shader(made.atlas), "sbrdf_eval", {texture_of(made.texture)}};
    const std::vector<float> values = take(run_shader(context_, shader.text, shader.function, shader.textures, pairs_));
    const ShaderDifference off = difference(made.atlas, pairs_, values);
    if (off.largest > 2e-3) fail(fmt::format("{}: the shader is off by {}", name, off.largest));
    Times of_baseline, of_this;
    for (int turn = 0; turn < kTurns; ++turn) {
      of_baseline.add(draw(baseline_));
      of_this.add(draw(shader));
    }
    const ShaderCounts counts = counts_of(shader);
    const double baseline_ms = 1e3 * median(of_baseline.frames), this_ms = 1e3 * median(of_this.frames);
    const double baseline_work = 1e3 * median(of_baseline.processor), this_work = 1e3 * median(of_this.processor);
    std::cout << fmt::format(
                     "| {} | {} {}x{} | {} | {} | {:.1e} | {:.1f} | {:.1f} | {:.2f} | {:.1f} | {:.1f} | {:.2f} |\n",
                     name, name_of(kTexelFormatNames, made.texture.format), made.texture.width, made.texture.height,
                     counts.fetches, counts.instructions, off.largest, baseline_ms, this_ms, this_ms / baseline_ms,
                     baseline_work, this_work, this_work / baseline_work)
              << std::flush;
  }

  GlTiming draw(const Shader& shader) {
    return take(context_.time_frames(shader.drawing(), shader.textures, kSide, kSide, (frames_ + kTurns - 1) / kTurns));
  }

  GlContext& context_;
  int frames_;
  Pairs pairs_ = drawn_pairs();
  Shader baseline_;
};

SliceOptions searched_options(FrameId frame, bool use_mirrors) {
  SliceOptions options;
  options.stop = SampleCount{1500};
  options.structure = SearchedStructure{.frame = frame, .use_mirrors = use_mirrors, .evaluations = 20};
  return options;
}

void run_all(int frames, const char* file) {
  GlContext context = take(GlContext::make());
  std::cout << context.driver() << ", " << kSide << " x " << kSide << "\n\n";
  Benchmark benchmark(context, frames);
  // Not BC6H: a processor unpacks a block for each texel that is read.
  const std::vector<TexelFormat> all = {TexelFormat::kRgba32f, TexelFormat::kRgba16f, TexelFormat::kE5b9g9r9};
  const std::vector<TexelFormat> halves = {TexelFormat::kRgba16f};
  const AnalyticModel fabric = kurt_material("fabric112").value();
  const auto anisotropic = make_analytic_source(fabric);
  benchmark.run("anisotropic, elevation 14/36", *anisotropic, paper_options(), all);
  benchmark.run("anisotropic, half/difference, mirrors", *anisotropic, searched_options(FrameId::kHalfDifference, true),
                halves);
  benchmark.run("anisotropic, half/difference", *anisotropic, searched_options(FrameId::kHalfDifference, false),
                halves);
  AnalyticModel turned = fabric;
  for (AnalyticLobe& lobe : turned.lobes) lobe.m_y = lobe.m_x;
  const auto isotropic = make_analytic_source(turned);
  benchmark.run("isotropic, elevation", *isotropic, searched_options(FrameId::kElevation, true), halves);
  benchmark.run("isotropic, half/difference", *isotropic, searched_options(FrameId::kHalfDifference, true), all);
  if (file == nullptr) return;
  const OpenedSource opened = take(open_source(file));
  SliceOptions options;
  options.stop = SampleCount{3000};
  benchmark.run("measured, isotropic", *opened.source, options, halves);
}

}  // namespace
}  // namespace sbrdf::internal

int main(int argument_count, char** arguments) {
  const int frames = argument_count > 1 ? std::atoi(arguments[1]) : 50;
  sbrdf::internal::run_all(std::max(frames, 1), argument_count > 2 ? arguments[2] : nullptr);
}
