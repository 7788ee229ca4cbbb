#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "converters/files/format.h"
#include "converters/files/options.h"
#include "converters/source/brdf_source.h"
#include "converters/tables/dense_table.h"
#include "converters/tables/grid.h"
#include "formats/ngan/ngan.h"

namespace sbrdf::internal {

// Anisotropic tables in the layout of A. Ngan, F. Durand, W. Matusik, 2005 (specs/ngan.md): the row of the format
// table.

/// What the half with phi_v - phi_i beyond 180 degrees holds in a table of the other half.
enum class NganOtherHalf : std::uint8_t {
  kTangent,     ///< the material is symmetric about its tangent: both azimuths change their sign
  kPlane,       ///< the material is symmetric about the plane of incidence: only phi_v - phi_i does
  kUnmeasured,  ///< nothing
};

/// How the numbers of a file are to be understood, as nothing in it tells.
struct NganConventions {
  bool interleaved = false;  ///< channels of a bin side by side; else one channel after the other
  bool at_edges = false;     ///< values belong to the lower edges of their bins; else to the centres
  double scale = 1;          ///< f_r = number x scale
  NganOtherHalf other_half = NganOtherHalf::kTangent;
};
/// Of options that check_options took.
[[nodiscard]] NganConventions ngan_conventions(const Options& options);

/// The nodes of a table: both halves of one that stores half. One bin along phi_in: isotropic.
[[nodiscard]] Grid ngan_grid(const NganHeader& header, bool at_edges);
/// Those that are stored: of half data, bins along phi_diff up to 180 degrees.
[[nodiscard]] Grid ngan_stored_grid(const NganHeader& header, bool at_edges);

/// Values at the nodes of ngan_grid, of values at those of its first half.
[[nodiscard]] std::shared_ptr<const NodeValues> with_other_half(std::shared_ptr<const NodeValues> first_half,
                                                                const NganHeader& header, bool at_edges,
                                                                NganOtherHalf other_half);

/// Opens a table; the file stays where it is. Errors of parse_ngan_header and DenseSource::make; with --non-finite
/// refuse kInvalidFile with the offset of the first number that is NaN or infinite.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_ngan(std::shared_ptr<const ByteSource> file,
                                                            const Options& options);

/// Writes a table. kUsage for a shape of more than 2^31 - 1 numbers, as readers count in 32 bits; kUnsupported for more
/// than kNganMaxChannels channels; kInvalidFile where no bin without a negative value has a positive one; otherwise as
/// sample_table.
[[nodiscard]] Status save_ngan(const BrdfSource& source, ByteSink& sink, const Options& options, Report& report,
                               const Progress& progress);

[[nodiscard]] std::span<const OptionSpec> ngan_options();

/// Four counts such as "45,45,72,36"; kUsage otherwise.
[[nodiscard]] Result<std::array<std::uint32_t, 4>> parse_ngan_shape_option(std::string_view text);

}  // namespace sbrdf::internal
