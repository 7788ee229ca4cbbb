#include "converters/files/atlas/paper/make_paper.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "codec/atlas/paper/paper_evaluator.h"

namespace sbrdf::internal {

std::uint64_t MadePaper::texel_bytes() const {
  std::uint64_t bytes = 0;
  for (const Texture& texture : packed) bytes += texture.bytes.size();
  return bytes;
}

Status check_paper_options(const AtlasOptions& options) {
  if (options.texel != TexelFormat::kRgb32f && options.texel != TexelFormat::kRgba16f) {
    return usage_error(
        fmt::format("--layout paper holds signed values, which --texel {} does not; take rgb32f or rgba16f",
                    name_of(kTexelFormatNames, options.texel)));
  }
  return check_atlas_options(options);
}

Result<MadePaper> make_paper(const DecodedSliced& sliced, const BrdfSource& source, const AtlasOptions& options) {
  Result<PaperTextures> baked = bake_paper_textures(sliced.sliced, sliced.lattice);
  if (!baked) return baked.error();
  MadePaper made;
  made.textures = *std::move(baked);
  const TexelFormat texel = stored_texel(options);
  for (std::size_t k = 0; k < kPaperTextureCount; ++k) {
    PaperTexture& texture = made.textures.textures[k];
    TexelCounts counts;
    Result<Texture> packed = encode_texels(texel, texture.width, texture.height, texture.texels, counts);
    if (!packed) return packed.error();
    if (counts.clamped > 0) {
      return unsupported(fmt::format("{} channels of the {} texture are beyond half floats; take --texel rgb32f",
                                     counts.clamped, kPaperTextureNames[k].name));
    }
    made.packed[k] = *std::move(packed);
    Result<std::vector<float>> texels = decode_texels(made.packed[k]);
    if (!texels) return texels.error();
    texture.texels = *std::move(texels);
  }
  const Result<AtlasJudge> judge = AtlasJudge::make(sliced, source);
  if (!judge) return judge.error();
  const PaperEvaluator evaluator(made.textures);
  const AtlasJudge::Errors errors =
      judge->errors([&](const DirectionPair& pair, std::span<float, 3> rgb) { evaluator.evaluate(pair, rgb); });
  made.errors = errors.to_slices;
  made.of_source = errors.to_source;
  return made;
}

}  // namespace sbrdf::internal
