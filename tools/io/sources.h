#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "converters/source/brdf_source.h"
#include "formats/core/result.h"

namespace sbrdf {

/// How a model of kurt_material_names() or a file of Kurt parameters is named on the command line.
inline constexpr std::string_view kKurtPrefix = "kurt:";

struct OpenedSource {
  std::unique_ptr<BrdfSource> source;
  std::optional<std::uint64_t> bytes;  ///< of the file; none for a built-in model
};

/// `text` is "kurt:NAME", "kurt:FILE.json", the path of a file whose format its content tells, or
/// "BUNDLE:MATERIAL". "./kurt:x" is a path.
[[nodiscard]] Result<OpenedSource> open_source(const std::string& text);

}  // namespace sbrdf
