#include "converters/files/rgl/rgl_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sbrdf::internal {
namespace {

/// A position along an axis: the node before it, and how far it is to the next in [0, 1].
struct Position {
  std::size_t index = 0;
  double fraction = 0;
};

Position position_on_grid(double u, std::size_t node_count) {
  const double scaled = u * static_cast<double>(node_count - 1);
  const std::size_t index = std::min(static_cast<std::size_t>(std::max(0.0, scaled)), node_count - 2);
  return {index, scaled - static_cast<double>(index)};
}

Position position_on_axis(std::span<const float> nodes, double value) {
  if (nodes.size() == 1) return {};
  const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, value);
  const auto index = static_cast<std::size_t>(above - nodes.begin()) - 1;
  const double low = nodes[index];
  const double high = nodes[index + 1];
  return {index, std::clamp((value - low) / (high - low), 0.0, 1.0)};
}

/// From the nearer end, so that what lies between two positive numbers never rounds to zero.
double mix(double a, double b, double fraction) {
  return fraction < 0.5 ? a + fraction * (b - a) : b - (1 - fraction) * (b - a);
}

/// Integral of a linear function over the first part of an interval of width 1 with the values `a` and `b` at its ends.
double integral_to(double fraction, double a, double b) { return fraction * (a + 0.5 * fraction * (b - a)); }

/// The inverse: the fraction in [0, 1] with this integral, 0 where there is nothing to integrate.
double fraction_of(double integral, double a, double b) {
  const double divisor = a + std::sqrt(std::max(0.0, a * a + 2 * (b - a) * integral));
  return divisor > 0 ? std::clamp(2 * integral / divisor, 0.0, 1.0) : 0.0;
}

/// Of `count` rising values: the last that is not above `target`, but not the very last.
template <class Value>
std::size_t last_not_above(std::size_t count, double target, const Value& value) {
  std::size_t low = 0;
  std::size_t high = count - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (value(middle) <= target ? low : high) = middle;
  }
  return low;
}

}  // namespace

RglSlices rgl_slices(std::span<const float> phi_i, std::span<const float> theta_i, double at_phi_i, double at_theta_i) {
  const Position phi = position_on_axis(phi_i, at_phi_i);
  const Position theta = position_on_axis(theta_i, at_theta_i);
  const std::size_t first = phi.index * theta_i.size() + theta.index;
  const std::array<std::size_t, 4> indices = {first, first + 1, first + theta_i.size(), first + theta_i.size() + 1};
  const std::array<double, 4> weights = {(1 - phi.fraction) * (1 - theta.fraction), (1 - phi.fraction) * theta.fraction,
                                         phi.fraction * (1 - theta.fraction), phi.fraction * theta.fraction};
  RglSlices slices;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (weights[i] == 0) continue;
    slices.index[slices.count] = indices[i];
    slices.weight[slices.count++] = weights[i];
  }
  return slices;
}

RglTable::RglTable(const RglGrid& grid, std::span<const float> values)
    : grid_(grid), values_(values.begin(), values.end()) {}

double RglTable::at(const RglPoint& u) const {
  const Position x = position_on_grid(u.x, grid_.x_count);
  const Position y = position_on_grid(u.y, grid_.y_count);
  const float* low = values_.data() + y.index * grid_.x_count + x.index;
  const float* high = low + grid_.x_count;
  return mix(mix(low[0], low[1], x.fraction), mix(high[0], high[1], x.fraction), y.fraction);
}

RglWarp::RglWarp(const RglGrid& grid, std::span<const float> density) : grid_(grid) {
  const std::size_t slice_count = density.size() / grid.cell_count();
  nodes_.reserve(density.size());
  rows_.reserve(slice_count * grid.y_count);
  for (std::size_t slice = 0; slice < slice_count; ++slice) {
    add_slice(density.subspan(slice * grid.cell_count(), grid.cell_count()));
  }
}

void RglWarp::add_slice(std::span<const float> density) {
  const auto row_mass = [&](std::size_t y) {
    const std::span<const float> row = density.subspan(y * grid_.x_count, grid_.x_count);
    double mass = 0;
    for (std::size_t x = 1; x < row.size(); ++x) mass += integral_to(1, row[x - 1], row[x]);
    return mass;
  };
  double total = 0;
  for (std::size_t y = 1; y < grid_.y_count; ++y) total += integral_to(1, row_mass(y - 1), row_mass(y));

  double before_row = 0;
  double mass_of_previous_row = 0;
  for (std::size_t y = 0; y < grid_.y_count; ++y) {
    double before = 0;
    double previous = 0;
    for (std::size_t x = 0; x < grid_.x_count; ++x) {
      const double value = density[y * grid_.x_count + x] / total;
      if (x > 0) before += integral_to(1, previous, value);
      nodes_.push_back({static_cast<float>(value), static_cast<float>(before)});
      previous = value;
    }
    if (y > 0) before_row += integral_to(1, mass_of_previous_row, before);
    rows_.push_back({static_cast<float>(before), static_cast<float>(before_row)});
    mass_of_previous_row = before;
  }
}

