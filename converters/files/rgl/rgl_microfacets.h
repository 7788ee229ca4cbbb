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

/// Fills `vndf` on `size` x `size` nodes, so that the nodes of the colours lie where a source asks for them: most after
/// the square root of the paper's density of visible normals, ndf(m) max(i.m, 0) times the solid angle of a part of the
/// square, which spreads them over narrow lobes and wide ones; the others towards the horizon of theta_v, where
/// relative errors grow. Few lie below it. Each slice has a mean of 1 / size^2, as in published files.
void fill_visible_normals(std::size_t size, RglMaterial& material);

}  // namespace sbrdf::internal
