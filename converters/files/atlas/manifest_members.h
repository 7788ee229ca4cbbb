#pragma once

#include <nlohmann/json.hpp>

#include "codec/atlas/atlas.h"
#include "converters/json/members.h"

namespace sbrdf::internal {

/// What stands in the member "values" of a manifest, of any layout.
[[nodiscard]] nlohmann::ordered_json domain_json(const AtlasDomain& domain);
[[nodiscard]] AtlasDomain read_domain(MemberReader& reader, const nlohmann::ordered_json& json);

}  // namespace sbrdf::internal