RglPoint RglWarp::invert(const RglPoint& u, const RglSlices& slices) const {
  const Position x = position_on_grid(u.x, grid_.x_count);
  const Position y = position_on_grid(u.y, grid_.y_count);
  double before_row = 0;
  double mass_low = 0;
  double mass_high = 0;
  double before_low = 0;
  double before_high = 0;
  for (std::size_t i = 0; i < slices.count; ++i) {
    const double weight = slices.weight[i];
    const Row* rows = rows_.data() + slices.index[i] * grid_.y_count + y.index;
    before_row += weight * rows[0].before;
    mass_low += weight * rows[0].mass;
    mass_high += weight * rows[1].mass;
    const Node* low = nodes_.data() + slices.index[i] * grid_.cell_count() + y.index * grid_.x_count + x.index;
    const Node* high = low + grid_.x_count;
    before_low += weight * (low[0].before + integral_to(x.fraction, low[0].density, low[1].density));
    before_high += weight * (high[0].before + integral_to(x.fraction, high[0].density, high[1].density));
  }
  const double mass = mix(mass_low, mass_high, y.fraction);
  const double before = mix(before_low, before_high, y.fraction);
  const double at_y = before_row + integral_to(y.fraction, mass_low, mass_high);
  return {mass > 0 ? std::clamp(before / mass, 0.0, 1.0) : 0.0, std::clamp(at_y, 0.0, 1.0)};
}

double RglWarp::row_before(std::size_t y, const RglSlices& slices) const {
  double before = 0;
  for (std::size_t i = 0; i < slices.count; ++i)
    before += slices.weight[i] * rows_[slices.index[i] * grid_.y_count + y].before;
  return before;
}

double RglWarp::row_mass(std::size_t y, const RglSlices& slices) const {
  double mass = 0;
  for (std::size_t i = 0; i < slices.count; ++i)
    mass += slices.weight[i] * rows_[slices.index[i] * grid_.y_count + y].mass;
  return mass;
}

RglWarp::Node RglWarp::node(std::size_t x, std::size_t y, double y_fraction, const RglSlices& slices) const {
  Node sum;
  for (std::size_t i = 0; i < slices.count; ++i) {
    const Node* low = nodes_.data() + slices.index[i] * grid_.cell_count() + y * grid_.x_count + x;
    const Node* high = low + grid_.x_count;
    const auto weight = static_cast<float>(slices.weight[i]);
    const auto fraction = static_cast<float>(y_fraction);
    sum.density += weight * ((1 - fraction) * low->density + fraction * high->density);
    sum.before += weight * ((1 - fraction) * low->before + fraction * high->before);
  }
  return sum;
}

RglPoint RglWarp::warp(const RglPoint& s, const RglSlices& slices) const {
  const double y_target = s.y * row_before(grid_.y_count - 1, slices);
  const std::size_t y = last_not_above(grid_.y_count, y_target, [&](std::size_t k) { return row_before(k, slices); });
  const double y_fraction = fraction_of(y_target - row_before(y, slices), row_mass(y, slices), row_mass(y + 1, slices));
  const double x_target = s.x * node(grid_.x_count - 1, y, y_fraction, slices).before;
  const std::size_t x =
      last_not_above(grid_.x_count, x_target, [&](std::size_t k) { return node(k, y, y_fraction, slices).before; });
  const Node low = node(x, y, y_fraction, slices);
  const double x_fraction = fraction_of(x_target - low.before, low.density, node(x + 1, y, y_fraction, slices).density);
  return {(static_cast<double>(x) + x_fraction) / static_cast<double>(grid_.x_count - 1),
          (static_cast<double>(y) + y_fraction) / static_cast<double>(grid_.y_count - 1)};
}

double RglWarp::density(const RglPoint& u, const RglSlices& slices) const {
  const Position x = position_on_grid(u.x, grid_.x_count);
  const Position y = position_on_grid(u.y, grid_.y_count);
  const double in_cells = mix(node(x.index, y.index, y.fraction, slices).density,
                              node(x.index + 1, y.index, y.fraction, slices).density, x.fraction);
  return in_cells * static_cast<double>((grid_.x_count - 1) * (grid_.y_count - 1));
}

RglCell rgl_cell(const RglGrid& grid, const RglPoint& u) {
  const Position x = position_on_grid(u.x, grid.x_count);
  const Position y = position_on_grid(u.y, grid.y_count);
  return {y.index * grid.x_count + x.index,
          {(1 - y.fraction) * (1 - x.fraction), (1 - y.fraction) * x.fraction, y.fraction * (1 - x.fraction),
           y.fraction * x.fraction}};
}

RglColours::RglColours(const RglGrid& grid, std::size_t channel_count, std::span<const float> values)
    : grid_(grid), channel_count_(channel_count), values_(values.size()) {
  const std::size_t cell_count = grid.cell_count();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t plane = i / cell_count;
    const std::size_t slice = plane / channel_count_;
    const std::size_t channel = plane % channel_count_;
    values_[(slice * cell_count + i % cell_count) * channel_count_ + channel] = values[i];
  }
}

void RglColours::at(const RglPoint& u, const RglSlices& slices, double scale, std::span<float> values) const {
  constexpr double largest = std::numeric_limits<float>::max();
  const Position x = position_on_grid(u.x, grid_.x_count);
  const Position y = position_on_grid(u.y, grid_.y_count);
  const std::size_t first = (y.index * grid_.x_count + x.index) * channel_count_;
  const std::size_t row = grid_.x_count * channel_count_;
  for (std::size_t c = 0; c < channel_count_; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < slices.count; ++i) {
      const float* low = values_.data() + slices.index[i] * grid_.cell_count() * channel_count_ + first + c;
      const float* high = low + row;
      sum += slices.weight[i] * mix(mix(low[0], low[channel_count_], x.fraction),
                                    mix(high[0], high[channel_count_], x.fraction), y.fraction);
    }
    values[c] = static_cast<float>(std::clamp(sum * scale, -largest, largest));
  }
}

}  // namespace sbrdf::internal
