#include "converters/json/members.h"

#include <array>

namespace sbrdf::internal {

using Json = nlohmann::ordered_json;

namespace {

constexpr int kDeepest = 32;               // levels of JSON: what compares and copies it is recursive
constexpr std::size_t kMostMembers = 256;  // of an object, which are looked for one by one

/// " from byte 17 on", where text ends to be JSON.
std::string place_of_error(std::string_view text) {
  try {
    const Json kept = Json::parse(text, [](int, Json::parse_event_t, Json&) { return false; });  // nothing
    return kept.empty() ? "" : ": more than that";
  } catch (const Json::parse_error& error) {
    return " from byte " + std::to_string(error.byte) + " on";
  } catch (const Json::exception& error) {
    return std::string(": ") + error.what();
  }
}

}  // namespace

Result<Json> parse_small_json(std::string_view text) {
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
  if (json.is_discarded()) return invalid_file("is no JSON" + place_of_error(text));
  return json;
}

}  // namespace sbrdf::internal
