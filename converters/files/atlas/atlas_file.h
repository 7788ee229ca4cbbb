#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codec/atlas/atlas.h"
#include "codec/atlas/atlas_evaluator.h"
#include "converters/files/format.h"
#include "converters/source/brdf_source.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

/// An atlas, evaluated as its shader does (specs/atlas.md).
class AtlasSource final : public BrdfSource {
 public:
  /// `texels` are there; `description` is one line for people.
  AtlasSource(Atlas atlas, std::string description);

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override;

  /// Cells that were left out are not measured: `evaluate` gives 0 there.
  void measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const override;
  [[nodiscard]] std::optional<MaskGrid> mask_grid() const override;

  [[nodiscard]] const Atlas& atlas() const { return atlas_; }

 private:
  Atlas atlas_;
  AtlasEvaluator evaluator_;
  SourceTraits traits_;
};

/// What a manifest says of a texture.
struct StatedTexture {
  std::string file;
  TexelFormat texel = TexelFormat::kRgb32f;
  std::uint32_t width = 0, height = 0;
  std::optional<std::uint32_t> texels_crc32;
};

/// The texels of such a texture, a file beside the manifest of any container: RGB, row by row. kIo where it is not
/// there, kInvalidFile where it has other sides or texels, or one that is not finite.
[[nodiscard]] Result<std::vector<float>> read_texels(const ByteSource& manifest, const StatedTexture& stated);

/// What is said of a material in textures, its directions up to `theta_max_deg`.
[[nodiscard]] SourceTraits traits_of_textures(bool isotropic, double theta_max_deg, std::string description);

/// The names of the other files of an atlas: textures, and the shader where it has one. None where this is no manifest.
[[nodiscard]] std::vector<std::string> files_of_atlas(const ByteSource& manifest);

/// Opens a manifest of any layout and the textures that it names: the row of the format table.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_atlas(std::shared_ptr<const ByteSource> bytes,
                                                             const Options& options);

}  // namespace sbrdf::internal
