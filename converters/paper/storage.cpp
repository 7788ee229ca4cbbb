#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "converters/baselines/barycentric.h"
#include "converters/baselines/cube_map.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/files/atlas/paper/make_paper.h"
#include "converters/models/analytic.h"
#include "converters/paper/reproduce.h"
#include "formats/texture/exr_texture.h"
#include "formats/texture/ktx2.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kRgb32fBytes = 12;
constexpr std::uint64_t kLookUpBytes = 9;      // of a texel of the cube maps
constexpr std::uint32_t kSampleColumns = 128;  // of the texture of samples
constexpr double kDegreesOfTexel = 1;

/// Section 8 of the paper: crossings, axial and diagonal slices in areas of their elevations, horizontal ones.
std::uint64_t texels_of(const Placement& placement) {
  const auto elevations = static_cast<std::uint64_t>(std::ceil(kPaperThetaMaxDeg / placement.elevation_step_deg));
  const auto azimuths = static_cast<std::uint64_t>(std::lround(360 / placement.azimuth_step_deg));
  const std::uint64_t areas = elevations * (elevations + 1) / 2;
  const auto along = static_cast<std::uint64_t>(360 / kDegreesOfTexel);
  return areas * (azimuths + 1) * (2 * azimuths + 1) + 2 * areas * (azimuths + 1) * along +
         azimuths * (2 * azimuths + 1) * (along / 4) * elevations;
}

/// As the paper places and interpolates them, or with logarithms, placed by the true error and fitted.
enum class SlicesOf : std::uint8_t { kPaper, kProgram };
Result<DecodedSliced> slices_with(const BrdfSource& source, std::uint64_t samples, SlicesOf whose,
                                  const Progress& progress) {
  SliceOptions options;
  options.stop = SampleCount{samples};
  options.structure = table_3_placement(samples);
  options.domain = whose == SlicesOf::kPaper ? DomainKind::kLinear : DomainKind::kLog;
  options.refinement = whose == SlicesOf::kPaper ? Refinement::kByMeasured : Refinement::kBySource;
  options.precision = 0;
  Result<Slicing> slicing = slice_source(source, options, progress);
  if (!slicing) return slicing.error();
  return DecodedSliced{std::move(slicing->sliced), std::move(slicing->lattice)};
}

Result<TextureSizes> proposed(const DecodedSliced& sliced, const BrdfSource& source, std::size_t count) {
  AtlasOptions options;
  options.texel = TexelFormat::kRgb32f;
  options.container = AtlasContainer::kExr;
  const Result<MadePaper> made = make_paper(sliced, source, options);
  if (!made) return made.error();
  const Placement placement = table_3_placement(kPaperCounts[count]);
  TextureSizes sizes{"proposed", placement_text(placement), kPaperCounts[count], kPaperProposedMegabytes[count],
                     kRgb32fBytes * texels_of(placement)};
  sizes.texel_bytes = made->texel_bytes();
  for (std::size_t k = 0; k < kPaperTextureCount; ++k) {
    Result<std::vector<std::byte>> bytes = pack_texture(made->packed[k], options);
    if (!bytes) return bytes.error();
    sizes.files.push_back(
        {fmt::format("proposed_{}_{}.exr", sizes.samples, kPaperTextureNames[k].name), *std::move(bytes)});
  }
  sizes.of_source = made->of_source;
  return sizes;
}

template <class T>
void append(std::vector<std::uint8_t>& bytes, std::span<const T> values) {
  const auto* const first = reinterpret_cast<const std::uint8_t*>(values.data());
  bytes.insert(bytes.end(), first, first + values.size_bytes());
}

/// The two cube maps, and the samples in rows.
Result<std::vector<TextureSizes::File>> files_of(const BarycentricCube& cube, const SchemeSamples& samples,
                                                 std::uint64_t& texel_bytes) {
  CubeTexture vertices{CubeTexture::Texel::kRgb8, BarycentricCube::kFaceSide, {}};
  CubeTexture weights{CubeTexture::Texel::kRgb16f, BarycentricCube::kFaceSide, {}};
  for (const BarycentricCube::Texel& texel : cube.texels) {
    append(vertices.bytes, std::span<const std::uint8_t>(texel.vertices));
    append(weights.bytes, std::span<const std::uint16_t>(texel.weights));
  }
  const std::size_t pairs = samples.values.size() / 3;
  Texture values{TexelFormat::kRgb32f,
                 kSampleColumns,
                 static_cast<std::uint32_t>((pairs + kSampleColumns - 1) / kSampleColumns),
                 {}};
  append(values.bytes, std::span<const float>(samples.values));
  texel_bytes = vertices.bytes.size() + weights.bytes.size() + values.bytes.size();  // the last row is not full
  values.bytes.resize(texture_bytes(values.format, values.width, values.height));
  Result<std::vector<std::byte>> vertex_file = write_ktx2_cube(vertices);
  if (!vertex_file) return vertex_file.error();
  Result<std::vector<std::byte>> weight_file = write_ktx2_cube(weights);
  if (!weight_file) return weight_file.error();
  Result<std::vector<std::byte>> value_file = write_exr_texture(values);
  if (!value_file) return value_file.error();
  std::vector<TextureSizes::File> files;
  files.push_back({"vertices.ktx2", *std::move(vertex_file)});
  files.push_back({"weights.ktx2", *std::move(weight_file)});
  files.push_back({"samples.exr", *std::move(value_file)});
  return files;
}

