#include "converters/files/atlas/manifest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "codec/frame/frame.h"
#include "formats/core/named.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kBeginning = "{\"sbrdf\":\"atlas\"";
constexpr std::size_t kMostNodes = 4096;
constexpr std::uint32_t kMostTexels = 65536;
constexpr std::uint32_t kMostSide = 16384;
constexpr int kDeepest = 32;               // levels of JSON: what compares and copies it is recursive
constexpr std::size_t kMostMembers = 256;  // of an object, which are looked for one by one
/// With grey shares the values of all channels are added up.
constexpr float kLargestOfSum = 1e37F;

/// Reads members of objects. The first one that is missing or wrong sticks: what is read from then on means nothing.
class MemberReader {
 public:
  void refuse(const std::string& member, const std::string& what) {
    if (!error_) error_ = "'" + member + "' " + what;
  }
  [[nodiscard]] const std::optional<std::string>& error() const { return error_; }

  /// null where there is none.
  const Json& member(const Json& json, const char* name) {
    static const Json kNone;
    if (json.is_object() && json.contains(name)) return json.at(name);
    refuse(name, "is missing");
    return kNone;
  }

  double number(const Json& json, const char* name, double least, double most) {
    const Json& value = member(json, name);
    const double number = value.is_number() ? value.get<double>() : least - 1;
    if (number >= least && number <= most) return number;
    refuse(name, "is no number in range");
    return least;
  }

  std::uint32_t whole(const Json& value, const char* name, std::uint32_t most) {
    if (value.is_number_unsigned() && value.get<std::uint64_t>() <= most) return value.get<std::uint32_t>();
    refuse(name, "is no whole number in range");
    return 0;
  }

  bool flag(const Json& json, const char* name) {
    const Json& value = member(json, name);
    if (value.is_boolean()) return value.get<bool>();
    refuse(name, "is neither true nor false");
    return false;
  }

  std::string text(const Json& json, const char* name) {
    const Json& value = member(json, name);
    if (value.is_string()) return value.get<std::string>();
    refuse(name, "is no text");
    return {};
  }

  /// A text that can be only one.
  void constant(const Json& json, const char* name, const std::string& value) {
    if (text(json, name) != value) refuse(name, "is not '" + value + "'");
  }

  /// A name in the folder of the manifest, and in no other.
  std::string file_name(const Json& json, const char* name) {
    std::string file = text(json, name);
    if (file.empty() || file.find_first_of(std::string_view("/\\\0", 3)) != std::string::npos || file == "." ||
        file == "..") {
      refuse(name, "is no plain file name");
    }
    return file;
  }

  std::array<float, 3> colour(const Json& json, const char* name) {
    const Json& value = member(json, name);
    std::array<float, 3> rgb{};
    const bool three = value.is_array() && value.size() == rgb.size();
    for (std::size_t c = 0; three && c < rgb.size(); ++c) {
      rgb[c] = value[c].is_number() ? value[c].get<float>() : std::numeric_limits<float>::infinity();
      if (!std::isfinite(rgb[c])) refuse(name, "is no list of three numbers");
    }
    if (!three) refuse(name, "is no list of three numbers");
    return rgb;
  }

  /// A list; empty where it is none, or longer than `most`.
  const Json& list(const Json& json, const char* name, std::size_t most) {
    static const Json kEmpty = Json::array();
    const Json& value = member(json, name);
    if (value.is_array() && value.size() <= most) return value;
    refuse(name, "is no list of at most " + std::to_string(most));
    return kEmpty;
  }

 private:
  std::optional<std::string> error_;
};

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
    scales.push_back({reader.colour(entry, "offset"), reader.colour(entry, "scale")});
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

/// All that lay_out sets: for people and other programs, and to be compared when it is read.
Json table_json(const AtlasLayout& layout, const AtlasTable& table) {
  const auto names = geometry(layout.frame).axis_names();
  Json between = Json::array();
  for (const std::size_t axis : table.between) between.push_back(names[axis]);
  return {{"along", names[table.along]},
          {"across", table.across ? Json(names[*table.across]) : Json()},
          {"between", between},
          {"triangular", table.triangular},
          {"x", table.x},
          {"y", table.y},
          {"tile_width", table.tile_width},
          {"tile_height", table.tile_height},
          {"tiles_per_row", table.tiles_per_row},
          {"tile_count", table.tile_count}};
}

Json ring_json(const AtlasRing& ring) {
  return {{"x", ring.x},
          {"y", ring.y},
          {"tile_width", ring.tile_width},
          {"tile_height", ring.tile_height},
          {"ring_texels", ring.ring_texels},
          {"period_deg", ring.period_deg}};
}

