#include "converters/slicing/metadata.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "converters/slicing/metadata_json.h"
#include "converters/slicing/names.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

namespace key {
constexpr const char* kSource = "source";
constexpr const char* kFormat = "format";
constexpr const char* kDescription = "description";
constexpr const char* kSha256 = "sha256";
constexpr const char* kCommand = "command";
constexpr const char* kQuantity = "quantity";
constexpr const char* kColour = "colour";
constexpr const char* kSymmetrised = "symmetrised";
constexpr const char* kReciprocityResidual = "reciprocity_residual_percent";
constexpr const char* kRefinement = "refinement";
constexpr const char* kZeroValues = "zero_values";
constexpr const char* kNegativeValues = "negative_values";
constexpr const char* kFilledSamples = "filled_samples";
constexpr const char* kError = "error";
constexpr const char* kMre = "mre_percent";
constexpr const char* kRelL1 = "rel_l1_percent";
constexpr const char* kDirections = "directions";
constexpr const char* kMeasuredOn = "measured_on";
constexpr const char* kValuesAllZero = "values_all_zero";
constexpr const char* kFindings = "findings";
constexpr const char* kWhat = "what";
constexpr const char* kCount = "count";
constexpr const char* kTotal = "total";
constexpr const char* kErrorBeforeRounding = "error_before_rounding";
constexpr const char* kCodedBefore = "coded_before_percent";
constexpr const char* kErrorOfWhole = "error_of_whole";
constexpr const char* kExtracted = "extracted";
constexpr const char* kThetaMax = "theta_max_deg";
constexpr const char* kMaxLevel = "max_level";
constexpr const char* kDifferenceFromWhole = "difference_from_whole_percent";
constexpr const char* kExtractedBefore = "extracted_before";
}  // namespace key

constexpr std::array kKeys = {
    MetadataKey{"", key::kSource, MetadataType::kObject, ""},
    MetadataKey{key::kSource, key::kFormat, MetadataType::kText, ""},
    MetadataKey{key::kSource, key::kDescription, MetadataType::kText, ""},
    MetadataKey{key::kSource, key::kSha256, MetadataType::kText, ""},
    MetadataKey{"", key::kCommand, MetadataType::kText, ""},
    MetadataKey{"", key::kQuantity, MetadataType::kText, ""},
    MetadataKey{"", key::kColour, MetadataType::kText, ""},
    MetadataKey{"", key::kSymmetrised, MetadataType::kBoolean, ""},
    MetadataKey{"", key::kReciprocityResidual, MetadataType::kNumber, "%"},
    MetadataKey{"", key::kRefinement, MetadataType::kText, ""},
    MetadataKey{"", key::kZeroValues, MetadataType::kCount, ""},
    MetadataKey{"", key::kNegativeValues, MetadataType::kCount, ""},
    MetadataKey{"", key::kFilledSamples, MetadataType::kCount, ""},
    MetadataKey{"", key::kError, MetadataType::kObject, ""},
    MetadataKey{key::kError, key::kMre, MetadataType::kNumber, "%"},
    MetadataKey{key::kError, key::kRelL1, MetadataType::kNumber, "%"},
    MetadataKey{key::kError, key::kDirections, MetadataType::kCount, ""},
    MetadataKey{key::kError, key::kMeasuredOn, MetadataType::kText, ""},
    MetadataKey{key::kError, key::kValuesAllZero, MetadataType::kBoolean, ""},
    MetadataKey{"", key::kFindings, MetadataType::kList, ""},
    MetadataKey{key::kFindings, key::kWhat, MetadataType::kText, ""},
    MetadataKey{key::kFindings, key::kCount, MetadataType::kCount, ""},
    MetadataKey{key::kFindings, key::kTotal, MetadataType::kCount, ""},
    MetadataKey{"", key::kErrorBeforeRounding, MetadataType::kObject, ""},
    MetadataKey{"", key::kCodedBefore, MetadataType::kList, "%"},
    MetadataKey{"", key::kErrorOfWhole, MetadataType::kObject, ""},
    MetadataKey{"", key::kExtracted, MetadataType::kObject, ""},
    MetadataKey{key::kExtracted, key::kThetaMax, MetadataType::kNumber, "degrees"},
    MetadataKey{key::kExtracted, key::kMaxLevel, MetadataType::kCount, ""},
    MetadataKey{key::kExtracted, key::kDifferenceFromWhole, MetadataType::kNumber, "%"},
    MetadataKey{"", key::kExtractedBefore, MetadataType::kList, ""},
};

constexpr std::array<std::string_view, 6> kTypeNames = {"text", "number", "count", "boolean", "object", "list"};

// Four digits say enough of a percentage, and compress well.
double rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return std::strtod(text.data(), nullptr);
}

constexpr std::size_t kLeanDigits = 16;  // of the checksum: enough to tell files apart

Json describe_source(const SourceTraits& traits, const SliceOptions& options) {
  const bool full = options.metadata == MetadataDetail::kFull;
  Json source = {{key::kFormat, traits.format}};
  if (full) source[key::kDescription] = traits.description;
  if (!options.source_sha256.empty()) {
    source[key::kSha256] = full ? options.source_sha256 : options.source_sha256.substr(0, kLeanDigits);
  }
  return source;
}

