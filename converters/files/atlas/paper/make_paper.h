#pragma once

#include <array>

#include "codec/atlas/paper/paper_textures.h"
#include "codec/file/encoder.h"
#include "converters/files/atlas/atlas_judge.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/source/brdf_source.h"
#include "formats/core/result.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

struct MadePaper {
  PaperTextures textures;  ///< with the texels that `packed` gives back
  std::array<Texture, kPaperTextureCount> packed;
  AtlasErrors errors;     ///< against the slices
  AtlasErrors of_source;  ///< against the source

  /// Of the texels alone, without files.
  [[nodiscard]] std::uint64_t texel_bytes() const;
};

/// Texel, container and packing; --max-error plays no part, since the sides follow from the placement. kUsage where the
/// container does not hold such texels, and for texels without a sign, which logarithms have.
[[nodiscard]] Status check_paper_options(const AtlasOptions& options);

/// Errors as of bake_paper_textures; kUnsupported where half floats do not hold a value, too. `source` is what the
/// slices were made of, or they themselves.
[[nodiscard]] Result<MadePaper> make_paper(const DecodedSliced& sliced, const BrdfSource& source,
                                           const AtlasOptions& options);

}  // namespace sbrdf::internal
