#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "converters/files/format.h"

namespace sbrdf::internal {

// NPY files (specs/npy.md): an array [n0, n1, n2, n3, channels] of f_r [1/sr], and beside it a file of the same name
// followed by ".json" that says where its nodes are (converters/files/dense/table_head.h).

/// What the name of the second file ends with.
inline constexpr std::string_view kNpyHeadSuffix = ".json";

/// Options: grid, type, negatives, non-finite.
[[nodiscard]] std::span<const OptionSpec> npy_options();

/// Reads numbers from the view of `bytes` as they are needed; a file without a view is read into memory. NaN is
/// unmeasured. Errors as of parse_npy_header and parse_table_head; kInvalidFile where head and array do not fit;
/// kUsage where there is neither a head nor --grid, and where that does not fit the array.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_npy(std::shared_ptr<const ByteSource> bytes,
                                                           const Options& options);

/// A few MB at a time. A sink that has no place for a second file gets the array alone, which is said in the report. A
/// table that was read from an NPY file and is asked for as it is, is copied byte for byte.
[[nodiscard]] Status save_npy(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                              const Progress& progress);

}  // namespace sbrdf::internal
