#include "converters/files/atlas/manifest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "codec/frame/frame.h"
#include "converters/files/atlas/manifest_members.h"
#include "formats/core/named.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostNodes = 4096;
constexpr std::uint32_t kMostTexels = 65536;
constexpr std::uint32_t kMostSide = 16384;
constexpr std::uint32_t kMostCells = 1U << 22U;

Json axis_json(const AtlasAxis& axis, std::string_view name) {
  Json json = {{"name", name}, {"nodes_deg", axis.nodes_deg}};
  if (axis.moves()) json["texels"] = axis.texels;
  json["root_spacing"] = axis.root_spacing;
  return json;
}

AtlasAxis read_axis(MemberReader& reader, const Json& json) {
  AtlasAxis axis;
  for (const Json& node : reader.list(json, "nodes_deg", kMostNodes)) {
    const double degrees = node.is_number() ? node.get<double>() : -1;
    const bool rises = axis.nodes_deg.empty() ? degrees == 0 : degrees > axis.nodes_deg.back();
    if (!rises || !(degrees <= 720)) reader.refuse("nodes_deg", "does not rise from 0 to 720 degrees at most");
    axis.nodes_deg.push_back(degrees);
  }
  if (axis.nodes_deg.empty()) reader.refuse("nodes_deg", "has no nodes");
  axis.root_spacing = reader.flag(json, "root_spacing");
  if (!axis.moves()) return axis;
  for (const Json& texel : reader.list(json, "texels", kMostNodes)) {
    const std::uint32_t place = reader.whole(texel, "texels", kMostTexels);
    const bool rises = axis.texels.empty() ? place == 0 : place > axis.texels.back();
    if (!rises) reader.refuse("texels", "does not rise from 0");
    axis.texels.push_back(place);
  }
  if (axis.texels.size() != axis.nodes_deg.size()) reader.refuse("texels", "has another length than 'nodes_deg'");
  return axis;
}

Json scales_json(const std::vector<AtlasScale>& scales) {
  Json list = Json::array();
  for (const AtlasScale& scale : scales) list.push_back({{"offset", scale.offset}, {"scale", scale.scale}});
  return list;
}

std::vector<AtlasScale> read_scales(MemberReader& reader, const Json& json, std::size_t tiles) {
  std::vector<AtlasScale> scales;
  for (const Json& entry : reader.list(json, "scales", std::max<std::size_t>(tiles, 1))) {
    scales.push_back({reader.three(entry, "offset"), reader.three(entry, "scale")});
  }
  if (scales.size() != 1 && scales.size() != tiles) reader.refuse("scales", "is not one for each tile, or one");
  return scales;
}

/// Whether an object says the same as another one, beside its scales and whatever their order.
bool same_without_scales(const Json& given, const Json& expected) {
  nlohmann::json bare = given;
  if (bare.is_object()) bare.erase("scales");
  return bare == nlohmann::json(expected);
}

/// Of a table of which not all is held: x, y, width, height, first column and first row of each tile.
Json tiles_json(const AtlasTable& table) {
  Json tiles = Json::array();
  for (const AtlasTile& tile : table.tiles) {
    tiles.push_back({tile.x, tile.y, tile.width, tile.height, tile.first_column, tile.first_row});
  }
  return tiles;
}

/// All that lay_out sets: for people and other programs, and to be compared when it is read.
Json table_json(const AtlasLayout& layout, const AtlasTable& table) {
  const auto names = geometry(layout.frame).axis_names();
  Json between = Json::array();
  for (const std::size_t axis : table.between) between.push_back(names[axis]);
  Json json = {{"along", names[table.along]},
               {"across", table.across ? Json(names[*table.across]) : Json()},
               {"between", between},
               {"triangular", table.triangular},
               {"x", table.x},
               {"y", table.y},
               {"tile_width", table.tile_width},
               {"tile_height", table.tile_height},
               {"tiles_per_row", table.tiles_per_row},
               {"tile_count", table.tile_count}};
  if (!layout.cells.is_everything()) json["tiles"] = tiles_json(table);
  return json;
}

