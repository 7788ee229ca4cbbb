#include "converters/slicing/metadata_json.h"

#include <nlohmann/json.hpp>

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kDeepest = 64;
constexpr std::size_t kMostValues = 4096;

/// Looks at a text without keeping anything of it, and stops at what is too deep or too much.
class Survey final : public nlohmann::json_sax<Json> {
 public:
  bool null() override { return count(); }
  bool boolean(bool /*value*/) override { return count(); }
  bool number_integer(number_integer_t /*value*/) override { return count(); }
  bool number_unsigned(number_unsigned_t /*value*/) override { return count(); }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override { return count(); }
  bool string(string_t& /*value*/) override { return count(); }
  bool binary(binary_t& /*value*/) override { return false; }
  bool key(string_t& /*name*/) override { return true; }
  bool start_object(std::size_t /*count*/) override { return open(); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t /*count*/) override { return open(); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t /*position*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return false;
  }

 private:
  bool count() { return ++values_ <= kMostValues; }
  bool open() { return ++depth_ <= kDeepest && count(); }
  bool close() {
    --depth_;
    return true;
  }

  std::size_t depth_ = 0;
  std::size_t values_ = 0;
};

}  // namespace

Json parse_metadata(const std::string& text) {
  // First of all: a value takes far more memory than the two bytes that it may be in the text.
  Survey survey;
  if (!Json::sax_parse(text, &survey)) return text;
  return Json::parse(text);
}

std::string emit_metadata(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace sbrdf::internal