Result<TextureSizes> barycentric(const DecodedSliced& sliced, const BrdfSource& source, std::size_t count) {
  const Result<UniformScheme> scheme = paper_scheme(kPaperSchemes[count]);
  if (!scheme) return scheme.error();
  const Result<BarycentricCube> cube = BarycentricCube::make(*scheme);
  if (!cube) return cube.error();
  Result<SchemeSamples> samples = sample_scheme(source, *scheme);
  if (!samples) return samples.error();
  TextureSizes sizes{"barycentric", "scheme " + std::string(kPaperSchemes[count]), kPaperCounts[count],
                     kPaperBarycentricMegabytes[count],
                     kLookUpBytes * cube->texels.size() + kRgb32fBytes * scheme->reciprocal_pair_count()};
  Result<std::vector<TextureSizes::File>> files = files_of(*cube, *samples, sizes.texel_bytes);
  if (!files) return files.error();
  for (TextureSizes::File& file : *files) file.name = fmt::format("barycentric_{}_{}", sizes.samples, file.name);
  sizes.files = *std::move(files);
  const Result<std::unique_ptr<SchemeSource>> interpolated = BarycentricSource::make(*std::move(samples));
  if (!interpolated) return interpolated.error();
  const Result<AtlasJudge> judge = AtlasJudge::make(sliced, source);
  if (!judge) return judge.error();
  sizes.of_source = judge
                        ->errors([&](const DirectionPair& pair, std::span<float, 3> rgb) {
                          (*interpolated)->evaluate(std::span(&pair, 1), rgb);
                        })
                        .to_source;
  return sizes;
}

Result<TextureSizes> engine(const BrdfSource& source, std::size_t count, const Progress& progress) {
  StepwiseProgress steps(progress);
  const Result<DecodedSliced> sliced = slices_with(source, kPaperCounts[count], SlicesOf::kProgram, steps.step(0.3));
  if (!sliced) return sliced.error();
  AtlasOptions options;
  options.texel = TexelFormat::kBc6hUnsigned;
  const Result<MadeAtlas> made = make_atlas(*sliced, source, options, steps.step(1));
  if (!made) return made.error();
  TextureSizes sizes{"engine layout", "BC6H", kPaperCounts[count], {}, {}};
  sizes.texel_bytes = made->texture.bytes.size();
  Result<std::vector<std::byte>> bytes = pack_texture(made->texture, options);
  if (!bytes) return bytes.error();
  sizes.files.push_back({fmt::format("engine_{}.ktx2", sizes.samples), *std::move(bytes)});
  sizes.of_source = made->of_source;
  return sizes;
}

}  // namespace

std::uint64_t TextureSizes::file_bytes() const {
  std::uint64_t bytes = 0;
  for (const File& file : files) bytes += file.bytes.size();
  return bytes;
}

Result<std::vector<TextureSizes>> reproduce_storage(const std::string& material, const Progress& progress) {
  const Result<AnalyticModel> found = kurt_material(material);
  if (!found) return found.error();
  const std::unique_ptr<BrdfSource> source = make_analytic_source(*found);
  StepwiseProgress steps(progress);
  std::vector<TextureSizes> rows;
  for (std::size_t count = 0; count < kPaperCounts.size(); ++count) {
    const Result<DecodedSliced> sliced = slices_with(*source, kPaperCounts[count], SlicesOf::kPaper, steps.step(0.1));
    if (!sliced) return sliced.error();
    const auto add = [&](Result<TextureSizes> sizes) -> Status {
      if (!sizes) return sizes.error();
      rows.push_back(*std::move(sizes));
      return ok_status();
    };
    if (Status made = add(proposed(*sliced, *source, count)); !made) return made.error();
    if (Status made = add(barycentric(*sliced, *source, count)); !made) return made.error();
    if (Status made = add(engine(*source, count, steps.step(count == 0 ? 0.4 : 1))); !made) return made.error();
  }
  if (!steps.finish()) return interrupted_error();
  return rows;
}

}  // namespace sbrdf::internal
