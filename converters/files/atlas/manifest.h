#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "codec/atlas/atlas.h"
#include "formats/core/result.h"
#include "formats/texture/texels.h"

namespace sbrdf::internal {

/// Longer files are no manifests [bytes].
inline constexpr std::uint64_t kLongestManifest = std::uint64_t{1} << 24U;

/// What a manifest says beside how to evaluate (specs/atlas.md).
struct AtlasFiles {
  std::string texture;  ///< names, in the folder of the manifest
  std::string shader;
  TexelFormat texel = TexelFormat::kRgb32f;
  std::uint64_t texture_bytes = 0;  ///< of the file
  /// CRC-32 of the texels as they are uploaded, whichever file they lie in (Texture::bytes); not known: not compared.
  std::optional<std::uint32_t> texels_crc32 = {};
};

/// The text of a manifest: `more` are members that follow those of this page, such as errors and the source.
[[nodiscard]] std::string emit_manifest(const Atlas& atlas, const AtlasFiles& files,
                                        const nlohmann::ordered_json& more);

/// A manifest without its texels: `atlas.texels` is empty.
struct AtlasManifest {
  Atlas atlas;
  AtlasFiles files;
  nlohmann::ordered_json json;  ///< all of it
};

/// Everything is checked, so that any texture of these sides can be evaluated: kInvalidFile names the member,
/// also where the layout is not "engine".
[[nodiscard]] Result<AtlasManifest> parse_manifest(std::string_view text);

/// Which layout a manifest says it has, known or not: what has to be asked before it is parsed. kInvalidFile for what
/// is no JSON, or has no such member.
[[nodiscard]] Result<std::string> manifest_layout(std::string_view text);

/// The JSON of a manifest as one line that recognises_manifest knows; it begins with the member "sbrdf".
[[nodiscard]] std::string manifest_text(const nlohmann::ordered_json& json);

/// By its beginning, as emit_manifest writes it.
[[nodiscard]] bool recognises_manifest(std::string_view head);

}  // namespace sbrdf::internal
