#include "converters/files/atlas/manifest_members.h"

#include <algorithm>
#include <cmath>

namespace sbrdf::internal {

using Json = nlohmann::ordered_json;

namespace {

/// With grey shares the values of all channels are added up.
constexpr float kLargestOfSum = 1e37F;

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

}  // namespace

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
  domain.reference = reader.three(json, "reference");
  domain.floor = reader.three(json, "floor");
  domain.at_floor = reader.three(json, "at_floor");
  domain.at_zero = reader.three(json, "at_zero");
  domain.least = reader.three(json, "least");
  domain.most = reader.three(json, "most");
  domain.grey_shares = reader.three(json, "grey_shares");
  domain.grey_divisor = static_cast<float>(reader.number(json, "grey_divisor", 0, 1e6));
  check_domain(reader, domain);
  return domain;
}

}  // namespace sbrdf::internal