Json ring_json(const AtlasRing& ring) {
  return {{"x", ring.x},
          {"y", ring.y},
          {"tile_width", ring.tile_width},
          {"tile_height", ring.tile_height},
          {"ring_texels", ring.ring_texels},
          {"period_deg", ring.period_deg}};
}

/// Lengths of runs, in turn of cells left out and held.
Json cells_json(const AtlasCells& cells) {
  Json runs = Json::array();
  bool held = false;
  std::size_t length = 0;
  for (const bool flag : cells.flags()) {
    if (flag != held) {
      runs.push_back(length);
      length = 0;
      held = flag;
    }
    ++length;
  }
  runs.push_back(length);
  return {{"counts", cells.counts()}, {"held", cells.size()}, {"runs", runs}};
}

AtlasCells read_cells(MemberReader& reader, const Json& json, const AtlasCells::Counts& counts) {
  const Json& given = reader.list(json, "counts", kAxisCount);
  if (AtlasCells::cell_count(counts) > kMostCells) reader.refuse("cells", "are too many to be left out one by one");
  if (given != Json(counts)) reader.refuse("counts", "does not follow from the axes");
  if (reader.error()) return {};
  AtlasCells cells(counts);
  const std::size_t all = cells.flags().size();
  std::size_t at = 0;
  bool held = false;
  for (const Json& run : reader.list(json, "runs", all + 1)) {
    const std::uint32_t length = reader.whole(run, "runs", kMostCells);
    if (length > all - at) {
      reader.refuse("runs", "has more cells than 'counts'");
      return {};
    }
    for (std::uint32_t k = 0; k < length && held; ++k) cells.add_number(at + k);
    at += length;
    held = !held;
  }
  if (at != all) reader.refuse("runs", "has fewer cells than 'counts'");
  const std::size_t size = cells.size();
  if (size == 0) reader.refuse("runs", "holds no cell");
  if (reader.whole(reader.member(json, "held"), "held", kMostCells) != size)
    reader.refuse("held", "is not what 'runs' says");
  return cells;
}

FrameId read_frame_id(MemberReader& reader, const Json& frame) {
  const std::string id = reader.text(frame, "id");
  for (const FrameId each : {FrameId::kElevation, FrameId::kHalfDifference}) {
    if (geometry(each).name() == id) return each;
  }
  reader.refuse("id", "is no frame: '" + id + "'");
  return FrameId::kElevation;
}

std::size_t read_dense_axis(MemberReader& reader, const Json& json, const AtlasLayout& layout) {
  const std::string name = reader.text(json, "dense_along");
  const auto names = geometry(layout.frame).axis_names();
  const auto* const found = std::find(names.begin(), names.end(), name);
  const auto axis = static_cast<std::size_t>(found - names.begin());
  if (axis < kAxisCount && layout.axes[axis].moves() && layout.symmetries.isotropic &&
      layout.frame == FrameId::kHalfDifference) {
    return axis;
  }
  reader.refuse("dense_along", "is no axis that moves, of an isotropic material in the half/difference frame");
  return 0;
}

