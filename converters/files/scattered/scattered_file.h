#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "converters/files/format.h"

namespace sbrdf::internal {

// Samples at any directions, as text (specs/scattered.md), fitted to a dense table. Read only.

/// Options: scattered-angles, scattered-quantity, scattered-columns, scattered-radius, grid.
[[nodiscard]] std::span<const OptionSpec> scattered_options();

/// Text with numbers in at least five columns. One that only begins with comments may be such a file.
[[nodiscard]] Match recognise_scattered(std::span<const std::byte> head, std::uint64_t size);

/// The table has the grid of --grid, or one that choose_grid() finds; its values are those of LocalFit, as 32-bit
/// floats. Nodes that have no sample within the radius are unmeasured. Findings say what grid that is, how the samples
/// were fitted, how the table differs from them, how well held-back samples are predicted, and which samples were left
/// out.
///
/// Errors as of parse_number_table and samples_of; kUnsupported where the table takes more memory than allowed.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_scattered(std::shared_ptr<const ByteSource> bytes,
                                                                 const Options& options);

}  // namespace sbrdf::internal
