#include "converters/slicing/metadata_json.h"

#include <nlohmann/json.hpp>

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kDeepest = 64;

}  // namespace

Json parse_metadata(const std::string& text) {
  bool too_deep = false;
  const auto watch_depth = [&](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > kDeepest;
    return !too_deep;
  };
  Json metadata = Json::parse(text, watch_depth, false);
  if (metadata.is_discarded() || too_deep) return text;
  return metadata;
}

std::string emit_metadata(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace sbrdf::internal
