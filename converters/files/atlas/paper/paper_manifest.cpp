#include "converters/files/atlas/paper/paper_manifest.h"

#include <string>

#include "codec/frame/frame.h"
#include "converters/files/atlas/manifest.h"
#include "converters/files/atlas/manifest_members.h"
#include "formats/core/named.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kMostNodes = 4096;

Json texture_json(const PaperTexture& texture, const std::string& file, std::uint64_t bytes, bool wraps) {
  return {{"file", file}, {"width", texture.width}, {"height", texture.height}, {"bytes", bytes}, {"rows_wrap", wraps}};
}

void read_frame(MemberReader& reader, const Json& json, PaperTextures& textures) {
  const Json& frame = reader.member(json, "frame");
  if (reader.text(frame, "id") != geometry(FrameId::kElevation).name()) reader.refuse("id", "is not 'elevation'");
  textures.isotropic = reader.flag(frame, "isotropic");
  textures.azimuth_count = reader.whole(reader.member(frame, "azimuth_count"), "azimuth_count", kMostNodes);
  if (textures.azimuth_count == 0) reader.refuse("azimuth_count", "is 0");
  double last = 0;
  for (const Json& node : reader.list(frame, "elevations_deg", kMostNodes)) {
    const double degrees = node.is_number() ? node.get<double>() : -1;
    if (!(degrees > last && degrees <= kPaperMostThetaDeg)) {
      reader.refuse("elevations_deg", "does not rise from above 0 to 89 degrees at most");
    }
    textures.elevations_deg.push_back(degrees);
    last = degrees;
  }
  if (textures.elevations_deg.empty()) reader.refuse("elevations_deg", "has no nodes");
}

void read_textures(MemberReader& reader, const Json& json, PaperManifest& manifest) {
  const Json& list = reader.member(json, "textures");
  for (const auto& [name, kind] : kPaperTextureNames) {
    const std::string member(name);
    const Json& texture = reader.member(list, member.c_str());
    const auto k = static_cast<std::size_t>(kind);
    manifest.files.names[k] = reader.file_name(texture, "file");
    manifest.files.bytes[k] = static_cast<std::uint64_t>(reader.number(texture, "bytes", 1, 1e12));
    manifest.files.texels_crc32[k] = reader.optional_crc32(texture, "texels_crc32");
    const PaperTexture& sides = manifest.textures.textures[k];
    if (reader.whole(reader.member(texture, "width"), "width", kLongestTextureSide) != sides.width ||
        reader.whole(reader.member(texture, "height"), "height", kLongestTextureSide) != sides.height) {
      reader.refuse(member, "has other sides than the frame asks for");
    }
  }
  const auto texel = value_of(kTexelFormatNames, reader.text(json, "texel"));
  if (!texel) reader.refuse("texel", "is no texel format");
  manifest.files.texel = texel.value_or(TexelFormat::kRgb32f);
}

void read_all(MemberReader& reader, const Json& json, PaperManifest& manifest) {
  if (reader.text(json, "sbrdf") != "atlas") reader.refuse("sbrdf", "is not 'atlas'");
  if (reader.number(json, "version", 0, 1e9) != 1) reader.refuse("version", "is not 1, the only one known here");
  if (reader.text(json, "layout") != kPaperLayout) reader.refuse("layout", "is not 'paper'");
  read_frame(reader, json, manifest.textures);
  if (reader.error()) return;
  if (const Status laid = lay_out_paper(manifest.textures); !laid) return reader.refuse("frame", laid.error().message);
  read_textures(reader, json, manifest);
  manifest.textures.at_normal = reader.three(json, "at_normal");
  manifest.textures.domain = read_domain(reader, reader.member(json, "values"));
}

}  // namespace

std::string emit_paper_manifest(const PaperTextures& textures, const PaperFiles& files, const Json& more) {
  Json json = {{"sbrdf", "atlas"}, {"version", 1}, {"layout", kPaperLayout}};
  json["texel"] = name_of(kTexelFormatNames, files.texel);
  json["first_row"] = "top";
  json["filter"] = "linear";
  json["colour_space"] = "linear";
  for (const auto& [name, kind] : kPaperTextureNames) {
    const auto k = static_cast<std::size_t>(kind);
    const bool wraps = kind == PaperTextureKind::kAxial || kind == PaperTextureKind::kDiagonal;
    Json& texture = json["textures"][std::string(name)];
    texture = texture_json(textures.textures[k], files.names[k], files.bytes[k], wraps);
    if (files.texels_crc32[k]) texture["texels_crc32"] = *files.texels_crc32[k];
  }
  json["frame"] = {{"id", geometry(FrameId::kElevation).name()}, {"isotropic", textures.isotropic},
                   {"azimuth_count", textures.azimuth_count},    {"azimuth_step_deg", textures.azimuth_step_deg()},
                   {"elevations_deg", textures.elevations_deg},  {"theta_max_deg", textures.elevations_deg.back()}};
  json["at_normal"] = textures.at_normal;
  json["values"] = domain_json(textures.domain);
  for (const auto& [name, value] : more.items()) json[name] = value;
  return manifest_text(json);
}

Result<PaperManifest> parse_paper_manifest(std::string_view text) {
  const Result<Json> json = parse_small_json(text);
  if (!json) return json.error();
  PaperManifest manifest;
  MemberReader reader;
  read_all(reader, *json, manifest);
  if (reader.error()) return invalid_file("manifest of an atlas: " + *reader.error());
  return manifest;
}

}  // namespace sbrdf::internal
