#include "converters/files/atlas/paper/paper_file.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "converters/files/atlas/atlas_file.h"
#include "converters/files/atlas/paper/paper_manifest.h"

namespace sbrdf::internal {

PaperSource::PaperSource(PaperTextures textures, std::string description)
    : textures_(std::move(textures)),
      evaluator_(textures_),
      traits_(traits_of_textures(textures_.isotropic, textures_.elevations_deg.back(), std::move(description))) {}

void PaperSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    evaluator_.evaluate(pairs[k], std::span<float, 3>(values.data() + 3 * k, 3));
  }
}

Result<std::unique_ptr<BrdfSource>> open_paper(const ByteSource& manifest, std::string_view json) {
  Result<PaperManifest> parsed = parse_paper_manifest(json);
  if (!parsed) return parsed.error();
  for (std::size_t k = 0; k < kPaperTextureCount; ++k) {
    PaperTexture& texture = parsed->textures.textures[k];
    Result<std::vector<float>> texels = read_texels(
        manifest,
        {parsed->files.names[k], parsed->files.texel, texture.width, texture.height, parsed->files.texels_crc32[k]});
    if (!texels) return texels.error();
    texture.texels = *std::move(texels);
  }
  std::string description = fmt::format("the paper's four textures, {} texels, {}", parsed->textures.texel_count(),
                                        name_of(kTexelFormatNames, parsed->files.texel));
  std::unique_ptr<BrdfSource> source =
      std::make_unique<PaperSource>(std::move(parsed->textures), std::move(description));
  return source;
}

}  // namespace sbrdf::internal
