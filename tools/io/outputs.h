#pragma once

#include <span>
#include <string>

#include "converters/files/format.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// Whether a command may write `out`, asked before it begins: a file can be made there (check_destination), and nothing
/// is lost that nobody meant to lose. `written` is the format; nullptr for a table of figures. `inputs` are what the
/// command reads, as they were named: files, "BUNDLE:NAME", models.
///
/// A file of another kind is never replaced: neither an input, whatever it holds and by whichever link it was reached,
/// nor anything that is recognised as a BRDF or a bundle. A table replaces nothing that has the name of such a file,
/// either, in case it is damaged. A file of the same kind is, also an input: "convert a.sbrdf a.sbrdf --precision 1%"
/// says what it does, and an error on the way leaves the old file.
///
/// kUsage where something would be lost, kIo as check_destination.
[[nodiscard]] Status check_output(const std::string& out, const Format* written, std::span<const std::string> inputs);

}  // namespace sbrdf::internal
