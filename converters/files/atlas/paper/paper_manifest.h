#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "codec/atlas/paper/paper_textures.h"
#include "formats/core/result.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

/// The member "layout" of a manifest of the paper's four textures (specs/atlas.md).
inline constexpr std::string_view kPaperLayout = "paper";

/// The files of the textures, by PaperTextureKind.
struct PaperFiles {
  std::array<std::string, kPaperTextureCount> names;      ///< in the folder of the manifest
  std::array<std::uint64_t, kPaperTextureCount> bytes{};  ///< of the files
  TexelFormat texel = TexelFormat::kRgb32f;               ///< of all four
  /// Of their texels, as AtlasFiles::texels_crc32.
  std::array<std::optional<std::uint32_t>, kPaperTextureCount> texels_crc32 = {};
};

/// The text of a manifest; `more` as of emit_manifest.
[[nodiscard]] std::string emit_paper_manifest(const PaperTextures& textures, const PaperFiles& files,
                                              const nlohmann::ordered_json& more);

/// A manifest without its texels: those of `textures` are empty, their sides are set.
struct PaperManifest {
  PaperTextures textures;
  PaperFiles files;
};

/// Everything is checked, so that any textures of these sides can be evaluated: kInvalidFile names the member.
[[nodiscard]] Result<PaperManifest> parse_paper_manifest(std::string_view text);

}  // namespace sbrdf::internal
