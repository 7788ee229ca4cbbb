#include "converters/files/atlas/make_atlas.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "codec/atlas/atlas_evaluator.h"
#include "codec/atlas/bake.h"
#include "codec/atlas/slice_values.h"
#include "codec/atlas/texel_range.h"
#include "formats/texture/dds.h"
#include "formats/texture/exr_texture.h"
#include "formats/texture/ktx2.h"

namespace sbrdf::internal {
namespace {

constexpr double kFirstTolerance = 0.04;
constexpr int kMostSteps = 8;  // each halves the tolerance
/// A finer atlas that is not nearer by so much is not worth its texels.
constexpr double kWorthIt = 0.9;
constexpr std::uint64_t kWorthOfNearer = 4;  // so many times the texels where the error is not reached otherwise
constexpr std::uint64_t kAnyNumber = std::numeric_limits<std::uint64_t>::max();

TexelRange range_of(TexelFormat format) {
  switch (format) {
    case TexelFormat::kRgb32f:
    case TexelFormat::kRgba32f:
      return TexelRange::kAsIs;
    case TexelFormat::kRgba16f:
    case TexelFormat::kBc6hSigned:
      return TexelRange::kSigned;
    case TexelFormat::kE5b9g9r9:
      return TexelRange::kUnsigned;
    case TexelFormat::kBc6hUnsigned:
      break;
  }
  return TexelRange::kBlocks;
}

class Maker {
 public:
  Maker(const DecodedSliced& sliced, const BrdfSource& source, const AtlasOptions& options)
      : sliced_(sliced), source_(source), options_(options) {}

  Result<MadeAtlas> make(const Progress& progress) {
    const Result<AtlasJudge> judge = AtlasJudge::make(sliced_, source_, options_.cells);
    if (!judge) return judge.error();
    std::vector<bool> kinds = {false};
    if (dense_axis(sliced_.lattice)) kinds.push_back(true);
    ProgressCounter counter(progress, kMostSteps * kinds.size());
    std::optional<MadeAtlas> best;
    for (const bool dense : kinds) {
      Result<MadeAtlas> made = make_kind(dense, best ? worth(*best) : kAnyNumber, *judge, counter);
      if (counter.stopped()) return interrupted_error();
      if (!made && !best && dense == kinds.back()) return made.error();
      if (made && (!best || is_better(*made, *best))) best = *std::move(made);
    }
    best->texels_of_all = texels_of_all(best->atlas.layout);
    // Only the one that is kept is worth a long search for its blocks.
    if (texel_block(options_.texel).side == 1 || options_.fast) return *std::move(best);
    Result<MadeAtlas> made =
        attempt(best->atlas.layout.dense_along.has_value(), best->tolerance, kAnyNumber, Bc6hSpeed::kThorough, *judge);
    if (!made) return made.error();
    made->reached = error_of(*made) <= options_.max_error_percent;
    made->texels_of_all = best->texels_of_all;
    return made;
  }

 private:
  /// How many texels another kind may have to be worth a look.
  static std::uint64_t worth(const MadeAtlas& made) {
    const std::uint64_t texels = std::uint64_t{made.texture.width} * made.texture.height;
    return made.reached ? texels : kWorthOfNearer * texels;
  }

  /// Bakes one kind of table with smaller and smaller tolerance.
  Result<MadeAtlas> make_kind(bool dense, std::uint64_t most_texels, const AtlasJudge& judge,
                              ProgressCounter& counter) const {
    std::optional<MadeAtlas> best;
    double tolerance = kFirstTolerance;
    bool in_vain = false;  // the last one was not worth it
    for (int step = 0; step < kMostSteps; ++step, tolerance /= 2) {
      if (!counter.advance()) return interrupted_error();
      Result<MadeAtlas> made = attempt(dense, tolerance, most_texels, Bc6hSpeed::kFast, judge);
      if (!made && best) break;  // too large for a texture
      if (!made) return made.error();
      const bool enough = error_of(*made) <= options_.max_error_percent;
      if (best && !enough) {
        if (in_vain) break;
        // Some have the bad luck of where their nodes fall: the next one may yet reach the error.
        in_vain = !is_worth_it(made->errors, best->errors);
        if (in_vain) continue;
      }
      best = *std::move(made);
      best->reached = enough;
      if (enough) break;
    }
    return *std::move(best);
  }

