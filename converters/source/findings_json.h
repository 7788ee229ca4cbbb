#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// As reports and metadata of tables tell them: [{"what", "count", "total"}, ...].
[[nodiscard]] nlohmann::ordered_json findings_json(std::span<const Finding> findings);

}  // namespace sbrdf::internal
