#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sbrdf::internal {

/// The metadata of a sliced file as JSON. What is none, is nested more than 64 deep (so that writing it out again could
/// overflow the stack), or has more than 4096 values (each takes many times the memory of its text), comes as one
/// string.
[[nodiscard]] nlohmann::ordered_json parse_metadata(const std::string& text);

/// The same on one line; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string emit_metadata(const nlohmann::ordered_json& json);

}  // namespace sbrdf::internal
