#include "converters/files/atlas/atlas_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/atlas/manifest.h"
#include "converters/files/atlas/paper/paper_file.h"
#include "converters/files/atlas/paper/paper_manifest.h"
#include "formats/sbrdf/container.h"
#include "formats/table/exr_image.h"
#include "formats/texture/dds.h"
#include "formats/texture/exr_texture.h"
#include "formats/texture/ktx2.h"

namespace sbrdf::internal {
namespace {

Error of_texture(const std::string& file, const Error& error) {
  Error named = error;
  named.message = "the texture " + file + ": " + error.message;
  return named;
}

Result<std::string> read_manifest(const ByteSource& bytes) {
  if (bytes.size() > kLongestManifest) return unsupported("the manifest is longer than 16 MB");
  const Result<std::vector<std::byte>> text = read_range(bytes, 0, bytes.size());
  if (!text) return text.error();
  return std::string(reinterpret_cast<const char*>(text->data()), text->size());
}

Result<Texture> read_texture(const std::shared_ptr<const ByteSource>& bytes) {
  const Result<std::vector<std::byte>> head = read_start(*bytes, kHeadSize);
  if (!head) return head.error();
  const bool ktx2 = recognises_ktx2(*head);
  if (!ktx2 && !recognises_dds(*head)) {
    if (!recognises_exr(*head)) return invalid_file("is neither a KTX2, a DDS nor an EXR file");
    return read_exr_texture(bytes);
  }
  const Result<std::vector<std::byte>> all = read_range(*bytes, 0, bytes->size());
  if (!all) return all.error();
  return ktx2 ? read_ktx2(*all) : read_dds(*all);
}

Status check_stated(const Texture& texture, const StatedTexture& stated) {
  if (texture.width != stated.width || texture.height != stated.height) {
    return invalid_file(fmt::format("the texture {} has {} x {} texels, and the manifest says {} x {}", stated.file,
                                    texture.width, texture.height, stated.width, stated.height));
  }
  if (texture.format != stated.texel) {
    return invalid_file(fmt::format("the texture {} has {} texels, and the manifest says {}", stated.file,
                                    name_of(kTexelFormatNames, texture.format),
                                    name_of(kTexelFormatNames, stated.texel)));
  }
  if (stated.texels_crc32 && checksum(std::as_bytes(std::span(texture.bytes))) != *stated.texels_crc32) {
    return invalid_file(fmt::format("the texture {} has other texels than those of this manifest", stated.file));
  }
  return ok_status();
}

}  // namespace

SourceTraits traits_of_textures(bool isotropic, double theta_max_deg, std::string description) {
  SourceTraits traits;
  traits.format = "atlas";
  traits.description = std::move(description);
  traits.channels = {"R", "G", "B"};
  traits.isotropic = isotropic;
  traits.reciprocal = true;
  traits.theta_max_deg = theta_max_deg;
  traits.slice_theta_max_deg = theta_max_deg;
  if (theta_max_deg < 90) traits.beyond_theta_max = "the value held at theta_max";
  return traits;
}

Result<std::vector<float>> read_texels(const ByteSource& manifest, const StatedTexture& stated) {
  const std::string& file = stated.file;
  const Result<std::shared_ptr<const ByteSource>> bytes = manifest.neighbour(file);
  if (!bytes) return bytes.error();
  if (*bytes == nullptr) return io_error("the texture that belongs to it, " + file + ", is not in its folder");
  const Result<Texture> texture = read_texture(*bytes);
  if (!texture) return of_texture(file, texture.error());
  if (Status same = check_stated(*texture, stated); !same) return same.error();
  Result<std::vector<float>> texels = decode_texels(*texture);
  if (!texels) return of_texture(file, texels.error());
  const auto wrong = std::find_if_not(texels->begin(), texels->end(), [](float v) { return std::isfinite(v); });
  if (wrong != texels->end()) {
    const auto at = static_cast<std::size_t>(wrong - texels->begin()) / 3;
    return invalid_file(fmt::format("the texture {} has a texel that is not finite, at column {} of row {}", file,
                                    at % stated.width, at / stated.width));
  }
  return texels;
}

AtlasSource::AtlasSource(Atlas atlas, std::string description)
    : atlas_(std::move(atlas)),
      evaluator_(atlas_),
      traits_(traits_of_textures(atlas_.layout.symmetries.isotropic, atlas_.layout.theta_max_deg,
                                 std::move(description))) {}

void AtlasSource::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  const bool whole = atlas_.layout.cells.is_everything();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const std::span<float, 3> rgb(values.data() + 3 * k, 3);
    evaluator_.evaluate(pairs[k], rgb);
    // The colour of the shader that shows them is no value.
    if (!whole && above_horizon(pairs[k]) && !evaluator_.holds(pairs[k])) std::ranges::fill(rgb, 0.0F);
  }
}

void AtlasSource::measured(std::span<const DirectionPair> pairs, std::span<std::uint8_t> flags) const {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    flags[k] = !above_horizon(pairs[k]) || evaluator_.holds(pairs[k]) ? 1 : 0;
  }
}

std::optional<MaskGrid> AtlasSource::mask_grid() const {
  if (atlas_.layout.cells.is_everything()) return std::nullopt;
  // Finer than cells are: what lies on the border of one is told to two degrees.
  const std::uint32_t azimuths = atlas_.layout.symmetries.isotropic ? 1 : 90;
  return MaskGrid{MaskFrame::kHalfDifference, {azimuths, 90, 45, 90}};
}

std::vector<std::string> files_of_atlas(const ByteSource& manifest) {
  const Result<std::string> json = read_manifest(manifest);
  if (!json) return {};
  if (const Result<AtlasManifest> engine = parse_manifest(*json)) return {engine->files.texture, engine->files.shader};
  const Result<PaperManifest> paper = parse_paper_manifest(*json);
  if (!paper) return {};
  return {paper->files.names.begin(), paper->files.names.end()};
}

Result<std::unique_ptr<BrdfSource>> open_atlas(std::shared_ptr<const ByteSource> bytes, const Options& /*options*/) {
  const Result<std::string> json = read_manifest(*bytes);
  if (!json) return json.error();
  const Result<std::string> name = manifest_layout(*json);
  if (!name) return name.error();
  if (*name == kPaperLayout) return open_paper(*bytes, *json);
  Result<AtlasManifest> manifest = parse_manifest(*json);
  if (!manifest) return manifest.error();
  const AtlasLayout& layout = manifest->atlas.layout;
  Result<std::vector<float>> texels = read_texels(*bytes, {manifest->files.texture, manifest->files.texel, layout.width,
                                                           layout.height, manifest->files.texels_crc32});
  if (!texels) return texels.error();
  manifest->atlas.texels = *std::move(texels);
  std::string description = fmt::format("texture atlas, {} x {} texels, {}", layout.width, layout.height,
                                        name_of(kTexelFormatNames, manifest->files.texel));
  if (!layout.cells.is_everything()) {
    description += fmt::format(", {} of {} cells", layout.cells.size(), layout.cells.flags().size());
  }
  std::unique_ptr<BrdfSource> source =
      std::make_unique<AtlasSource>(std::move(manifest->atlas), std::move(description));
  return source;
}

}  // namespace sbrdf::internal
