#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "converters/models/analytic.h"

namespace sbrdf::internal {

namespace {

using Json = nlohmann::json;
using Triple = std::array<double, 3>;

// Both lobes of a material of Table 2 share k_s.
// clang-format off
const std::array<AnalyticModel, 10>& table_2() {
  static const std::array<AnalyticModel, 10> kMaterials = {{
      {"Brushed alum", {0.0036, 0.0034, 0.0026}, {{{0.0115, 0.0105, 0.0075}, 0.999, 0.035, 0.129, 0.005}}},
      {"Purple satin", {0.0026, 0.0004, 0.0011}, {{{0.1404, 0.0522, 0.0711}, 0.055, 0.339, 1.256, 0}}},
      {"Red velvet", {0.0048, 0.0005, 0}, {{{0.1938, 0.0333, 0.0267}, 0.041, 2.337, 2.644, 0}}},
      {"Yellow satin", {0.0066, 0.0022, 0.0004}, {{{0.0542, 0.0345, 0.0131}, 0.207, 0.129, 1.084, 0.197}}},
      {"fabric002", {0.0805, 0.0945, 0.081}, {{{0.0798, 0.1205, 0.1796}, 0.3431, 1.3508, 0.8121, 0.8359},
                                              {{0.0798, 0.1205, 0.1796}, 1, 0.3168, 1.0061, 0.0905}}},
      {"fabric041", {0.2565, 0.0703, 0.0613}, {{{0.0211, 0.019, 0.0146}, 1, 0.3665, 1.1075, 0.4984},
                                               {{0.0211, 0.019, 0.0146}, 0.1222, 1.1864, 0.7247, 0.8356}}},
      {"fabric112", {0.0838, 0.0596, 0.0434}, {{{0.1419, 0.1078, 0.0521}, 1, 1.2101, 0.2139, 0},
                                               {{0.1419, 0.1078, 0.0521}, 1, 0.7046, 1.2292, 0.976}}},
      {"fabric135", {0.0395, 0.0258, 0.0205}, {{{0.014, 0.011, 0.0087}, 1, 1.2025, 0.1029, 0.5043},
                                               {{0.014, 0.011, 0.0087}, 0.3078, 2.038, 0.3867, 0.5723}}},
      {"fabric139", {0.1607, 0.153, 0.135}, {{{0.0483, 0.0461, 0.0414}, 1, 0.2948, 1.3215, 0.5753},
                                             {{0.0483, 0.0461, 0.0414}, 1, 1.3281, 0.3677, 0.667}}},
      {"wood01", {0.1548, 0.1219, 0.0836}, {{{0.0768, 0.0741, 0.0706}, 1, 0.5672, 0.7619, 0.5051},
                                            {{0.0768, 0.0741, 0.0706}, 1, 1.7007, 1.923, 0.2285}}},
  }};
  return kMaterials;
}
// clang-format on

std::string folded(std::string_view name) {
  std::string out(name);
  for (char& c : out) {
    c = c == '-' || c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

std::optional<Error> range_error(const std::string& path, double value, double least, double most) {
  if (value >= least && value <= most) return {};
  return usage_error(fmt::format("{} is {}, must be {} to {}", path, value, least, most));
}

std::optional<Error> range_error(const std::string& path, const Triple& values) {
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (auto error = range_error(fmt::format("{}[{}]", path, c), values[c], 0, kParameterLargest)) return error;
  }
  return {};
}

/// Beside k_s, as they stand in files.
struct ShapeMember {
  std::string_view name;
  double AnalyticLobe::*member;
  double least, most;
};

/// Of each kind, in the order in which they are written.
std::span<const ShapeMember> shape_members(LobeKind kind) {
  constexpr double kLeast = 1 / kParameterLargest;
  static constexpr std::array<ShapeMember, 4> kKurt = {{{"f_0", &AnalyticLobe::f_0, 0, kParameterLargest},
                                                        {"m_x", &AnalyticLobe::m_x, kLeast, kParameterLargest},
                                                        {"m_y", &AnalyticLobe::m_y, kLeast, kParameterLargest},
                                                        {"alpha", &AnalyticLobe::alpha, 0, kLargestAlpha}}};
  static constexpr std::array<ShapeMember, 3> kGgx = {{{"f_0", &AnalyticLobe::f_0, 0, kParameterLargest},
                                                       {"alpha_x", &AnalyticLobe::m_x, kLeast, kParameterLargest},
                                                       {"alpha_y", &AnalyticLobe::m_y, kLeast, kParameterLargest}}};
  if (kind == LobeKind::kKurt) return kKurt;
  return std::span(kGgx).subspan(kind == LobeKind::kWard ? 1 : 0);
}

/// Reads the members of objects. The first complaint sticks.
class AnalyticReader {
 public:
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  AnalyticModel model(const Json& json) {
    AnalyticModel out;
    std::set<std::string> keys = {"name", "k_d", "lobes"};
    if (json.is_object() && json.contains("model")) {
      keys.insert("model");
      const auto kind = json["model"].is_string() ? value_of(kLobeKindNames, json["model"].get<std::string>())
                                                  : std::optional<LobeKind>();
      if (!kind) {
        complain("model must be \"kurt\", \"ward\" or \"ggx\"");
        return out;
      }
      out.kind = *kind;
    }
    if (!has_keys(json, "", keys)) return out;
    const Json& name = json["name"];
    if (name.is_string()) {
      out.name = name.get<std::string>();
    } else {
      complain("name must be a string");
    }
    // It appears in one-line descriptions.
    if (std::any_of(out.name.begin(), out.name.end(),
                    [](char c) { return std::iscntrl(static_cast<unsigned char>(c)); })) {
      complain("name holds a control character");
    }
    out.k_d = triple(json["k_d"], "k_d");
    const Json& lobes = json["lobes"];
    if (!lobes.is_array()) complain("lobes must be an array");
    for (std::size_t n = 0; n < lobes.size() && !error_; ++n) {
      out.lobes.push_back(lobe(lobes[n], fmt::format("lobes[{}]", n), out.kind));
    }
    return out;
  }

 private:
  AnalyticLobe lobe(const Json& json, const std::string& path, LobeKind kind) {
    AnalyticLobe out;
    std::set<std::string> keys = {"k_s"};
    for (const ShapeMember& shape : shape_members(kind)) keys.emplace(shape.name);
    if (!has_keys(json, path, keys)) return out;
    out.k_s = triple(json["k_s"], path + ".k_s");
    for (const ShapeMember& shape : shape_members(kind)) {
      const std::string name(shape.name);
      out.*shape.member = number(json[name], fmt::format("{}.{}", path, name));
    }
    return out;
  }

  Triple triple(const Json& json, const std::string& path) {
    if (!json.is_array() || json.size() != 3) {
      complain(path + " must be an array of 3 numbers");
      return {};
    }
    return {number(json[0], path + "[0]"), number(json[1], path + "[1]"), number(json[2], path + "[2]")};
  }

  double number(const Json& json, const std::string& path) {
    if (!json.is_number()) complain(path + " must be a number");
    return json.is_number() ? json.get<double>() : 0;
  }

  bool has_keys(const Json& json, const std::string& path, const std::set<std::string>& keys) {
    const std::string prefix = path.empty() ? "" : path + ".";
    if (!json.is_object()) {
      complain((path.empty() ? "the whole" : path) + " must be an object");
      return false;
    }
    for (const auto& member : json.items()) {
      // An unknown key can be any text: it is written with its quotes and escapes.
      if (!keys.contains(member.key()))
        complain(fmt::format("{}{} is not a known key", prefix, Json(member.key()).dump()));
    }
    for (const std::string& key : keys) {
      if (!json.contains(key)) complain(fmt::format("{}{} is missing", prefix, key));
    }
    return !error_;
  }

  void complain(const std::string& message) {
    if (!error_) error_ = invalid_file("parameters of a model: " + message);
  }

  std::optional<Error> error_;
};

/// Sees a key that stands twice in an object, of which the parser would keep the last.
class RepeatedKeys {
 public:
  bool operator()(Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start) open_.emplace_back();
    if (event == Json::parse_event_t::object_end) open_.pop_back();
    if (event == Json::parse_event_t::key && !open_.back().insert(parsed.get<std::string>()).second &&
        repeated.empty()) {
      repeated = parsed.dump();
    }
    return true;
  }

  std::string repeated;

 private:
  std::vector<std::set<std::string>> open_;
};

Error syntax_error(const Json::parse_error& error) {
  std::string what = error.what();
  // The parser's own position and its echo of the text, which may be anything, are left out.
  what = what.substr(0, what.find("; last read"));
  if (const auto start = what.find(": "); start != std::string::npos) what = what.substr(start + 2);
  const std::optional<std::uint64_t> offset =
      error.byte > 0 ? std::optional<std::uint64_t>(error.byte - 1) : std::nullopt;
  return invalid_file("parameters of a model: no valid JSON: " + what, offset);
}

}  // namespace

std::vector<std::string> kurt_material_names() {
  std::vector<std::string> names;
  for (const AnalyticModel& material : table_2()) names.push_back(material.name);
  return names;
}

Result<AnalyticModel> kurt_material(std::string_view name) {
  for (const AnalyticModel& material : table_2()) {
    if (folded(material.name) == folded(name)) return material;
  }
  return usage_error(
      fmt::format("there is no Kurt material \"{}\"; there are {}", name, fmt::join(kurt_material_names(), ", ")));
}

Status check_analytic(const AnalyticModel& model) {
  if (auto error = range_error("k_d", model.k_d)) return *error;
  for (std::size_t n = 0; n < model.lobes.size(); ++n) {
    const AnalyticLobe& lobe = model.lobes[n];
    const std::string path = fmt::format("lobes[{}].", n);
    if (auto error = range_error(path + "k_s", lobe.k_s)) return *error;
    for (const ShapeMember& shape : shape_members(model.kind)) {
      if (auto error =
              range_error(fmt::format("{}{}", path, shape.name), lobe.*shape.member, shape.least, shape.most)) {
        return *error;
      }
    }
  }
  return ok_status();
}

Result<AnalyticModel> parse_analytic_json(std::string_view text) {
  RepeatedKeys repeated_keys;
  Json json;
  try {
    json =
        Json::parse(text, [&](int, Json::parse_event_t event, Json& parsed) { return repeated_keys(event, parsed); });
  } catch (const Json::parse_error& error) {
    return syntax_error(error);
  } catch (const Json::exception&) {
    return invalid_file("parameters of a model: a number is beyond the range of double");
  }
  if (!repeated_keys.repeated.empty()) {
    return invalid_file("parameters of a model: key " + repeated_keys.repeated + " is repeated");
  }
  AnalyticReader reader;
  AnalyticModel model = reader.model(json);
  if (reader.error()) return *reader.error();
  if (const Status status = check_analytic(model); !status.ok()) {
    return invalid_file("parameters of a model: " + status.error().message);
  }
  return model;
}

std::string emit_analytic_json(const AnalyticModel& model) {
  nlohmann::ordered_json json;
  // Files of Kurt's model are older than the member.
  if (model.kind != LobeKind::kKurt) json["model"] = name_of(kLobeKindNames, model.kind);
  json["name"] = model.name;
  json["k_d"] = model.k_d;
  json["lobes"] = nlohmann::ordered_json::array();
  for (const AnalyticLobe& lobe : model.lobes) {
    nlohmann::ordered_json one = {{"k_s", lobe.k_s}};
    for (const ShapeMember& shape : shape_members(model.kind)) one[std::string(shape.name)] = lobe.*shape.member;
    json["lobes"].push_back(std::move(one));
  }
  return json.dump(1) + "\n";
}

}  // namespace sbrdf::internal
