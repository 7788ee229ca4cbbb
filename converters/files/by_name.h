#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "converters/files/format.h"
#include "converters/source/brdf_source.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf {

struct OpenedSource {
  std::unique_ptr<BrdfSource> source;
  std::optional<std::uint64_t> bytes;  ///< of the file; none for a built-in model
  const Format* format = nullptr;      ///< of the file; nullptr for a built-in model
};

/// The bytes of what `text` names: the path of a file, or "FILE:MATERIAL" for one material of a file that holds many,
/// such as a bundle. A path that exists comes first.
[[nodiscard]] Result<std::shared_ptr<const ByteSource>> open_named_bytes(const std::string& text);

/// `text` is "kurt:NAME", "kurt:FILE.json", or as for open_named_bytes; the format of a file is told by its content.
/// "./kurt:x" is a path. Of `options`, those are used that the format has for reading.
[[nodiscard]] Result<OpenedSource> open_source(const std::string& text, const Options& options = {});

}  // namespace sbrdf
