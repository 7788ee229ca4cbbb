#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "formats/core/result.h"

namespace sbrdf::internal {

/// Reads members of objects. The first one that is missing or wrong sticks: what is read from then on means nothing.
class MemberReader {
 public:
  using Json = nlohmann::ordered_json;

  void refuse(const std::string& member, const std::string& what) {
    if (!error_) error_ = within_ + "'" + member + "' " + what;
  }
  /// What is read next lies in "cameras[2]", which errors then say; empty: at the top.
  void enter(const std::string& place) { within_ = place.empty() ? "" : place + ": "; }
  [[nodiscard]] const std::optional<std::string>& error() const { return error_; }

  /// null where there is none.
  const Json& member(const Json& json, const char* name) {
    static const Json kNone;
    if (json.is_object() && json.contains(name)) return json.at(name);
    refuse(name, "is missing");
    return kNone;
  }

  double number(const Json& json, const char* name, double least, double most) {
    const Json& value = member(json, name);
    const double number = value.is_number() ? value.get<double>() : least - 1;
    if (number >= least && number <= most) return number;
    refuse(name, "is no number in range");
    return least;
  }

  std::uint32_t whole(const Json& value, const char* name, std::uint32_t most) {
    if (value.is_number_unsigned() && value.get<std::uint64_t>() <= most) return value.get<std::uint32_t>();
    refuse(name, "is no whole number in range");
    return 0;
  }

  /// Nothing where there is no such member.
  std::optional<std::uint32_t> optional_crc32(const Json& json, const char* name) {
    if (!json.is_object() || !json.contains(name)) return std::nullopt;
    return whole(json.at(name), name, std::numeric_limits<std::uint32_t>::max());
  }

  bool flag(const Json& json, const char* name) {
    const Json& value = member(json, name);
    if (value.is_boolean()) return value.get<bool>();
    refuse(name, "is neither true nor false");
    return false;
  }

  std::string text(const Json& json, const char* name) {
    const Json& value = member(json, name);
    if (value.is_string()) return value.get<std::string>();
    refuse(name, "is no text");
    return {};
  }

  /// A text that can be only one.
  void constant(const Json& json, const char* name, const std::string& value) {
    if (text(json, name) != value) refuse(name, "is not '" + value + "'");
  }

  /// A name in the folder of the manifest, and in no other.
  std::string file_name(const Json& json, const char* name) {
    std::string file = text(json, name);
    if (file.empty() || file.find_first_of(std::string_view("/\\\0", 3)) != std::string::npos || file == "." ||
        file == "..") {
      refuse(name, "is no plain file name");
    }
    return file;
  }

  std::array<float, 3> three(const Json& json, const char* name) {
    const Json& value = member(json, name);
    std::array<float, 3> rgb{};
    const bool three = value.is_array() && value.size() == rgb.size();
    for (std::size_t c = 0; three && c < rgb.size(); ++c) {
      rgb[c] = value[c].is_number() ? value[c].get<float>() : std::numeric_limits<float>::infinity();
      if (!std::isfinite(rgb[c])) refuse(name, "is no list of three numbers");
    }
    if (!three) refuse(name, "is no list of three numbers");
    return rgb;
  }

  /// A list; empty where it is none, or longer than `most`.
  const Json& list(const Json& json, const char* name, std::size_t most) {
    static const Json kEmpty = Json::array();
    const Json& value = member(json, name);
    if (value.is_array() && value.size() <= most) return value;
    refuse(name, "is no list of at most " + std::to_string(most));
    return kEmpty;
  }

  /// Refuses members that are none of these, as a misspelt one would be without effect.
  void only(const Json& json, std::initializer_list<std::string_view> names) {
    if (!json.is_object()) return;
    for (const auto& entry : json.items()) {
      if (std::find(names.begin(), names.end(), entry.key()) == names.end()) refuse(entry.key(), "is not known here");
    }
  }

 private:
  std::optional<std::string> error_;
  std::string within_;
};

/// Of a small file. kInvalidFile for text that is no JSON, nested too deeply, or with an object of too many members.
[[nodiscard]] Result<nlohmann::ordered_json> parse_small_json(std::string_view text);

}  // namespace sbrdf::internal
