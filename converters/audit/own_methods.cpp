#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "codec/file/encoder.h"
#include "codec/file/reader.h"
#include "codec/series/series_file.h"
#include "converters/audit/methods.h"
#include "converters/files/atlas/atlas_file.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/files/atlas/manifest.h"
#include "converters/files/atlas/paper/make_paper.h"
#include "converters/files/atlas/paper/paper_file.h"
#include "converters/files/atlas/paper/paper_manifest.h"
#include "converters/slicing/placements.h"
#include "converters/slicing/slicing.h"
#include "formats/core/byte_source.h"
#include "formats/sbrdf/container.h"

// The ways that this library adds: files of slices, dense files, textures.

namespace sbrdf::internal {
namespace {

constexpr int kTries = 2;
/// A file that is nearer to the target than this need not be searched for again.
constexpr double kNear = 0.93;

/// Of a file of slices or coefficients.
std::uint64_t overhead_of(const std::vector<std::byte>& bytes) {
  const std::uint64_t head = head_size_of(0);
  const OwnedMemorySource file(bytes);
  if (is_series_file(file)) {
    Result<SeriesBrdf> brdf = decode_series(file);
    if (!brdf) return 0;
    brdf->metadata.clear();
    return head + (bytes.size() - encode_series(*brdf).size());
  }
  const Result<SlicedReader> reader = SlicedReader::open(file);
  if (!reader) return 0;
  const auto& chunks = reader->index().chunk_sizes;
  const auto stored = std::count_if(chunks.begin(), chunks.end(), [](std::uint32_t size) { return size > 0; });
  return head + reader->index().metadata.size() + kChecksumSize * static_cast<std::uint64_t>(stored);
}

/// "1,024 samples within 2 %", or "90 coefficients".
std::string setting_of(const FileBytes& file) {
  const OwnedMemorySource bytes(*file);
  if (is_series_file(bytes)) {
    const Result<SeriesBrdf> brdf = decode_series(bytes);
    return brdf ? fmt::format("{} coefficients", brdf->coefficient_count()) : std::string();
  }
  const Result<SlicedReader> reader = SlicedReader::open(bytes);
  if (!reader) return "";
  const SlicedIndex& index = reader->index();
  const std::size_t samples = reader->lattice().crossings.size() + index.adaptive_count + index.guide_count;
  return fmt::format("{} samples within {:.3g} %", samples, index.scale.lossless() ? 0 : 100 * index.scale.bound());
}

/// `make` of an error that is asked for [%], until what comes is just within the target: writers look at other
/// directions than this audit.
template <class Make>
Result<Found> find_by_target(double percent, const Make& make) {
  Smallest smallest(percent);
  double goal = 0.98 * percent;
  for (int k = 0; k < kTries; ++k) {
    Result<Kept> kept = make(goal);
    if (!kept) {
      if (!smallest.complain(kept.error())) return kept.error();
      break;
    }
    const double came = kept->percent;
    const bool reached = smallest.take(*std::move(kept));
    if (reached && came >= kNear * percent) break;
    goal *= std::clamp(0.995 * percent / came, 0.5, 1.5);
  }
  return std::move(smallest).found();
}

Result<Found> find_by_options(Workbench& bench, double percent, const Options& options, const Progress& progress) {
  StepwiseProgress steps(progress);
  return find_by_target(percent, [&](double goal) -> Result<Kept> {
    Options asked = options;
    asked.set("target-rel-l1", fmt::format("{:.6g}", goal));
    const Result<FileBytes> file = bench.file(".sbrdf", asked, steps.step(0.6));
    if (!file) return file.error();
    Result<Kept> kept = bench.kept(setting_of(*file), *file, {});
    if (!kept) return kept.error();
    kept->overhead = overhead_of(**file);
    return kept;
  });
}

Result<DecodedSliced> lossless_slices(Workbench& bench, SliceOptions options, const Progress& progress) {
  options.precision = 0;
  Result<Slicing> slicing = slice_source(bench.subject().source(), options, progress);
  if (!slicing) return slicing.error();
  DecodedSliced decoded;
  decoded.sliced = std::move(slicing->sliced);
  decoded.lattice = std::move(slicing->lattice);
  return decoded;
}

/// Slices for textures: so far off the source [%].
Result<DecodedSliced> slices_for(Workbench& bench, double percent, const Progress& progress) {
  SliceOptions options;
  options.stop = TargetRelL1{percent};
  options.structure = SearchedStructure{.evaluations = 20};  // texels hide what more would gain
  return lossless_slices(bench, options, progress);
}

Result<Kept> kept_atlas(Workbench& bench, const DecodedSliced& sliced, const AtlasOptions& options,
                        const Progress& progress) {
  Result<MadeAtlas> made = make_atlas(sliced, bench.subject().source(), options, progress);
  if (!made) return made.error();
  const Result<std::vector<std::byte>> packed = pack_texture(made->texture, options);
  if (!packed) return packed.error();
  Kept kept;
  const AtlasLayout& layout = made->atlas.layout;
  kept.setting =
      fmt::format("{} x {} texels {}", layout.width, layout.height, name_of(kTexelFormatNames, made->texture.format));
  AtlasFiles files;
  files.texture = "material.ktx2";
  files.texel = made->texture.format;
  const std::uint64_t manifest = emit_manifest(made->atlas, files, {}).size();
  kept.bytes = packed->size() + manifest;
  kept.overhead = packed->size() - std::min<std::size_t>(packed->size(), made->texture.bytes.size()) + manifest;
  const auto atlas = std::make_shared<const Atlas>(std::move(made->atlas));
  kept.open = [atlas]() -> Result<std::unique_ptr<BrdfSource>> {
    return std::unique_ptr<BrdfSource>(std::make_unique<AtlasSource>(*atlas, "atlas"));
  };
  if (Status judged = bench.judge(kept); !judged) return judged.error();
  return kept;
}

Result<Kept> kept_paper(Workbench& bench, const Placement& placement, const Progress& progress) {
  // So many samples that what lies between texels is all that is lost.
  constexpr std::uint64_t kSamples = 60'000;
  SliceOptions options;
  options.stop = SampleCount{kSamples};
  options.structure = placement;
  options.fit_values = false;
  const Result<DecodedSliced> decoded = lossless_slices(bench, options, progress);
  if (!decoded) return decoded.error();
  AtlasOptions atlas;
  atlas.container = AtlasContainer::kExr;
  const Result<MadePaper> made = make_paper(*decoded, bench.subject().source(), atlas);
  if (!made) return made.error();
  Kept kept;
  kept.setting = fmt::format("slices at {:g}/{:g}, four EXR textures, half floats", placement.elevation_step_deg,
                             placement.azimuth_step_deg);
  for (const Texture& texture : made->packed) {
    const Result<std::vector<std::byte>> packed = pack_texture(texture, atlas);
    if (!packed) return packed.error();
    kept.bytes += packed->size();
  }
  kept.overhead = emit_paper_manifest(made->textures, {}, {}).size();
  kept.bytes += kept.overhead;
  const auto textures = std::make_shared<const PaperTextures>(made->textures);
  kept.open = [textures]() -> Result<std::unique_ptr<BrdfSource>> {
    return std::unique_ptr<BrdfSource>(std::make_unique<PaperSource>(*textures, "paper"));
  };
  if (Status judged = bench.judge(kept); !judged) return judged.error();
  return kept;
}

}  // namespace

Result<Found> find_sliced(Workbench& bench, double percent, const Progress& progress) {
  return find_by_options(bench, percent, {}, progress);
}

Result<Found> find_sliced_tenth(Workbench& bench, double percent, const Progress& progress) {
  return find_by_options(bench, percent, Options().set("precision", "0.1%"), progress);
}

Result<Found> find_dense(Workbench& bench, double percent, const Progress& progress) {
  return find_by_options(bench, percent, Options().set("representation", "dense"), progress);
}

Result<Found> find_engine_atlas(Workbench& bench, double percent, const Progress& progress) {
  Smallest smallest(percent);
  StepwiseProgress steps(progress);
  double slices_percent = 0.7 * percent;
  for (int k = 0; k < 2 && !smallest.reached(); ++k, slices_percent /= 2) {
    const Result<DecodedSliced> sliced = slices_for(bench, slices_percent, steps.step(0.4));
    if (!sliced) {
      if (!smallest.complain(sliced.error())) return sliced.error();
      continue;
    }
    for (const TexelFormat texel : {TexelFormat::kBc6hUnsigned, TexelFormat::kE5b9g9r9}) {
      AtlasOptions options;
      options.texel = texel;
      for (const double share : {0.7, 0.35}) {
        options.max_error_percent = share * percent;
        Result<Kept> kept = kept_atlas(bench, *sliced, options, steps.step(0.3));
        if (kept && smallest.take(*std::move(kept))) break;
        if (kept) continue;
        if (!smallest.complain(kept.error())) return kept.error();
        break;
      }
    }
  }
  return std::move(smallest).found();
}

Result<Found> find_paper_atlas(Workbench& bench, double percent, const Progress& progress) {
  static constexpr std::array<Placement, 4> kPlacements = {{{28, 60}, {14, 36}, {10, 36}, {8, 20}}};
  Smallest smallest(percent);
  StepwiseProgress steps(progress);
  for (const Placement& placement : kPlacements) {
    Result<Kept> kept = kept_paper(bench, placement, steps.step(0.3));
    if (!kept) {
      if (!smallest.complain(kept.error())) return kept.error();
      continue;
    }
    if (smallest.take(*std::move(kept))) break;
  }
  return std::move(smallest).found();
}

}  // namespace sbrdf::internal