Json domain_json(const AtlasDomain& domain) {
  return {{"domain", domain.log ? "log" : "linear"},
          {"reference", domain.reference},
          {"floor", domain.floor},
          {"at_floor", domain.at_floor},
          {"at_zero", domain.at_zero},
          {"least", domain.least},
          {"most", domain.most},
          {"grey_shares", domain.grey_shares},
          {"grey_divisor", domain.grey_divisor}};
}

/// So that every texel gives a finite value.
void check_domain(MemberReader& reader, const AtlasDomain& domain) {
  float divisor = 3;
  for (std::size_t c = 0; c < 3; ++c) {
    if (domain.least[c] > domain.most[c]) reader.refuse("least", "is above 'most'");
    if (domain.log && !(domain.reference[c] > 0)) reader.refuse("reference", "is not above 0");
    if (domain.log && !(domain.floor[c] > 0)) reader.refuse("floor", "is not above 0");
    if (domain.grey_shares[c] < 0) reader.refuse("grey_shares", "has a share below 0");
    divisor += domain.grey_shares[c];
    if (domain.grey_divisor == 0) continue;
    if (std::max(-domain.least[c], domain.most[c]) > kLargestOfSum) reader.refuse("most", "is too large for shares");
  }
  const bool expected = std::abs(domain.grey_divisor - divisor) <= 1e-5F * divisor;
  if (domain.grey_divisor != 0 && !expected) reader.refuse("grey_divisor", "is neither 0 nor 3 and all 'grey_shares'");
}

AtlasDomain read_domain(MemberReader& reader, const Json& json) {
  AtlasDomain domain;
  const std::string name = reader.text(json, "domain");
  if (name != "log" && name != "linear") reader.refuse("domain", "is neither log nor linear");
  domain.log = name == "log";
  domain.reference = reader.colour(json, "reference");
  domain.floor = reader.colour(json, "floor");
  domain.at_floor = reader.colour(json, "at_floor");
  domain.at_zero = reader.colour(json, "at_zero");
  domain.least = reader.colour(json, "least");
  domain.most = reader.colour(json, "most");
  domain.grey_shares = reader.colour(json, "grey_shares");
  domain.grey_divisor = static_cast<float>(reader.number(json, "grey_divisor", 0, 1e6));
  check_domain(reader, domain);
  return domain;
}

FrameId read_frame_id(MemberReader& reader, const Json& frame) {
  const std::string id = reader.text(frame, "id");
  for (const FrameId each : {FrameId::kElevation, FrameId::kHalfDifference}) {
    if (geometry(each).name() == id) return each;
  }
  reader.refuse("id", "is no frame: '" + id + "'");
  return FrameId::kElevation;
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
  reader.constant(texture, "first_row", "top");
  reader.constant(texture, "filter", "linear");
  reader.constant(texture, "colour_space", "linear");
  return files;
}

/// kInvalidFile for text that is no JSON, or too deep or full to be a manifest.
Result<Json> parse_json(std::string_view text) {
  std::array<std::size_t, kDeepest + 1> members{};
  bool too_much = false;
  const auto keep = [&](int depth, Json::parse_event_t event, const Json& /*value*/) {
    const bool opens = event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start;
    too_much = too_much || (opens && depth >= kDeepest);
    if (too_much) return false;
    if (opens) members[static_cast<std::size_t>(depth) + 1] = 0;
    if (event == Json::parse_event_t::key) too_much = ++members[static_cast<std::size_t>(depth)] > kMostMembers;
    return !too_much;
  };
  Json json = Json::parse(text, keep, false);
  if (too_much) return invalid_file("JSON that is nested too deeply, or an object with too many members");
  if (json.is_discarded()) return invalid_file("is no JSON");
  return json;
}

void read_all(MemberReader& reader, const Json& json, AtlasManifest& manifest) {
  if (reader.text(json, "sbrdf") != "atlas") reader.refuse("sbrdf", "is not 'atlas'");
  if (reader.number(json, "version", 0, 1e9) != 1) reader.refuse("version", "is not 1, the only one known here");
  if (reader.text(json, "layout") != "engine") reader.refuse("layout", "is not 'engine', the only one read here");
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
  for (const auto& [name, value] : more.items()) json[name] = value;
  // Names of files can be any bytes, JSON holds UTF-8 only.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<AtlasManifest> parse_manifest(std::string_view text) {
  AtlasManifest manifest;
  Result<Json> json = parse_json(text);
  if (!json) return json.error();
  manifest.json = *std::move(json);
  MemberReader reader;
  read_all(reader, manifest.json, manifest);
  if (reader.error()) return invalid_file("manifest of an atlas: " + *reader.error());
  return manifest;
}

bool recognises_manifest(std::string_view head) { return head.starts_with(kBeginning); }

}  // namespace sbrdf::internal
