#pragma once

#include <memory>
#include <span>

#include "converters/files/format.h"
#include "converters/files/options.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/byte_sink.h"
#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// Dense tables and uniform samples in HDF5 (specs/hdf5.md): a row of the format table.

/// The table as a source. A file of more than 64 MiB is read in boxes as it is evaluated, of which 256 MB stay in
/// memory; a smaller one is read whole. Options: grid, where the file does not tell; hdf5-dataset; negatives;
/// non-finite, of which the default is unmeasured. Errors as of Hdf5TableReader::open and DenseSource::make; kUsage
/// where no grid is known, or one is given that the file contradicts.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_hdf5(std::shared_ptr<const ByteSource> file,
                                                            const Options& options);

/// Writes a table of --grid, or of the source's own, a box at a time. A file of the same format is copied byte for byte
/// unless an option asks for something else. Options: grid, type, deflate, negatives, non-finite.
[[nodiscard]] Status save_hdf5(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                               const Progress& progress);
/// kUsage where options of dense tables meet those of uniform samples.
[[nodiscard]] Status check_hdf5_options(const Options& options);
[[nodiscard]] std::span<const OptionSpec> hdf5_options();

}  // namespace sbrdf::internal
