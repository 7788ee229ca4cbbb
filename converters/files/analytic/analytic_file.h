#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "converters/files/format.h"
#include "converters/models/analytic.h"

namespace sbrdf::internal {

// Analytic sources as files and by name. A name needs no file system, so that a library can offer it, too; the file in
// "kurt:FILE.json" is opened by whoever may open files, and read by open_analytic_file.

/// How sources are named that need no file of measurements.
inline constexpr std::string_view kKurtPrefix = "kurt:";

/// Larger files of parameters are refused before they are parsed [bytes]; a lobe takes some 100.
inline constexpr std::uint64_t kAnalyticLargestFile = std::uint64_t{1} << 20U;

/// `text` begins as the name of a built-in source, or of a file by its kind, does.
[[nodiscard]] bool is_named(std::string_view text);
/// The file in "kurt:FILE.json"; nothing for another text.
[[nodiscard]] std::optional<std::string_view> file_in_name(std::string_view text);
/// The source that "kurt:NAME" names, without any file. kUsage, listing the names, where there is none.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_named(std::string_view text);

/// A file of parameters of such a model (specs/kurt.md, specs/models.md): a JSON object. One that does not name its
/// parameters early on may only be one, of Kurt's model, and so may one of a model that is not known.
[[nodiscard]] Match recognise_analytic_file(std::span<const std::byte> head, LobeKind kind);
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_analytic_file(const ByteSource& bytes);

}  // namespace sbrdf::internal
