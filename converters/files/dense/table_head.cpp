#include "converters/files/dense/table_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

namespace sbrdf::internal {
namespace {

// Sorted: looking for keys in the order of the file takes the square of their number.
using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kKind = "dense table";
constexpr int kVersion = 1;
constexpr std::string_view kQuantity = "f_r, without cosine";
constexpr std::string_view kUnit = "1/sr";
constexpr std::string_view kAngleUnit = "degree";
constexpr std::string_view kUnmeasured = "NaN";

Error wrong(std::string_view what) { return invalid_file(fmt::format("description of the table: {}", what)); }

/// The entry of an object; nullptr where there is none.
const Json* find(const Json& object, std::string_view name) {
  const auto found = object.find(std::string(name));
  return found == object.end() ? nullptr : &*found;
}

/// The text of an entry; empty where there is none or it is no text.
std::string text_of(const Json& object, std::string_view name) {
  const Json* entry = find(object, name);
  return entry != nullptr && entry->is_string() ? entry->get<std::string>() : std::string();
}

/// What has only one value that is known.
Status check_constant(const Json& json, std::string_view name, std::string_view known) {
  if (find(json, name) == nullptr) return wrong(fmt::format("\"{}\" is missing", name));
  if (text_of(json, name) == known) return ok_status();
  return unsupported(fmt::format("description of the table: \"{}\" is not \"{}\"", name, known));
}

Status check_kind(const Json& json) {
  if (text_of(json, "sbrdf") != kKind) return wrong("\"sbrdf\" is not \"dense table\"");
  const Json* version = find(json, "version");
  if (version == nullptr || !version->is_number_integer()) return wrong("\"version\" is missing");
  if (*version != kVersion) {
    return unsupported("description of the table: only version 1 is read");
  }
  if (Status known = check_constant(json, "quantity", kQuantity); !known) return known;
  if (Status known = check_constant(json, "unit", kUnit); !known) return known;
  return check_constant(json, "unmeasured", kUnmeasured);
}

Result<GridAxis> parse_axis(const Json& json, GridFrame frame, std::size_t axis) {
  const std::string name(Grid::axis_name(frame, axis));
  if (!json.is_object() || text_of(json, "name") != name) {
    return wrong(fmt::format("axis {} of this frame is to have the name {}", axis + 1, name));
  }
  if (text_of(json, "unit") != kAngleUnit) return wrong(fmt::format("the unit of {} is not \"degree\"", name));
  const auto ends = value_of(kEndsNames, text_of(json, "ends"));
  const auto spacing = value_of(kSpacingNames, text_of(json, "spacing"));
  if (!ends || !spacing) return wrong(fmt::format("\"ends\" or \"spacing\" of {} is none that is known", name));
  const Json* list = find(json, "nodes");
  if (list == nullptr || !list->is_array()) return wrong(fmt::format("\"nodes\" of {} are missing", name));
  if (list->size() > GridAxis::kMost) return wrong(fmt::format("more than {} nodes of {}", GridAxis::kMost, name));
  std::vector<double> nodes;
  for (const Json& node : *list) {
    if (!node.is_number()) return wrong(fmt::format("a node of {} is no number", name));
    nodes.push_back(node.get<double>());
  }
  if (!Grid::can_have(frame, axis, nodes, *ends, *spacing)) {
    return wrong(fmt::format("nodes of {} do not rise within the range of the axis", name));
  }
  return GridAxis(std::move(nodes), *ends, *spacing);
}

Result<Grid> parse_axes(const Json& json) {
  const auto frame = value_of(kGridFrameNames, text_of(json, "frame"));
  if (!frame) return wrong("\"frame\" is none that is known");
  const Json* axes = find(json, "axes");
  Grid grid;
  grid.frame = *frame;
  if (axes == nullptr || !axes->is_array() || axes->size() != grid.axes.size()) return wrong("\"axes\" are not four");
  std::uint64_t count = 1;
  for (std::size_t axis = 0; axis < grid.axes.size(); ++axis) {
    Result<GridAxis> parsed = parse_axis((*axes)[axis], *frame, axis);
    if (!parsed) return parsed.error();
    grid.axes[axis] = *std::move(parsed);
    count *= grid.axes[axis].size();  // 2^36 x 2^16 at most
    if (count > kGridMostNodes) return wrong("more than 2^36 nodes");
  }
  return grid;
}

Result<std::vector<std::string>> parse_channels(const Json& json) {
  const Json* list = find(json, "channels");
  if (list == nullptr || !list->is_array() || list->empty()) return wrong("\"channels\" are missing");
  if (list->size() > kMostTableChannels) return wrong(fmt::format("more than {} channels", kMostTableChannels));
  std::vector<std::string> channels;
  std::set<std::string> seen;
  for (const Json& name : *list) {
    if (!name.is_string() || name.get<std::string>().empty()) return wrong("a channel has no name");
    channels.push_back(name.get<std::string>());
    if (!seen.insert(channels.back()).second) return wrong("two channels have the same name");
  }
  return channels;
}

/// Left out by what others write: 90 degrees.
Result<MeasuredReach> parse_reach(const Json& json) {
  MeasuredReach reach;
  for (const auto& [name, angle] :
       {std::pair("theta_max", &reach.theta_max_deg), std::pair("slice_theta_max", &reach.slice_theta_max_deg)}) {
    const Json* entry = find(json, name);
    if (entry == nullptr) continue;
    if (!entry->is_number()) return wrong(fmt::format("\"{}\" is no number", name));
    *angle = entry->get<double>();
  }
  reach.slice_theta_max_deg = std::min(reach.slice_theta_max_deg, reach.theta_max_deg);
  reach.beyond_theta_max = text_of(json, "beyond_theta_max");
  if (!reach.is_valid()) return wrong("\"theta_max\" is not within 0 and 90 degrees");
  return reach;
}

}  // namespace

std::string emit_table_head(const TableHead& head) {
  OrderedJson json = {{"sbrdf", kKind}, {"version", kVersion}, {"frame", name_of(kGridFrameNames, head.grid.frame)}};
  json["axes"] = OrderedJson::array();
  for (std::size_t k = 0; k < head.grid.axes.size(); ++k) {
    const GridAxis& axis = head.grid.axes[k];
    json["axes"].push_back({{"name", head.grid.axis_name(k)},
                            {"unit", kAngleUnit},
                            {"ends", name_of(kEndsNames, axis.ends())},
                            {"spacing", name_of(kSpacingNames, axis.spacing())},
                            {"nodes", axis.nodes_deg()}});
  }
  json["channels"] = head.channels;
  json["type"] = name_of(kValueTypeNames, head.type);
  json["quantity"] = kQuantity;
  json["unit"] = kUnit;
  json["unmeasured"] = kUnmeasured;
  json["theta_max"] = head.reach.theta_max_deg;
  json["slice_theta_max"] = head.reach.slice_theta_max_deg;
  if (!head.reach.beyond_theta_max.empty()) json["beyond_theta_max"] = head.reach.beyond_theta_max;
  if (!head.report.empty()) json["report"] = OrderedJson::parse(head.report, nullptr, false);
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

bool begins_table_head(std::string_view text) {
  std::string dense;
  for (const char c : text.substr(0, 100)) {
    if (c != ' ' && c != '\t' && c != '\r' && c != '\n') dense += c;
  }
  return dense.starts_with(R"({"sbrdf":"densetable")");
}

bool is_table_head(std::string_view text) { return begins_table_head(text) || parse_table_head(text).ok(); }

Result<TableHead> parse_table_head(std::string_view text) {
  if (text.size() > kLongestTableHead) {
    return unsupported(
        fmt::format("description of the table: {} bytes; at most {} are read", text.size(), kLongestTableHead));
  }
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object()) return wrong("no JSON object");
  if (Status known = check_kind(json); !known) return known.error();
  Result<Grid> grid = parse_axes(json);
  if (!grid) return grid.error();
  Result<std::vector<std::string>> channels = parse_channels(json);
  if (!channels) return channels.error();
  TableHead head;
  head.grid = *std::move(grid);
  head.channels = *std::move(channels);
  Result<MeasuredReach> reach = parse_reach(json);
  if (!reach) return reach.error();
  head.reach = *std::move(reach);
  // Numbers may have been saved as another type since; the file itself tells.
  head.type = value_of(kValueTypeNames, text_of(json, "type")).value_or(ValueType::kFloat32);
  return head;
}

}  // namespace sbrdf::internal