AtlasLayout read_layout(MemberReader& reader, const Json& json) {
  AtlasLayout layout;
  const Json& frame = reader.member(json, "frame");
  layout.frame = read_frame_id(reader, frame);
  layout.theta_max_deg = reader.number(frame, "theta_max_deg", 0.001, 90);
  const Json& symmetries = reader.member(frame, "symmetries");
  layout.symmetries = {reader.flag(symmetries, "isotropic"), reader.flag(symmetries, "mirror_x"),
                       reader.flag(symmetries, "mirror_y")};
  const Json& axes = reader.list(frame, "axes", kAxisCount);
  if (axes.size() != kAxisCount) reader.refuse("axes", "is no list of four");
  bool all_move = true;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    reader.constant(axes[axis], "name", std::string(geometry(layout.frame).axis_names()[axis]));
    layout.axes[axis] = read_axis(reader, axes[axis]);
    all_move = all_move && layout.axes[axis].moves();
  }
  if (layout.frame == FrameId::kElevation && (layout.axes[kHorizontal].nodes_deg != layout.axes[kVertical].nodes_deg ||
                                              layout.axes[kHorizontal].texels != layout.axes[kVertical].texels)) {
    reader.refuse("axes", "has different elevations for light and view");
  }
  layout.blocks = reader.flag(json, "tiles_are_blocks");
  if (json.is_object() && json.contains("dense_along")) layout.dense_along = read_dense_axis(reader, json, layout);
  if (json.is_object() && json.contains("cells")) {
    layout.cells = read_cells(reader, json.at("cells"), cell_counts(layout));
  }
  if (all_move) {
    AtlasRing ring;
    ring.ring_texels =
        reader.whole(reader.member(reader.member(json, "ring"), "ring_texels"), "ring_texels", kMostTexels);
    if (ring.ring_texels == 0) reader.refuse("ring_texels", "is 0");
    ring.period_deg = geometry(layout.frame).mergings().front().period_deg;
    layout.ring = ring;
  }
  return layout;
}

/// Tables and ring stand in the manifest for others; here they have to be those that follow from the rest.
void read_tables(MemberReader& reader, const Json& json, Atlas& atlas) {
  const AtlasLayout& layout = atlas.layout;
  const Json& tables = reader.list(json, "tables", layout.tables.size());
  if (tables.size() != layout.tables.size()) return reader.refuse("tables", "has another length");
  for (std::size_t k = 0; k < tables.size(); ++k) {
    atlas.scales.push_back(read_scales(reader, tables[k], layout.tables[k].tile_count));
    if (!same_without_scales(tables[k], table_json(layout, layout.tables[k])))
      reader.refuse("tables", "does not follow from the axes");
  }
  if (!layout.ring) return;
  const Json& ring = reader.member(json, "ring");
  atlas.scales.push_back(read_scales(reader, ring, 1));
  if (!same_without_scales(ring, ring_json(*layout.ring))) reader.refuse("ring", "does not follow from the axes");
}

AtlasFiles read_files(MemberReader& reader, const Json& json) {
  AtlasFiles files;
  const Json& texture = reader.member(json, "texture");
  files.texture = reader.file_name(texture, "file");
  files.shader = reader.file_name(json, "shader");
  const auto texel = value_of(kTexelFormatNames, reader.text(texture, "texel"));
  if (!texel) reader.refuse("texel", "is no texel format");
  files.texel = texel.value_or(TexelFormat::kRgb32f);
  files.texture_bytes = static_cast<std::uint64_t>(reader.number(texture, "bytes", 1, 1e12));
  files.texels_crc32 = reader.optional_crc32(texture, "texels_crc32");
  reader.constant(texture, "first_row", "top");
  reader.constant(texture, "filter", "linear");
  reader.constant(texture, "colour_space", "linear");
  return files;
}

void read_all(MemberReader& reader, const Json& json, AtlasManifest& manifest) {
  if (reader.text(json, "sbrdf") != "atlas") reader.refuse("sbrdf", "is not 'atlas'");
  if (reader.number(json, "version", 0, 1e9) != 1) reader.refuse("version", "is not 1, the only one known here");
  if (reader.text(json, "layout") != "engine") reader.refuse("layout", "is neither 'engine' nor 'paper'");
  manifest.files = read_files(reader, json);
  AtlasLayout& layout = manifest.atlas.layout;
  layout = read_layout(reader, json);
  if (reader.error()) return;
  if (const Status laid = lay_out(layout, kMostSide); !laid) return reader.refuse("axes", laid.error().message);
  const Json& texture = reader.member(json, "texture");
  if (reader.whole(reader.member(texture, "width"), "width", kMostSide) != layout.width ||
      reader.whole(reader.member(texture, "height"), "height", kMostSide) != layout.height) {
    reader.refuse("texture", "has other sides than the axes ask for");
  }
  read_tables(reader, json, manifest.atlas);
  manifest.atlas.domain = read_domain(reader, reader.member(json, "values"));
}

}  // namespace