  /// The error that was asked for first, then fewer bytes; where neither reaches it, the smaller error.
  static bool is_better(const MadeAtlas& a, const MadeAtlas& b) {
    if (a.reached != b.reached) return a.reached;
    return a.reached ? a.texture.bytes.size() < b.texture.bytes.size() : error_of(a) < error_of(b);
  }

  /// Whether either error fell.
  static bool is_worth_it(const AtlasErrors& now, const AtlasErrors& before) {
    return now.mre_percent <= kWorthIt * before.mre_percent || now.rel_l1_percent <= kWorthIt * before.rel_l1_percent;
  }

  static double error_of(const MadeAtlas& made) {
    return std::max(made.errors.mre_percent, made.errors.rel_l1_percent);
  }

  Result<MadeAtlas> attempt(bool dense, double tolerance, std::uint64_t most_texels, Bc6hSpeed speed,
                            const AtlasJudge& judge) const {
    BakeOptions bake;
    bake.most_texels = most_texels;
    bake.dense = dense;
    bake.tolerance = tolerance;
    bake.blocks = texel_block(options_.texel).side > 1;
    bake.cells = options_.cells;
    Result<Atlas> baked = bake_atlas(sliced_.sliced, sliced_.lattice, bake);
    if (!baked) return baked.error();
    MadeAtlas made;
    made.tolerance = tolerance;
    made.atlas = *std::move(baked);
    use_range(made.atlas, range_of(options_.texel));
    const AtlasLayout& layout = made.atlas.layout;
    const TexelFormat texel = stored_texel(options_);
    Result<Texture> texture =
        encode_texels(texel, layout.width, layout.height, made.atlas.texels, made.counts, {speed, Bc6hMetric::kLinear});
    if (!texture) return texture.error();
    made.texture = *std::move(texture);
    Result<std::vector<float>> texels = decode_texels(made.texture);
    if (!texels) return texels.error();
    made.atlas.texels = *std::move(texels);
    const AtlasEvaluator evaluator(made.atlas);
    const AtlasJudge::Errors errors =
        judge.errors([&](const DirectionPair& pair, std::span<float, 3> rgb) { evaluator.evaluate(pair, rgb); });
    made.errors = errors.to_slices;
    made.of_source = errors.to_source;
    return made;
  }

  /// 0 where no texture holds them.
  static std::uint64_t texels_of_all(AtlasLayout layout) {
    layout.cells = {};
    if (!lay_out(layout, BakeOptions().most_side)) return 0;
    return std::uint64_t{layout.width} * layout.height;
  }

  const DecodedSliced& sliced_;
  const BrdfSource& source_;
  const AtlasOptions& options_;
};

}  // namespace

TexelFormat stored_texel(const AtlasOptions& options) {
  const bool wide = options.texel == TexelFormat::kRgb32f && options.container != AtlasContainer::kExr;
  return wide ? TexelFormat::kRgba32f : options.texel;
}

Status check_atlas_options(const AtlasOptions& options) {
  const bool half = options.texel == TexelFormat::kRgba16f;
  const bool floats = options.texel == TexelFormat::kRgb32f || options.texel == TexelFormat::kRgba32f;
  if (options.container == AtlasContainer::kExr && !half && !floats) {
    return usage_error("--container exr holds rgb32f and rgba16f; take ktx2 or dds");
  }
  if (options.container == AtlasContainer::kDds && half) {
    return usage_error("--container dds does not hold rgba16f, since common readers misread it; take ktx2 or exr");
  }
  if (options.fast && texel_block(options.texel).side == 1) return usage_error("--fast is for --texel bc6h");
  if (options.zstd && options.container != AtlasContainer::kKtx2) return usage_error("--zstd is for --container ktx2");
  return ok_status();
}

Result<MadeAtlas> make_atlas(const DecodedSliced& sliced, const BrdfSource& source, const AtlasOptions& options,
                             const Progress& progress) {
  if (Status held = check_atlas_channels(sliced.sliced.channel_count()); !held) return held.error();
  return Maker(sliced, source, options).make(progress);
}

Result<std::vector<std::byte>> pack_texture(const Texture& texture, const AtlasOptions& options) {
  switch (options.container) {
    case AtlasContainer::kExr:
      return write_exr_texture(texture);
    case AtlasContainer::kKtx2:
      return write_ktx2(texture, {.zstd = options.zstd});
    case AtlasContainer::kDds:
      break;
  }
  return write_dds(texture);
}

}  // namespace sbrdf::internal