Json describe_error(const SliceReport& report, bool full) {
  Json error = {{key::kMre, rounded(report.error.mre_percent)}, {key::kRelL1, rounded(report.error.rel_l1_percent)}};
  if (full) {
    error[key::kDirections] = report.error_directions;
    error[key::kMeasuredOn] = fmt::format("random directions that took no part in any choice, theta up to {:g} degrees",
                                          report.theta_max_deg);
  }
  if (report.error_values_all_zero) error[key::kValuesAllZero] = true;
  return error;
}

void rename(Json& json, const char* from, const char* to) {
  const auto found = json.find(from);
  if (found == json.end()) return;
  Json value = *found;
  json[to] = std::move(value);
  json.erase(from);
}

/// To the list under a key, which is begun anew where something else stands there.
void append(Json& json, const char* key, Json value) {
  Json& list = json[key];
  if (!list.is_array()) list = Json::array();
  list.push_back(std::move(value));
}

/// The lesser of both, of what an earlier part says and of what is new; what is no number says nothing.
template <class Number>
Number least(const Json& before, const char* key, Number value) {
  const auto found = before.find(key);
  return found != before.end() && found->is_number() ? std::min(value, found->get<Number>()) : value;
}

}  // namespace

std::span<const MetadataKey> metadata_keys() { return kKeys; }

std::string_view metadata_type_name(MetadataType type) { return kTypeNames[static_cast<std::size_t>(type)]; }

std::string metadata_of_slicing(const SourceTraits& traits, const SliceOptions& options, const SliceReport& report) {
  if (options.metadata == MetadataDetail::kNone) return {};
  const bool full = options.metadata == MetadataDetail::kFull;
  Json json;
  json[key::kSource] = describe_source(traits, options);
  if (full && !options.command.empty()) json[key::kCommand] = options.command;
  if (full) {
    json[key::kQuantity] = "f_r, 1/sr, without cosine";
    json[key::kColour] = "channels as in the source, linear";
    json[key::kSymmetrised] = !traits.reciprocal;
  }
  if (full || !traits.reciprocal) json[key::kReciprocityResidual] = rounded(report.reciprocity_difference_percent);
  if (full) {
    json[key::kRefinement] = name_of(kRefinementNames, options.refinement);
    json[key::kZeroValues] = report.zero_values;
    json[key::kNegativeValues] = report.negative_values;
  }
  if (report.filled_samples > 0) json[key::kFilledSamples] = report.filled_samples;
  json[key::kError] = describe_error(report, full);
  for (const Finding& finding : traits.findings) {
    json[key::kFindings].push_back(
        {{key::kWhat, finding.what}, {key::kCount, finding.count}, {key::kTotal, finding.total}});
  }
  return emit_metadata(json);
}

std::string metadata_of_copy(const std::string& text, double precision_before) {
  Json json = parse_metadata(text);
  if (!json.is_object()) return text;
  if (!json.contains(key::kErrorBeforeRounding)) rename(json, key::kError, key::kErrorBeforeRounding);
  if (precision_before != 0) append(json, key::kCodedBefore, Json(rounded(100 * precision_before)));
  return emit_metadata(json);
}

std::string lean_metadata(const std::string& text) {
  Json json = parse_metadata(text);
  if (!json.is_object()) return text;
  if (json.value(key::kSymmetrised, Json(true)) == false) json.erase(key::kReciprocityResidual);
  for (const char* name : {key::kCommand, key::kQuantity, key::kColour, key::kSymmetrised, key::kRefinement,
                           key::kZeroValues, key::kNegativeValues}) {
    json.erase(name);
  }
  if (const auto source = json.find(key::kSource); source != json.end() && source->is_object()) {
    source->erase(key::kDescription);
    const auto sum = source->find(key::kSha256);
    if (sum != source->end() && sum->is_string()) *sum = sum->get<std::string>().substr(0, kLeanDigits);
  }
  if (const auto error = json.find(key::kError); error != json.end() && error->is_object()) {
    error->erase(key::kDirections);
    error->erase(key::kMeasuredOn);
  }
  return emit_metadata(json);
}

std::string metadata_of_part(const std::string& text, const ExtractedPart& part) {
  Json json = parse_metadata(text);
  if (!json.is_object()) json = Json::object();
  rename(json, key::kError, key::kErrorOfWhole);
  ExtractedPart left = part;
  if (const auto found = json.find(key::kExtracted); found != json.end()) {  // from a part
    const Json before = *found;
    append(json, key::kExtractedBefore, before);
    if (before.is_object()) {
      left.theta_max_deg = least(before, key::kThetaMax, part.theta_max_deg);
      left.max_level = least(before, key::kMaxLevel, part.max_level);
    }
  }
  json[key::kExtracted] = {{key::kThetaMax, left.theta_max_deg},
                           {key::kMaxLevel, left.max_level},
                           {key::kDifferenceFromWhole, left.difference_from_whole_percent}};
  return emit_metadata(json);
}

}  // namespace sbrdf::internal
