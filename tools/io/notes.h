#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace sbrdf::internal {

// What a run notes for the next one: a JSON object in a file of its own.

[[nodiscard]] std::string note_text(const nlohmann::ordered_json& note);
/// As it is once it was written and read: names in no encoding are not what they were.
[[nodiscard]] nlohmann::ordered_json as_noted(const nlohmann::ordered_json& note);
/// null for what is no note, or larger than any that is written.
[[nodiscard]] nlohmann::ordered_json read_note(const std::string& path);

}  // namespace sbrdf::internal
