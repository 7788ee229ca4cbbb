#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "codec/atlas/atlas.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

struct BakeOptions {
  /// Between texels straight lines may be off a slice by so much, root of the mean square over slices, in the value
  /// domain (log values: about the relative error).
  double tolerance = 0.002;
  /// Tiles begin at multiples of 4 texels and are padded with copies, so that blocks of 4 x 4 hold one tile each.
  bool blocks = false;
  std::uint32_t most_texels_per_cell = 128;
  std::uint32_t most_side = 8192;  ///< [texels]
  std::uint64_t most_texels = std::numeric_limits<std::uint64_t>::max();
  bool dense = false;     ///< one table for all, where dense_axis gives an axis
  AtlasCells cells = {};  ///< what is to be held, of the axes that atlas_axes gives
};

/// Frame and nodes of the atlases of a material, of which no texels are known yet.
[[nodiscard]] AtlasLayout atlas_axes(const Lattice& lattice);

/// Along which axis the only table of a dense atlas lies: theta_h of isotropic materials in the half/difference frame.
/// Of others it would be far larger than the tables of slices.
[[nodiscard]] std::optional<std::size_t> dense_axis(const Lattice& lattice);

/// The atlas of a material with three channels (or one, which stands for all three). `sliced` has passed check_sliced
/// with the lattice. kUnsupported for other numbers of channels, and where no texture of `most_side` or `most_texels`
/// holds it.
[[nodiscard]] Result<Atlas> bake_atlas(const SlicedBrdf& sliced, const Lattice& lattice,
                                       const BakeOptions& options = {});

}  // namespace sbrdf::internal
