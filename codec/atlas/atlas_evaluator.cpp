#include "codec/atlas/atlas_evaluator.h"

#include <algorithm>
#include <cmath>

#include "codec/frame/frame.h"

namespace sbrdf::internal {

AtlasEvaluator::AtlasEvaluator(const Atlas& atlas) : atlas_(atlas), poles_(poles(atlas.layout)) {}

void AtlasEvaluator::evaluate(const DirectionPair& pair, std::span<float, 3> values) const {
  if (above_horizon(pair)) {
    evaluate_at(geometry(atlas_.layout.frame).coordinates(pair), values);
  } else {
    std::fill(values.begin(), values.end(), 0.0F);
  }
}

bool AtlasEvaluator::holds(const DirectionPair& pair) const {
  const AtlasLayout& layout = atlas_.layout;
  return layout.cells.is_everything() || layout.cells.has(cell_of(layout, pair));
}

void AtlasEvaluator::evaluate_at(const Coordinates& x, std::span<float, 3> values) const {
  const AtlasLayout& layout = atlas_.layout;
  Coordinates folded = fold_coordinates(layout, x);
  for (double& degrees : folded) {
    if (!std::isfinite(degrees)) degrees = 0;  // of an azimuth that is no number
  }
  Places places;
  for (std::size_t axis = 0; axis < kAxisCount; ++axis) places[axis] = place_on(layout.axes[axis], folded[axis]);
  if (!layout.cells.has({places[0].cell, places[1].cell, places[2].cell, places[3].cell})) {
    std::copy(kLeftOutColour.begin(), kLeftOutColour.end(), values.begin());
    return;
  }
  Rgb v{};
  const auto add = [&](const Rgb& part, float weight) {
    for (std::size_t c = 0; c < 3; ++c) v[c] += weight * part[c];
  };
  for (std::size_t k = 0; k < layout.tables.size(); ++k) add(sum_of_table(k, places), 1);
  for (const AtlasPole& pole : poles_) {
    const AtlasPlace& place = places[pole.polar_axis];
    if (place.cell == 0) add(on_ring(pole, folded, places), 1 - static_cast<float>(place.fraction));
  }
  bring_back(atlas_.domain, v, values);
}

// What the GPU's filter gives between the centres of texels.
AtlasEvaluator::Rgb AtlasEvaluator::read(double x, double y, const AtlasScale& scale) const {
  const auto column = static_cast<std::size_t>(x);
  const auto row = static_cast<std::size_t>(y);
  const auto along = static_cast<float>(x - static_cast<double>(column));
  const auto across = static_cast<float>(y - static_cast<double>(row));
  const std::size_t width = atlas_.layout.width;
  const std::size_t right = std::min<std::size_t>(column + 1, width - 1);
  const std::size_t below = std::min<std::size_t>(row + 1, atlas_.layout.height - 1);
  const float* texels = atlas_.texels.data();
  Rgb v;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto at = [&](std::size_t r, std::size_t q) { return texels[(r * width + q) * 3 + c]; };
    const float top = at(row, column) + along * (at(row, right) - at(row, column));
    const float bottom = at(below, column) + along * (at(below, right) - at(below, column));
    v[c] = scale.offset[c] + scale.scale[c] * (top + across * (bottom - top));
  }
  return v;
}

// Tiles at a pole are taken out as often as there are rings that stand for them.
AtlasEvaluator::Rgb AtlasEvaluator::sum_of_table(std::size_t number, const Places& places) const {
  const AtlasTable& table = atlas_.layout.tables[number];
  const std::vector<AtlasScale>& scales = atlas_.scales[number];
  double y = 0;
  if (table.across) {
    const AtlasPlace row = place_between(atlas_.layout, *table.across, places[*table.across]);
    y = static_cast<double>(row.cell) + row.fraction;
  }
  Rgb sum{};
  for (unsigned bits = 0; bits < (1U << table.between.size()); ++bits) {
    float weight = 1;
    float share = 1;
    std::array<std::size_t, 2> nodes{};
    for (std::size_t k = 0; k < table.between.size(); ++k) {
      const AtlasPlace place = place_between(atlas_.layout, table.between[k], places[table.between[k]]);
      const bool far = ((bits >> k) & 1U) != 0;
      nodes[k] = place.cell + (far ? 1 : 0);
      weight *= static_cast<float>(far ? place.fraction : 1 - place.fraction);
      for (const AtlasPole& pole : poles_) share -= pole.polar_axis == table.between[k] && nodes[k] == 0 ? 1.0F : 0.0F;
    }
    if (weight * share == 0) continue;
    const std::uint32_t number_of_tile = tile_number(atlas_.layout, table, nodes[0], nodes[1]);
    const AtlasTile& tile = table.tiles[number_of_tile];
    const Rgb v = read(places[table.along].texel - tile.first_column + tile.x, y - tile.first_row + tile.y,
                       scales[scales.size() > 1 ? number_of_tile : 0]);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * share * v[c];
  }
  return sum;
}

AtlasEvaluator::Rgb AtlasEvaluator::on_ring(const AtlasPole& pole, const Coordinates& x, const Places& places) const {
  const AtlasRing& ring = *atlas_.layout.ring;
  const std::size_t other = pole.ring_axis == kAxial ? kDiagonal : kAxial;
  const double turn = wrap(x[pole.ring_axis] + pole.sign * x[other], ring.period_deg) / ring.period_deg;
  // Both polar axes of the elevation frame have the same texels.
  return read(ring.x + turn * ring.ring_texels, ring.y + places[pole.along].texel, atlas_.scales.back().front());
}

void bring_back(const AtlasDomain& domain, std::span<const float, 3> v, std::span<float, 3> values) {
  float sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    float w = v[c];
    if (domain.log) {
      if (v[c] >= domain.at_floor[c]) {
        w = domain.reference[c] * std::exp(v[c] / 2) * std::exp(v[c] / 2);  // exp(v) alone may be infinite
      } else if (v[c] > domain.at_zero[c] - 1) {
        w = domain.floor[c] * (v[c] - domain.at_zero[c]);
      } else {
        const float down = (domain.at_zero[c] - 1 - v[c]) / 2;
        w = -domain.floor[c] * std::exp(down) * std::exp(down);
      }
    }
    // The least, too, where sums of numbers near the end of what floats hold are none.
    values[c] = w > domain.least[c] ? std::min(w, domain.most[c]) : domain.least[c];
    sum += values[c];
  }
  if (domain.grey_divisor == 0) return;
  for (std::size_t c = 0; c < 3; ++c) values[c] -= domain.grey_shares[c] * sum / domain.grey_divisor;
}

}  // namespace sbrdf::internal
