#pragma once

#include "tools/conversion/folder_conversion.h"

namespace sbrdf::internal {

/// What `sbrdf convert DIR OUTDIR` does and prints: a line for each file and one for all, or with `json` their reports
/// as one array. The exit code: 0, that of the first failure in the order of names, or that of a signal.
[[nodiscard]] int run_convert_folder(const FolderOrder& order, bool json);

}  // namespace sbrdf::internal
