#pragma once

#include <algorithm>
#include <cmath>

#include "codec/frame/frame.h"

namespace sbrdf::internal {

struct PairVectors {
  double ix = 0, iy = 0, iz = 0;
  double vx = 0, vy = 0, vz = 0;
};

inline PairVectors vectors_of(const DirectionPair& pair) {
  const auto [i, v] = pair;
  return {std::sin(i.theta) * std::cos(i.phi), std::sin(i.theta) * std::sin(i.phi), std::cos(i.theta),
          std::sin(v.theta) * std::cos(v.phi), std::sin(v.theta) * std::sin(v.phi), std::cos(v.theta)};
}

/// Nearer to the normal than this [radians] a direction has no azimuth.
inline constexpr double kPole = 1e-6;

/// Largest difference of a component between two pairs of unit vectors.
inline double vector_distance(const DirectionPair& a, const DirectionPair& b) {
  const PairVectors p = vectors_of(a);
  const PairVectors q = vectors_of(b);
  return std::max({std::abs(p.ix - q.ix), std::abs(p.iy - q.iy), std::abs(p.iz - q.iz), std::abs(p.vx - q.vx),
                   std::abs(p.vy - q.vy), std::abs(p.vz - q.vz)});
}

/// The same, where all pairs that reciprocity and the symmetries make equal are one measurement.
inline double measurement_distance(const DirectionPair& a, const DirectionPair& b, const Symmetries& symmetries) {
  const auto turned = [&](DirectionPair pair) {
    const double turn = !symmetries.isotropic ? 0 : pair.i.theta > kPole ? pair.i.phi : pair.v.phi;
    pair.i.phi -= turn;
    pair.v.phi -= turn;
    return pair;
  };
  double least = 2;
  for (int mirrors = 0; mirrors < 4; ++mirrors) {
    const bool mirror_x = (mirrors & 1) != 0;
    const bool mirror_y = (mirrors & 2) != 0;
    if ((mirror_x && !symmetries.mirror_x) || (mirror_y && !symmetries.mirror_y)) continue;
    DirectionPair image = b;
    for (Direction* direction : {&image.i, &image.v}) {
      if (mirror_x) direction->phi = -direction->phi;
      if (mirror_y) direction->phi = kPi - direction->phi;
    }
    least = std::min(
        {least, vector_distance(turned(a), turned(image)), vector_distance(turned(a), turned({image.v, image.i}))});
  }
  return least;
}

/// Smooth, positive, reciprocal, and beside that with the given symmetries and no others.
inline double analytic_brdf(const DirectionPair& pair, const Symmetries& symmetries) {
  const auto [ix, iy, iz, vx, vy, vz] = vectors_of(pair);
  const double twist = (iz - vz) * (ix * vy - iy * vx);
  double exponent = 0.3 * (iz + vz) + 0.4 * iz * vz + 0.6 * (ix * vx + iy * vy) + 0.5 * twist * twist;
  if (!symmetries.mirror_x && !symmetries.mirror_y) exponent += 0.9 * twist;
  if (!symmetries.isotropic) {
    const double mixed = ix * vy + iy * vx;
    exponent += 0.35 * (ix * vx - iy * vy) + 0.2 * mixed * (ix + vx) * (iy + vy) + 0.15 * (ix + vx) * (ix + vx);
    if (!symmetries.mirror_x) exponent -= 0.33 * (iy + vy);
    if (!symmetries.mirror_y) exponent += 0.27 * (ix + vx);
    if (!symmetries.mirror_x && !symmetries.mirror_y) exponent += 0.41 * mixed;
  }
  return std::exp(exponent);
}

}  // namespace sbrdf::internal
