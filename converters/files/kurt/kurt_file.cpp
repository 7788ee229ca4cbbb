#include "converters/files/kurt/kurt_file.h"

#include <string>
#include <vector>

#include "converters/models/kurt.h"

namespace sbrdf::internal {
namespace {

constexpr std::string_view kExtension = ".json";

bool ends_with_json(std::string_view name) {
  if (name.size() <= kExtension.size()) return false;
  std::string end(name.substr(name.size() - kExtension.size()));
  for (char& c : end) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return end == kExtension;
}

}  // namespace

bool is_named(std::string_view text) { return text.starts_with(kKurtPrefix); }

std::optional<std::string_view> file_in_name(std::string_view text) {
  if (!is_named(text)) return std::nullopt;
  text.remove_prefix(kKurtPrefix.size());
  return ends_with_json(text) ? std::optional(text) : std::nullopt;
}

Result<std::unique_ptr<BrdfSource>> open_named(std::string_view text) {
  const Result<KurtModel> model = kurt_material(is_named(text) ? text.substr(kKurtPrefix.size()) : text);
  if (!model) return model.error();
  return make_kurt_source(*model);
}

Match recognise_kurt_file(std::span<const std::byte> head) {
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos || text[start] != '{') return Match::kNone;
  const bool parameters =
      text.find("\"k_d\"") != std::string_view::npos || text.find("\"lobes\"") != std::string_view::npos;
  return parameters ? Match::kWhole : Match::kDamaged;
}

Result<std::unique_ptr<BrdfSource>> open_kurt_file(const ByteSource& bytes) {
  if (bytes.size() > kKurtLargestFile) {
    return invalid_file("Kurt parameters: a file of " + std::to_string(bytes.size()) + " bytes; at most " +
                        std::to_string(kKurtLargestFile) + " are read");
  }
  const Result<std::vector<std::byte>> text = read_range(bytes, 0, bytes.size());
  if (!text) return text.error();
  const Result<KurtModel> model = parse_kurt_json({reinterpret_cast<const char*>(text->data()), text->size()});
  if (!model) return model.error();
  return make_kurt_source(*model);
}

}  // namespace sbrdf::internal
