#include "converters/files/atlas/manifest_members.h"

namespace sbrdf::internal {

using Json = nlohmann::ordered_json;

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
  for (std::size_t c = 0; c < 3; ++c) {
    if (domain.least[c] > domain.most[c]) reader.refuse("least", "is above 'most'");
  }
  domain.grey_shares = reader.colour(json, "grey_shares");
  domain.grey_divisor = static_cast<float>(reader.number(json, "grey_divisor", 0, 1e6));
  return domain;
}

}  // namespace sbrdf::internal
