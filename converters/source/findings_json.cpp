#include "converters/source/findings_json.h"

#include <nlohmann/json.hpp>

namespace sbrdf::internal {

nlohmann::ordered_json findings_json(std::span<const Finding> findings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    json.push_back({{"what", finding.what}, {"count", finding.count}, {"total", finding.total}});
  }
  return json;
}

}  // namespace sbrdf::internal
