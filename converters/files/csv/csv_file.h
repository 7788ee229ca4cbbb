#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "converters/files/format.h"

namespace sbrdf::internal {

// Dense tables as text (specs/csv.md): a line "# {...}" with the head (converters/files/dense/table_head.h), a line of
// names, and a line for each node in C order: theta_i, phi_i, theta_v, phi_v [degrees] and f_r [1/sr] of each channel.

/// Options: grid, type, negatives, non-finite.
[[nodiscard]] std::span<const OptionSpec> csv_options();

[[nodiscard]] bool recognises_csv(std::span<const std::byte> head);

/// Nodes are those of the head; the angles of each line are compared with them. "nan" is unmeasured. Keeps the numbers
/// in memory, in as many bits as the head says. kInvalidFile, naming the line and the column, where a line is missing,
/// of another node, too long, or has other fields; errors as of parse_table_head.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_csv(std::shared_ptr<const ByteSource> bytes,
                                                           const Options& options);

/// A few MB at a time. A table that was read from such a file and is asked for as it is, is copied byte for byte.
/// kUnsupported for channels with a comma, a quote or a line end in their name.
[[nodiscard]] Status save_csv(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                              const Progress& progress);

}  // namespace sbrdf::internal
