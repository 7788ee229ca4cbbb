#pragma once

#include <cstddef>

#include "converters/source/brdf_source.h"
#include "formats/rgl/rgl_material.h"

namespace sbrdf::internal {

// The tables of an RGL material that say where its colours lie: microfacets that would reflect much as a source does
// (Dupuy & Jakob 2018, section 3). They need not be right, as the colours make up for it; the better they are, the
// smoother the colours.

/// Fills `ndf` and `sigma` of a material whose `phi_i` says whether it is isotropic.
///
/// Where light and viewer are the same direction m, microfacets give f_r cos(theta_m) = c ndf(m) / (4 sigma(m)), and
/// sigma(i) is the integral of ndf(m) max(i.m, 0) over m. Together an eigenvalue problem, solved by power iteration.
/// |f_r| is the mean over the channels. sigma is 1 at the normal. Returns c, the size that colours have; 0 where the
/// source is 0 wherever light and viewer are the same.
[[nodiscard]] double fill_microfacets(const BrdfSource& source, RglMaterial& material);

/// Fills `vndf` on `size` x `size` nodes: the density of visible normals over the square, ndf(m) max(i.m, 0) times the
/// solid angle of a part of it, to the power of `power`, and a little everywhere. With 1 it is that of the paper; less
/// spreads the nodes of the colours more evenly. Each slice is scaled to a mean of 1 / size^2, as in published files.
void fill_visible_normals(std::size_t size, double power, RglMaterial& material);

}  // namespace sbrdf::internal
