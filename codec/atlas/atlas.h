#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "codec/atlas/part/atlas_cells.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// A sliced BRDF as one 2-D texture, for evaluation in shaders (specs/atlas.md).
//
// Slices along each axis lie in a table of their own, sampled so densely that straight lines between texels will do.
// Between slices the lattice's nodes are neighbouring rows, so that the hardware's bilinear filter works along a slice
// and across one more axis at once; what remains are two explicit axes (one for isotropic materials).
//
// One axis, an azimuth, has the primary table: the slices' values in the value domain, guide and all. The tables of the
// other axes hold by how much a slice is off the straight line between its crossings. The four-slice sum is then
//
//   v = primary + sum of the differences
//
// without corners of its own, and texel errors of the small differences hardly count.

/// How the places of one axis become texels. Nodes are those of the padded lattice, as far as symmetries do not repeat
/// them; one single node: the coordinate does not matter.
struct AtlasAxis {
  std::vector<double> nodes_deg;
  /// Of each node, the texel of slices along this axis that it is: from 0 on, in the last entry the last texel.
  std::vector<std::uint32_t> texels;
  /// Between the first two nodes texels are equally far apart in the root of the coordinate: highlights lie there.
  bool root_spacing = false;

  [[nodiscard]] bool moves() const { return nodes_deg.size() > 1; }
  [[nodiscard]] std::uint32_t texel_count() const { return texels.empty() ? 1 : texels.back() + 1; }
};

/// Where a tile lies, or what is held of it: texels from a column and a row of its own on.
struct AtlasTile {
  std::uint32_t x = 0, y = 0;           ///< of the first texel that is there
  std::uint32_t width = 0, height = 0;  ///< [texels], padding included; 0 where nothing is held
  std::uint32_t first_column = 0, first_row = 0;
};

/// The slices along one axis. A tile holds those of all nodes of the axis `across` one below the other, one texel row
/// each; there is a tile for each pair of nodes of the explicit axes. With all cells there they lie row by row from
/// (x, y) on; else wherever `tiles` says.
struct AtlasTable {
  std::size_t along = 0;
  std::optional<std::size_t> across;
  std::vector<std::size_t> between;  ///< the explicit axes, one or two, rising
  /// In the elevation frame theta_i is not above theta_v: of the tiles (theta_v node j, theta_i node i) only those with
  /// i <= j + 1 are there, j (j + 3) / 2 + i.
  bool triangular = false;
  std::uint32_t x = 0, y = 0;
  std::uint32_t tile_width = 0, tile_height = 0;  ///< [texels], padding included
  std::uint32_t tiles_per_row = 1;
  std::uint32_t tile_count = 0;
  std::vector<AtlasTile> tiles;  ///< by their numbers
};

/// Where two azimuths become one (see PoleRing): the values there, in one tile. Rows are the texels of slices along the
/// other polar axis; the ring has `ring_texels` texels and the first one again.
struct AtlasRing {
  std::uint32_t x = 0, y = 0;
  std::uint32_t tile_width = 0, tile_height = 0;  ///< [texels], padding included; 0 where no cell at a pole is held
  std::uint32_t ring_texels = 0;
  double period_deg = 360;
};

/// Where each thing lies. All of it follows from the axes, the frame and the cells.
struct AtlasLayout {
  FrameId frame = FrameId::kElevation;
  Symmetries symmetries;
  double theta_max_deg = 90;
  std::array<AtlasAxis, kAxisCount> axes;
  /// Set: the table along this axis is the only one, and along all other axes it has a row or a tile for each texel,
  /// not only for each node. For few moving axes that takes less than the tables of all slices.
  std::optional<std::size_t> dense_along;
  std::vector<AtlasTable> tables;  ///< the primary first
  std::optional<AtlasRing> ring;
  AtlasCells cells;                     ///< that are held: what a scene does not need is left out
  bool blocks = false;                  ///< tiles begin at multiples of 4 texels and fill them
  std::uint32_t width = 0, height = 0;  ///< multiples of 4
};

/// What brings values back from the value domain, per channel.
struct AtlasDomain {
  bool log = true;
  std::array<float, 3> reference{}, floor{}, at_floor{}, at_zero{};
  std::array<float, 3> least{}, most{};  ///< f_r is kept between these
  std::array<float, 3> grey_shares{};
  float grey_divisor = 0;  ///< 0 where there are no shares
};

/// v = offset + scale x texel, per channel: of a tile, or of all tiles of a table.
struct AtlasScale {
  std::array<float, 3> offset{};
  std::array<float, 3> scale{1, 1, 1};
};

/// Texels are RGB, row by row from the top.
struct Atlas {
  AtlasLayout layout;
  AtlasDomain domain;
  /// Of each table, and of the ring behind them: one for each tile, or one for all.
  std::vector<std::vector<AtlasScale>> scales;
  std::vector<float> texels;  ///< width x height x 3
};

/// What is given for a pair of directions whose cell is left out: a colour that catches the eye.
inline constexpr std::array<float, 3> kLeftOutColour = {1, 0, 1};

/// Sets tables, the place of the ring, and the sides, which follow from everything else in a layout: the texture with
/// the fewest texels whose sides are at most `most_side`. kUnsupported where there is none.
[[nodiscard]] Status lay_out(AtlasLayout& layout, std::uint32_t most_side);

/// The frame coordinates that an atlas is asked for: symmetries of the material bring them among its nodes.
[[nodiscard]] Coordinates fold_coordinates(const AtlasLayout& layout, Coordinates x);

/// How many cells the axes have.
[[nodiscard]] AtlasCells::Counts cell_counts(const AtlasLayout& layout);
/// The cell of coordinates that have been folded.
[[nodiscard]] AtlasCell cell_of(const AtlasLayout& layout, const Coordinates& folded);
/// The cell of a pair above the horizon.
[[nodiscard]] AtlasCell cell_of(const AtlasLayout& layout, const DirectionPair& pair);

/// The cell of an axis that holds a coordinate (which is kept among the nodes), how far in it lies, and where on the
/// texels of the axis.
struct AtlasPlace {
  std::size_t cell = 0;
  double fraction = 0;
  double texel = 0;
};
[[nodiscard]] AtlasPlace place_on(const AtlasAxis& axis, double x_deg);

/// How many rows or tiles a table has along an axis that is not its own: nodes, or texels.
[[nodiscard]] std::size_t step_count(const AtlasLayout& layout, std::size_t axis);
/// Between which of these a coordinate lies: `cell` and `fraction` of its place, or those of its texel.
[[nodiscard]] AtlasPlace place_between(const AtlasLayout& layout, std::size_t axis, const AtlasPlace& place);

/// The number of the tile of steps `first` and `second` of the explicit axes (`second` is 0 where there is one).
[[nodiscard]] std::uint32_t tile_number(const AtlasLayout& layout, const AtlasTable& table, std::size_t first,
                                        std::size_t second);

/// The polar axes whose node 0 is a ring, with the sign of the other azimuth there; none without a ring.
struct AtlasPole {
  std::size_t polar_axis = kVertical;
  std::size_t along = kHorizontal;
  std::size_t ring_axis = kAxial;
  double sign = 1;
};
[[nodiscard]] std::vector<AtlasPole> poles(const AtlasLayout& layout);

}  // namespace sbrdf::internal