std::string emit_manifest(const Atlas& atlas, const AtlasFiles& files, const Json& more) {
  const AtlasLayout& layout = atlas.layout;
  const auto names = geometry(layout.frame).axis_names();
  Json json = {{"sbrdf", "atlas"}, {"version", 1}, {"layout", "engine"}};
  json["texture"] = {{"file", files.texture},        {"texel", name_of(kTexelFormatNames, files.texel)},
                     {"width", layout.width},        {"height", layout.height},
                     {"bytes", files.texture_bytes}, {"first_row", "top"},
                     {"filter", "linear"},           {"colour_space", "linear"}};
  json["shader"] = files.shader;
  Json axes = Json::array();
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) axes.push_back(axis_json(layout.axes[axis], names[axis]));
  json["frame"] = {{"id", geometry(layout.frame).name()},
                   {"symmetries",
                    {{"isotropic", layout.symmetries.isotropic},
                     {"mirror_x", layout.symmetries.mirror_x},
                     {"mirror_y", layout.symmetries.mirror_y}}},
                   {"theta_max_deg", layout.theta_max_deg},
                   {"axes", axes}};
  json["tiles_are_blocks"] = layout.blocks;
  if (layout.dense_along) json["dense_along"] = names[*layout.dense_along];
  if (!layout.cells.is_everything()) json["cells"] = cells_json(layout.cells);
  json["tables"] = Json::array();
  for (std::size_t k = 0; k < layout.tables.size(); ++k) {
    Json table = table_json(layout, layout.tables[k]);
    table["scales"] = scales_json(atlas.scales[k]);
    json["tables"].push_back(std::move(table));
  }
  if (layout.ring) {
    json["ring"] = ring_json(*layout.ring);
    json["ring"]["scales"] = scales_json(atlas.scales.back());
  }
  json["values"] = domain_json(atlas.domain);
  if (files.texels_crc32) json["texture"]["texels_crc32"] = *files.texels_crc32;
  for (const auto& [name, value] : more.items()) json[name] = value;
  return manifest_text(json);
}

std::string manifest_text(const Json& json) {
  // Names of files can be any bytes, JSON holds UTF-8 only.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<std::string> manifest_layout(std::string_view text) {
  const Result<Json> json = parse_small_json(text);
  if (!json) return json.error();
  MemberReader reader;
  std::string layout = reader.text(*json, "layout");
  if (reader.error()) return invalid_file("manifest of an atlas: " + *reader.error());
  return layout;
}

Result<AtlasManifest> parse_manifest(std::string_view text) {
  AtlasManifest manifest;
  Result<Json> json = parse_small_json(text);
  if (!json) return json.error();
  manifest.json = *std::move(json);
  MemberReader reader;
  read_all(reader, manifest.json, manifest);
  if (reader.error()) return invalid_file("manifest of an atlas: " + *reader.error());
  return manifest;
}

bool recognises_manifest(std::string_view head) {
  // Also what another program has written anew, with blanks and line ends.
  const auto skip = [&](std::string_view token) {
    head.remove_prefix(std::min(head.find_first_not_of(" \t\r\n"), head.size()));
    if (!head.starts_with(token)) return false;
    head.remove_prefix(token.size());
    return true;
  };
  return skip("{") && skip("\"sbrdf\"") && skip(":") && skip("\"atlas\"");
}

}  // namespace sbrdf::internal
