#include "codec/atlas/paper/paper_evaluator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "codec/atlas/atlas_evaluator.h"
#include "codec/frame/frame.h"

namespace sbrdf::internal {
namespace {

constexpr double kDegreesPerRow = 2;  // of s and of u: 360 rows for 720 degrees
constexpr double kTurn = 720;

using Rgb = std::array<float, 3>;

Rgb mixed(const Rgb& near, const Rgb& far, float t) {
  Rgb v;
  for (std::size_t c = 0; c < 3; ++c) v[c] = near[c] + t * (far[c] - near[c]);
  return v;
}

}  // namespace

PaperEvaluator::PaperEvaluator(const PaperTextures& textures) : textures_(textures) {}

void PaperEvaluator::evaluate(const DirectionPair& pair, std::span<float, 3> values) const {
  // Of an azimuth that is no number a texel's place would be none either.
  if (above_horizon(pair) && std::isfinite(pair.i.phi) && std::isfinite(pair.v.phi)) {
    evaluate_at(geometry(FrameId::kElevation).coordinates(pair), values);
  } else {
    std::fill(values.begin(), values.end(), 0.0F);
  }
}

void PaperEvaluator::evaluate_at(const Coordinates& x, std::span<float, 3> values) const {
  // Azimuths so large that their turns cannot be taken off lie anywhere.
  const double s = std::isfinite(x[kAxial]) ? x[kAxial] : 0;
  const double u = std::isfinite(x[kDiagonal]) ? std::clamp(x[kDiagonal], 0.0, kTurn) : 0;
  const Azimuths a = u >= 360 ? Azimuths{wrap(s + 360, kTurn), u - 360} : Azimuths{wrap(s, kTurn), u};
  const Place view = place(x[kHorizontal]);
  const Place light = place(x[kVertical]);
  Sum sum;
  sum.least.fill(std::numeric_limits<float>::infinity());
  for (unsigned side = 0; side < 4; ++side) {
    const std::size_t v = view.node + (side & 1U);
    const std::size_t i = light.node + (side >> 1U);
    const float weight = ((side & 1U) != 0 ? view.fraction : 1 - view.fraction) *
                         ((side >> 1U) != 0 ? light.fraction : 1 - light.fraction);
    const Rgb c = crossing(v, i, a);
    for (std::size_t k = 0; k < 3; ++k) sum.c[k] += weight * c[k];
    add(axial(v, i, a), weight, sum);
    add(diagonal(v, i, a), weight, sum);
  }
  for (unsigned far = 0; far < 2; ++far) {
    add(along_view(view, light.node + far, a), far != 0 ? light.fraction : 1 - light.fraction, sum);
    add(along_light(view.node + far, light, a), far != 0 ? view.fraction : 1 - view.fraction, sum);
  }
  Rgb r;
  for (std::size_t k = 0; k < 3; ++k) {
    // Section 7: r = max(p + q + s + t - 3c, min).
    r[k] = std::max(sum.slices[k] - 3 * sum.c[k], sum.least[k]);
  }
  bring_back(textures_.domain, r, values);
}

void PaperEvaluator::add(const Rgb& slice, float weight, Sum& sum) {
  for (std::size_t k = 0; k < 3; ++k) {
    sum.slices[k] += weight * slice[k];
    sum.least[k] = std::min(sum.least[k], slice[k]);
  }
}

// Light and view change places: (s, -u) is (s + 360, 360 - u).
PaperEvaluator::Azimuths PaperEvaluator::exchanged(Azimuths a) {
  return a.u == 0 ? a : Azimuths{wrap(a.s + 360, kTurn), 360 - a.u};
}

PaperEvaluator::Place PaperEvaluator::place(double theta_deg) const {
  const std::vector<double>& nodes = textures_.elevations_deg;
  Place place;
  place.angle_deg = std::clamp(theta_deg, 0.0, nodes.back());
  place.node =
      static_cast<std::size_t>(std::upper_bound(nodes.begin(), nodes.end() - 1, place.angle_deg) - nodes.begin());
  const double low = place.node == 0 ? 0 : nodes[place.node - 1];
  place.fraction = static_cast<float>((place.angle_deg - low) / (nodes[place.node] - low));
  return place;
}

// What the filter gives between the centres of texels. Rows wrap, as the hardware is told for the axial and diagonal
// slices; in the other textures no look-up comes to the last row with a weight on the next.
PaperEvaluator::Rgb PaperEvaluator::read(PaperTextureKind kind, double x, double y) const {
  const PaperTexture& texture = textures_.texture(kind);
  const auto column = static_cast<std::size_t>(x);
  const std::size_t row = static_cast<std::size_t>(y) % texture.height;
  const auto along = static_cast<float>(x - static_cast<double>(column));
  const auto across = static_cast<float>(y - std::floor(y));
  const std::size_t right = std::min<std::size_t>(column + 1, texture.width - 1);
  const std::size_t below = (row + 1) % texture.height;
  const auto at = [&](std::size_t r, std::size_t q) {
    const float* texel = texture.texels.data() + (r * texture.width + q) * 3;
    return Rgb{texel[0], texel[1], texel[2]};
  };
  return mixed(mixed(at(row, column), at(row, right), along), mixed(at(below, column), at(below, right), along),
               across);
}

// Here and below `v` and `i` number elevations with the normal as 0; textures leave it out.
PaperEvaluator::Rgb PaperEvaluator::crossing(std::size_t v, std::size_t i, Azimuths a) const {
  if (v == 0 || i == 0) return at_pole(v, i, a);
  if (i > v) return crossing(i, v, exchanged(a));
  const double step = textures_.azimuth_step_deg();
  const double left = paper_area(static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(v - 1)) *
                      (textures_.azimuth_count + 1.0);
  return read(PaperTextureKind::kCrossings, left + a.u / step, a.s / step);
}

PaperEvaluator::Rgb PaperEvaluator::axial(std::size_t v, std::size_t i, Azimuths a) const {
  if (v == 0 || i == 0) return on_ring(v, i, a);
  if (i > v) return axial(i, v, exchanged(a));
  const double left = paper_area(static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(v - 1)) *
                      (textures_.azimuth_count + 1.0);
  return read(PaperTextureKind::kAxial, left + a.u / textures_.azimuth_step_deg(), a.s / kDegreesPerRow);
}

PaperEvaluator::Rgb PaperEvaluator::diagonal(std::size_t v, std::size_t i, Azimuths a) const {
  if (v == 0 || i == 0) return at_pole(v, i, a);
  if (i > v) return diagonal(i, v, exchanged(a));
  if (a.s >= 360) a = {a.s - 360, a.u + 360};  // the same directions
  const double left = paper_area(static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(v - 1)) *
                      (textures_.azimuth_count + 1.0);
  return read(PaperTextureKind::kDiagonal, left + a.s / textures_.azimuth_step_deg(), a.u / kDegreesPerRow);
}

// Straight lines between the slices at two nodes of u, of which the last, at 360, is that at 0, half a turn of s on.
PaperEvaluator::Rgb PaperEvaluator::horizontal(std::size_t i, double theta_v_deg, Azimuths a) const {
  const double step = textures_.azimuth_step_deg();
  const std::uint32_t columns = 2 * textures_.azimuth_count + 1;
  const double u = a.u / step;
  const std::uint32_t node = std::min(static_cast<std::uint32_t>(u), textures_.azimuth_count - 1);
  const bool last = node + 1 == textures_.azimuth_count;
  const double y = static_cast<double>(i - 1) * kPaperElevationRows + theta_v_deg;
  const Rgb near = read(PaperTextureKind::kHorizontal, node * columns + a.s / step, y);
  const double s = last ? wrap(a.s + 360, kTurn) : a.s;
  const Rgb far = read(PaperTextureKind::kHorizontal, (last ? 0 : node + 1) * columns + s / step, y);
  return mixed(near, far, static_cast<float>(u - node));
}

// One direction at the normal, by straight lines between the crossings there.
PaperEvaluator::Rgb PaperEvaluator::at_pole(std::size_t v, std::size_t i, Azimuths a) const {
  if (v == 0 && i == 0) return textures_.at_normal;
  return v == 0 ? horizontal(i, 0, a) : horizontal(v, 0, exchanged(a));
}

// The same on the ring of the azimuth that is left: s - u at theta_i = 0, s + u at theta_v = 0.
PaperEvaluator::Rgb PaperEvaluator::on_ring(std::size_t v, std::size_t i, Azimuths a) const {
  if (v == 0 && i == 0) return textures_.at_normal;
  return horizontal(v == 0 ? i : v, 0, {wrap(v == 0 ? a.s + a.u : a.s - a.u, kTurn), 0});
}

PaperEvaluator::Rgb PaperEvaluator::along_view(const Place& view, std::size_t i, Azimuths a) const {
  if (i == 0) return mixed(at_pole(view.node, 0, a), at_pole(view.node + 1, 0, a), view.fraction);
  return horizontal(i, view.angle_deg, a);
}

// Vertical slices are the horizontal ones, light and view exchanged.
PaperEvaluator::Rgb PaperEvaluator::along_light(std::size_t v, const Place& light, Azimuths a) const {
  if (v == 0) return mixed(at_pole(0, light.node, a), at_pole(0, light.node + 1, a), light.fraction);
  return horizontal(v, light.angle_deg, exchanged(a));
}

}  // namespace sbrdf::internal
