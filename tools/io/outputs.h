#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "converters/files/format.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Whether a command may write `out`, asked before it begins: a file can be made there (check_destination), and nothing
/// is lost that nobody meant to lose. `written` is the format; nullptr for a table of figures. `inputs` are what the
/// command reads, as they were named: files, "BUNDLE:NAME", models.
///
/// A file of another kind is never replaced: neither an input, whatever it holds and by whichever link it was reached,
/// what belongs to an input (x.npy.json), nor anything that is recognised as a BRDF or a bundle. What is written along
/// with `out` replaces nothing but another one of its kind. A table replaces nothing that has the name of such a file,
/// either, in case it is damaged. A file of the same kind is, also an input: "convert a.sbrdf a.sbrdf --precision 1%"
/// says what it does, and an error on the way leaves the old file.
///
/// kUsage where something would be lost, kIo as check_destination.
[[nodiscard]] Status check_output(const std::string& out, const Format* written, std::span<const std::string> inputs);

/// From the root, without links, "." and "..", as far as the path is there.
[[nodiscard]] std::filesystem::path whole_path(const std::filesystem::path& path);

/// Whether two paths mean one file, also one that is still to be made: "./a" and "a", links of both kinds.
[[nodiscard]] bool is_same_place(const std::string& a, const std::string& b);
/// Whether a path means any of these files.
[[nodiscard]] bool is_among(const std::string& path, const std::vector<std::string>& others);

/// All files that a command writes which is asked for `out`: it, and what belongs to a file of that format.
[[nodiscard]] std::vector<std::string> paths_written(const std::string& out, const Format& written);

/// All files that a command reads which is asked for `inputs`: they, and those that belong to them, there or not.
[[nodiscard]] std::vector<std::string> paths_read(std::span<const std::string> inputs);

}  // namespace sbrdf::internal
