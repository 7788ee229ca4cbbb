#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/atlas/atlas.h"
#include "codec/frame/lattice.h"
#include "codec/material/sliced_brdf.h"
#include "formats/core/named.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// The four textures of section 8 of the paper ("Graphics Hardware Implementation"), with its sizes.
//
// An area is a pair of elevations, theta_i not above theta_v, 0 not among them: with e_n elevations there are
// e_n (e_n + 1) / 2, that of elevations number i and j (0 the lowest, i <= j) at number j (j + 1) / 2 + i. With a_n
// axial and as many diagonal slices, a_s = 360 / a_n degrees apart:
//
//   crossings    areas side by side, each (a_n + 1) columns u = 0, a_s, ... 360 by (2 a_n + 1) rows s = 0, a_s, ... 720
//   axial        the same columns, 360 rows s = 0, 2, ... 718, and then row 0 again
//   diagonal     columns s = 0, a_s, ... 360, rows u = 0, 2, ... 718, and then row 0 again
//   horizontal   for u = 0, a_s, ... 360 - a_s the (2 a_n + 1) columns s = 0, a_s, ... 720, a_n (2 a_n + 1) in all; for
//                each theta_i 90 rows theta_v = 0, 1, ... 89; from theta_max on the value there
//
// Two dimensions are then the filter's in each texture, and two remain: theta_v and theta_i, or u and the elevation.

enum class PaperTextureKind : std::uint8_t { kCrossings, kAxial, kDiagonal, kHorizontal };
inline constexpr std::size_t kPaperTextureCount = 4;
inline constexpr std::array kPaperTextureNames = {
    Named{"crossings", PaperTextureKind::kCrossings}, Named{"axial", PaperTextureKind::kAxial},
    Named{"diagonal", PaperTextureKind::kDiagonal}, Named{"horizontal", PaperTextureKind::kHorizontal}};

inline constexpr std::uint32_t kPaperAzimuthRows = 360;  ///< the paper's 1 degree of t = s / 2, t = u / 2
inline constexpr std::uint32_t kPaperElevationRows = 90;
inline constexpr double kPaperMostThetaDeg = kPaperElevationRows - 1;

/// Texels are RGB in the value domain, row by row from the top.
struct PaperTexture {
  std::uint32_t width = 0, height = 0;
  std::vector<float> texels;  ///< width x height x 3
};

struct PaperTextures {
  std::vector<double> elevations_deg;  ///< rising, without 0, the last is theta_max, at most 89
  std::uint32_t azimuth_count = 0;     ///< a_n, 1 or more
  bool isotropic = false;              ///< nothing depends on s
  AtlasDomain domain;
  /// Both directions at the normal, in the value domain. It lies in no texture: a constant of the shader.
  std::array<float, 3> at_normal{};
  std::array<PaperTexture, kPaperTextureCount> textures;  ///< by PaperTextureKind

  [[nodiscard]] const PaperTexture& texture(PaperTextureKind kind) const {
    return textures[static_cast<std::size_t>(kind)];
  }
  [[nodiscard]] PaperTexture& texture(PaperTextureKind kind) { return textures[static_cast<std::size_t>(kind)]; }
  [[nodiscard]] double azimuth_step_deg() const { return 360.0 / azimuth_count; }
  [[nodiscard]] std::uint64_t texel_count() const;
};

/// Sets the sides of all four from `elevations_deg` and `azimuth_count`. kUnsupported where one is longer than 16,384.
[[nodiscard]] Status lay_out_paper(PaperTextures& textures);

/// The number of the area of two elevations, `i` <= `j`, each counted from 0.
[[nodiscard]] inline std::uint32_t paper_area(std::uint32_t i, std::uint32_t j) { return j * (j + 1) / 2 + i; }

/// The textures of a sliced BRDF in the elevation frame with as many axial as diagonal slices, regularly placed: a
/// placement e_s/a_s. Of an isotropic one, which has no axial slices, they are filled as if it had as many.
///
/// `sliced` has passed check_sliced with the lattice. kUnsupported names what does not fit: the frame, the nodes of an
/// azimuth, theta_max above 89 (the last row of 1 degree), other numbers of channels than 1 and 3, a side too long.
[[nodiscard]] Result<PaperTextures> bake_paper_textures(const SlicedBrdf& sliced, const Lattice& lattice);

}  // namespace sbrdf::internal
