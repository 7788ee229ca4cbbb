#include "converters/files/analytic/analytic_file.h"

#include <string>
#include <vector>

namespace sbrdf::internal {
namespace {

constexpr std::string_view kExtension = ".json";

bool ends_with_json(std::string_view name) {
  if (name.size() <= kExtension.size()) return false;
  std::string end(name.substr(name.size() - kExtension.size()));
  for (char& c : end) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return end == kExtension;
}

/// What the member "model" says; empty where there is none.
std::string_view model_in(std::string_view text) {
  constexpr std::string_view kMember = "\"model\"";
  constexpr std::string_view kBlank = " \t\r\n";
  for (std::size_t at = text.find(kMember); at != std::string_view::npos; at = text.find(kMember)) {
    text.remove_prefix(at + kMember.size());
    const std::size_t colon = text.find_first_not_of(kBlank);
    if (colon == std::string_view::npos || text[colon] != ':') continue;  // a name that is this word
    const std::size_t first = text.find_first_not_of(kBlank, colon + 1);
    if (first == std::string_view::npos || text[first] != '"') continue;
    return text.substr(first + 1, text.find('"', first + 1) - first - 1);
  }
  return {};
}

}  // namespace

bool is_named(std::string_view text) { return text.starts_with(kKurtPrefix); }

std::optional<std::string_view> file_in_name(std::string_view text) {
  if (!is_named(text)) return std::nullopt;
  text.remove_prefix(kKurtPrefix.size());
  return ends_with_json(text) ? std::optional(text) : std::nullopt;
}

Result<std::unique_ptr<BrdfSource>> open_named(std::string_view text) {
  const Result<AnalyticModel> model = kurt_material(is_named(text) ? text.substr(kKurtPrefix.size()) : text);
  if (!model) return model.error();
  return make_analytic_source(*model);
}

Match recognise_analytic_file(std::span<const std::byte> head, LobeKind kind) {
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos || text[start] != '{') return Match::kNone;
  const bool parameters =
      text.find("\"k_d\"") != std::string_view::npos || text.find("\"lobes\"") != std::string_view::npos;
  if (kind == value_of(kLobeKindNames, model_in(text)).value_or(LobeKind::kKurt)) {
    if (parameters) return Match::kWhole;
    return kind == LobeKind::kKurt ? Match::kDamaged : Match::kNone;
  }
  return Match::kNone;
}

Result<std::unique_ptr<BrdfSource>> open_analytic_file(const ByteSource& bytes) {
  if (bytes.size() > kAnalyticLargestFile) {
    return invalid_file("parameters of a model: a file of " + std::to_string(bytes.size()) + " bytes; at most " +
                        std::to_string(kAnalyticLargestFile) + " are read");
  }
  const Result<std::vector<std::byte>> text = read_range(bytes, 0, bytes.size());
  if (!text) return text.error();
  const Result<AnalyticModel> model = parse_analytic_json({reinterpret_cast<const char*>(text->data()), text->size()});
  if (!model) return model.error();
  return make_analytic_source(*model);
}

}  // namespace sbrdf::internal
