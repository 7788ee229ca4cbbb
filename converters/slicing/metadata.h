#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "converters/slicing/slicing.h"

namespace sbrdf::internal {

// The metadata of sliced files: a JSON object on one line that says how the file came to be (specs/sbrdf.md, section
// 8). It is made for a new file, and changed for a copy and for a part of one. Whatever a file holds instead, another
// type or nothing, is no error: nothing but people depends on it.

/// What stands under a key.
enum class MetadataType : std::uint8_t { kText, kNumber, kCount, kBoolean, kObject, kList };

/// One key of the object, or of an object in it.
struct MetadataKey {
  std::string_view in;    ///< key of the object, or of the list of objects, that it belongs to; empty: the whole
  std::string_view name;  ///< such as "mre_percent"
  MetadataType type = MetadataType::kText;
  std::string_view unit;  ///< such as "%"; empty for a text, a count or a truth
};

/// All keys that are written, in the order of the specification's table.
[[nodiscard]] std::span<const MetadataKey> metadata_keys();
/// "text", "number", "count", "boolean", "object" or "list", as the specification calls it.
[[nodiscard]] std::string_view metadata_type_name(MetadataType type);

/// Of a file that was sampled, in as much detail as the options say: the source, the choices, and what the report says.
/// Texts that are not UTF-8 are mended.
[[nodiscard]] std::string metadata_of_slicing(const SourceTraits& traits, const SliceOptions& options,
                                              const SliceReport& report);

/// Of a copy whose samples were rounded again; before, they were rounded to within `precision_before` (as a fraction;
/// 0: not). The errors in `text` were measured before and are kept under another name. What is no object stays as it
/// is.
[[nodiscard]] std::string metadata_of_copy(const std::string& text, double precision_before);

/// What MetadataDetail::kLean leaves of metadata. What is no object stays as it is.
[[nodiscard]] std::string lean_metadata(const std::string& text);

/// What was taken out of a file.
struct ExtractedPart {
  double theta_max_deg = 90;
  std::uint64_t max_level = 0;
  double difference_from_whole_percent = 0;  ///< relative L1
};

/// Of a part: errors in `text` belong to the whole and are kept under another name. A part of a part has no more than
/// either.
[[nodiscard]] std::string metadata_of_part(const std::string& text, const ExtractedPart& part);

}  // namespace sbrdf::internal
