#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "converters/files/format.h"
#include "converters/source/brdf_source.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"
#include "formats/sbrdf/memory_limit.h"

namespace sbrdf::internal {

struct OpenedSource {
  std::unique_ptr<BrdfSource> source;
  std::optional<std::uint64_t> bytes;  ///< of the file; none for a built-in model
  const Format* format = nullptr;      ///< of the file; nullptr for a built-in model
};

/// The bytes of what `text` names: the path of a file, or "FILE:MATERIAL" for one material of a file that holds many,
/// such as a bundle; unpacking that stays within `limit`. A path that exists comes first.
[[nodiscard]] Result<std::shared_ptr<const ByteSource>> open_named_bytes(const std::string& text,
                                                                         const MemoryLimit& limit = {});

/// The source in bytes that open_named_bytes gave. Where the program allows trials, a file of a fragile format is tried
/// first: kInvalidFile for one that brings the library down that reads it.
[[nodiscard]] Result<OpenedSource> source_in(const std::shared_ptr<const ByteSource>& bytes,
                                             const Options& options = {});

/// The same for commands that work on sliced files as they are stored. kUnsupported for what is another kind of BRDF,
/// saying that `what`, such as "levels", are those of sliced files; kUsage, listing names, for a bundle without a name.
[[nodiscard]] Result<std::shared_ptr<const ByteSource>> open_sliced_bytes(const std::string& text,
                                                                          std::string_view what,
                                                                          const MemoryLimit& limit = {});

/// The format of what `text` names: nullptr for a model; nothing where that cannot be told without taking something
/// away, as from a pipe, or where opening it will be an error.
[[nodiscard]] std::optional<const Format*> format_of(const std::string& text, const MemoryLimit& limit = {});

/// What a trial (formats/os/trial.h) is to do: opens and closes its file as source_in does. The arguments are those of
/// the process behind kTrialArguments. False where there is no file to be tried.
[[nodiscard]] bool open_in_trial(std::span<char* const> arguments);

/// The path of the file that is read for `text`, which may name a material in it or its kind, too; nothing for a
/// built-in model. It need not be there.
[[nodiscard]] std::optional<std::string> file_of(const std::string& text);

/// Of a path, with its dot and in lower case.
[[nodiscard]] std::string lower_extension(const std::string& path);

/// `text` is "kurt:NAME", "kurt:FILE.json", or as for open_named_bytes; the format of a file is told by its content.
/// "./kurt:x" is a path. Of `options`, those are used that the format has for reading.
[[nodiscard]] Result<OpenedSource> open_source(const std::string& text, const Options& options = {});

}  // namespace sbrdf::internal
