#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "codec/atlas/atlas.h"
#include "codec/file/encoder.h"
#include "converters/files/atlas/atlas_judge.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/named.h"
#include "formats/core/result.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

enum class AtlasContainer : std::uint8_t { kExr, kKtx2, kDds };
inline constexpr std::array kAtlasContainerNames = {
    Named{"exr", AtlasContainer::kExr}, Named{"ktx2", AtlasContainer::kKtx2}, Named{"dds", AtlasContainer::kDds}};

struct AtlasOptions {
  TexelFormat texel = TexelFormat::kRgba16f;
  AtlasContainer container = AtlasContainer::kKtx2;
  bool zstd = false;  ///< KTX2 only
  bool fast = false;  ///< BC6H only: blocks are searched less
  /// How far the atlas may be off the slices, by either error: as few texels as reach it.
  double max_error_percent = 0.5;
  AtlasCells cells = {};  ///< what is packed, of the axes that atlas_axes gives; errors are those of directions there
};

struct MadeAtlas {
  Atlas atlas;  ///< with the texels that its texture gives back
  Texture texture;
  TexelCounts counts;
  AtlasErrors errors;               ///< against the slices
  AtlasErrors of_source;            ///< against the source
  double tolerance = 0;             ///< of BakeOptions
  bool reached = false;             ///< max_error_percent
  std::uint64_t texels_of_all = 0;  ///< that a texture with all cells would have
};

/// kUsage where the container does not hold such texels.
[[nodiscard]] Status check_atlas_options(const AtlasOptions& options);

/// The texels that are written: three floats as four where the container is for graphics cards, which take no three.
[[nodiscard]] TexelFormat stored_texel(const AtlasOptions& options);

/// Bakes with smaller and smaller tolerance until the error is small enough, or no smaller any more. Where a dense
/// table is possible, it is tried, too, and the smaller texture taken. `source` is what the slices were made of, or
/// they themselves.
[[nodiscard]] Result<MadeAtlas> make_atlas(const DecodedSliced& sliced, const BrdfSource& source,
                                           const AtlasOptions& options, const Progress& progress = {});

/// The bytes of the texture's file.
[[nodiscard]] Result<std::vector<std::byte>> pack_texture(const Texture& texture, const AtlasOptions& options);

}  // namespace sbrdf::internal
